import numpy as np
import pytest

from photonmap.camera import check_camera
from photonmap.errors import InputError
from photonmap.readers.scene_file import load_scene
from photonmap.scene import Camera

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
CAMERA = "[camera]\norigin = [0, 1, 5]\ntarget = [0.5, 0, 0]\n"


@pytest.fixture
def load(tmp_path):
    def load(toml=None, name="room.obj"):
        (tmp_path / name).write_text(TRIANGLE)
        if toml is not None:
            toml = toml if isinstance(toml, bytes) else toml.encode()
            (tmp_path / "room.toml").write_bytes(toml)
        return load_scene(tmp_path / name)

    return load


@pytest.mark.parametrize("toml", [None, "", "# no camera\n"])
def test_without_camera(load, toml):
    scene = load(toml)
    assert (scene.name, scene.camera, scene.lights) == ("room", None, [])
    assert [mesh.name for mesh in scene.meshes] == ["room"]


@pytest.mark.parametrize(
    ("toml", "up", "fov"),
    [
        (CAMERA, (0, 1, 0), 40),
        (CAMERA + "up = [0, 0, 2]\nfov = 90\n", (0, 0, 2), 90),
        ("\ufeff" + CAMERA.replace("\n", "\r\n"), (0, 1, 0), 40),
        ("camera = {origin = [0, 1, 5], target = [0.5, 0, 0]}", (0, 1, 0), 40),
    ],
)
def test_camera(load, toml, up, fov):
    camera = load(toml).camera
    assert camera == Camera((0, 1, 5), (0.5, 0, 0), up, fov)
    assert all(type(x) is float for x in (*camera.origin, *camera.target, *camera.up, camera.fov))


def test_suffix_in_capitals(load):
    assert load(CAMERA, "room.OBJ").camera is not None


@pytest.mark.parametrize("name", ["room.fbx", "room", "obj"])
def test_unknown_kind(load, name):
    with pytest.raises(InputError, match=rf"{name}: .*supported: \.obj, \.toml"):
        load(name=name)


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (CAMERA + "[cameras]\n", r":4: section 'cameras' .*did you mean 'camera'\?"),
        (CAMERA + "fow = 3\n", r":4: \[camera\] key 'fow' .*did you mean 'fov'\?"),
        ("# camera.\n\n[Camera]\n", r":3: section 'Camera' .*'camera'\?"),
        ("camera = 3\n", r":1: camera is no section; write \[camera\]"),
        ("\n[[camera]]\nfov = 3\n", r":2: camera is no section"),
        (
            "[camera]\ntarget = [0, 0, 0]\n",
            r":1: \[camera\] lacks origin; add origin = \[x, y, z\]",
        ),
        ("[camera]\norigin = [0, 0, 0]\n", r":1: \[camera\] lacks target"),
        (CAMERA + "fov = \n", r":4: is not valid TOML: Invalid value"),
        (CAMERA + "fov = [1,\n", r":4: is not valid TOML"),
        (CAMERA + "fov = 3\nfov = 4\n", r":5: is not valid TOML"),
        ("x = " + "[" * 100_000, r": is not valid TOML"),
        (CAMERA + "fov = " + "9" * 5000 + "\n", r": is not valid TOML"),
        (CAMERA + "fov = 0x" + "f" * 5000 + "\n", r":4: camera fov a number of thousands"),
        (CAMERA.encode() + b"# T\xfcr\n", r":4: is not in UTF-8"),
        (CAMERA + "fov = 180\n", r":4: camera fov 180 .*between 0 and 180"),
        (CAMERA + "fov = 0\n", r":4: camera fov 0 "),
        (CAMERA + "fov = nan\n", r":4: camera fov nan "),
        (CAMERA + "fov = true\n", r":4: camera fov True "),
        (CAMERA + 'fov = "wide"\n', r":4: camera fov 'wide' "),
        (CAMERA + "up = [0, 0, 0]\n", r":4: camera up \[0, 0, 0\] is zero or along the view"),
        (CAMERA + "up = [-1, 2, 10]\n", r":4: camera up .*along the view"),
        (CAMERA + "up = [0, 1]\n", r":4: camera up \[0, 1\] .*three finite numbers"),
        (CAMERA.replace("5]", "inf]"), r":2: camera origin \[0, 1, inf\] .*three finite numbers"),
        (CAMERA.replace("[0, 1, 5]", "3"), r":2: camera origin 3 .*three finite numbers"),
        (CAMERA.replace("0.5", '"x"'), r":3: camera target \['x', 0, 0\] .*three finite"),
        (CAMERA.replace("[0, 1, 5]", "[0.5, 0, 0]"), r":3: camera target .*move one of them"),
    ],
)
def test_errors_name_line_value_and_remedy(load, toml, message):
    with pytest.raises(InputError, match=r"room\.toml" + message):
        load(toml)


def test_toml_is_a_directory(load, tmp_path):
    (tmp_path / "room.toml").mkdir()
    with pytest.raises(InputError, match=r"room\.toml: cannot be read"):
        load()


def test_missing_scene(tmp_path):
    with pytest.raises(InputError, match=r"none\.obj: cannot be read"):
        load_scene(tmp_path / "none.obj")


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_camera_of_any_scale(scale):
    origin, target = (0.0, 0.0, -scale), (0.0, 0.0, scale)
    camera = check_camera(Camera(origin, target, (0.0, scale, 0.0)))
    assert (camera.origin, camera.target) == (origin, target)


def test_camera_takes_arrays():
    camera = check_camera(Camera(np.zeros(3), np.ones(3, np.float32), [0, 1, 0], np.float64(30)))
    assert camera == Camera((0, 0, 0), (1, 1, 1), (0, 1, 0), 30)


def test_camera_without_file():
    with pytest.raises(InputError, match=r"^camera fov 200"):
        check_camera(Camera((0, 0, 0), (0, 0, 1), fov=200))
