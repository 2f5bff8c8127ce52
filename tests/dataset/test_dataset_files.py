"""The folder of a data set: what is written, read, resumed, split and verified."""

import json
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import photonmap as pm
from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.files import image_files, reader
from photonmap.dataset.files.derived_buffers import as_rgb, rgb_residual
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs import render_image, schedule
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.verify import verify
from photonmap.results.record import describe_code
from photonmap.spectra.color_text import ILLUMINANTS

SIZE = ["--size", "16x12", "--bands", "3", "--error", "0.5"]
PRESET = """
scenes = ["jug", "gallery"]
illuminations = ["white", "two_mixed"]
"""


@pytest.fixture(scope="module")
def preset(tmp_path_factory):
    path = tmp_path_factory.mktemp("preset") / "two.toml"
    path.write_text(PRESET)
    return str(path)


@pytest.fixture(scope="module")
def made(tmp_path_factory, preset):
    """A data set of two scenes in two lights, in every format."""
    folder = tmp_path_factory.mktemp("sets") / "made"
    arguments = ["dataset", str(folder), "--preset", preset, *SIZE, "--format", "exr,hdf5,png"]
    assert main([*arguments, "--quiet"]) == 0
    return folder


@pytest.fixture
def copied(made, tmp_path):
    return shutil.copytree(made, tmp_path / "copied")


def command(folder, preset, *more):
    formats = ["--format", "exr,hdf5,png"]
    return main(["dataset", str(folder), "--preset", preset, *SIZE, *formats, *more])


def test_every_image_has_its_arrays(made):
    images = dataset.open(made)
    assert len(images) == 4
    assert [image.geometry for image in images] == ["jug-0", "jug-0", "gallery-0", "gallery-0"]
    for image in images:
        for name in ("radiance", "direct", "indirect", "reflectance", "shading", "illuminant"):
            assert image[name].shape == (12, 16, 3)
            assert image[name].dtype == np.float32
        for name in ("scalar_shading", "depth", "object_id", "material_id"):
            assert image[name].shape == (12, 16)
        for name in ("valid", "light_source", "background"):
            assert image[name].dtype == bool
        assert image["shading.error"].shape == image["normal"].shape == (12, 16, 3)
        groups = [name for name in image if name.startswith("shading@") and "error" not in name]
        assert len(groups) == len(image.entry["lights"]) == len(image.entry["job"]["colors"])
        assert set(groups) <= set(image.rgb)
    for index in ("jug-0", 4):
        with pytest.raises((IndexError, TypeError), match="numbered from 0 to 3"):
            images[index]


def test_hdf5_has_what_exr_has(made, copied):
    (copied / dataset.open(copied)[1].name / image_files.BANDS_EXR).unlink()
    first, second = dataset.open(made)[1], dataset.open(copied)[1]
    assert len(first) > 20
    assert set(first) == set(second)
    for name, array in first.items():
        np.testing.assert_array_equal(array, second[name])
    (second.folder / image_files.RGB_EXR).unlink()
    for name, array in first.rgb.items():  # computed from bands that were rounded
        np.testing.assert_allclose(array, second.rgb[name], atol=4e-3 * max(np.abs(array).max(), 1))


def test_hypersims_loaders_find_their_files(made):
    import h5py

    image = dataset.open(made)[2]

    def load(kind, name):
        path = image.folder / "images" / f"scene_cam_00_{kind}_hdf5" / f"frame.0000.{name}.hdf5"
        with h5py.File(path, "r") as file:
            return file["dataset"][:]

    color = load("final", "color")
    product = load("final", "diffuse_reflectance") * load("final", "diffuse_illumination")
    np.testing.assert_allclose(color, product + load("final", "residual"), rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(color, image.rgb["radiance"])
    np.testing.assert_array_equal(load("geometry", "depth_meters"), image["distance"])
    assert load("geometry", "normal_world").shape == (12, 16, 3)
    ids = load("geometry", "render_entity_id")
    assert ids.dtype == np.int32
    assert (ids[~image["background"]] == image["object_id"][~image["background"]]).all()
    assert (ids[image["background"]] == -1).all()


def test_the_manifest_says_how_to_render_an_image_again(made):
    head = json.loads((made / "manifest.json").read_text())
    lines = [json.loads(line) for line in (made / "manifest.jsonl").read_text().splitlines()]
    assert head["images"] == [line["name"] for line in lines]
    for line in lines:
        assert line["job"]["seed"] == 0
        assert line["goal"]["reached"] <= 0.5
        assert line["reached"]
        assert line["versions"]["photonmap"] == pm.__version__
        assert line["effects"]["direct"][0]
        assert np.shape(line["camera"]["camera_to_world"]) == (4, 4)
        assert set(line["files"]) == {
            path.relative_to(made / line["name"]).as_posix()
            for path in (made / line["name"]).rglob("*")
            if path.is_file() and path.name != render_image.ENTRY
        }
        image = dataset.open(made)[lines.index(line)]
        assert image["object_id"].max() <= len(line["objects"])
        assert image["material_id"].max() <= len(line["materials"])
        assert line["rgb"]["residual"] == pytest.approx(
            rgb_residual(as_rgb(image.result, "rec2020")), rel=0.05
        )
    first = dataset.open(made)[0]
    corner = lines[0]["materials"][first["material_id"][0, 0] - 1]
    np.testing.assert_allclose(
        first["reflectance"][0, 0], lines[0]["reflectances"][corner], rtol=2**-11
    )


def test_resume_makes_what_is_missing_or_damaged(copied, preset, capsys):
    before = dataset.open(copied)
    missing, damaged, kept = before[0], before[1], before[2]
    arrays = {image.name: dict(image) for image in (missing, damaged)}
    stamp = (kept.folder / image_files.BANDS_EXR).stat().st_mtime_ns
    shutil.rmtree(missing.folder)
    with (damaged.folder / image_files.RGB_EXR).open("r+b") as file:
        file.seek(200)
        file.write(b"\0\1\2\3")
    (copied / ".photonmap-left").mkdir()
    (damaged.folder / "notes").mkdir()
    (damaged.folder / "notes" / "mine.txt").write_text("keep me")
    (kept.folder / ".DS_Store").write_text("x")
    assert command(copied, preset, "--resume") == 0
    captured = capsys.readouterr()
    first, second = (line for line in captured.err.splitlines() if "/2 " in line)
    assert " processor hours" in first
    assert " left" not in second
    assert (damaged.folder / "notes" / "mine.txt").read_text() == "keep me"
    assert "2 images rendered, 2 rendered earlier" in captured.out
    after = dataset.open(copied)
    assert [image.name for image in after] == [image.name for image in before]
    for image in after[:2]:
        for name, array in arrays[image.name].items():
            np.testing.assert_array_equal(image[name], array)
    assert (kept.folder / image_files.BANDS_EXR).stat().st_mtime_ns == stamp
    assert not list(copied.glob(".photonmap-*"))
    assert verify(copied, sample=0) == []


@pytest.mark.parametrize("name", ["kernels", "numpy"])
def test_a_set_is_of_one_code(copied, preset, capsys, name):
    """What an edit of the kernels, or another version, would render may not join the set."""
    head = json.loads((copied / "manifest.json").read_text())
    here = head["versions"][name]
    (copied / "manifest.json").write_text(
        json.dumps({**head, "versions": {**head["versions"], name: "other"}})
    )
    shutil.rmtree(dataset.open(copied)[0].folder)
    assert command(copied, preset, "--resume") == 2
    printed = capsys.readouterr().err.splitlines()
    assert len(printed) == 1
    assert f"{name} other there, {here} here; choose another folder, or restore" in printed[0]
    assert len(list(copied.glob("jug-*"))) == 1


def test_a_worker_of_other_versions_renders_nothing(made, tmp_path):
    job = Job.from_description(dataset.open(made)[0].entry["job"])
    task = render_image.Task(job, str(tmp_path), ("exr",), {**describe_code(), "kernels": "edited"})
    with pytest.raises(pm.InputError, match=r"kernels edited there, \w+ here; install those"):
        render_image.render_image(task)
    assert not list(tmp_path.iterdir())


def test_the_kernels_are_those_of_the_render(made):
    versions = dataset.open(made).head["versions"]
    assert versions == describe_code()
    for image in dataset.open(made):
        assert image.entry["fingerprint"]["kernels"] == f"kernels-{versions['kernels']}"


@pytest.mark.slow
def test_other_measured_sets_make_another_set(tmp_path, preset, capsys, monkeypatch):
    monkeypatch.setenv(ILLUMINANTS, "")  # the command sets it
    lights = tmp_path / "lights"
    lights.mkdir()
    rows = "\n".join(f"{nm},1.0" for nm in range(380, 781, 10))
    (lights / "even.csv").write_text(f"nm,even\n{rows}\n")
    folder, more = tmp_path / "set", ["--illuminants", str(lights / "even.csv"), "--dry-run"]
    assert command(folder, preset, *more[:2]) == 0
    assert command(folder, preset, *more, "--resume") == 0
    (lights / "even.csv").write_text(f"nm,even\n{rows}\n".replace("400,1.0", "400,1.1"))
    assert command(folder, preset, *more, "--resume") == 2
    assert "begun with other curves of bands or measured sets; choose" in capsys.readouterr().err


@pytest.mark.slow
def test_a_larger_count_goes_on_with_a_set(copied, preset):
    assert command(copied, preset, "--resume", "--count", "2") == 0
    images = dataset.open(copied)
    assert len(images) == 8
    assert len(images.head["images"]) == 8
    assert [image.entry["split"] for image in images] == [part_of(i.geometry) for i in images]


def test_verify_finds_what_is_wrong(copied, capsys):
    images = dataset.open(copied)
    path = images[0].folder / image_files.RGB_EXR
    path.write_bytes(path.read_bytes()[:-1])
    notes = images[1].folder / ".DS_Store"
    notes.write_text("x")
    text = (copied / "manifest.jsonl").read_text().splitlines()
    text[2] = json.dumps({**images[2].entry, "passes": images[2].entry["passes"] + 1})
    (copied / "manifest.jsonl").write_text("\n".join(text[:3]) + "\n")
    assert main(["dataset", "verify", str(copied), "--sample", "3"]) == 1
    captured = capsys.readouterr()
    printed = captured.err
    assert f"{images[0].name}: missing or changed files: rgb.exr" in printed
    assert f"{images[1].name}: other files are left alone: .DS_Store" in captured.out
    assert images[1].name not in printed
    assert notes.exists()
    assert f"{images[2].name}: rendered again, its error is reached after " in printed
    assert f"{images[3].name}: is missing" in printed


def test_verify_finds_images_of_other_code(copied):
    head = json.loads((copied / "manifest.json").read_text())
    head["versions"] |= {"kernels": "others"}
    (copied / "manifest.json").write_text(json.dumps(head))
    faults = verify(copied, sample=0)
    assert len(faults) == 4
    assert all(
        "was rendered by other versions than the data set's: kernels others there" in f
        for f in faults
    )


def test_verify_passes_a_whole_set(made, capsys):
    assert main(["dataset", "verify", str(made)]) == 0
    assert "rendered again, identical bit for bit" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::photonmap.errors.SceneWarning")
def test_mirrors_and_glass_keep_the_identities(tmp_path):
    path = tmp_path / "mixed.toml"
    path.write_text('scenes = ["pottery"]\nilluminations = ["two_planckian"]\nmaterials = "mixed"')
    folder = tmp_path / "set"
    assert main(["dataset", str(folder), "--preset", str(path), *SIZE, "--quiet"]) == 0
    assert verify(folder, sample=1) == []
    assert dataset.open(folder)[0]["residual"].any()


@pytest.mark.filterwarnings("ignore:.*has fewer light groups")
def test_a_scene_that_fails_is_skipped(tmp_path, capsys):
    pm.save_scene(pm.scenes.cornell_box(), tmp_path / "room.obj")
    path = tmp_path / "own.toml"
    path.write_text('files = ["room.obj"]\nilluminations = ["two_mixed", "white"]')
    folder = tmp_path / "set"
    assert main(["dataset", str(folder), "--preset", str(path), *SIZE]) == 1
    printed = capsys.readouterr()
    assert "photonmap: failed: room-0-two_mixed-" in printed.err
    assert "has fewer light groups (light) than the 2 colours" in printed.err
    assert "1 images rendered, 1 failed" in printed.out
    assert [image.entry["job"]["illumination"] for image in dataset.open(folder)] == ["white"]
    assert verify(folder, sample=0)[0].endswith("is missing")


def test_ctrl_c_keeps_what_is_done(tmp_path, preset, monkeypatch, capsys):
    calls = []

    def interrupted(task):
        calls.append(task)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return render_image.render_image(task)

    monkeypatch.setattr(schedule, "render_image", interrupted)
    assert main(["dataset", str(tmp_path / "set"), "--preset", preset, *SIZE]) == 130
    assert "continue with --resume" in capsys.readouterr().err
    assert len(dataset.open(tmp_path / "set")) == 2


def test_dry_run_lists_and_writes_nothing(tmp_path, preset, capsys):
    assert main(["dataset", str(tmp_path / "set"), "--preset", preset, *SIZE, "--dry-run"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6
    assert lines[1].split()[1:4] == ["0", "white", "D65"]
    assert lines[-1] == "4 images of 16x12, bands 3, error 0.5"
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--preset", "icip2031"], "there is no preset 'icip2031'; did you mean 'icip2013'?"),
        (["--count", "0"], "count 0 is out of range"),
        (["--size", "0x4"], "must be whole pixels"),
        (["--error", "x"], "write 0.02"),
        (["--bands", "nonsense"], "nonsense"),
        (["--format", "exr,jpg"], "there is no format 'jpg'; did you mean"),
        (["--format", "png"], "needs exr or hdf5 among its formats"),
        (["--workers", "0"], "workers 0 must be a whole number from 1"),
        (["--resume", "--size", "8x8"], ": it was begun with --size 16x12, not 8x8; choose"),
        (["--resume", "--full"], "another data set: it was begun without --full; choose"),
        (["--resume", "--format", "exr"], "begun with --format exr,hdf5,png, not exr; choose"),
        (["--resume", "--seed", "7"], "none of its images is asked for"),
        ([], "holds a data set already; add --resume"),
    ],
)
def test_bad_input_touches_nothing(made, preset, capsys, more, message):
    before = {path: path.stat().st_mtime_ns for path in made.rglob("*.exr")}
    assert command(made, preset, *more) == 2
    printed = capsys.readouterr().err.splitlines()
    assert len(printed) == 1
    assert message in printed[0]
    assert before == {path: path.stat().st_mtime_ns for path in made.rglob("*.exr")}


def test_folders_that_are_refused(tmp_path, preset, capsys):
    (tmp_path / "file").write_text("x")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("x")
    for place, message in (
        ("file", "this is a file"),
        ("other", "holds other files"),
        ("file/deep", "Not a directory"),
    ):
        assert command(tmp_path / place, preset) == 2
        assert message in capsys.readouterr().err
    assert main(["dataset", "verify", str(tmp_path / "other")]) == 2
    assert "does not hold a data set" in capsys.readouterr().err
    assert main(["dataset", "verify"]) == 2
    assert main(["dataset", "a", "b"]) == 2


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="no folder that nobody may write to")
def test_a_folder_that_cannot_be_written_to(preset, capsys):
    assert command("/proc/set", preset) == 2
    printed = capsys.readouterr().err.splitlines()
    assert len(printed) == 1
    assert "cannot write to the folder /proc" in printed[0]


def test_an_illuminant_file_of_the_wrong_shape(tmp_path, preset, capsys, monkeypatch):
    monkeypatch.setenv(ILLUMINANTS, "")  # the command sets it
    (tmp_path / "lights.csv").write_text("1,2,3\n4\n")
    assert command(tmp_path / "set", preset, "--illuminants", str(tmp_path / "lights.csv")) == 2
    printed = capsys.readouterr().err.splitlines()
    assert len(printed) == 1
    assert "lights.csv" in printed[0]
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize("package", ["h5py", "distributed", "torch"])
def test_packages_that_are_missing_are_named(made, tmp_path, preset, monkeypatch, package):
    def without(name):
        return None if name == package else find_spec(name)

    monkeypatch.setattr(image_files, "find_spec", without)
    monkeypatch.setattr(reader, "find_spec", without)
    monkeypatch.setattr(schedule, "find_spec", without)
    needs = {
        "h5py": lambda: image_files.check_formats(("hdf5",)),
        "distributed": lambda: schedule.check_scheduler("tcp://127.0.0.1:1", 1),
        "torch": lambda: dataset.open(made).torch(),
    }
    with pytest.raises(pm.InputError, match=r"needs? .*: pip install"):
        needs[package]()


def test_opening_a_set_is_light(made):
    code = (
        f"import sys; from photonmap import dataset; d = dataset.open({str(made)!r});"
        "d.splits(1, 0, 0); d[0]; heavy = {'numba', 'OpenImageIO', 'h5py', 'distributed', 'torch'};"
        "heavy &= set(sys.modules); sys.exit(str(heavy) if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
