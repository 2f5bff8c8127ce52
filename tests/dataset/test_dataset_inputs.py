"""The files that a data set is made from: what is in them counts, not where they are."""

import dataclasses
import json
import shutil

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs.job_scene import describe_inputs
from photonmap.dataset.jobs.plan import TEXT, CommonSettings, Job, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.verify import verify

SIZE = ["--size", "12x8", "--error", "0.9", "--format", "exr", "--quiet"]
ROWS = "\n".join(f"{nm},{nm - 390},{720 - 0.5 * nm},{710 - nm}" for nm in range(400, 701, 10))
PRESET = Preset("one", ("jug",), illuminations=("white",))


@pytest.fixture(scope="module")
def sets(tmp_path_factory):
    """The same set, made in two places with the same files under other names."""
    made = []
    for name in ("one", "two"):
        home = tmp_path_factory.mktemp(f"someones-{name}")
        curves, rooms = home / "curves", home / "far" / "rooms"
        curves.mkdir()
        rooms.mkdir(parents=True)
        pm.save_scene(pm.scenes.cornell_box(), rooms / "room.obj")
        (curves / f"{name}.csv").write_text(f"nm,r,g,b\n{ROWS}\n")
        (home / "own.toml").write_text('files = ["far/rooms/room.obj"]\nilluminations = ["white"]')
        folder = home / "sets" / "all" / "set"
        folder.parent.mkdir(parents=True)
        camera = str(curves / f"{name}.csv")
        files = ["--bands", camera, "--rgb", camera, "--sensor", camera]
        preset = ["--preset", str(home / "own.toml")]
        assert main(["dataset", str(folder), *preset, *files, *SIZE]) == 0
        made.append((home, folder, [*preset, *files]))
    return made


def test_names_and_places_do_not_change_a_bit(sets):
    first, second = (dataset.open(folder)[0] for _, folder, _ in sets)
    assert first.name == second.name
    assert first.entry["render_seed"] == second.entry["render_seed"]
    assert first.entry["arrays"] == second.entry["arrays"]
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])


def test_no_file_tells_of_the_machine(sets):
    _, folder, _ = sets[0]
    for file in folder.rglob("*"):
        if file.is_file():
            assert b"someones" not in file.read_bytes(), file.name
            assert b"../.." not in file.read_bytes(), file.name
    entry = dataset.open(folder)[0].entry
    assert entry["job"]["scene"] == "room.obj"
    assert entry["job"]["common"]["bands"] == "inputs/bands/one.csv"
    assert entry["rgb"]["space"] == "inputs/rgb/one.csv"
    assert (folder / "inputs" / "sensor" / "one.csv").is_file()


def test_a_set_is_verified_elsewhere(sets, tmp_path):
    home, folder, _ = sets[0]
    moved = shutil.copytree(folder, tmp_path / "moved")
    assert verify(moved, sample=1, scenes=home) == []
    lines = []
    [fault] = verify(moved, sample=0, log=lines.append)
    assert lines[-1].endswith("geometry and errors checked, 1 fault")
    assert "the scene room.obj is not there; say where with --scenes DIR" in fault
    (tmp_path / "others").mkdir()
    box = pm.scenes.cornell_box()
    pm.save_scene(dataclasses.replace(box, meshes=box.meshes[1:]), tmp_path / "others" / "room.obj")
    [fault] = verify(moved, sample=0, scenes=tmp_path / "others")
    assert "holds no scene room.obj that the set was made from" in fault
    (moved / dataset.open(moved)[0].name / "rgb.exr").unlink()
    assert dataset.open(moved)[0].rgb["radiance"].shape == (8, 12, 3)


def test_a_file_of_another_name_resumes(sets, capsys):
    _, folder, _ = sets[0]
    home, _, options = sets[1]
    assert main(["dataset", str(folder), *options, *SIZE, "--resume", "--dry-run"]) == 0
    other = home / "other.csv"
    other.write_text(f"nm,r,g,b\n{ROWS}\n".replace("400,10,", "400,11,"))
    changed = [str(other) if option.endswith(".csv") else option for option in options]
    assert main(["dataset", str(folder), *changed, *SIZE, "--resume", "--dry-run"]) == 2
    assert "with other curves of bands or measured sets" in capsys.readouterr().err


def test_a_set_is_resumed_with_its_own_options(sets, tmp_path, capsys):
    _, folder, options = sets[0]
    files = ["--preset", options[1], "--sensor", options[-1]]
    assert main(["dataset", str(folder), *files, "--resume", "--dry-run"]) == 0
    assert "images of 12x8, bands " in capsys.readouterr().out
    assert main(["dataset", str(folder), *files, "--resume", "--dry-run", "--size", "8x8"]) == 2
    assert "begun with --size 12x8, not 8x8; choose" in capsys.readouterr().err
    folder, given = tmp_path / "drawn", ["--preset", str(tmp_path / "jug.toml")]
    (tmp_path / "jug.toml").write_text('scenes = ["jug"]')
    drawn = ["--illuminations", "white", "--count", "2", "--seed", "7", "--lightness", "0.4"]
    assert main(["dataset", str(folder), *given, *drawn, *SIZE, "--bands", "3"]) == 0
    assert main(["dataset", str(folder), *given, "--resume", "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert "2 images of 12x8, bands 3, error 0.9" in told
    assert all(image.name in told for image in dataset.open(folder))


def test_an_old_set_keeps_its_names(sets):
    """Its jobs are identified by how files were written, as they were when it was made."""
    _, folder, _ = sets[0]
    camera = str(folder / "inputs" / "bands" / "one.csv")
    common = CommonSettings((12, 8), camera, "0.9", rgb=camera, inputs="0", identity=TEXT)
    job = plan_jobs(PRESET, [], common)[0]
    old = job.describe()
    del old["common"]["identity"]
    assert Job.from_description(json.loads(json.dumps(old))) == job
    assert job.relative_to(folder).common.bands == camera
    elsewhere = dataclasses.replace(common, rgb="/x/one.csv")
    assert dataclasses.replace(job, common=elsewhere).digest != job.digest


def test_plain_sets_keep_their_names():
    """No image of a set without files changes: its name is that of before."""
    new = CommonSettings((16, 12), "3", "0.5", inputs="0")
    old = dataclasses.replace(new, identity=TEXT)
    first, second = (plan_jobs(PRESET, [], common)[0].digest for common in (new, old))
    assert first == second


def test_measured_sets_are_found_again(tmp_path, monkeypatch):
    rows = "\n".join(f"{nm},1.0" for nm in range(380, 781, 10))
    digests = set()
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(f"nm,even\n{rows}\n")
        common = CommonSettings((16, 12), "3", "0.5", illuminants=str(tmp_path / name))
        digests.add(describe_inputs(common).inputs)
    assert len(digests) == 1
    assert digests != {describe_inputs(dataclasses.replace(common, identity=TEXT)).inputs}
