"""Lights whose spectra are in files: what is in them decides the images, and goes with the set."""

import shutil

import pytest

from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs.presets import load_preset
from photonmap.dataset.jobs.verify import verify

SIZE = ["--size", "12x8", "--error", "0.9", "--bands", "3", "--format", "exr", "--quiet"]
PRESET = """
scenes = ["jug"]

[[illumination]]
name = "measured"
colors = [COLOR]
"""


def rows(slope):
    return "".join(f"{nm},{1.0 + slope * (nm - 380)}\n" for nm in range(380, 781, 10))


def write_preset(home, color="lamp.csv", slope=0.01):
    home.mkdir(exist_ok=True)
    (home / "lamp.csv").write_text(f"nm,power\n{rows(slope)}")
    (home / "own.toml").write_text(PRESET.replace("COLOR", f'"{color}"'))
    return home / "own.toml"


def planned(preset, capsys):
    """Return the name of the one image of a preset."""
    capsys.readouterr()
    assert main(["dataset", "unused", "--preset", str(preset), *SIZE, "--dry-run"]) == 0
    line = capsys.readouterr().out.splitlines()[1]
    assert str(preset.parent) not in line
    return line.split()[0]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A set under the light of a file, and the folder of its preset."""
    home = tmp_path_factory.mktemp("someones")
    preset = write_preset(home / "presets")
    assert main(["dataset", str(home / "set"), "--preset", str(preset), *SIZE]) == 0
    return home / "set", preset


def test_files_are_found_beside_the_preset(tmp_path, monkeypatch):
    preset = write_preset(tmp_path / "presets")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    [light] = load_preset(str(preset)).illuminations
    assert light.colors == (str(preset.parent / "lamp.csv"),)


def test_the_curve_decides_the_name(tmp_path, capsys):
    first = planned(write_preset(tmp_path / "one"), capsys)
    absolute = write_preset(tmp_path / "two", color=str(tmp_path / "two" / "lamp.csv"))
    assert planned(absolute, capsys) == first
    assert planned(write_preset(tmp_path / "three", color="lamp.csv 2"), capsys) == first
    assert planned(write_preset(tmp_path / "one", slope=0.02), capsys) != first
    held = write_preset(tmp_path / "four", color="extrapolate: lamp.csv")
    assert planned(held, capsys) != first


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_the_file_goes_with_the_set(made, tmp_path):
    folder, _ = made
    [copy] = folder.glob("inputs/lights/*/lamp.csv")
    entry = dataset.open(folder)[0].entry
    assert entry["job"]["colors"] == [copy.relative_to(folder).as_posix()]
    assert main(["dataset", "publish", str(folder), "--license", "CC0-1.0", "--quiet"]) == 0
    assert entry["job"]["colors"][0] in (folder / "README.md").read_text()
    assert entry["job"]["colors"][0] in (folder / "SHA256SUMS").read_text()
    for file in folder.rglob("*"):
        assert not file.is_file() or b"someones" not in file.read_bytes(), file.name
    moved = shutil.copytree(folder, tmp_path / "moved")
    assert verify(moved) == []
    [copy] = moved.glob("inputs/lights/*/lamp.csv")
    copy.write_text(copy.read_text().replace("780,5.0", "780,6.0"))
    assert any("has changed since the data set was begun" in fault for fault in verify(moved))


@pytest.mark.filterwarnings("always::photonmap.SceneWarning")
def test_a_changed_file_is_another_image(made, tmp_path, capsys):
    folder = shutil.copytree(made[0], tmp_path / "grown")
    [first] = dataset.open(folder)
    changed = write_preset(tmp_path / "presets", slope=0.03)
    options = ["dataset", str(folder), "--preset", str(changed), *SIZE, "--resume"]
    assert main(options) == 2
    assert "none of its images is asked for" in capsys.readouterr().err
    write_preset(changed.parent)
    changed.write_text(f'illuminations = ["white"]\n{changed.read_text()}')
    assert main(options) == 0
    (changed.parent / "lamp.csv").write_text(rows(0.03))
    assert main(options) == 0
    assert "images of earlier runs that are not asked for stay" in capsys.readouterr().err
    images = dataset.open(folder)
    assert first.name in [image.name for image in images]
    assert len({str(image.entry["lights"]) for image in images}) == 3
    assert verify(folder, sample=3) == []
