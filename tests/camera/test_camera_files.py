"""Cameras in files and commands: round trips, several of them, ray maps, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import OpenImageIO
import pytest
from helpers.scenes import closed_box

import photonmap as pm
from photonmap.commands.main import main
from photonmap.scene.camera import check_camera
from photonmap.scene.projections import CHANNELS, save_rays

POSE = {"origin": (0.1, 0.2, 0.9), "target": (0.0, 0.1, -0.5), "up": (0.1, 1.0, 0.0)}
ROOM = closed_box(pm.Material("room", 0.5))
LAMP = pm.PointLight((0.3, 0.5, 0.1))
BROWN = pm.Intrinsics(500.5, (640, 480), 490.0, 330.0, 228.0, (-0.3, 0.1, 0.001, -0.002))
KINDS = {
    "pinhole": {"fov": 33.0},
    "orthographic": {"height": 1.5},
    "lens": {"lens": pm.Lens(1.2, 0.01, blades=6, rotation=12.5)},
    "f-number": {"lens": pm.Lens(1.2, f_number=2.8, focal_length=0.05)},
    "intrinsics": {"projection": BROWN, "lens": pm.Lens(0.7, 0.1)},
    "fisheye": {"projection": pm.Fisheye(220.0)},
    "OpenCV fisheye": {
        "projection": pm.FisheyeIntrinsics(300.0, (640, 480), distortion=(0.1, 0.0, 0.01, 0.0))
    },
    "panorama": {"projection": pm.Panorama()},
    "ray map": {"projection": pm.RayMap(np.random.default_rng(1).uniform(1, 2, (3, 4, 6)))},
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_saved_is_loaded(tmp_path, kind):
    camera = pm.Camera(**POSE, **KINDS[kind], name="cam")
    pm.save_scene(pm.Scene([ROOM], [LAMP], camera), tmp_path / "room.obj")
    scene = pm.load_scene(tmp_path / "room.obj")
    assert scene.camera == camera
    assert scene.cameras == []


def test_all_cameras_are_saved_and_loaded_in_their_order(tmp_path):
    cameras = [pm.Camera(**POSE, **values, name=kind) for kind, values in KINDS.items()]
    pm.save_scene(pm.Scene([ROOM], [LAMP], cameras=cameras), tmp_path / "room.obj")
    scene = pm.load_scene(tmp_path / "room.obj")
    assert scene.cameras == cameras
    assert scene.camera == cameras[0]
    chosen = scene.seen_by("panorama")
    assert (chosen.camera, len(chosen.every_camera)) == (cameras[7], len(cameras))


def test_a_baseline_makes_a_parallel_pair(tmp_path):
    text = "[camera]\norigin = [0, 0, 0.9]\ntarget = [0, 0, 0]\nname = 'eye'\nbaseline = 0.2\n"
    scene = load(tmp_path, text)
    left, right = scene.cameras
    assert (left.name, right.name) == ("eye_left", "eye_right")
    assert (left.origin, right.origin) == ((-0.1, 0.0, 0.9), (0.1, 0.0, 0.9))
    assert (left.target, right.target) == ((-0.1, 0.0, 0.0), (0.1, 0.0, 0.0))
    assert scene.cameras == list(
        check_camera(pm.Camera((0, 0, 0.9), (0, 0, 0), name="eye")).stereo(0.2)
    )


def test_panoramas_and_fisheyes_make_pairs_too(tmp_path):
    text = ONE + "projection = { type = 'panorama' }\nname = 'around'\nbaseline = 0.2\n"
    left, right = load(tmp_path, text).cameras
    assert (left.model.kind, right.model.kind) == ("panorama", "panorama")
    assert (left.origin, right.origin) == ((-0.1, 0.0, 0.9), (0.1, 0.0, 0.9))


def test_a_fisheye_sees_half_of_all_directions_unless_told_otherwise(tmp_path):
    assert load(tmp_path, ONE + "projection = { type = 'fisheye' }\n").camera.model.fov == 180.0


def test_a_pinhole_in_code_is_orthographic_when_it_is_given_a_height():
    pinhole = pm.Camera((0, 0, 1), (0, 0, 0), fov=50.0)
    assert check_camera(replace(pinhole, height=1.0)).model.kind == "orthographic"


def test_tables_may_be_sections(tmp_path):
    table = "type = 'fisheye'\nfov = {}\n"
    text = "[[camera]]\n" + AT + "name = 'a'\n[camera.projection]\n" + table + "[[camera]]\n" + AT
    text += "name = 'b'\n[camera.lens]\nfocus = 2\nradius = {}\n"
    first, second = load(tmp_path, text.format(90, 0.1)).cameras
    assert (first.projection, second.lens) == (pm.Fisheye(90.0), pm.Lens(2.0, 0.1))
    with pytest.raises(pm.InputError, match=r"room\.toml:5: camera projection fov -1 "):
        load(tmp_path, text.format(-1, 0.1))
    with pytest.raises(pm.InputError, match=r"room\.toml:12: camera lens radius -1 "):
        load(tmp_path, text.format(90, -1))


def load(folder, text):
    pm.save_scene(pm.Scene([ROOM], [LAMP]), folder / "room.obj")
    lights = (folder / "room.toml").read_text()
    (folder / "room.toml").write_text(text + lights)
    return pm.load_scene(folder / "room.obj")


FEW = ["--size", "6x4", "--passes", "1", "--photons", "100", "--bands", "1", "--quiet"]
AT = "origin = [0, 0, 0.9]\ntarget = [0, 0, 0]\n"
ONE = "[camera]\n" + AT
FOLDS = "{ type = 'intrinsics', fx = 300, size = [640, 480], distortion = [-0.6, 0, 0, 0] }"
TURNS = "{ type = 'fisheye intrinsics', fx = 90, size = [640, 480], distortion = [-0.2, 0, 0, 0] }"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ONE + "lens = { radius = 0.1 }\n", ":4: camera lens has no focus distance; add focus"),
        (ONE + "lens = { focus = 1 }\n", ":4: camera lens has no size; add radius, or f_number"),
        (ONE + "lens = { focus = 1, radius = 1, f_number = 2 }\n", ":4: .* give the one or the"),
        (ONE + "lens = { focus = 1, radius = 0 }\n", ":4: camera lens radius 0 .* above 0"),
        (ONE + "lens = { focus = 1, radius = 1, blades = 2 }\n", ":4: camera lens blades 2 .*om 3"),
        (ONE + "lens = { focus = 1, raduis = 1 }\n", ":4: camera lens key 'raduis' .*'radius'"),
        (ONE + "lens = 0.1\n", ":4: camera lens 0.1 is not a lens; write a table"),
        (ONE + "projection = { fov = 90 }\n", ":4: camera projection has no type; add one of"),
        (ONE + "projection = { type = 'fish' }\n", ":4: camera projection type 'fish' .*'fisheye'"),
        (ONE + "projection = { type = 'fisheye', fov = 361 }\n", ":4: .*fov 361 .*above 0 to 360"),
        (ONE + "projection = { type = 'pinhole', fov = 180 }\n", ":4: .*fov 180 .* below 180"),
        (ONE + "projection = { type = 'intrinsics', fx = 1 }\n", ":4: .* lacks size; add size ="),
        (ONE + f"projection = {FOLDS}\n", ":4: camera projection folds inside the image"),
        (ONE + f"projection = {TURNS}\n", ":4: camera projection folds inside the image, at 73.97"),
        (ONE + "projection = { type = 'ray map', file = 'no.npz' }\n", "no.npz.*no such file"),
        (ONE + "fov = 50\nprojection = { type = 'panorama' }\n", ":4: camera fov is given besides"),
        (ONE + "projection = { type = 'panorama' }\nfov = 40\n", ":5: camera fov is given besides"),
        (ONE + "height = 1\nprojection = { type = 'panorama' }\n", ":4: camera height is given b"),
        (ONE + "height = 1\nfov = 40\n", ":5: camera fov is given besides the height .* leave one"),
        (ONE + "projection = { type = 'panorama' }\nlens = { focus = 1, radius = 1 }\n",
         ":5: camera lens does not go with the projection, panorama"),
        (ONE + "baseline = 0\n", ":4: camera baseline 0 is not a baseline; give .* above 0"),
        (ONE + "name = 'a/b'\n", ":4: camera name 'a/b' cannot be part of a file's name"),
        ("[[camera]]\nname = 'a'\n" + AT + "[[camera]]\nname = 'a'\n" + AT,
         ":6: two cameras are named 'a'"),
        ("[[camera]]\nname = 'a'\n" + AT + "[[camera]]\n" + AT, ":5: one of several cameras has"),
        ("[[camera]]\nname = 'a'\n" + AT + "fow = 3\n", r":5: \[\[camera\]\] key 'fow' .*'fov'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    with pytest.raises(pm.InputError, match=f"^[^\n]*{message}[^\n]*$"):
        load(tmp_path, text)


@pytest.mark.parametrize(
    ("rays", "message"),
    [
        (np.ones((4, 6)), r"has shape \(4, 6\); give \(H, W, 6\)"),
        (np.ones((4, 5, 3)), r"has shape \(4, 5, 3\)"),
        (np.full((2, 3, 6), np.nan), "ray at row 0, column 0 that is not finite"),
        (np.eye(6)[None, :, :], "has no direction at row 0, column 0"),
        ("text", "cannot be read"),
        ([[["a"] * 6]], "is not an array of numbers"),
    ],
)
def test_bad_ray_maps_are_refused(rays, message):
    with pytest.raises(pm.InputError, match=message):
        pm.RayMap(rays)


def test_ray_maps_of_another_size_are_refused():
    camera = pm.Camera(**POSE, **KINDS["ray map"])
    with pytest.raises(pm.InputError, match=r"ray map is of 4x3 pixels, .*at a size of 4x3"):
        pm.render(pm.Scene([ROOM], [LAMP], camera), bands=1, size=(4, 4), passes=1)
    with pytest.raises(pm.InputError, match="does not go with a ray map, whose rays do not"):
        camera.stereo(0.1)


def test_nothing_is_written_if_one_of_all_cameras_is_refused(tmp_path, capsys):
    cameras = [pm.Camera(**POSE, name="a"), pm.Camera(**POSE, **KINDS["ray map"], name="b")]
    pm.save_scene(pm.Scene([ROOM], [LAMP], cameras=cameras), tmp_path / "room.obj")
    command = [str(tmp_path / "room.obj"), *FEW, "--camera", "all"]
    assert main([*command, "--output", str(tmp_path / "out.exr")]) == 2
    error = capsys.readouterr().err
    assert error.endswith(
        "camera 'b': its ray map is of 4x3 pixels, and the image of 6x4; render at a size of 4x3\n"
    )
    assert error.count("\n") == 1
    assert not list(tmp_path.glob("out*"))


def test_cameras_of_one_name_are_refused_in_code():
    camera = pm.Camera(**POSE, name="a")
    with pytest.raises(pm.InputError, match=r"^two cameras are named 'a'; name each differently$"):
        pm.Scene([ROOM], [LAMP], cameras=[camera, camera])
    with pytest.raises(pm.InputError, match=r"^one of several cameras has no name; name each$"):
        pm.Scene([ROOM], [LAMP], cameras=[camera, pm.Camera(**POSE)])


def test_ray_maps_are_read_from_npz_and_openexr(tmp_path):
    rays = pm.camera_rays(pm.Camera(**POSE), (5, 4)).astype(np.float32)
    save_rays(rays, tmp_path / "rays.npz")
    file = OpenImageIO.ImageOutput.create(str(tmp_path / "rays.exr"))
    spec = OpenImageIO.ImageSpec(5, 4, 6, OpenImageIO.FLOAT)
    spec.channelnames = CHANNELS
    file.open(str(tmp_path / "rays.exr"), spec)
    file.write_image(rays)
    file.close()
    for name in ("rays.npz", "rays.exr"):
        np.testing.assert_array_equal(pm.RayMap(tmp_path / name).array, rays)
        text = f"[camera]\nprojection = {{ type = 'ray map', file = '{name}' }}\n"
        camera = load(tmp_path, text).camera
        np.testing.assert_array_equal(camera.projection.array, rays)
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    with pytest.raises(pm.InputError, match=r"bad\.npz: is not an NPZ file"):
        pm.RayMap(tmp_path / "bad.npz")


def test_the_command_chooses_a_camera_or_renders_by_all(tmp_path, capsys):
    cameras = [pm.Camera(**POSE, name="front"), *pm.Camera(**POSE, name="eye").stereo(0.1)]
    scene = pm.Scene([ROOM], [LAMP], cameras=cameras)
    pm.save_scene(scene, tmp_path / "room.obj")
    command = [str(tmp_path / "room.obj"), *FEW, "--output", str(tmp_path / "out.exr")]
    names = ["front", "eye_left", "eye_right"]
    assert main([*command, "--camera", "all"]) == 0
    files = {path.name for path in tmp_path.glob("*.exr")}
    assert files == {f"out-{name}.exr" for name in names}
    for name, camera in zip(names, cameras, strict=True):
        record = json.loads((tmp_path / f"out-{name}.json").read_text())["camera"]
        assert (record["name"], record["origin"]) == (name, list(camera.origin))
    state = str(tmp_path / "state")
    for more in (["--checkpoint"], ["--checkpoint", state]):
        assert main([*command, "--camera", "all", *more]) == 0
    for name in names:
        assert (tmp_path / f"out-{name}.checkpoint").is_file()
        assert (tmp_path / f"state-{name}").is_file()
    assert main([*command, "--camera", "eye_right"]) == 0
    one, other = (pm.load_result(tmp_path / f"out{end}.exr") for end in ("", "-eye_right"))
    np.testing.assert_array_equal(one.radiance, other.radiance)
    assert main([*command, "--camera", "all", "--threads", "-1"]) != 0
    assert "threads -1 must be a whole number" in capsys.readouterr().err
    assert main([*command, "--camera", "frond"]) != 0
    error = capsys.readouterr().err
    assert "there is no camera 'frond'; the scene has 'front', 'eye_left', 'eye_right'" in error


def test_python_renders_by_any_camera():
    cameras = [pm.Camera(**POSE, name="a"), pm.Camera(**POSE, height=1.0, name="b")]
    scene = pm.Scene([ROOM], [LAMP], cameras=cameras)
    few = {"size": (4, 3), "bands": 1, "passes": 1, "photons": 100}
    kinds = [pm.render(scene.seen_by(name), **few).record["camera"]["kind"] for name in "ab"]
    assert kinds == ["pinhole", "orthographic"]
    with pytest.raises(pm.InputError, match="no camera 'c'; the scene has 'a', 'b'"):
        scene.seen_by("c")
