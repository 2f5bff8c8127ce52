"""Tangents that meshes give, and images of directions and strengths along a surface."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from test_relief import ABOVE, SMALL, encoded, plane, tilted

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.sampling_plan import _textured_materials

SETTINGS = {"bands": "rgb", "size": (16, 16), "passes": 2, "seed": 4, "pixel": "center"}
"""Pixels that show an image have more samples, unless they all pass through the centre."""
CORNERS = np.array([[-2, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]], float)
UV = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
UP = np.tile([0.0, 1.0, 0.0], (4, 1))


def tangents(x, y, z, sign=-1.0):
    return np.tile([x, y, z, sign], (4, 1)).astype(float)


def floor(given=None, uv=UV, **look):
    """A floor of brushed metal under a small lamp; u rises along x, and v along z."""
    metal = {"glossy": 0.8, "roughness": 0.4, "anisotropy": 0.8} | look
    material = pm.Material("metal", 0.0, **metal)
    faces = [[0, 2, 1], [0, 3, 2]]
    mesh = pm.Mesh(CORNERS, faces, material, "floor", UP, uv, tangents=given)
    lamp = trimesh.creation.box((0.3, 0.02, 0.3))
    lamp.apply_translation([0, 1.5, 0])
    light = pm.Mesh(lamp.vertices, lamp.faces, pm.Material("lamp", 0.0, 20.0), "lamp")
    camera = pm.Camera((0, 3.0, 0.01), (0, 0, 0), fov=40, up=(0, 0, -1))
    return pm.Scene([mesh, light], [], camera)


def look_alike(one, other, **tolerances):
    pictures = [pm.render(scene, **SETTINGS).radiance for scene in (one, other)]
    np.testing.assert_allclose(*pictures, **({"rtol": 1e-4, "atol": 1e-6} | tolerances))


def test_given_tangents_are_those_that_follow_from_coordinates():
    """v rises along z = -(y × x): against normal × tangent."""
    look_alike(floor(), floor(tangents(2.0, 0, 0)))
    look_alike(floor(), floor(tangents(1.0, 0, 0), uv=None))


def test_tangents_turned_by_90_degrees_are_a_rotation_by_90_degrees():
    turned = floor(tangents(0, 0, 1.0))
    look_alike(floor(anisotropy_rotation=0.25), turned)
    aslant = floor(tangents(1, 0, 1), anisotropy_rotation=-0.125)
    look_alike(floor(), aslant)
    differs = pm.render(turned, **SETTINGS).radiance - pm.render(floor(), **SETTINGS).radiance
    assert np.abs(differs).max() > 0.05


def test_the_sign_says_to_which_side_a_rotation_turns():
    """Where v rises along the other side, the same turn goes the other way."""
    look_alike(
        floor(tangents(1, 0, 0, -1.0), anisotropy_rotation=0.1),
        floor(tangents(1, 0, 0, 1.0), anisotropy_rotation=-0.1),
    )


@pytest.mark.parametrize("rows", [np.zeros((4, 4)), tangents(1, 0, 0, 0.0), tangents(np.nan, 0, 0)])
def test_tangents_that_are_none_follow_from_coordinates(rows):
    look_alike(floor(anisotropy_rotation=0.1), floor(rows, anisotropy_rotation=0.1), rtol=0, atol=0)


def test_tangents_of_another_shape_are_refused():
    with pytest.raises(pm.InputError, match=r"'floor': tangents must be \(4, 4\), one per vertex"):
        pm.render(floor(np.zeros((4, 3))), **SETTINGS)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("azimuth", [0.3, 2.0])
def test_normal_maps_lie_in_the_given_frame(azimuth, sign):
    """x of the map goes along (1, 0, 1) / √2, and y along sign · normal × tangent."""
    (x, y, z), _ = tilted(0.5, azimuth)
    mesh = plane(pm.NormalMap(encoded(x, y, z)))
    along, up = np.array([0.5**0.5, 0.0, 0.5**0.5]), np.array([0.0, 1.0, 0.0])
    mesh = replace(mesh, normals=UP, tangents=tangents(*along, sign))
    scene = pm.Scene([mesh], [pm.DomeLight()], ABOVE)
    wanted = x * along + y * sign * np.cross(up, along) + z * up
    found = pm.render(scene, **SMALL).normal
    np.testing.assert_allclose(found, np.broadcast_to(wanted, (8, 8, 3)), atol=1e-5)


def test_frames_are_interpolated_as_mikktspace_has_it():
    """Neither tangent nor normal is made of length 1, or at right angles, between vertices."""
    texel = np.array([0.3, 0.4, 0.8])
    mesh = plane(pm.NormalMap(encoded(*texel)))
    lean = np.where(mesh.vertices[:, :1] < 0.0, -0.6, 0.6)
    normals = np.hstack([lean, np.full((4, 1), 0.8), np.zeros((4, 1))])
    along = np.hstack([np.full((4, 1), 0.8), -lean, np.zeros((4, 1)), np.ones((4, 1))])
    mesh = replace(mesh, normals=normals, tangents=along)
    result = pm.render(pm.Scene([mesh], [pm.DomeLight()], ABOVE), **SMALL | {"pixel": "center"})
    centers = (np.arange(8) + 0.5) / 8 - 0.5
    x = np.broadcast_to(centers[None, :, None], (8, 8, 1))
    share = 0.5 + x / 4.0
    n = (1.0 - share) * np.array([-0.6, 0.8, 0.0]) + share * np.array([0.6, 0.8, 0.0])
    t = (1.0 - share) * np.array([0.8, 0.6, 0.0]) + share * np.array([0.8, -0.6, 0.0])
    wanted = texel[0] * t + texel[1] * np.cross(n, t) + texel[2] * n
    wanted /= np.linalg.norm(wanted, axis=2, keepdims=True)
    np.testing.assert_allclose(result.normal, wanted, atol=2e-5)


def brush(red, green, blue):
    return pm.AnisotropyMap(pm.Texture.of(np.full((2, 2, 3), [red, green, blue], np.float32)))


def test_an_even_image_is_the_numbers():
    """Direction (0, 1) is a turn of 90 degrees; half of the strength is half of the anisotropy."""
    look_alike(floor(), floor(anisotropy_map=brush(1.0, 0.5, 1.0)), rtol=2e-3)
    turned = floor(anisotropy=0.4, anisotropy_rotation=0.25)
    look_alike(turned, floor(anisotropy_map=brush(0.5, 1.0, 0.5)), rtol=2e-3)
    both = floor(anisotropy_rotation=0.25, anisotropy_map=brush(0.5, 0.0, 1.0))
    look_alike(floor(), both, rtol=2e-3)


def test_an_image_of_two_halves_is_two_floors():
    """Seen where bilinear interpolation is far from the seam; coarser tables differ a little."""
    texels = np.empty((1, 64, 3), np.float32)
    texels[:, :32], texels[:, 32:] = (1.0, 0.5, 1.0), (0.5, 1.0, 0.25)
    halves = pm.AnisotropyMap(pm.Texture.of(texels))
    mixed = pm.render(floor(anisotropy_map=halves), **SETTINGS).radiance
    left = pm.render(floor(), **SETTINGS).radiance
    right = pm.render(floor(anisotropy=0.2, anisotropy_rotation=0.25), **SETTINGS).radiance
    np.testing.assert_allclose(mixed[:, :7], left[:, :7], rtol=5e-3, atol=1e-5)
    np.testing.assert_allclose(mixed[:, 9:], right[:, 9:], rtol=1e-2, atol=1e-5)


@pytest.mark.parametrize("image", [None, brush(1.0, 0.5, 1.0)])
def test_pixels_that_show_an_image_get_more_samples(image):
    """As with any texture, which may vary within a pixel."""
    compiled = compile_scene(floor(anisotropy_map=image), pm.Bands.rgb())
    varies = _textured_materials(compiled.arrays)
    assert varies.tolist() == [image is not None, False]


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_keeps_both(tmp_path, suffix):
    texels = np.array([[[255, 128, 51], [128, 255, 255]]], np.uint8)
    image = pm.Texture(pm.Texture.of(texels).image)
    image = replace(image, image=replace(image.image, srgb=False))
    scene = floor(tangents(1, 0, 1) * 0.5, anisotropy_map=pm.AnisotropyMap(image))
    pm.save_scene(scene, tmp_path / f"floor{suffix}")
    found = pm.load_scene(tmp_path / f"floor{suffix}").meshes[0]
    np.testing.assert_allclose(found.tangents, tangents(0.5**0.5, 0, 0.5**0.5), atol=1e-6)
    kept = found.material.anisotropy_map.texture.image
    np.testing.assert_array_equal(kept.texels, texels)
    assert not kept.srgb
