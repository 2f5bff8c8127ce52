"""Opacity: what light comes through, and what the buffers show behind holes."""

import numpy as np
import pytest
from helpers.comparisons import assert_within
from helpers.scenes import closed_box, closed_tetrahedron
from test_textures import SQUARE, assert_methods_agree, bilinear, full_view, textured_box, wall

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.kernels.geometry.opacity import MOST_LAYERS, intersect, occluded
from photonmap.spectra.bands import Bands

CHECKS = np.kron([[1.0, 0.0], [0.0, 1.0]], np.ones((4, 4)))


def through(alpha, lamp=(4.0, 2.0, 1.0), pairs=1):
    """A ground lit from above through a cut-out square."""
    ground = wall(0.5, z=0.0, size=0.2, name="ground")
    veils = [wall(0.0, alpha=alpha, z=0.5 + 0.01 * i, size=4.0) for i in range(pairs)]
    light = pm.PointLight((0.1, 0.0, 1.5), lamp)
    camera = pm.Camera((0.5, 0, 0.4), (0, 0, 0), fov=15.0)
    return pm.Scene([ground, *veils], [light], camera)


@pytest.mark.parametrize("method", ["photon", "path"])
def test_light_that_comes_through(method):
    settings = {"bands": "rgb", "size": (8, 8), "passes": 64, "method": method}
    bare = pm.render(through(0.0), **settings)
    for alpha, pairs in ((0.3, 1), (0.5, 2)):
        veiled = pm.render(through(alpha, pairs=pairs), **settings)
        values = veiled.direct.mean(axis=(0, 1), dtype=float)
        truth = bare.direct.mean(axis=(0, 1), dtype=float) * (1.0 - alpha) ** pairs
        spread = veiled.standard_error("direct").astype(float) ** 2
        assert_within(values, truth, np.sqrt(spread.sum(axis=(0, 1))) / 64, slack=2e-3)


def test_a_mask_gives_exact_coverage():
    texture = pm.Texture.of(CHECKS, clamp=True)
    scene = pm.Scene([wall(0.5, alpha=texture)], [pm.DomeLight()], full_view(8))
    result = pm.render(scene, bands="rgb", size=(8, 8), pixel="center", passes=2)
    np.testing.assert_array_equal(result.coverage, CHECKS)
    np.testing.assert_array_equal(result.object_id, CHECKS)
    np.testing.assert_array_equal(result.reflectance[..., 0], 0.5 * CHECKS)
    box = pm.render(scene, bands="rgb", size=(2, 2), passes=64)
    steps = (np.arange(64) + 0.5) / 64
    image = CHECKS[..., None]
    fine = np.array([[bilinear(image, s, 1 - t, True)[0] for s in steps] for t in steps])
    wanted = fine.reshape(2, 32, 2, 32).mean(axis=(1, 3))
    np.testing.assert_allclose(box.coverage, wanted, atol=0.03)


def test_partly_there():
    scene = pm.Scene([wall(0.5, alpha=0.3)], [pm.DomeLight()], full_view(16))
    result = pm.render(scene, bands="rgb", size=(16, 16), passes=16)
    count = 16 * 16 * 16 * 16
    assert result.coverage.mean() == pytest.approx(0.3, abs=4 * np.sqrt(0.21 / count))


def test_buffers_show_what_is_behind_the_holes():
    front = wall(0.5, alpha=pm.Texture.of(CHECKS, clamp=True), z=0.5, name="front", size=0.95)
    back = wall((0.1, 0.2, 0.3), z=0.0, size=2.0, name="back")
    scene = pm.Scene([front, back], [pm.DomeLight()], full_view(8))
    result = pm.render(scene, bands="rgb", size=(8, 8), pixel="center", passes=2)
    np.testing.assert_array_equal(result.coverage, 1.0)
    np.testing.assert_array_equal(result.object_id, np.where(CHECKS, 1, 2))
    np.testing.assert_allclose(result.reflectance[..., 2], np.where(CHECKS, 0.5, 0.3), rtol=1e-6)
    x = (np.arange(8) + 0.5) / 4 - 1
    slant = np.sqrt(100 + x[:, None] ** 2 + x**2) / 10
    np.testing.assert_allclose(result.depth, np.where(CHECKS, 9.5, 10.0), rtol=1e-5)
    np.testing.assert_allclose(result.distance, np.where(CHECKS, 9.5, 10.0) * slant, rtol=1e-5)
    np.testing.assert_allclose(result.normal[..., 2], 1.0)


def test_a_lamp_with_holes():
    """Half of it is there, so half of its light; photons and paths agree."""
    scene = textured_box()
    lamp = scene.meshes[-1]
    material = pm.Material("lamp", 0.0, 5.0, alpha=pm.Texture.of(CHECKS))
    scene.meshes[-1] = pm.Mesh(lamp.vertices, lamp.faces, material, "lamp", uv=SQUARE)
    back = scene.meshes[2]
    cut = pm.Material("back", back.material.reflectance, alpha=0.5)
    scene.meshes[2] = pm.Mesh(back.vertices, back.faces, cut, "back", uv=back.uv)
    assert_methods_agree(scene, 16, 200, ("emission", "direct", "indirect"), bands="rgb")


@pytest.mark.parametrize("method", ["photon", "path"])
def test_a_furnace_of_sieves(method):
    """In a closed room that radiates 1 behind others that are partly there, all is 1."""
    outer = closed_tetrahedron(pm.Material("outer", 0.5, 0.5), "outer")
    inner = closed_box(pm.Material("inner", 1.0, alpha=0.4), -0.5, 0.5, "inner")
    scene = pm.Scene([outer, inner], [], pm.Camera((0.2, 0.1, 0.8), (0, 0, -1), fov=60.0))
    result = pm.render(scene, bands="rgb", size=(12, 12), passes=24, method=method, photons=4000)
    assert result.radiance.mean() == pytest.approx(1.0, rel=0.01)


def stacked(count, alpha=0.0):
    walls = [wall(0.5, alpha=alpha, z=0.01 * i) for i in range(count)]
    return compile_scene(pm.Scene(walls, [pm.DomeLight()]), Bands.rgb())


def test_layers_are_passed_in_order_and_bounded():
    compiled = stacked(40)
    geometry, up = compiled.geometry, (0.01, 0.02, 1.0)
    below = (0.1, 0.03, -1.0)
    assert intersect(geometry, below, up)[0] == -1
    assert not occluded(geometry, below, up, np.inf)
    assert not occluded(geometry, below, (0.02, 0.04, 2.0), 1.0)
    solid = geometry.alpha._replace(value=np.where(np.arange(40) == 30, 1.0, 0.0))
    geometry = geometry._replace(alpha=solid)
    triangle, _, _, distance = intersect(geometry, below, up)
    assert geometry.material[triangle] == 30
    z = geometry.vertices[geometry.triangles[triangle, 0], 2]
    assert distance == pytest.approx(1.0 + z, rel=1e-4)
    assert occluded(geometry, below, up, np.inf)
    for share, stops in ((1.01, True), (0.99, False)):
        segment = tuple(share * distance * x for x in up)
        assert occluded(geometry, below, segment, 1.0) == stops
    layer, count = wall(0.5, alpha=0.0), MOST_LAYERS + 4
    vertices = np.repeat(layer.vertices[None], count, axis=0)
    vertices[..., 2] += 0.01 * np.arange(count)[:, None]
    faces = len(layer.vertices) * np.arange(count)[:, None, None] + layer.faces
    mesh = pm.Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), layer.material, "layers")
    many = compile_scene(pm.Scene([mesh], [pm.DomeLight()]), Bands.rgb())
    assert occluded(many.geometry, below, up, np.inf)
    assert intersect(many.geometry, below, up)[0] >= 0


@pytest.mark.parametrize("alpha", [-0.1, 1.1, np.nan, "half", None])
def test_bad_opacities(alpha):
    with pytest.raises(InputError, match=r"material 'wall': alpha: .* is not an opacity"):
        compile_scene(pm.Scene([wall(0.5, alpha=alpha)]), Bands.rgb())
