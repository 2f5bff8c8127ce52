"""Renders by each kind of camera: blur in closed form, skies all around, and the same bits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.scenes import closed_box, quad

import photonmap as pm

METHODS = ("photon", "path")
ALONE = "ignore:light 'lamp' sends nothing:photonmap.SceneWarning"
PIXELS = 48
FOV = 30.0
FOCAL = 0.5 * PIXELS / math.tan(math.radians(FOV) / 2.0)
"""Pixels."""
LIT = {"bands": 1, "effects": "emission", "size": (PIXELS, PIXELS), "threads": 2}


def lamp(distance, pixels):
    """A square that faces a camera at the origin, of so many pixels seen from there."""
    half = 0.5 * pixels * distance / FOCAL
    a, b = (-half, half), -distance
    corners = [(a[0], a[0], b), (a[1], a[0], b), (a[1], a[1], b), (a[0], a[1], b)]
    return quad(*corners, pm.Material("lamp", 0.0, 1.0))


def seen(distance, lens, **settings):
    camera = pm.Camera((0, 0, 0), (0, 0, -1), fov=FOV, lens=lens)
    scene = pm.Scene([lamp(distance, 3.0)], camera=camera)
    return pm.render(scene, **{**LIT, "passes": 24, **settings}).emission[..., 0].astype(float)


@pytest.mark.filterwarnings(ALONE)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("distance", "focus"), [(2.0, 3.0), (3.0, 2.0)])
def test_blur_is_the_circle_of_confusion(method, distance, focus):
    """Its diameter, in the plane that is sharp: A |d − f| / d."""
    radius = 0.2
    image = seen(distance, pm.Lens(focus, radius), method=method, passes=96)
    y, x = np.mgrid[:PIXELS, :PIXELS] + 0.5 - PIXELS / 2.0
    spread = (image * (x * x + y * y)).sum() / image.sum()
    blur = radius * abs(distance - focus) / distance / focus * FOCAL
    expected = 0.5 * blur**2 + 3.0**2 / 6.0 + 1.0 / 6.0
    assert spread == pytest.approx(expected, rel=0.04)
    assert image.sum() == pytest.approx(9.0, rel=0.03)


@pytest.mark.filterwarnings(ALONE)
def test_what_is_in_focus_is_sharp():
    one, other = (seen(2.5, lens) for lens in (pm.Lens(2.5, 0.2), None))
    np.testing.assert_allclose(one, other, atol=1e-3)


@pytest.mark.filterwarnings(ALONE)
def test_centre_pixels_are_blurred_too():
    wide, sharp = (seen(2.0, lens, pixel="center") for lens in (pm.Lens(3.0, 0.2), None))
    assert (sharp > 0.0).sum() <= 16
    assert (wide > 0.0).sum() > 50
    assert wide.sum() == pytest.approx(9.0, rel=0.05)


def test_buffers_of_the_centre_are_those_of_the_pinhole(cornell):
    few = {"bands": 1, "size": (16, 12), "passes": 1, "photons": 200}
    lens = pm.Lens(3.0, 0.3)
    blurred = replace(cornell, camera=replace(cornell.camera, lens=lens))
    one, other = (pm.render(scene, **few) for scene in (cornell, blurred))
    for name in ("depth", "distance", "normal", "object_id", "material_id"):
        np.testing.assert_array_equal(one.buffers[name], other.buffers[name])
    assert (one.radiance != other.radiance).any()


def test_depth_is_planar_and_distance_is_not():
    room = closed_box(pm.Material("room", 0.5))
    camera = pm.Camera((0, 0, 0.5), (0, 0, -1), fov=60.0)
    few = {"bands": 1, "size": (21, 21), "passes": 1, "photons": 100}
    result = pm.render(pm.Scene([room], [pm.PointLight((0, 0, 0))], camera), **few)
    wall = result.normal[..., 2] > 0.99
    np.testing.assert_allclose(result.depth[wall], 1.5, rtol=1e-6)
    rays = pm.camera_rays(camera, (21, 21))
    length = np.linalg.norm(rays[..., 3:], axis=-1)
    np.testing.assert_allclose(result.distance, result.depth * length, rtol=1e-5)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("fov", [None, 180.0, 360.0])
def test_a_dome_is_seen_all_around(method, fov):
    """Everywhere in a panorama, and inside of a fisheye's circle; nothing is seen outside."""
    ball = closed_box(pm.Material("far", 0.0), 9.0, 9.01)
    projection = pm.Panorama() if fov is None else pm.Fisheye(fov)
    camera = pm.Camera((0, 0, 0), (-1, -1, -1), projection=projection)
    scene = pm.Scene([ball], [pm.DomeLight(0.7)], camera)
    result = pm.render(scene, bands=1, size=(24, 12), passes=2, photons=100, method=method)
    y, x = np.mgrid[:12, :24] + 0.5 - np.array([6.0, 12.0])[:, None, None]
    radius = np.hypot(x, y)
    inside = radius < (99.0 if fov is None else 5.2)
    empty = result.coverage == 0.0
    np.testing.assert_allclose(result.emission[..., 0][inside & empty], 0.7, rtol=1e-6)
    assert (inside & ~empty).sum() <= 2
    if fov is not None:
        assert not result.radiance[radius > 6.8].any()
        assert not result.coverage[radius > 6.8].any()


@pytest.mark.parametrize("method", METHODS)
def test_a_ray_map_of_a_pinhole_gives_its_bits(cornell, method):
    size = (16, 12)
    rays = pm.RayMap(pm.camera_rays(cornell.camera, size))
    place = cornell.camera.origin, cornell.camera.target, cornell.camera.up
    mapped = replace(cornell, camera=pm.Camera(*place, projection=rays))
    few = {"bands": 3, "size": size, "passes": 2, "photons": 1000, "method": method}
    one, other = (pm.render(scene, **few, pixel="center") for scene in (cornell, mapped))
    for name in ("radiance", "direct", "indirect", "shading", "normal", "distance"):
        np.testing.assert_array_equal(one.buffers[name], other.buffers[name])
    one, other = (pm.render(scene, **few) for scene in (cornell, mapped))
    close = np.isclose(one.radiance, other.radiance, rtol=1e-3, atol=1e-6)
    assert close.mean() > 0.95


def test_the_record_has_kind_lens_and_both_poses():
    lens = pm.Lens(2.0, f_number=4.0, focal_length=0.1)
    projection = pm.Intrinsics(300.0, (640, 480), 310.0, 330.0, 250.0, (0.01, 0.0, 0.0, 0.001))
    camera = pm.Camera((1, 2, 3), (0, 0, 0), projection=projection, lens=lens, name="left")
    described = camera.describe(320, 240)
    assert described["intrinsics"] == [[150.0, 0.0, 165.0], [0.0, 155.0, 125.0], [0.0, 0.0, 1.0]]
    assert described["distortion"] == [0.01, 0.0, 0.0, 0.001]
    assert (described["kind"], described["name"]) == ("intrinsics", "left")
    assert (described["lens"]["radius"], described["lens"]["focus"]) == (0.0125, 2.0)
    gl, cv = (np.array(described[f"camera_to_world{end}"]) for end in ("", "_opencv"))
    np.testing.assert_array_equal(gl[:, [0, 3]], cv[:, [0, 3]])
    np.testing.assert_array_equal(gl[:, 1:3], -cv[:, 1:3])
    assert camera.describe(320, 240) == described
    plain = replace(camera, projection=pm.Panorama(), lens=None).describe(8, 4)
    assert (plain["intrinsics"], plain["distortion"]) == (None, [])
