"""A light that cannot light the view is named; one that can is not."""

import warnings

import pytest
from helpers.scenes import closed_box, quad

import photonmap as pm
from photonmap.film.budget import LEAST_PASSES

LAMP, BLACK = pm.Material("lamp", 0.5, 1.0), pm.Material("black", 0.0)


def render(scene):
    return pm.render(scene, bands=1, size=(8, 8), passes=1, photons=100)


def up(height, name="lamp"):
    return quad((-1, height, 1), (1, height, 1), (1, height, -1), (-1, height, -1), LAMP, name)


def test_wrong_winding(cornell):
    walls = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    with pytest.warns(pm.SceneWarning, match="'lamp' sends nothing into the view"):
        render(pm.Scene([*walls, up(1.2)], camera=cornell.camera))


def test_buried_in_a_wall(cornell):
    wall = closed_box(pm.Material("wall", 0.5), -0.2, 0.2, "block")
    light = pm.PointLight((0.0, 0.0, 0.0), 1.0, "bulb")
    with pytest.warns(pm.SceneWarning, match="'bulb' sends nothing into the view"):
        render(pm.Scene([*cornell.meshes[:4], wall], [light], cornell.camera))


def test_a_point_light_has_no_winding(cornell):
    """A spot has a direction; both may be inside a wall."""
    bulb = pm.PointLight((0.0, -3.0, 0.0), 1.0, "bulb")
    walls = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    with pytest.warns(pm.SceneWarning, match="check that it is not inside a wall"):
        render(pm.Scene(walls, [bulb], cornell.camera))
    spot = pm.SpotLight((0.0, -3.0, 0.0), (0.0, -9.0, 0.0), 1.0, name="spot")
    with pytest.warns(pm.SceneWarning, match="check its direction, and that"):
        render(pm.Scene(walls, [spot], cornell.camera))


def test_an_image_without_light_has_a_warning(cornell):
    """Beside a mirror nothing is said of single lights: their light may come by it."""
    walls = [mesh for mesh in cornell.meshes if mesh.name != "light"]
    mirror = closed_box(pm.Material.polished("mirror"), -0.2, 0.2, "block")
    dark = pm.Scene([*walls, mirror, up(1.2)], camera=cornell.camera)
    with pytest.warns(pm.SceneWarning, match="no light reaches what the camera sees"):
        render(dark)
    lit = pm.Scene([*cornell.meshes, mirror], camera=cornell.camera)
    for scene, settings in ((lit, {}), (dark, {"effects": "emission,specular"})):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pm.render(scene, bands=1, size=(8, 8), passes=1, photons=100, **settings)


def test_a_camera_behind_a_wall_is_suspected_too(cornell):
    """Where one light of two reaches the view, it is not."""
    camera = pm.Camera((-1.0005, 0.2, 0.0), (1.0, 0.2, 0.0))
    with pytest.warns(pm.SceneWarning, match="or the camera is inside or behind an object"):
        render(pm.Scene(cornell.meshes, camera=camera))
    bulb = pm.PointLight((-3.0, 0.0, 0.0), 1.0, "bulb")
    with pytest.warns(pm.SceneWarning, match="not inside a wall$"):
        render(pm.Scene(cornell.meshes, [bulb], cornell.camera))


def test_a_camera_that_sees_nothing(cornell):
    away = pm.Camera((0.0, 0.0, -5.0), (0.0, 0.0, -9.0))
    with pytest.warns(pm.SceneWarning, match="the camera sees nothing; check its origin"):
        render(pm.Scene(cornell.meshes, camera=away))


@pytest.mark.parametrize("name", ["cornell_box", "furnace", "two_rooms"])
def test_lights_that_work_are_not_named(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = render(getattr(pm.scenes, name)())
    assert result.record["warnings"] == []


def test_a_dome_is_a_light_too():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(pm.Scene([closed_box(pm.Material("block", 0.5))], [pm.DomeLight()]))


@pytest.mark.parametrize("light", ["lamp", "dome", "portal"])
def test_a_light_that_fills_the_view_is_not_named(light):
    """Nothing else is there that it could light."""
    down = [(-1, 1, 1), (-1, 1, -1), (1, 1, -1), (1, 1, 1)]
    looks = {"lamp": LAMP, "portal": pm.Material("opening", 0.0, portal=True)}
    far = [(-1, -9, 1), (-1, -9, -1), (1, -9, -1), (1, -9, 1)]
    meshes = [quad(*down, looks[light], "ceiling")] if light in looks else [quad(*far, BLACK)]
    lights = [] if light == "lamp" else [pm.DomeLight()]
    camera = pm.Camera((0.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), fov=60.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = render(pm.Scene(meshes, lights, camera))
    assert result.emission == pytest.approx(1.0)


def test_no_error_is_reached_where_only_lights_are_seen():
    lamp = quad((-1, 1, 1), (-1, 1, -1), (1, 1, -1), (1, 1, 1), LAMP, "ceiling")
    camera = pm.Camera((0.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), fov=60.0)
    with pytest.warns(pm.SceneWarning, match=r"no error 0\.5 to reach: every pixel is unres"):
        result = pm.render(pm.Scene([lamp], camera=camera), bands=1, size=(8, 8), error=0.5)
    assert result.record["error"] is result.record["goal"]["reached"] is None
    assert result.record["passes"] == LEAST_PASSES
