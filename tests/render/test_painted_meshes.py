"""Colours of vertices and faces as renders show them."""

import numpy as np
import pytest
from helpers.scenes import closed_tetrahedron

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.compile.textures import paint_meshes
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

RNG = np.random.default_rng(7)
FAN = np.array([[0, 0, 0], [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
FACES = np.array([[0, 1, 2], [0, 2, 3], [3, 4, 0], [1, 0, 4]])


def interpolate(place, corner_colors):
    """The colour of the fan at a place, (2,), by barycentrics in the triangle around it."""
    for corners, colors in zip(FAN[FACES, :2], corner_colors, strict=True):
        weights = np.linalg.solve(np.vstack([corners.T, np.ones(3)]), [*place, 1.0])
        if weights.min() >= -1e-9:
            return weights @ colors
    raise AssertionError("outside")


def show(*meshes, bands="rgb"):
    camera = pm.Camera((0, 0, 9), (0, 0, 0), height=2)
    scene = pm.Scene(list(meshes), [pm.DomeLight()], camera)
    return pm.render(scene, bands=bands, size=(24, 24), pixel="center", passes=2, photons=64)


@pytest.mark.parametrize("bands", [5, "rgb"])
@pytest.mark.parametrize("shape", [(5, 3), (4, 1, 3), (4, 3, 3)])
def test_reflectance_is_linear_in_barycentrics(shape, bands):
    colors = RNG.integers(0, 2, shape).astype(float)  # contrast at which texels leave [0, 1]
    corner_colors = colors[FACES] if len(shape) == 2 else np.broadcast_to(colors, (4, 3, 3))
    result = show(pm.Mesh(FAN, FACES, colors=colors), bands=bands)
    middles = (np.arange(24) + 0.5) / 12 - 1
    wanted = [[interpolate((x, y), corner_colors) for x in middles] for y in -middles]
    if len(shape) == 2:
        basis = result.bands.reflectance_basis
        np.testing.assert_allclose(result.reflectance, wanted @ basis, atol=2e-6)
    else:  # pixels on the diagonals show either face
        diagonal = np.abs(np.abs(middles[:, None]) - np.abs(middles)) < 1e-9
        found = (result.reflectance - wanted @ result.bands.reflectance_basis)[~diagonal]
        np.testing.assert_allclose(found, 0.0, atol=2e-6)


def test_faces_of_one_material_share_a_texture():
    plain, paint = pm.Material("plain"), pm.Material("paint")
    meshes = [
        pm.Mesh(FAN, FACES, paint, "a", colors=RNG.random((5, 3))),
        pm.Mesh(FAN + [0, 0, 1], FACES, plain, "b"),
        pm.Mesh(FAN + [0, 0, 2], FACES[:3], paint, "c", colors=RNG.random((3, 3))),
    ]
    first, second, third = paint_meshes(meshes)
    assert second is meshes[1]
    assert first.material is third.material
    assert first.material.reflectance.values.shape == (7, 3, 3)
    assert first.material.reflectance.largest <= 1.0
    corners = [meshes[0].colors[FACES], np.repeat(meshes[2].colors, 3, axis=1)]
    mean = np.concatenate(corners).mean(axis=(0, 1))
    np.testing.assert_allclose(first.material.reflectance.mean, mean, rtol=1e-6)
    compiled = compile_scene(pm.Scene(meshes, [pm.DomeLight()]), Bands.rgb())
    assert compiled.counts["materials"] == 2
    np.testing.assert_allclose(compiled.materials.reflectance[0], mean, rtol=1e-6)


def test_a_constant_colour_is_that_reflectance():
    """In a furnace, photons, gather rays and walks meet it too."""
    color = (0.2, 0.5, 0.8)
    images = []
    for reflectance, colors in ((color, None), (0.5, np.tile(color, (4, 1)))):
        walls = closed_tetrahedron(pm.Material("wall", reflectance, 1.0))
        walls = pm.Mesh(walls.vertices, walls.faces, walls.material, colors=colors)
        camera = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)
        scene = pm.Scene([walls], camera=camera)
        images.append(pm.render(scene, bands="rgb", size=(12, 12), passes=3, photons=3000))
    for name in ("radiance", "indirect", "reflectance", "shading"):
        plain, colored = (image.buffers[name] for image in images)
        np.testing.assert_allclose(colored, plain, rtol=1e-5)


def test_colours_and_smooth_normals_go_together():
    normals = FAN - [0, 0, -2]
    colors = RNG.random((5, 3))
    colored = show(pm.Mesh(FAN, FACES, normals=normals, colors=colors))
    plain = show(pm.Mesh(FAN, FACES, normals=normals))
    np.testing.assert_array_equal(colored.normal, plain.normal)
    assert np.ptp(plain.normal, axis=(0, 1)).min() > 0


def test_colors_by_count():
    faces = RNG.random((4, 3))
    assert pm.Mesh(FAN, FACES, colors=faces).colors.shape == (4, 1, 3)
    assert pm.Mesh(FAN[:4], FACES[:2], colors=faces).colors.shape == (4, 3)
    assert pm.Mesh(FAN[:4], [[0, 1, 2]] * 4, colors=faces).colors.shape == (4, 3)


TEXTURED = pm.Material("wood", pm.Texture.of(np.ones((1, 1, 3), np.uint8)))


@pytest.mark.parametrize(
    ("colors", "material", "message"),
    [
        (
            np.ones((3, 3)),
            pm.Material(),
            r"mesh 'fan': colors must be \(5, 3\), one per vertex, or",
        ),
        (np.ones(3), pm.Material(), r"not \(3,\)"),
        (np.eye(5)[:, :3] * 1.5, pm.Material(), r"color 0 is \[1\.5, 0\.0, 0\.0\]; keep it within"),
        (np.full((4, 1, 3), np.nan), pm.Material(), "color 0 is"),
        (np.ones((5, 3)), TEXTURED, "has colors, and its material 'wood' has textures; remove"),
        (np.ones((5, 3)), pm.Material.glass("pane"), "'pane' is glass; set its reflectance"),
    ],
)
def test_bad_colors(colors, material, message):
    mesh = pm.Mesh(FAN, FACES, material, "fan", colors=colors)
    with pytest.raises(InputError, match=message):
        compile_scene(pm.Scene([mesh]), Bands.rgb())
