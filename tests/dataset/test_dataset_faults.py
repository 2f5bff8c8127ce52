"""What may go wrong while a data set is made or changed, and is noticed at once."""

import dataclasses
import hashlib
import json
import re
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files.image_files import BANDS_EXR
from photonmap.dataset.files.manifest import lines_of, locked
from photonmap.dataset.jobs import render_image, schedule
from photonmap.dataset.jobs import verify as verify_module
from photonmap.dataset.jobs.job_scene import make_scene
from photonmap.dataset.jobs.make_dataset import describe_dataset
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.verify import verify
from photonmap.dataset.scenes import view_search
from photonmap.dataset.scenes.views import View
from photonmap.integrators.look import Onlooker

SIZE = ["--size", "16x12", "--bands", "3", "--error", "0.5", "--quiet"]
COMMON = CommonSettings((16, 12), "3", "0.5", inputs="0")


@pytest.fixture
def one(tmp_path):
    """The preset of one image."""
    path = tmp_path / "one.toml"
    path.write_text('scenes = ["jug"]\nilluminations = ["white"]')
    return str(path)


def test_a_file_that_cannot_be_read_is_left_out(tmp_path, capsys):
    pm.save_scene(pm.scenes.cornell_box(), tmp_path / "room.obj")
    (tmp_path / "broken.obj").write_text("v 0 0\nf 1 2 3\n")
    (tmp_path / "unseen.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = tmp_path / "own.toml"
    path.write_text('files = ["broken.obj", "room.obj", "unseen.obj"]\nilluminations = ["white"]')
    assert main(["dataset", str(tmp_path / "set"), "--preset", str(path), *SIZE]) == 1
    broken, unseen = capsys.readouterr().err.splitlines()
    assert "photonmap: failed: " in broken
    assert "broken.obj:1" in broken
    assert "unseen.obj: has no camera; add [camera] to its TOML file" in unseen
    assert len(dataset.open(tmp_path / "set")) == 1
    path.write_text('files = ["broken.obj"]')
    assert main(["dataset", str(tmp_path / "none"), "--preset", str(path), *SIZE]) == 2
    assert not (tmp_path / "none").exists()


def test_what_is_left_out_is_named_until_it_is_mended(tmp_path, capsys):
    folder = tmp_path / "set"
    pm.save_scene(pm.scenes.cornell_box(), tmp_path / "room.obj")
    broken = [tmp_path / "broken-1.obj", tmp_path / "broken-2.obj"]
    for each in broken:
        each.write_text("v 0 0\nf 1 2 3\n")
    path = tmp_path / "own.toml"
    path.write_text('files = ["."]\nilluminations = ["white"]')
    make = ["dataset", str(folder), "--preset", str(path), *SIZE]
    publish = ["dataset", "publish", str(folder), "--license", "CC0-1.0"]
    warning = r"2 files are missing from the set, as \.\./broken-1\.obj and 1 more could"
    assert main(make) == 1
    with pytest.warns(pm.SceneWarning, match=warning):
        assert verify(folder, sample=0) == []
    capsys.readouterr()
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)  # which are errors in tests
        assert main([*publish, "--quiet"]) == 0
    assert re.search(warning, capsys.readouterr().err)
    for name in ("manifest.json", "report.html", "README.md"):
        assert "broken-2.obj" in (folder / name).read_text()
    first, second = lines_of(dataset.open(folder).head)
    assert first.startswith("../broken-1.obj:1: ")
    assert f"- {second}" in (folder / "README.md").read_text()
    pm.save_scene(pm.scenes.cornell_box(), broken[0])
    broken[1].unlink()
    assert main([*make, "--resume"]) == 0
    head = json.loads((folder / "manifest.json").read_text())
    assert lines_of(head) == []
    assert len(dataset.open(folder)) == 2
    assert "broken-2" not in (folder / "report.html").read_text()
    del head["left_out"]  # as in sets of before
    assert lines_of(head) == []


def test_warnings_of_scene_files_come_once(tmp_path, capsys):
    """When the set is planned, and not again with each image."""
    pm.save_scene(pm.scenes.cornell_box(), tmp_path / "room.obj")
    with (tmp_path / "room.obj").open("a") as file:
        file.write("v 9 9 9\n")
    path = tmp_path / "own.toml"
    path.write_text('files = ["room.obj"]\nilluminations = ["white"]')
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)  # which are errors in tests
        assert main(["dataset", str(tmp_path / "set"), "--preset", str(path), *SIZE]) == 0
    assert capsys.readouterr().err.count("vertices are in no face") == 1


@pytest.mark.filterwarnings("ignore:.*has fewer light groups")
def test_images_that_are_no_longer_asked_for(tmp_path, capsys):
    """Finished ones stay; the list of the set forgets those that were not."""
    folder, path = tmp_path / "set", tmp_path / "own.toml"
    for name in ("room", "bare"):
        pm.save_scene(pm.scenes.cornell_box(), tmp_path / f"{name}.obj")
    make = ["dataset", str(folder), "--preset", str(path), *SIZE]
    both = 'illuminations = ["white", "two_mixed"]'  # of which a box with one lamp has the first
    path.write_text(f'files = ["room.obj", "bare.obj"]\n{both}')
    assert main(make) == 1
    path.write_text('files = ["room.obj"]\nilluminations = ["white"]')
    kept = r"set: images of earlier runs .* stay in the set \(1: bare-0-white-\w+\)"
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)  # which are errors in tests
        capsys.readouterr()
        assert main([*make, "--resume"]) == 0
        lost = r"; those .* leave its list \(2: room-0-two_mixed-\w+ and 1 more\)$"
        assert re.search(kept + lost, capsys.readouterr().err, re.M)
        lines = folder / "manifest.jsonl"
        lines.write_bytes(lines.read_bytes()[:-50])  # a full disk took a part of an entry
        with pytest.raises(pm.InputError, match=r"jsonl: cannot be read .* with --resume"):
            dataset.open(folder)
        assert main([*make, "--resume"]) == 0
        assert re.search(kept + "$", capsys.readouterr().err, re.M)
    images = dataset.open(folder)
    assert sorted(images.head["images"]) == sorted(image.name for image in images)
    assert [image.name.partition("-")[0] for image in images] == ["room", "bare"]
    assert verify(folder, sample=0) == []


def test_a_set_names_no_folder_of_its_machine(tmp_path):
    """It may be moved with the scenes that it is made from, and is verified there."""
    home = tmp_path / "home-of-someone"
    home.mkdir()
    pm.save_scene(pm.scenes.cornell_box(), home / "room.obj")
    (home / "own.toml").write_text('files = ["room.obj"]\nilluminations = ["white"]')
    preset, folder = str(home / "own.toml"), home / "set"
    assert main(["dataset", str(folder), "--preset", preset, "--format", "exr", *SIZE]) == 0
    for file in folder.rglob("*"):
        if file.is_file():
            assert b"home-of-someone" not in file.read_bytes(), file.name
    moved = home.rename(tmp_path / "elsewhere") / "set"
    assert dataset.open(moved)[0].entry["job"]["scene"] == "../room.obj"
    assert verify(moved, sample=1) == []


def test_measured_sets_keep_their_names_alone(tmp_path):
    """Those of a job are seen from the set's folder; the set's own head has just their names."""
    common = dataclasses.replace(COMMON, munsell=str(tmp_path / "chips" / "m.mat"))
    head = describe_dataset(str(tmp_path / "p.toml"), common, ["exr"], [])
    assert (head["preset"], head["common"]["munsell"]) == ("p.toml", "m.mat")
    job = plan_jobs(Preset("one", ("jug",), illuminations=("white",)), [], common)[0]
    described = job.relative_to(tmp_path / "set")
    assert described.common.munsell == "../chips/m.mat"
    assert described.digest == job.digest
    assert described.located(tmp_path / "set") == job


def test_after_a_full_disk_nothing_more_is_rendered(tmp_path, monkeypatch, capsys):
    tried = []

    def fail(task):
        tried.append(task)
        raise OSError("[Errno 28] No space left on device")

    monkeypatch.setattr(schedule, "render_image", fail)
    assert main(["dataset", str(tmp_path / "set"), "--preset", "small", *SIZE]) == 1
    assert len(tried) == 1
    assert "as the disk is full; free some space" in capsys.readouterr().err


STAGES = ("build", "compile", "render", "write")
JSON_VALUES = st.one_of(st.floats(), st.integers(), st.booleans(), st.none(), st.text(max_size=3))


@given(st.dictionaries(st.sampled_from(STAGES), JSON_VALUES), JSON_VALUES)
@example(dict.fromkeys(STAGES, 1.5), 2.0)
@example(dict.fromkeys(STAGES, 1e300), 2.0)
def test_seconds_out_of_range_are_damage(tmp_path_factory, seconds, cpu_seconds):
    """Costs of a run that is resumed are sums of them."""
    folder = tmp_path_factory.mktemp("set") / "image"
    folder.mkdir()
    entry = {"name": "image", "files": {}, "seconds": seconds, "cpu_seconds": cpu_seconds}
    (folder / "entry.json").write_text(json.dumps(entry))
    values = [*seconds.values(), cpu_seconds]
    are_sound = len(seconds) == len(STAGES) and all(
        isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1e9
        for value in values
    )
    assert (render_image.read_entry(folder) is not None) == are_sound


def test_two_runs_do_not_meet(tmp_path, one, capsys):
    folder = tmp_path / "set"
    folder.mkdir()
    with locked(folder):
        assert main(["dataset", str(folder), "--preset", one, *SIZE]) == 2
        assert "another run is making this data set" in capsys.readouterr().err
        assert not list(folder.iterdir())
    code = (
        "import sys, time; from pathlib import Path;"
        "from photonmap.dataset.files.manifest import locked\n"
        "with locked(Path(sys.argv[1])):\n print('locked', flush=True); time.sleep(60)"
    )
    command = [sys.executable, "-c", code, str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"locked\n"
        assert main(["dataset", str(folder), "--preset", one, *SIZE]) == 2
        other.kill()
    (folder / ".DS_Store").write_text("x")
    assert main(["dataset", str(folder), "--preset", one, *SIZE]) == 0


@pytest.mark.filterwarnings("ignore:.*the camera sees nothing")
def test_an_image_without_light_is_refused(tmp_path, monkeypatch):
    preset = Preset("one", ("jug",), illuminations=("white",))
    [job] = plan_jobs(preset, [], COMMON)
    lit = make_scene(job)
    dark = dataclasses.replace(
        lit,
        meshes=[
            dataclasses.replace(mesh, material=dataclasses.replace(mesh.material, emission=0.0))
            for mesh in lit.meshes
        ],
        lights=[pm.PointLight((0.0, 0.0, -1e3), 1e-9)],
        camera=pm.Camera((0.0, 1e3, 0.0), (0.0, 2e3, 0.0), up=(1.0, 0.0, 0.0)),
    )
    monkeypatch.setattr(render_image, "make_scene", lambda job: dark)
    with pytest.raises(pm.InputError, match="shows no light; choose another view"):
        render_image.render_image(render_image.Task(job, str(tmp_path), ("exr",)))
    assert not list(tmp_path.iterdir())


def test_verify_traces_rays_and_reads_every_format(tmp_path, one):
    """A value that was changed along with its hash, where no image is rendered again."""
    made = tmp_path / "set"
    assert main(["dataset", str(made), "--preset", one, *SIZE, "--format", "exr,hdf5"]) == 0
    assert verify(made, sample=0) == []
    [image] = dataset.open(made)
    result = image.result
    before = shutil.copytree(image.folder, tmp_path / "before")
    result.buffers["depth"] = result.depth.copy()
    result.buffers["depth"][3, 4] += 1e-3
    result.save_exr(image.folder / BANDS_EXR)
    rewrite_hash(made, image, BANDS_EXR)
    faults = verify(made, sample=0)
    assert any("rays traced again give other values: depth" in fault for fault in faults)
    assert any("bands.hdf5 has other arrays than the image: depth" in fault for fault in faults)
    shutil.copy(before / BANDS_EXR, image.folder / BANDS_EXR)
    rewrite_hash(made, image, BANDS_EXR)
    assert verify(made, sample=0) == []
    place = "images/scene_cam_00_final_hdf5/frame.0000.color.hdf5"
    (image.folder / place).write_bytes(b"damaged")
    rewrite_hash(made, image, place)
    assert any("color.hdf5: is damaged" in fault for fault in verify(made, sample=0))


def rewrite_hash(folder, image, name):
    """Make the manifest agree with a changed file."""
    [image] = dataset.open(folder)
    digest = hashlib.sha256((image.folder / name).read_bytes()).hexdigest()
    image.entry["files"][name] = digest
    (folder / "manifest.jsonl").write_text(json.dumps(image.entry) + "\n")


def test_verify_draws_another_sample_each_time(tmp_path, monkeypatch):
    preset = tmp_path / "two.toml"
    preset.write_text('scenes = ["jug", "bowl"]\nilluminations = ["white"]')
    assert main(["dataset", str(tmp_path / "set"), "--preset", str(preset), *SIZE]) == 0
    drawn = []
    monkeypatch.setattr(verify_module, "_faults", lambda image, head, log, find: [])
    monkeypatch.setattr(
        verify_module, "_render_again", lambda image, log, find: drawn.append(image.name) or []
    )
    for _ in range(30):
        verify(tmp_path / "set")
    assert len(set(drawn)) > 1
    assert verify(tmp_path / "set", seed=1) == verify(tmp_path / "set", seed=1) == []
    assert drawn[-1] == drawn[-2]


@pytest.mark.parametrize("scene", ["bedroom", pytest.param("kitchen", marks=pytest.mark.slow)])
def test_views_are_kept_inside_and_clear(scene):
    """The way from the scene's own camera is free, and things are seen, as rays say."""
    for view in (View("left", 20.0, -5.0, 1.1), View("far", -150.0, 0.0, 1.5)):
        preset = Preset("one", (scene,), illuminations=("white", "colored"), views=(view,))
        lit, relit = (make_scene(job) for job in plan_jobs(preset, [], COMMON))
        assert lit.camera == relit.camera
        own = make_scene(plan_jobs(dataclasses.replace(preset, views=(View(),)), [], COMMON)[0])
        low, high = bounds(own)
        assert (low < lit.camera.origin).all()
        assert (high > lit.camera.origin).all()
        onlooker = Onlooker(lit)
        seen = onlooker.see(lit.camera, (32, 24))
        usual = onlooker.see(own.camera, (32, 24))
        count = [len(np.unique(image["object_id"])) for image in (seen, usual)]
        assert count[0] >= 0.4 * count[1]
        assert np.median(seen["distance"]) > 0.3 * np.median(usual["distance"])


def bounds(scene):
    vertices = np.concatenate([mesh.vertices for mesh in scene.meshes])
    return vertices.min(axis=0), vertices.max(axis=0)


def test_a_view_that_nothing_is_good_for_says_so(monkeypatch):
    scene = pm.scenes.cornell_box()
    monkeypatch.setattr(view_search, "TRIES", 3)
    with pytest.raises(pm.InputError, match="3 cameras near it are inside walls or see too"):
        view_search.find_camera(View("in", distance=1e12), scene, "box")
