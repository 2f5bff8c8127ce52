"""The colour of light in data sets, and pixels that show one surface alone."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.files.derived_buffers import (
    light_colors,
    one_piece,
    pure_pixels,
    with_derived,
)
from photonmap.dataset.scenes.build import build_scene
from photonmap.integrators.look import Onlooker

SIZE = (48, 36)

pytestmark = pytest.mark.filterwarnings("ignore:luminance by these bands")


@pytest.fixture(scope="module")
def jug():
    """A striped jug under one sodium lamp, with its render."""
    scene = build_scene("jug", seed=0, illumination="colored")
    return scene, pm.render(scene, bands=6, size=SIZE, passes=8, photons=2000, per_light=True)


def degrees(colors, color):
    cosine = colors @ color / np.linalg.norm(colors, axis=-1) / np.linalg.norm(color)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def test_one_light_has_one_colour(jug):
    """Where the ratio of direct light to reflectance has others, at edges between stripes."""
    scene, result = jug
    [group] = result.per_light
    color = light_colors(scene, [group], result.bands)[group]
    whole = with_derived(result, scene).buffers["illuminant_direct"]
    lit = whole.any(axis=-1)
    assert lit.mean() > 0.9
    assert degrees(whole[lit].astype(float), color).max() < 0.01
    ratio = with_derived(result).buffers["illuminant_direct"]
    known = ratio.any(axis=-1)
    assert (degrees(ratio[known].astype(float), color) > 1.0).mean() > 0.01


def test_pure_pixels_show_one_light_ratio(jug):
    scene, result = jug
    [group] = result.per_light
    color = light_colors(scene, [group], result.bands)[group]
    buffers = with_derived(result, scene).buffers
    ratio = with_derived(result).buffers["illuminant_direct"]
    sure = buffers["pure"] & buffers["valid"] & ratio.any(axis=-1)
    assert 0.5 < sure.mean() < 0.99
    assert degrees(ratio[sure].astype(float), color).max() < 0.01


def test_pixels_with_edges_are_not_pure(jug):
    """Rays ten times as dense meet another object or material in none of the pure pixels."""
    scene, result = jug
    pure = pure_pixels(result, scene)
    seen = Onlooker(scene).see(scene.camera, (10 * SIZE[0], 10 * SIZE[1]))
    for name in ("object_id", "material_id"):
        blocks = seen[name].reshape(SIZE[1], 10, SIZE[0], 10)
        mixed = blocks.min(axis=(1, 3)) != blocks.max(axis=(1, 3))
        assert not (pure & mixed).any()
        assert mixed.any()
    assert (result.errors["reflectance"][pure] == 0.0).all()


def test_creases_are_not_pure():
    """Two walls of one material in one mesh meet in an edge."""
    wall = pm.Material("wall", 0.5)
    vertices = [[-1, -3, 0], [0, -3, -1], [0, 3, -1], [-1, 3, 0], [1, -3, 0], [1, 3, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]
    mesh = pm.Mesh(vertices, faces, wall, name="corner")
    scene = pm.Scene([mesh], camera=pm.Camera((0.013, 0.0, 3.0), (0.013, 0.0, 0.0), fov=30.0))
    pure = one_piece(scene, (21, 21))
    assert pure[:, 3:9].all()
    assert pure[:, 12:18].all()
    assert not pure[:, 10].any()
    assert one_piece(scene, (21, 21), at_centre=True)[:, 10].all()


def test_groups_of_several_colours_have_none():
    lights = [
        pm.PointLight((0, 0, 1), 1.0, group="two"),
        pm.PointLight((0, 1, 1), (1.0, 0.5, 0.1), group="two"),
        pm.PointLight((1, 0, 1), (1.0, 0.5, 0.1), group="one"),
        pm.PointLight((1, 1, 1), (2.0, 1.0, 0.2), group="one"),
    ]
    scene = pm.Scene(pm.scenes.cornell_box().meshes, lights)
    colors = light_colors(scene, ["one", "two"], pm.Bands.parse("rgb"))
    assert colors["two"] is None
    np.testing.assert_allclose(colors["one"], np.array([1.0, 0.5, 0.1]) / (1.6 / 3), rtol=1e-6)
