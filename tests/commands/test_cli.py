"""The command: some in a real process, the others in this one."""

import json
import subprocess
import sys
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.spectra.color_text import ILLUMINANTS
from photonmap.spectra.munsell import VARIABLE

MEASURED_SETS = (VARIABLE, ILLUMINANTS)
SCENES = Path(pm.scenes.FOLDER)
QUICK = ["--size", "16x12", "--passes", "2", "--photons", "1000"]


def command(*arguments):
    return [sys.executable, "-m", "photonmap", *map(str, arguments)]


def run(*arguments, cwd):
    return subprocess.run(
        command(*arguments), capture_output=True, text=True, cwd=cwd, timeout=300, check=False
    )


@pytest.fixture
def call(tmp_path, monkeypatch, capsys):
    """Run a command in this process, in an empty folder; warnings are printed, as in its own."""
    monkeypatch.chdir(tmp_path)

    def run_here(*arguments):
        with warnings.catch_warnings():
            warnings.simplefilter("always", pm.SceneWarning)
            code = main(list(map(str, arguments)))
        printed = capsys.readouterr()
        return SimpleNamespace(returncode=code, stdout=printed.out, stderr=printed.err)

    return run_here


def test_render_a_file(tmp_path):
    done = run(SCENES / "cornell_box.obj", *QUICK, "--bands", "6", "--seed", "3", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "cornell_box.exr" in done.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "cornell_box.exr",
        "cornell_box.json",
        "cornell_box.png",
    ]
    result = pm.load_result(tmp_path / "cornell_box.exr")
    again = pm.render(
        pm.scenes.cornell_box(), bands=6, size=(16, 12), passes=2, photons=1000, seed=3
    )
    np.testing.assert_array_equal(result.radiance, again.radiance)
    np.testing.assert_array_equal(result.standard_error("shading"), again.standard_error("shading"))
    record = json.loads((tmp_path / "cornell_box.json").read_text())
    assert record["passes"] == 2
    assert record["photons"] == 2000
    assert not record["interrupted"]
    assert record["scene"]["triangles"] == 36
    assert set(record["seconds"]) >= {"load", "compile", "photons", "camera", "write", "render"}
    assert record["seconds"]["render"] == pytest.approx(
        record["seconds"]["photons"] + record["seconds"]["camera"]
    )
    pose = np.array(record["camera"]["camera_to_world"])
    np.testing.assert_allclose(pose[:3, 3], (0, 0, 3.9))
    np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-12)


def test_options(tmp_path, call):
    done = call(
        SCENES / "cornell_box.obj", *QUICK, "--bands", "rgb", "--origin=0,0,3", "--fov", "30",
        "--pixel", "center", "--threads", "1", "--buffers", "shading,direct",
        "--output", "some.exr", "--quiet",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == done.stderr == ""
    result = pm.load_result(tmp_path / "some.exr")
    assert set(result.buffers) == {"shading", "direct"}
    assert result.record["camera"]["origin"] == [0, 0, 3]
    assert result.record["camera"]["fov"] == 30


def test_spectra_and_sensors(tmp_path, call):
    (tmp_path / "camera.csv").write_text("nm,long,short\n390,0,0\n450,0,1\n600,1,0\n710,0,0\n")
    box = SCENES / "cornell_box_measured.toml"
    done = call(box, *QUICK, "--bands", "camera.csv", "--range", "400:700")
    assert done.returncode == 0, done.stderr
    result = pm.load_result(tmp_path / "cornell_box_measured.exr")
    assert result.bands.names == ("long", "short")
    assert result.bands == pm.Bands.parse(tmp_path / "camera.csv", (400.0, 700.0))
    assert result.record["scene"]["spectra"]
    assert result.record["measured_sets"] == {"munsell": None, "illuminants": None}


def test_the_sensor_study(tmp_path, call):
    options = ["--bands", "3,box:4", "--bounces", "2", "--csv", "t.csv", "--plot", "t.svg"]
    done = call("sensors", *options)
    assert done.returncode == 0, done.stderr
    assert "illuminant D65" in done.stdout
    assert "Eq. 4" in done.stdout
    head, *rows = (tmp_path / "t.csv").read_text().splitlines()
    assert head == "bands,bounces,mean_percent,max_percent"
    assert [row.split(",")[:2] for row in rows] == [
        ["3", "1"], ["3", "2"], ["box:4", "1"], ["box:4", "2"],
    ]  # fmt: skip
    assert "<svg" in (tmp_path / "t.svg").read_text()
    assert done.stderr == ""


def test_framing_is_said(tmp_path, call):
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    done = call("one.obj", *QUICK, "--up", "z")
    assert done.returncode == 0, done.stderr
    assert "no camera given: seen from the front right" in done.stdout
    assert "no light" in done.stderr
    record = json.loads((tmp_path / "one.json").read_text())
    assert record["camera"]["up"] == [0.0, 0.0, 1.0]
    assert record["camera"]["framed"]
    assert any("no light" in warning for warning in record["warnings"])


BAD = {
    "missing scene": (["nowhere.obj"], "nowhere.obj"),
    "a folder": (["."], "is a folder"),
    "no name": ([""], "is a folder"),
    "info of a folder": (["info", "."], "is a folder"),
    "conversion of a folder": (["convert", ".", "x.obj"], "is a folder"),
    "wrong error": (["ok.obj", "--error", "indirect:95:0.01"], "'95' is not a percentile"),
    "error of no buffer": (["ok.obj", "--error", "depth:0.01"], "'depth:0.01'"),
    "checkpoint in nowhere": (["ok.obj", "--checkpoint", "ok.obj/such"], "Not a directory"),
    "checkpoint over the scene": (["ok.obj", "--checkpoint", "ok.obj"], "not a checkpoint"),
    "merge of one": (["merge", "one.exr", "-o", "out.exr"], "one.exr"),
    "zero size": (["ok.obj", "--size", "0x10"], "0x10"),
    "absurd size": (["ok.obj", "--size", "99999999x10"], "too large"),
    "no size": (["ok.obj", "--size", "big"], "big"),
    "zero bands": (["ok.obj", "--bands", "0"], "0"),
    "absurd bands": (["ok.obj", "--bands", "100000"], "100000"),
    "wrong bands": (["ok.obj", "--bands", "red"], "red"),
    "wrong vector": (["ok.obj", "--origin", "1,2"], "1,2"),
    "half a camera": (["ok.obj", "--target", "0,0,5"], "--target needs --origin too"),
    "wrong angle": (["ok.obj", "--origin", "0,0,5", "--target", "0,0,0", "--fov", "190"], "190"),
    "file for a folder": (["ok.obj", "--output", "ok.obj/x.exr"], "Not a directory"),
    "wrong suffix": (["ok.obj", "--output", "x.jpg"], ".exr"),
    "wrong buffer": (["ok.obj", "--buffers", "shadnig"], "shadnig"),
    "unknown flag": (["ok.obj", "--bandz", "3"], "--bandz"),
    "binary": (["binary.obj"], "binary.obj"),
    "empty": (["empty.obj"], "empty.obj"),
    "bright": (["bright.obj"], "bright.mtl:2"),
    "index": (["index.obj"], "index.obj:4"),
    "wrong range": (["ok.obj", "--range", "400-700"], "400-700"),
    "range beyond": (["ok.obj", "--range", "200:700"], "280 to 800"),
    "sensor file": (["ok.obj", "--bands", "nan.csv"], "nan.csv:3"),
    "sensor name": (["ok.obj", "--bands", "Nikon 5100 (NLP)"], "Nikon 5100 (NPL)"),
    "measured set": (["ok.obj", "--munsell", "none.mat"], "none.mat"),
    "measured lights": (["ok.obj", "--illuminants", "none.npz"], "none.npz"),
    "sensors of rgb": (["sensors", "--bands", "3,rgb"], "rgb"),
    "sensors of nothing": (["sensors", "--bands", ""], "bands"),
    "sensors into nowhere": (["sensors", "--csv", "ok.obj/such.csv"], "ok.obj/such.csv"),
    "sensors flag": (["sensors", "--band", "3"], "--band"),
}


@pytest.fixture
def bad_files(tmp_path):
    """A folder of scenes and tables, of which most are wrong."""
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    (tmp_path / "ok.obj").write_text(corners + "f 1 2 3\n")
    (tmp_path / "m.mtl").write_text("newmtl here\nKd 1 1 1\n")
    (tmp_path / "bright.obj").write_text("mtllib bright.mtl\n" + corners + "usemtl b\nf 1 2 3\n")
    (tmp_path / "bright.mtl").write_text("newmtl b\nKd 1.5 0 0\n")
    (tmp_path / "index.obj").write_text(corners + "f 1 2 7\n")
    (tmp_path / "binary.obj").write_bytes(bytes(range(256)) * 8)
    (tmp_path / "empty.obj").write_text("")
    (tmp_path / "nan.csv").write_text("nm,red\n400,0.5\n700,nan\n")
    return tmp_path


@pytest.mark.parametrize("case", BAD)
def test_bad_input(bad_files, case, monkeypatch, capsys):
    before = sorted(bad_files.iterdir())
    arguments, named = BAD[case]
    monkeypatch.chdir(bad_files)
    for variable in MEASURED_SETS:  # set by options; put back at the end
        monkeypatch.setenv(variable, "")
        monkeypatch.delenv(variable)
    assert exit_code(arguments) == 2
    assert_one_line(*capsys.readouterr(), named)
    assert sorted(bad_files.iterdir()) == before


@pytest.mark.parametrize("case", ["missing scene", "unknown flag"])
def test_bad_input_of_a_process(bad_files, case):
    arguments, named = BAD[case]
    done = run(*arguments, cwd=bad_files)
    assert done.returncode == 2
    assert_one_line(done.stdout, done.stderr, named)


def exit_code(arguments):
    try:
        return main(arguments)
    except SystemExit as stop:  # of the parser
        return stop.code


def assert_one_line(stdout, stderr, named):
    assert stdout == ""
    assert len(stderr.splitlines()) == 1, stderr
    assert named in stderr


def test_version_and_help(tmp_path):
    assert run("--version", cwd=tmp_path).stdout.strip() == f"photonmap {pm.__version__}"
    text = " ".join(run("--help", cwd=tmp_path).stdout.split())
    assert "gives up after 1 hour" in text
