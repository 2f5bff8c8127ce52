"""What accuracy costs: errors against a reference, and the command end to end."""

import argparse
import base64
import csv
import dataclasses
import math
import signal
import struct
import subprocess
import sys

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands import study as command
from photonmap.errors import InputError
from photonmap.report.pages import webp_uri
from photonmap.results.result import Result
from photonmap.runtime.progress import Silent
from photonmap.spectra.color_difference import delta_e_2000
from photonmap.study import run_study
from photonmap.study.convergence import Findings
from photonmap.study.errors import (
    BUFFERS,
    Reference,
    color_error,
    counted_pixels,
    mean_relative,
    relative_distance,
    stated_error,
    true_map,
)
from photonmap.study.measure import COLUMNS, Settings, Study
from photonmap.study.sweeps import Extent, effects_on, run_sweeps


def noisy(seed, sigma, shape=(60, 60, 2)):
    """A result whose buffers are noise around 1, and around 3 in the second band."""
    rng = np.random.default_rng(seed)
    truth = np.broadcast_to([1.0, 3.0], shape)
    buffers = {
        name: (truth * (1.0 + rng.normal(0.0, sigma, shape))).astype(np.float32) for name in BUFFERS
    }
    errors = {name: (sigma * truth).astype(np.float32) for name in BUFFERS}
    coverage, dark = np.ones(shape[:2], np.float32), np.zeros(shape, np.float32)
    record = {"passes": 4, "seconds": {"render": 1.0}}
    buffers |= {"coverage": coverage, "emission": dark, "unresolved": coverage == 0.0}
    return Result(buffers, errors, pm.Bands.gaussian(2), record)


def test_true_errors_are_not_biased_by_the_reference():
    # 7200 values each: an error of 5% is known to 5% / sqrt(14400) = 0.04%, and its cross terms
    # with halves of 8% to 0.1%; four of these are allowed.
    reference = Reference(noisy(1, 0.08), noisy(2, 0.08))
    once = math.sqrt(1 / 1.01)
    assert reference.own_error("shading") == pytest.approx(once * 0.08 / math.sqrt(2), rel=0.05)
    off = noisy(3, 0.05)
    assert reference.true_error(off, "shading") == pytest.approx(once * 0.05, abs=0.005)
    assert stated_error(off, "shading", reference.mask) == pytest.approx(once * 0.05, rel=0.02)
    assert reference.mean_difference(off) == pytest.approx(0.0, abs=0.005)
    assert (reference.passes, reference.seconds) == (8, 2.0)
    assert reference.fits(off)
    assert not reference.fits(noisy(3, 0.05, (8, 8, 2)))


def test_stated_errors_are_the_renderers(cornell):
    result = pm.render(cornell, size=(16, 16), passes=4, photons=1000, bands=3)
    mask = counted_pixels(result)
    assert stated_error(result, "radiance", mask) == pytest.approx(
        result.record["standard_error"], rel=1e-4
    )
    single = pm.render(cornell, size=(16, 16), passes=1, photons=1000, bands=3)
    assert math.isnan(stated_error(single, "radiance", mask))


def test_black_bands_have_no_error():
    values = np.zeros((5, 2))
    values[:, 0] = 1.0
    assert mean_relative(values, values) == pytest.approx(0.5 / 1.01)
    assert relative_distance(np.zeros((5, 3)), np.zeros((5, 3))) == 0.0


def test_colours_of_the_same_image_do_not_differ(cornell):
    few, more = (
        pm.render(cornell, size=(16, 16), passes=2, photons=1000, bands=n, seed=1) for n in (3, 9)
    )
    mask = counted_pixels(more)
    same = color_error(more, more, mask)
    assert set(dataclasses.astuple(same)) == {0.0}
    off = color_error(few, more, mask)
    assert 0.1 < off.delta_mean < off.delta_p95 < 10.0
    assert 0.001 < off.shading < off.indirect < 0.2
    assert not delta_e_2000(np.ones((2, 2, 3)), np.zeros((2, 2, 3))).any()


def test_pictures_stand_in_the_page(cornell):
    uri = webp_uri(np.zeros((5, 7, 3), np.uint8))
    data = base64.b64decode(uri.removeprefix("data:image/webp;base64,"))
    assert data[8:12] == b"WEBP"
    halves = [pm.render(cornell, size=(12, 12), passes=2, photons=500, seed=s) for s in (0, 1)]
    shown = true_map(halves[0], Reference(*halves))
    assert shown.kind == "true"
    assert 0.0 < shown.scale < 10.0


def run(*arguments):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    command.run(parser.parse_args(list(map(str, arguments))))


def test_the_command_end_to_end(study_folder):
    assert {path.name for path in study_folder.iterdir()} == {
        "study.html", "study.csv", "error_time.png", "bands.png", "pareto.png", "choices.png",
    }  # fmt: skip
    with (study_folder / "study.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    sweeps = {row["sweep"] for row in rows}
    assert sweeps == {"passes", "path", "bands", "photons", "resolution", "choices"}
    for row in rows:
        assert float(row["wall_seconds"]) > 0.0
        assert float(row["stated_radiance"]) > 0.0
        assert int(row["photons_per_pass"]) > 0
        assert row["seed"] == "0" or row["sweep"] in ("passes", "path")
    swept = [row for row in rows if row["sweep"] == "passes"]
    assert [int(row["passes"]) for row in swept] == [2**k for k in range(1, len(swept) + 1)]
    assert all(float(row["true_shading"]) >= 0.0 for row in swept)
    few = {row["bands"] for row in rows if row["delta_e_mean"]}
    assert few == {"3", "6"}
    labels = {row["label"] for row in rows if row["sweep"] == "choices"}
    assert labels == {
        "as usual", "center pixels", "without emission", "without direct", "without soft_shadows",
        "without indirect",
    }  # fmt: skip
    stdout = (study_folder.parent / "stdout").read_text()
    assert stdout.startswith("1% error in shading: ")
    assert f"{len(rows)} points: {study_folder / 'study.html'}" in stdout
    stderr = (study_folder.parent / "stderr").read_text()
    assert " reference" in stderr
    assert "6 bands: " in stderr


def test_the_page_holds_everything(study_folder):
    page = (study_folder / "study.html").read_text(encoding="utf-8")
    assert "1% error in shading: " in page
    assert page.count("<svg") == 4
    assert "interrupted" not in page
    assert "http://" not in page.replace("http://www.w3.org/", "")
    assert "https://" not in page
    for name in ("error_time", "bands", "pareto", "choices"):
        image = (study_folder / f"{name}.png").read_bytes()
        width, height = struct.unpack(">II", image[16:24])
        assert (width, height) > (600, 300)


@pytest.fixture
def tiny(cornell):
    """A study of a few pixels."""
    settings = Settings(size=(8, 8), photons=500, threads=1)
    return Study(cornell, settings, None, Silent(), lambda line: None)


def points_of(study, sweep):
    return [point for point in study.points if point.sweep == sweep]


def test_all_of_a_study_in_a_few_pixels(tiny):
    extent = Extent(0.05, ("rgb", "3", "81"), (1, 2), (1, 2), (1,), repeats=2, forced=False)
    run_sweeps(tiny, extent)
    assert len(points_of(tiny, "photons")) == len(points_of(tiny, "resolution")) == 2
    assert [p.settings.bands for p in points_of(tiny, "bands")] == ["81", "rgb", "3", "6"]
    assert points_of(tiny, "bands")[0].color is None
    assert effects_on(tiny) == ["emission", "direct", "soft_shadows", "indirect"]
    assert points_of(tiny, "resolution")[1].settings.size == (16, 16)
    assert points_of(tiny, "resolution")[1].error_map.kind == "stated"
    assert points_of(tiny, "resolution")[1].true == {}


def test_ctrl_c_keeps_what_is_done(tmp_path, monkeypatch, capsys):
    measure = Study.measure

    def press(study, sweep, label, settings, truth=None):
        if sweep == "path":
            raise KeyboardInterrupt
        return measure(study, sweep, label, settings, truth)

    monkeypatch.setattr(Study, "measure", press)
    scene = f"{pm.scenes.FOLDER}/cornell_box.obj"
    options = ("--quick", "--size", "8x8", "--minutes", "0.001", "--threads", "1", "--quiet")
    run(scene, *options, "--output", tmp_path / "box")
    assert {path.name for path in (tmp_path / "box").iterdir()} == {
        "study.html", "study.csv", "error_time.png",
    }  # fmt: skip
    page = (tmp_path / "box" / "study.html").read_text(encoding="utf-8")
    assert "was interrupted" in page
    assert page.count("<svg") == 1
    assert capsys.readouterr().out == ""

    monkeypatch.setattr(Study, "measure", lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        run(scene, *options, "--output", tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_ctrl_c_in_a_real_process(tmp_path):
    command = [sys.executable, "-m", "photonmap", "study", f"{pm.scenes.FOLDER}/cornell_box.obj"]
    with subprocess.Popen(
        [*command, "--size", "8x8", "--minutes", "60", "--output", tmp_path / "box"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        lines = iter(process.stderr.readline, "")
        assert any("pass " in line for line in lines)  # of the pilot, or of the reference
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT
    assert list(tmp_path.iterdir()) == []


def test_a_study_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(run_study, "write_csv", fail)
    monkeypatch.setattr(run_study, "write_page", lambda *_: "")
    with pytest.raises(OSError, match="disk full"):
        run_study.write_study(tmp_path / "box", Findings([], "6", {}), None)
    assert list(tmp_path.iterdir()) == []


BAD = {
    "no scene": (["nowhere.obj"], "nowhere.obj"),
    "no bands": (["box.obj", "--bands", "nosuch"], "nosuch"),
    "a file": (["box.obj", "--output", "box.obj"], "this is a file"),
    "no folder": (["box.obj", "--output", "box.obj/folder"], "Not a directory"),
    "half a camera": (["box.obj", "--target", "0,0,5"], "--origin"),
    "no memory": (["box.obj", "--size", "60000x60000"], "GB"),
    "nothing but lamps": (["lamp.obj", "--quick", "--size", "8x8"], "point the camera"),
}


@pytest.mark.filterwarnings("ignore::photonmap.SceneWarning")
@pytest.mark.parametrize(("arguments", "named"), BAD.values(), ids=BAD)
def test_bad_input(arguments, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lamp.mtl").write_text("newmtl lamp\nKd 0 0 0\nKe 1 1 1\n")
    shape = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"
    (tmp_path / "lamp.obj").write_text("mtllib lamp.mtl\nusemtl lamp\n" + shape)
    (tmp_path / "box.obj").write_text(shape)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError) as error:
        run(*arguments, "--quiet")
    assert named in str(error.value)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("arguments", [["--minutes", "0"], ["--minutes", "x"], ["--size", "8x"]])
def test_bad_flags(arguments, capsys):
    with pytest.raises(SystemExit):
        run("box.obj", *arguments)
    assert arguments[0] in capsys.readouterr().err


def test_missing_packages_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    with pytest.raises(
        InputError, match=r"jinja2 and matplotlib: pip install 'photonmap\[study\]'"
    ):
        run("box.obj")
