"""Scenes built in code: checked once, normalised, and turned back without loss."""

import numpy as np
import pytest
from helpers.scenes import CAMERA, GREY, closed_box

import photonmap as pm
from photonmap.compile.lights.probabilities import EVEN
from photonmap.compile.scene_arrays import compile_scene
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
LIT = [pm.PointLight((0.0, 0.0, 0.0), (2.0, 4.0, 6.0))]


def scene_of(*meshes, lights=LIT):
    return pm.Scene(list(meshes), list(lights), CAMERA)


def test_geometry_is_centred_at_unit_size():
    compiled = compile_scene(scene_of(closed_box(GREY, 100.0, 140.0)), RGB)
    assert compiled.size == pytest.approx(40.0)
    np.testing.assert_allclose(compiled.center, 120.0)
    assert np.abs(compiled.geometry.vertices).max() == pytest.approx(0.5)
    np.testing.assert_allclose(np.linalg.norm(compiled.geometry.normals, axis=1), 1.0, rtol=1e-6)


def test_power_is_one():
    lamp = pm.Material("lamp", 0.5, (1.0, 2.0, 3.0))
    compiled = compile_scene(scene_of(closed_box(lamp, 0.0, 2.0)), RGB)
    lights = compiled.lights
    area, intensity = 24.0 / 4.0, 4.0 / 4.0
    power = np.pi * area * 2.0 + 4.0 * np.pi * intensity
    assert compiled.power == pytest.approx(power)
    assert lights.cdf[-1] == 1.0
    point = 1.0 - lights.cdf[-2]
    assert point == pytest.approx((1.0 - EVEN) * 4.0 * np.pi * intensity / power + EVEN / 2)
    assert compiled.light_names[-1] == "point"
    assert compiled.counts["lights"] == 2
    assert compiled.counts["emitting_triangles"] == 12


def test_ids_follow_names():
    compiled = compile_scene(
        scene_of(
            closed_box(GREY, -1.0, 1.0, "room"),
            closed_box(GREY, -0.5, 0.5, "box"),
            closed_box(pm.Material("red", (0.5, 0.1, 0.1)), -0.2, 0.2, "room"),
        ),
        RGB,
    )
    assert compiled.object_ids[::12].tolist() == [1, 2, 1]
    assert compiled.material_ids[::12].tolist() == [1, 1, 2]


def test_degenerate_triangles_are_counted_and_left_out():
    flat = pm.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]], GREY)
    with pytest.warns(pm.SceneWarning, match="1 degenerate triangle "):
        assert len(compile_scene(scene_of(flat), RGB).geometry.triangles) == 1


BAD_MESHES = {
    "faces names vertex 9": pm.Mesh(np.eye(3), [[0, 1, 9]], GREY, "bad"),
    "face names vertex -1": pm.Mesh(np.eye(3), [[0, 1, -1]], GREY, "bad"),
    "vertex 1 is": pm.Mesh([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]], [[0, 1, 2]], GREY, "bad"),
    "vertices must be": pm.Mesh(np.zeros((3, 2)), [[0, 1, 2]], GREY, "bad"),
    "faces must be": pm.Mesh(np.eye(3), [[0, 1, 2, 0]], GREY, "bad"),
    "normals must be": pm.Mesh(np.eye(3), [[0, 1, 2]], GREY, "bad", np.zeros((2, 3))),
    "reflectance is 1.5": pm.Mesh(np.eye(3), [[0, 1, 2]], pm.Material("m", 1.5), "bad"),
    "reflectance is -0.5": pm.Mesh(
        np.eye(3), [[0, 1, 2]], pm.Material("m", (0.1, -0.5, 0.1)), "bad"
    ),
    "emits -1": pm.Mesh(np.eye(3), [[0, 1, 2]], pm.Material("m", 0.5, -1.0), "bad"),
}


@pytest.mark.parametrize("message", BAD_MESHES)
def test_bad_meshes(message):
    with pytest.raises(pm.InputError, match=message.replace("faces names", "face names")):
        compile_scene(scene_of(BAD_MESHES[message]), RGB)


@pytest.mark.parametrize(
    ("light", "message"),
    [
        (pm.PointLight((0.0, np.inf, 0.0)), "is not a point; give three finite numbers"),
        (pm.PointLight((0.0, 0.0, 0.0), -1.0, "lamp"), "'lamp' emits -1"),
        (pm.DomeLight(-2.0, "sky"), "'sky' emits -2"),
        ("sun", "'sun' is not a light; give one of PointLight"),
    ],
)
def test_bad_lights(light, message):
    with pytest.raises(pm.InputError, match=message):
        compile_scene(scene_of(closed_box(GREY), lights=[light]), RGB)


def test_one_dome_at_most():
    with pytest.raises(pm.InputError, match="one dome"):
        compile_scene(scene_of(closed_box(GREY), lights=[pm.DomeLight(), pm.DomeLight(2.0)]), RGB)


def test_nothing_to_render():
    with pytest.raises(pm.InputError, match="no faces"):
        compile_scene(pm.Scene(), RGB)
    line = pm.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], GREY)
    with (
        pytest.warns(pm.SceneWarning),
        pytest.raises(pm.InputError, match="no triangle has an area"),
    ):
        compile_scene(scene_of(line), RGB)
