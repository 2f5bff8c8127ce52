"""Film points, the inverse of rays: round trips, and densities by finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.cameras import CAMERAS, camera_of

import photonmap as pm
from photonmap.compile.camera import compile_camera
from photonmap.compile.frame import Frame
from photonmap.kernels.camera.cameras import fill_film_points, fill_rays
from photonmap.scene.camera import check_camera

SIZE = (40, 28)
FRAME = Frame(np.array([0.2, -0.1, 0.3]), 1.7)
STEP = 1e-4
"""Of finite differences, pixels"""


def record_of(camera, size=SIZE):
    return compile_camera(check_camera(camera), FRAME, size)


def rays_of(record, points):
    rays = np.empty((len(points), 6))
    fill_rays(record, *np.ascontiguousarray(points.T), rays)
    return rays[:, :3], rays[:, 3:]


def film_points(record, points):
    seen = np.empty((len(points), 3))
    fill_film_points(record, np.ascontiguousarray(points), seen)
    return seen


def drawn(record, count=500):
    """Film points anywhere in the image to which light comes, and points on their rays."""
    rng = np.random.default_rng(7)
    at = rng.uniform(0.01, 0.99, (count, 2)) * SIZE
    origins, directions = rays_of(record, at)
    at = at[directions.any(axis=1)]
    origins, directions = rays_of(record, at)
    distances = rng.uniform(0.1, 9.0, (len(at), 1))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return at, origins + distances * directions, distances[:, 0]


@pytest.mark.parametrize("name", CAMERAS)
def test_points_on_a_ray_are_seen_where_it_leaves_the_film(name):
    record = record_of(camera_of(name))
    at, points, _ = drawn(record)
    assert len(at) > 200
    seen = film_points(record, points)
    np.testing.assert_allclose(seen[:, :2], at, atol=1e-7)
    assert (seen[:, 2] > 0.0).all()


@pytest.mark.parametrize("name", CAMERAS)
def test_density_is_that_of_neighbouring_rays(name):
    """The area across a ray that a small square of film sees, by central differences."""
    record = record_of(camera_of(name))
    at, points, distances = drawn(record)
    sides = []
    for axis in range(2):
        ends = []
        for sign in (-1.0, 1.0):
            moved = at.copy()
            moved[:, axis] += sign * STEP
            origins, directions = rays_of(record, moved)
            directions /= np.linalg.norm(directions, axis=1, keepdims=True)
            ends.append(origins + distances[:, None] * directions)
        sides.append((ends[1] - ends[0]) / (2.0 * STEP))
    area = np.linalg.norm(np.cross(*sides), axis=1)
    np.testing.assert_allclose(film_points(record, points)[:, 2] * area, 1.0, rtol=1e-5)


@pytest.mark.parametrize("name", ["pinhole", "orthographic", "shifted", "Brown-Conrady"])
def test_what_lies_behind_the_camera_is_not_seen(name):
    record = record_of(camera_of(name))
    at, _, distances = drawn(record)
    origins, directions = rays_of(record, at)
    behind = origins - distances[:, None] * directions
    assert not film_points(record, behind)[:, 2].any()


def test_a_fisheye_sees_nothing_beyond_its_largest_angle():
    camera = pm.Camera((0, 0, 0), (0, 0, -1), projection=pm.Fisheye(120.0))
    angles = np.radians([59.0, 61.0, 120.0, 179.0])
    points = np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1)
    record = compile_camera(check_camera(camera), Frame(np.zeros(3), 1.0), SIZE)
    assert (film_points(record, points)[:, 2] > 0.0).tolist() == [True, False, False, False]


def test_what_distortion_folds_back_into_the_image_is_not_seen():
    """Barrel distortion moves points far outside the image back to its middle."""
    barrel = pm.Intrinsics(500.0, (640, 480), 500.0, 320.0, 240.0, (-0.2, 0.0, 0.0, 0.0, 0.0))
    camera = pm.Camera((0, 0, 0), (0, 0, -1), projection=barrel)
    record = compile_camera(check_camera(camera), Frame(np.zeros(3), 1.0), (640, 480))
    outward = np.linspace(0.0, 3.0, 301)
    points = np.stack([outward, 0 * outward, -np.ones(301)], axis=1)
    moved = 320.0 + 500.0 * outward * (1.0 - 0.2 * outward**2)
    seen = film_points(record, points)[:, 2] > 0.0
    folded = (moved > 0.0) & (moved < 640.0) & (outward > 1.3)
    assert folded.any()
    assert not seen[folded].any()
    assert seen[(moved < 640.0) & (outward < 0.8)].all()


def test_ray_maps_have_no_film_points():
    camera = pm.Camera((0, 0, 2), (0, 0, 0))
    rays = pm.RayMap(pm.camera_rays(camera, (8, 6)))
    record = record_of(replace(camera, projection=rays), (8, 6))
    assert not film_points(record, np.random.default_rng(1).normal(size=(50, 3)))[:, 2].any()
