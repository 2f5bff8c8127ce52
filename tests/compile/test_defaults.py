"""The view of a scene without a camera, and the light of one without lights."""

import numpy as np
import pytest
import trimesh
from helpers.comparisons import assert_within

import photonmap as pm
from photonmap.compile.camera import frame_scene
from photonmap.scene.camera import frame_of

UP = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "-y": (0.0, -2.0, 0.0)}


def places_in_image(camera, points, aspect):
    """Return where points lie in the image, from -1 to 1 across and upwards: (V, 2)."""
    view, right, up = frame_of(camera)
    offsets = points - np.array(camera.origin)
    depth = offsets @ view
    assert (depth > 0.0).all()
    across = np.stack([offsets @ right / aspect, offsets @ up], axis=1)
    return across / (np.tan(np.radians(camera.fov) / 2.0) * depth)[:, None]


@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("up", UP)
@pytest.mark.parametrize("away", [0.0, 1e6])
@pytest.mark.parametrize("fov", [10.0, 40.0, 120.0])
def test_a_scene_fills_the_image(up, aspect, away, fov):
    points = np.random.default_rng(1).normal(size=(1000, 3)) * (3.0, 1.0, 0.5) + away
    camera = frame_scene(points, aspect, UP[up], fov)
    assert camera.fov == fov
    low, high = np.sort(places_in_image(camera, points, aspect), axis=0)[[0, -1]]
    tight = np.argmax(high - low)
    np.testing.assert_allclose([-low[tight], high[tight]], 1.0 / 1.05, rtol=1e-6)
    assert np.abs([low, high]).max() < 1.0


def test_the_camera_stands_to_the_right_of_the_front_and_above_it():
    box = trimesh.creation.box().vertices
    for up, front in (("y", (0, 0, 1)), ("z", (0, -1, 0))):
        camera = frame_scene(box, 1.0, UP[up])
        toward = np.array(camera.origin) - camera.target
        toward /= np.linalg.norm(toward)
        assert toward @ front > toward[0] > 0.4
        assert toward @ UP[up] == pytest.approx(np.sin(np.radians(25.0)))
        assert frame_of(camera)[2] @ UP[up] > 0.9


def test_odd_scenes_and_directions():
    assert frame_scene(np.ones((3, 3))).target == (1.0, 1.0, 1.0)
    for up in ((0, 0, 0), "z"):
        with pytest.raises(pm.InputError, match="is not a direction; give three numbers"):
            frame_scene(np.eye(3), 1.0, up)
    with pytest.raises(pm.InputError, match="not an angle of view; give degrees above 0"):
        frame_scene(np.eye(3), fov=180.0)


def irradiance(normal, key, rng):
    """Return ∫ L cos dω of the default light, as the guide describes it."""
    directions = rng.normal(size=(2_000_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    cosines = np.maximum(directions @ normal, 0.0)
    radiance = 0.2 + 6.6 * np.exp(12.0 * (directions @ key - 1.0))
    return 4.0 * np.pi * (radiance * cosines).mean()


def test_the_default_light():
    """A convex body reflects ρ E / π; the upper left is brightest, and the background even."""
    ball = pm.Mesh.from_trimesh(trimesh.creation.icosphere(2), pm.Material("ball", 0.5))
    with pytest.warns(pm.SceneWarning, match="a dome of radiance 0.2 .* and a soft key light"):
        result = pm.render(
            pm.Scene([ball], up=(0, 0, 1)), bands=2, size=(16, 16), passes=32, pixel="center"
        )
    view, right, up = frame_of(
        pm.Camera(*(result.record["camera"][n] for n in ("origin", "target", "up")))
    )
    key = -0.5 * right + 0.65 * up - 0.6 * view
    key /= np.linalg.norm(key)
    rng = np.random.default_rng(2)
    for y, x in ((5, 5), (5, 10), (10, 5), (10, 10), (8, 8)):
        expected = 0.5 / np.pi * irradiance(result.normal[y, x], key, rng)
        assert_within(
            result.radiance[y, x], expected, result.standard_error("radiance")[y, x], slack=0.01
        )
    shade = result.shading[..., 0]
    assert shade[4:8, 4:8].mean() > 1.3 * shade[8:12, 8:12].mean()
    assert np.ptp(result.emission[result.depth == 0.0]) < 0.01
    assert result.record["light_groups"] == []
    np.testing.assert_allclose(result.record["white"], 1.0)
