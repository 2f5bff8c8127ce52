"""The orthographic camera: parallel rays over a known height, in files, commands and pictures."""

import json

import numpy as np
import pytest
from helpers.scenes import closed_box, quad

import photonmap as pm
from photonmap.commands.main import main
from photonmap.compile.camera import compile_camera
from photonmap.compile.frame import Frame
from photonmap.kernels.camera.cameras import generate_ray
from photonmap.kernels.core.jit import kernel
from photonmap.scene.camera import check_camera

METHODS = ("photon", "path")
SETTINGS = {"bands": 1, "passes": 2, "photons": 500, "threads": 2}
FRONT = pm.Camera((0.1, 0.2, 3.0), (0.1, 0.2, 0.0), height=2.0)
LIGHT = pm.PointLight((0.3, -0.1, 1.5), 2.0)


def sheet(half, z=0.0, material=pm.Material("sheet", 0.8)):  # noqa: B008
    return quad((-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z), material)


@kernel
def _fill_rays(camera, x, y, origins, directions):
    for i in range(len(x)):
        ray = generate_ray(camera, x[i], y[i])
        origins[i, 0], origins[i, 1], origins[i, 2] = ray.origin
        directions[i, 0], directions[i, 1], directions[i, 2] = ray.direction


def test_rays_are_parallel_and_a_pixel_is_height_over_rows():
    """Rays leave a plane across the view; the image's middle is the camera's origin."""
    camera = check_camera(pm.Camera((1, 2, 3), (-1, 0.5, 2), (0.1, 1, 0.3), height=2.5))
    frame, width, height = Frame(np.array([0.5, 0.0, -1.0]), 4.0), 30, 20
    record = compile_camera(camera, frame, (width, height))
    x, y = np.array([0.0, width / 2, width / 2 + 1, 7.25, 8.25]), np.array([0.0, 10, 10, 3.5, 4.5])
    origins, directions = np.empty((2, 5, 3))
    _fill_rays(record, x, y, origins, directions)
    view = np.subtract(camera.target, camera.origin)
    view /= np.linalg.norm(view)
    np.testing.assert_allclose(directions, np.broadcast_to(view, (5, 3)), atol=1e-12)
    world = origins * frame.size + frame.center
    np.testing.assert_allclose(world[1], camera.origin, atol=1e-12)
    np.testing.assert_allclose((world - camera.origin) @ view, 0.0, atol=1e-12)
    pixel = 2.5 / height
    assert np.linalg.norm(world[2] - world[1]) == pytest.approx(pixel)
    assert np.linalg.norm(world[4] - world[3]) == pytest.approx(np.sqrt(2.0) * pixel)
    across, down = world[2] - world[1], world[4] - world[3] - (world[2] - world[1])
    right = np.cross(view, camera.up)
    right /= np.linalg.norm(right)
    np.testing.assert_allclose(across, pixel * right, atol=1e-12)
    np.testing.assert_allclose(down, -pixel * np.cross(right, view), atol=1e-12)


def test_a_wall_across_the_view_is_equally_deep_everywhere():
    result = pm.render(pm.Scene([sheet(9.0, -1.0)], [LIGHT], FRONT), **SETTINGS, size=(24, 16))
    np.testing.assert_allclose(result.depth, 4.0, rtol=1e-6)
    np.testing.assert_allclose(result.normal, np.broadcast_to((0, 0, 1), (16, 24, 3)), atol=1e-6)


@pytest.mark.parametrize("distance", [1.5, 3.0, 50.0])
@pytest.mark.parametrize("method", METHODS)
def test_a_square_covers_its_own_size(method, distance):
    """Whatever its distance: of 1.2² scene units, in pixels of height / rows."""
    rows, half = 20, 0.6
    camera = pm.Camera((0.0, 0.0, distance), (0.0, 0.0, 0.0), height=2.0)
    scene = pm.Scene([sheet(half)], [LIGHT], camera)
    result = pm.render(scene, **SETTINGS, size=(30, rows), method=method)
    inside = result.object_id > 0
    assert inside.sum() == 12 * 12
    assert inside[4:16, 9:21].all()
    area = result.coverage.sum(dtype=float) * (2.0 / rows) ** 2
    assert area == pytest.approx((2.0 * half) ** 2, rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_every_pixel_sees_its_own_point(method):
    """Direct light of a point light, in closed form at the centre of each pixel."""
    rows, columns = 10, 14
    scene = pm.Scene([sheet(5.0)], [LIGHT], FRONT)
    result = pm.render(scene, **SETTINGS, size=(columns, rows), pixel="center", method=method)
    y, x = np.mgrid[:rows, :columns] + 0.5
    x = FRONT.origin[0] + (x - columns / 2) * 2.0 / rows
    y = FRONT.origin[1] - (y - rows / 2) * 2.0 / rows
    a, b, height = LIGHT.position
    distance = np.sqrt((x - a) ** 2 + (y - b) ** 2 + height**2)
    truth = 0.8 / np.pi * LIGHT.intensity * height / distance**3
    np.testing.assert_allclose(result.direct[..., 0], truth, rtol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_a_far_pinhole_of_small_angle_sees_the_same(method, cornell):
    """With the same random numbers: the same pictures, but where rays just miss an edge."""
    distance, height = 500.0, 1.7
    near = pm.Camera((0.1, 0.05, 3.0), (0.1, 0.05, 0.0), height=height)
    fov = float(np.degrees(2.0 * np.arctan(0.5 * height / distance)))
    far = pm.Camera((0.1, 0.05, distance), (0.1, 0.05, 0.0), fov=fov)
    first, second = (
        pm.render(
            pm.Scene(cornell.meshes, camera=camera),
            **SETTINGS,
            size=(24, 24),
            method=method,
            seed=2,
        )
        for camera in (near, far)
    )
    assert (first.object_id != second.object_id).mean() < 0.01
    seen = (first.object_id == second.object_id) & (first.object_id > 0)
    step = second.depth[seen] - first.depth[seen] - (distance - 3.0)
    assert np.percentile(np.abs(step), 95) < 0.01
    for name in ("radiance", "direct", "indirect", "reflectance"):
        one, other = first.buffers[name].astype(float), second.buffers[name].astype(float)
        assert np.abs(one - other).sum() < 0.05 * np.abs(one).sum(), name
        close = np.abs(one - other) <= 0.02 * np.abs(one) + 1e-6
        assert close.mean() > 0.9, name


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "tall", True, [2.0]])
def test_bad_heights_are_refused(value):
    with pytest.raises(
        pm.InputError, match=r"^camera height .* is not a height; give [^\n]*above 0"
    ):
        check_camera(pm.Camera((0, 0, 1), (0, 0, 0), height=value))


@pytest.mark.parametrize("value", ["0", "-2.5", "nan", '"tall"'])
def test_bad_heights_in_files_are_refused_with_their_line(tmp_path, value):
    pm.save_scene(pm.Scene([sheet(1.0)]), tmp_path / "room.obj")
    camera = f"[camera]\norigin = [0, 0, 1]\ntarget = [0, 0, 0]\nheight = {value}\n"
    (tmp_path / "room.toml").write_text(camera)
    with pytest.raises(pm.InputError, match=r"room\.toml:4: camera height .* above 0"):
        pm.load_scene(tmp_path / "room.obj")


@pytest.mark.parametrize("size", [{"fov": 33.0}, {"height": 2.0}, {"height": 0.1 + 0.2}])
def test_what_is_saved_is_loaded(tmp_path, size):
    """The angle of a pinhole, or the height of an orthographic camera: not both."""
    camera = pm.Camera((1.0, 2.0, 3.0), (0.0, 0.5, 0.0), (0.1, 1.0, 0.0), **size)
    pm.save_scene(pm.Scene([sheet(1.0)], camera=camera), tmp_path / "room.obj")
    assert pm.load_scene(tmp_path / "room.obj").camera == camera
    text = (tmp_path / "room.toml").read_text()
    assert ("height" in text, "fov" in text) == ("height" in size, "fov" in size)


def test_the_record_describes_the_camera():
    """Its matrix takes scene units to pixels, at any depth."""
    described = check_camera(FRONT).describe(24, 16)
    assert described["height"] == 2.0
    assert "fov" not in described
    assert described["intrinsics"] == [[8.0, 0.0, 12.0], [0.0, 8.0, 8.0], [0.0, 0.0, 1.0]]
    pose = np.array(described["camera_to_world"])
    np.testing.assert_allclose(pose[:3, 3], FRONT.origin)


def test_the_command_renders_it(tmp_path):
    """A scene file's camera is what the command sees by; `--fov` makes a pinhole of it."""
    scene = pm.Scene([closed_box(pm.Material("box", 0.5), -0.5, 0.5)], [LIGHT], FRONT)
    pm.save_scene(scene, tmp_path / "room.obj")
    found = {}
    for name, more in {"own": [], "moved": ["--origin=0,0,5"], "pinhole": ["--fov", "30"]}.items():
        output = tmp_path / f"{name}.exr"
        few = ["--size", "8x8", "--passes", "1", "--photons", "100", "--bands", "1", "--quiet"]
        code = main([str(tmp_path / "room.obj"), *few, *more, "--output", str(output)])
        assert code == 0
        found[name] = json.loads(output.with_suffix(".json").read_text())["camera"]
    assert found["own"]["height"] == 2.0
    assert (found["moved"]["height"], found["moved"]["origin"]) == (2.0, [0.0, 0.0, 5.0])
    assert found["pinhole"]["fov"] == 30.0
    assert "height" not in found["pinhole"]
    again = pm.render(scene, bands=1, size=(8, 8), passes=1, photons=100)
    kept = pm.load_result(tmp_path / "own.exr")
    np.testing.assert_array_equal(kept.radiance, again.radiance)
