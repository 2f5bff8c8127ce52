"""Rays of each kind of camera against closed forms, directly and through buffers."""

import math

import numpy as np
import pytest
from helpers.cameras import CALIBRATED, CAMERAS, camera_of
from helpers.scenes import closed_box, quad

import photonmap as pm
from photonmap.compile.camera import compile_camera
from photonmap.compile.frame import Frame
from photonmap.kernels.camera.cameras import generate_lens_ray
from photonmap.kernels.core.jit import kernel
from photonmap.scene.camera import check_camera, frame_of
from photonmap.scene.projections import distort, fisheye_radius

SIZE = (32, 24)


def in_frame(camera, points):
    """Coordinates along right, down and view."""
    view, right, up = frame_of(camera)
    return points @ np.stack([right, -up, view], axis=1)


def project(camera, points, size):
    """Film points of world points, by the camera's record and the formulas of OpenCV's manual."""
    described = camera.describe(*size)
    pose = np.linalg.inv(np.array(described["camera_to_world_opencv"]))
    x, y, z = (points @ pose[:3, :3].T + pose[:3, 3]).T
    if described["kind"] == "panorama":
        across = np.arctan2(x, z) / (2.0 * math.pi) + 0.5
        down = np.arctan2(y, np.hypot(x, z)) / math.pi + 0.5
        return np.stack([across * size[0], down * size[1]], axis=-1)
    matrix = np.array(described["intrinsics"])
    plane = np.stack([x, y], axis=-1)
    if "fisheye" in described["kind"]:
        radius = np.hypot(x, y)
        angle = np.arctan2(radius, z)
        plane *= (fisheye_radius(described["distortion"] or (0, 0, 0, 0), angle) / radius)[:, None]
    elif described["kind"] != "orthographic":
        plane = distort((*described.get("distortion", ()), 0, 0, 0, 0, 0)[:5], plane / z[:, None])[
            0
        ]
    return plane * matrix[[0, 1], [0, 1]] + matrix[:2, 2]


def centres(size):
    y, x = np.mgrid[: size[1], : size[0]] + 0.5
    return np.stack([x, y], axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("size", [SIZE, (20, 33)])
def test_points_on_rays_are_projected_to_their_pixels(name, size):
    camera = camera_of(name)
    rays = pm.camera_rays(camera, size).reshape(-1, 6)
    seen = (rays[:, 3:] != 0.0).any(axis=1)
    points = rays[seen, :3] + 1.7 * rays[seen, 3:]
    np.testing.assert_allclose(project(camera, points, size), centres(size)[seen], atol=1e-9)
    assert seen.all() == (name not in ("fisheye", "all around", "OpenCV fisheye")) or seen.any()


@pytest.mark.parametrize("name", CAMERAS)
def test_a_small_square_is_seen_where_its_middle_is_projected(name):
    camera = camera_of(name)
    rays = pm.camera_rays(camera, SIZE)
    row, column = 7, 20
    origin, direction = rays[row, column, :3], rays[row, column, 3:]
    direction = direction / np.linalg.norm(direction)
    middle = origin + 2.0 * direction
    beside = np.cross(direction, (0.3, 0.5, 0.8))
    beside *= 0.01 / np.linalg.norm(beside)
    over = np.cross(beside, direction)
    square = quad(middle - beside - over, middle + beside - over, middle + beside + over,
                  middle - beside + over, pm.Material("square", 0.5))  # fmt: skip
    far = 30.0 * np.array([-1.0, 1.0])
    room = closed_box(pm.Material("room", 0.5), *far)
    scene = pm.Scene([room, square], [pm.PointLight((0, 0, 0))], camera)
    result = pm.render(scene, size=SIZE, bands=1, passes=1, photons=100)
    shown = np.argwhere(result.object_id == 2)
    assert shown.tolist() == [[row, column]]
    depth = (middle - np.array(camera.origin)) @ frame_of(camera)[0]
    away = 2.0 if name in ("fisheye", "all around", "OpenCV fisheye", "panorama") else depth
    assert result.distance[row, column] == pytest.approx(2.0, rel=1e-5)
    assert result.depth[row, column] == pytest.approx(away, rel=1e-5)


def test_distortion_is_inverted_all_over_a_large_image():
    """Strong, off-centre, tangential: OpenCV's formula takes every ray back to its pixel."""
    strong = pm.Intrinsics(
        420.0, CALIBRATED, 450.0, 300.0, 260.0, (-0.2, 0.04, 0.004, 0.003, -0.002)
    )
    camera = check_camera(pm.Camera((0, 0, 1), (0, 0, 0), projection=strong))
    rays = pm.camera_rays(camera, CALIBRATED).reshape(-1, 6)
    x, y, z = in_frame(camera, rays[:, 3:]).T
    moved = distort(strong.coefficients, np.stack([x / z, y / z], axis=-1))[0]
    matrix = strong.matrix(*CALIBRATED)
    np.testing.assert_allclose(
        moved * matrix[[0, 1], [0, 1]] + matrix[:2, 2], centres(CALIBRATED), atol=1e-9
    )


def test_intrinsics_without_shift_or_distortion_are_a_pinhole():
    fov = 2.0 * math.degrees(math.atan(240.0 / 500.0))
    same = pm.Camera((0, 0, 1), (0, 0, 0), projection=pm.Intrinsics(500.0, CALIBRATED))
    pinhole = pm.camera_rays(pm.Camera((0, 0, 1), (0, 0, 0), fov=fov), SIZE)
    np.testing.assert_allclose(pm.camera_rays(same, SIZE), pinhole, atol=1e-12)


def test_intrinsics_scale_with_the_image():
    """Pixel centres of an image of twice the size surround those of the original."""
    small, large = (pm.camera_rays(camera_of("Brown-Conrady"), size) for size in (SIZE, (96, 72)))
    np.testing.assert_allclose(small, large[1::3, 1::3], atol=1e-12)


def test_radius_of_a_fisheye_is_proportional_to_the_angle():
    camera = check_camera(pm.Camera((0, 0, 0), (0, 0, -1), projection=pm.Fisheye(180.0)))
    rays = pm.camera_rays(camera, (21, 21))
    x, y, z = in_frame(camera, rays[..., 3:].reshape(-1, 3)).T
    radius = np.hypot(*(centres((21, 21)) - 10.5).T)
    inside = radius <= 10.5
    np.testing.assert_allclose(
        np.arccos(z[inside]), radius[inside] / 10.5 * math.pi / 2.0, atol=1e-7
    )
    assert (rays[..., 3:].reshape(-1, 3)[~inside] == 0.0).all()
    assert (x == 0.0).sum() > 20
    assert y[0] == 0.0


def test_a_panorama_looks_along_all_axes():
    camera = pm.Camera((1, 2, 3), (1, 2, 2), projection=pm.Panorama())
    record = compile_camera(check_camera(camera), Frame(np.zeros(3), 1.0), (8, 4))
    looks = {
        (4.0, 2.0): (0, 0, -1), (6.0, 2.0): (1, 0, 0), (2.0, 2.0): (-1, 0, 0),
        (0.0, 2.0): (0, 0, 1), (8.0, 2.0): (0, 0, 1), (3.0, 0.0): (0, 1, 0), (5.0, 4.0): (0, -1, 0),
    }  # fmt: skip
    for (x, y), direction in looks.items():
        rays = np.empty((1, 6))
        _fill(record, np.array([[x, y]]), np.uint64(0), rays)
        np.testing.assert_allclose(rays[0], (1, 2, 3, *direction), atol=1e-12)


@kernel
def _fill(camera, points, key, rays):
    for i in range(len(points)):
        ray = generate_lens_ray(camera, points[i, 0], points[i, 1], i, key)
        for axis in range(3):
            rays[i, axis], rays[i, 3 + axis] = ray.origin[axis], ray.direction[axis]


def lens_rays(camera, points, frame=Frame(np.zeros(3), 1.0), size=SIZE):  # noqa: B008
    rays = np.empty((len(points), 6))
    _fill(compile_camera(check_camera(camera), frame, size), np.array(points), np.uint64(5), rays)
    return rays


@pytest.mark.parametrize("name", ["pinhole", "orthographic", "shifted", "Brown-Conrady"])
def test_rays_of_a_lens_meet_where_it_is_focused(name):
    """At the depth of the focus, whatever the film point; they fill the disk evenly."""
    camera = camera_of(name, lens=pm.Lens(focus=2.5, radius=0.2))
    center = np.tile([5.25, 19.5], (4096, 1))
    rays = lens_rays(camera, center, Frame(np.array([1.0, 2.0, 3.0]), 4.0))
    rays[:, :3] = rays[:, :3] * 4.0 + (1.0, 2.0, 3.0)
    through = lens_rays(camera_of(name), center[:1])[0]
    offsets = in_frame(camera, rays[:, :3] - through[:3])
    np.testing.assert_allclose(offsets[:, 2], 0.0, atol=1e-12)
    assert np.hypot(offsets[:, 0], offsets[:, 1]).max() == pytest.approx(0.2, rel=2e-3)
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=1e-3)
    assert (offsets[:, :2] ** 2).sum(axis=1).mean() == pytest.approx(0.5 * 0.2**2, rel=1e-2)
    direction = in_frame(camera, rays[:, 3:])
    focused = rays[:, :3] + (2.5 / direction[:, 2])[:, None] * rays[:, 3:]
    ahead = in_frame(camera, through[None, 3:])[0, 2]
    expected = through[:3] + 2.5 / ahead * through[3:]
    np.testing.assert_allclose(focused, np.tile(expected, (4096, 1)), atol=1e-10)


@pytest.mark.parametrize("blades", [3, 6])
def test_blades_make_a_polygon(blades):
    camera = camera_of("pinhole", lens=pm.Lens(2.0, 0.5, blades=blades, rotation=90.0))
    rays = lens_rays(camera, np.tile([3.0, 4.0], (8192, 1)))
    right, down, _ = in_frame(camera, rays[:, :3] - camera.origin).T
    turn = np.exp(-1j * math.pi / 2.0) * (right - 1j * down)
    sides = np.arange(blades) * 2.0 * math.pi / blades + math.pi / blades
    reach = (turn[:, None] * np.exp(-1j * sides)).real.max(axis=1)
    apothem = 0.5 * math.cos(math.pi / blades)
    assert reach.max() <= apothem + 1e-12
    assert (reach <= 0.5 * apothem).mean() == pytest.approx(0.25, abs=0.01)
    assert abs(turn.mean()) < 5e-3


def test_an_f_number_is_focal_length_over_diameter():
    assert pm.Lens(2.0, f_number=2.0, focal_length=0.05).opening == 0.0125


def test_the_eye_is_the_point_that_all_rays_leave():
    for name in CAMERAS:
        assert (camera_of(name).eye is None) == (name == "orthographic")
    assert camera_of("pinhole", lens=pm.Lens(1.0, 0.1)).eye is None
    one, other = (pm.camera_rays(camera_of(name), (3, 2)) for name in ("pinhole", "orthographic"))
    place = {"origin": (0, 0, 1), "target": (0, 0, 0)}
    assert pm.Camera(**place, projection=pm.RayMap(one)).eye == camera_of("pinhole").origin
    assert pm.Camera(**place, projection=pm.RayMap(other)).eye is None
    assert camera_of("panorama").changed(fov=30.0).model.kind == "pinhole"
