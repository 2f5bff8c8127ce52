"""What accuracy costs: laws on synthetic data, made-up points, and the command end to end."""

import argparse
import base64
import csv
import dataclasses
import io
import math
import signal
import struct
import subprocess
import sys

import numpy as np
import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.progress import Silent
from photonmap.result import Result
from photonmap.study import command, files, machine
from photonmap.study.color import ColorError, color_error, differences
from photonmap.study.findings import Findings, beyond_noise
from photonmap.study.fit import Cost, Power, fit_cost, fit_power
from photonmap.study.measure import Study
from photonmap.study.metrics import counted_pixels, mean_relative, relative_distance, stated_error
from photonmap.study.pictures import data_uri, true_map
from photonmap.study.point import COLUMNS, Point, Settings
from photonmap.study.recommend import PATH, Correction, Law, laws, pareto_front, total_error
from photonmap.study.reference import Reference
from photonmap.study.sweeps import Extent, effects_on, run_sweeps
from photonmap.study.words import duration, percent, recommend, two_digits

OWN = {"radiance": 0.001, "direct": 0.001, "indirect": 0.001, "shading": 0.001}


def point(sweep="passes", bands="6", passes=16, error=0.02, seconds=1.0, off=None, **more):
    """A made-up point, stated and true alike; `off` is the colour error of its bands."""
    settings = Settings(
        bands=bands, passes=passes, photons=1000, method="path" if sweep == "path" else "photon"
    )
    errors = dict.fromkeys(OWN, error)
    color = off and ColorError(1.0, 2.0, 1.5, 3.0, off, off, off, 2.0 * off)
    given = {"label": f"{passes} passes", "rays": None, "photons": 1000 * passes, "wall": seconds}
    return Point(
        **{"sweep": sweep, "settings": settings, "seconds": seconds, "processor": 2.0 * seconds}
        | {"stated": errors, "true": errors, "mean_difference": 0.0, "color": color}
        | given
        | more
    )


def law(label, factor=0.1, each=0.1, spectral=0.0, indirect=math.nan, most=1000):
    return Law(label, Power(factor, -0.5), Cost(0.0, each), most, spectral, indirect)


def test_a_power_is_found_exactly():
    x = np.array([1.0, 2.0, 5.0, 100.0])
    found = fit_power(x, 3.0 * x**-0.5)
    assert found.factor == pytest.approx(3.0)
    assert found.exponent == pytest.approx(-0.5)
    assert found.uncertainty == pytest.approx(0.0, abs=1e-9)
    assert found.inverse(found.at(7.0)) == pytest.approx(7.0)


def test_the_uncertainty_of_slopes_is_honest():
    # 400 fits of 8 points: Student's t with 6 degrees of freedom, P(|t| > 3.707) = 1%.
    rng = np.random.default_rng(5)
    x = 2.0 ** np.arange(8)
    missed = 0
    for _ in range(400):
        found = fit_power(x, 0.2 * x**-0.5 * np.exp(rng.normal(0.0, 0.1, 8)))
        missed += abs(found.exponent + 0.5) > 3.707 * found.uncertainty
    assert missed <= 13  # binomial(400, 0.01) exceeds it with a chance of 1e-4


@pytest.mark.parametrize("x", [[], [1.0], [2.0, 2.0], [1.0, 0.0], [1.0, math.nan]])
def test_no_power_from_too_little(x):
    assert fit_power(x, [1.0] * len(x)) is None


def test_two_points_have_a_slope_without_uncertainty():
    found = fit_power([1.0, 4.0], [1.0, 0.5])
    assert found.exponent == pytest.approx(-0.5)
    assert math.isnan(found.uncertainty)


def test_costs():
    passes = [2, 8, 64]
    found = fit_cost(passes, [0.3 + 0.05 * count for count in passes])
    assert found.setup == pytest.approx(0.3)
    assert found.seconds(100) == pytest.approx(5.3)
    assert fit_cost([1, 2], [1.0, 5.0]).setup == 0.0  # never negative
    assert fit_cost([4], [2.0]) == Cost(0.0, 0.5)


def test_the_pareto_front():
    costs, errors = [1.0, 2.0, 2.0, 3.0, 4.0], [5.0, 4.0, 3.0, 3.5, 1.0]
    assert pareto_front(costs, errors) == [0, 2, 4]
    assert pareto_front([], []) == []


def test_estimates_know_where_they_were_measured():
    some = law("6 bands", factor=0.1, each=0.5, most=100)
    near, far, least = (some.seconds_to(target) for target in (0.0101, 0.00501, 0.9))
    assert (near.passes, near.extrapolated) == (99, False)
    assert (far.passes, far.extrapolated) == (399, True)
    assert far.seconds == pytest.approx(199.5)
    assert least.passes == 16  # what --error never stops before
    assert law("3 bands", spectral=0.03).total_after(0.625 * 10) == pytest.approx(
        math.hypot(0.1 / math.sqrt(62.5), 0.03)
    )


def made_up():
    """Points of 3, 6 and 81 bands whose laws are known: 6 bands have error² · seconds = 0.01."""
    found = [
        point(passes=n, error=0.4 / math.sqrt(n), seconds=n / 16) for n in (2, 4, 8, 16, 32, 64)
    ]
    for bands, slower, off in (("81", 2.0, None), ("3", 0.5, 0.03), ("6", 1.0, 0.01)):
        found += [
            point("bands", bands, n, 0.4 / math.sqrt(n), slower * n / 16, off) for n in (8, 32)
        ]
    return found + [
        point("path", passes=n, error=4.0 / math.sqrt(n), seconds=n / 32) for n in (2, 8, 32)
    ]


def test_laws_of_made_up_points():
    three, six, many, path = laws(made_up(), "6", Correction())
    assert [some.label for some in (three, six, many, path)] == [
        "3 bands", "6 bands", "81 bands", PATH,
    ]  # fmt: skip
    assert six.noise.exponent == pytest.approx(-0.5)
    assert six.seconds_to(0.02).seconds == pytest.approx(25.0, rel=0.01)
    assert six.seconds_to(0.02).extrapolated
    assert three.cost.each == pytest.approx(0.5 * six.cost.each)
    assert many.cost.each == pytest.approx(2.0 * six.cost.each)
    assert (three.spectral, three.indirect) == (0.03, 0.06)
    assert path.seconds_to(0.1).seconds == pytest.approx(50.0, rel=0.01)
    assert laws([], "6", Correction()) == []


def test_the_recommendation_in_words():
    first, *rest = recommend(laws(made_up(), "6", Correction()), "6")
    assert first == (
        "1% on shading: 100 s (extrapolated) with 6 bands, 2.0% colour error in indirect light; "
        "50% of that time with 3 bands, but 6.0% colour error in indirect light; "
        "path tracing: 83 min (extrapolated)."
    )
    assert rest[0] == "5% on shading: 4.0 s with 6 bands; path tracing: 3.3 min (extrapolated)."
    assert rest[-2] == (
        "No time brings the colour of shading of 3 bands below 3.0%, of 6 bands below 1.0%."
    )
    assert rest[-1].startswith("Noise and colour of shading together are least with 3 bands, 6 b")
    assert rest[-1].endswith(" on.")
    assert recommend([], "6") == []


def test_the_recommendation_of_more_bands():
    found = [law("6 bands", indirect=0.03), law("31 bands", each=0.12, indirect=0.001)]
    first = recommend(found, "6")[0]
    assert "; 1.2 times the time with 31 bands, 0.10% colour error in indirect light." in first
    assert "path" not in first


def test_numbers_in_words():
    assert [two_digits(value) for value in (0.0, 0.0123, 0.1, 9.94, 12.3, 1234.0)] == [
        "0", "0.012", "0.10", "9.9", "12", "1234",
    ]  # fmt: skip
    assert [duration(value) for value in (0.5, 119.0, 121.0, 7300.0)] == [
        "0.50 s", "119 s", "2.0 min", "2.0 h",
    ]  # fmt: skip
    assert percent(0.041) == "4.1%"


def test_stated_errors_are_corrected_where_the_truth_is_unknown():
    true = dict.fromkeys(OWN, 0.04)
    points = [point(error=0.02, true=true), point(error=0.02, true=dict.fromkeys(OWN, 0.0005))]
    found = Correction.measure(points, own_error=0.001)
    assert found.ratio == 2.0
    assert found.error(points[0]) == 0.04
    assert found.error(points[1]) == 0.04  # below the reference's own error: stated, corrected
    assert Correction.measure([], 0.001).ratio == 1.0
    total = total_error(points[0], found, {"6": (0.03, 0.1)})
    assert total == pytest.approx(0.05)


def test_findings_of_made_up_points():
    found = Findings(made_up(), "6", OWN)
    assert found.slope("passes", "shading").exponent == pytest.approx(-0.5)
    assert found.slope_by_passes("path", "shading").exponent == pytest.approx(-0.5)
    assert {p.settings.passes for _, p in found.most_passes("bands")} == {32}
    assert found.bias.settings.passes == 32
    seconds = [p.seconds for _, p in found.front]
    assert seconds == sorted(seconds)
    assert {p.settings.bands for _, p in found.front} == {"3", "6"}


def test_a_change_is_told_from_noise():
    noise = dict.fromkeys(OWN, 0.03)
    assert beyond_noise(point(stated=noise, true=dict.fromkeys(OWN, 0.05))) == pytest.approx(0.04)
    assert beyond_noise(point(stated=noise, true=dict.fromkeys(OWN, 0.031))) is None


def test_the_clock():
    points = [point(seconds=8.0)]
    assert machine.choose_clock(points, 0.02, threads=2) == points
    assert machine.choose_clock(points, 0.6, threads=4)[0].seconds == 4.0
    described = machine.describe_machine()
    assert described["processors"] >= 1
    assert described["processor"]
    with machine.Others() as others:
        pass
    assert others.share >= 0.0


def noisy(seed, sigma, shape=(60, 60, 2)):
    """A result whose buffers are noise around 1, and around 3 in the second band."""
    rng = np.random.default_rng(seed)
    truth = np.broadcast_to([1.0, 3.0], shape)
    buffers = {
        name: (truth * (1.0 + rng.normal(0.0, sigma, shape))).astype(np.float32) for name in OWN
    }
    errors = {name: (sigma * truth).astype(np.float32) for name in OWN}
    coverage, dark = np.ones(shape[:2], np.float32), np.zeros(shape, np.float32)
    record = {"passes": 4, "seconds": {"render": 1.0}}
    buffers |= {"coverage": coverage, "emission": dark}
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
    assert stated_error(result, "radiance", mask) == pytest.approx(result.record["error"], rel=1e-4)
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
    assert not differences(np.ones((2, 2, 3)), np.zeros((2, 2, 3))).any()


def test_pictures_stand_in_the_page(cornell):
    uri = data_uri(np.zeros((5, 7, 3), np.uint8))
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
    assert stdout.startswith("1% on shading: ")
    assert f"{len(rows)} points: {study_folder / 'study.html'}" in stdout
    stderr = (study_folder.parent / "stderr").read_text()
    assert " reference" in stderr
    assert "6 bands: " in stderr


def test_the_page_holds_everything(study_folder):
    page = (study_folder / "study.html").read_text(encoding="utf-8")
    assert "1% on shading: " in page
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
    settings = Settings(size=(8, 8), photons=500)
    return Study(cornell, settings, None, 1, Silent(), lambda line: None)


def test_all_of_a_study_in_a_few_pixels(tiny):
    extent = Extent(0.5, ("rgb", "3", "81"), (1, 2), (1, 2), (1,), repeats=2, forced=False)
    run_sweeps(tiny, extent)
    assert len(tiny.of("photons")) == len(tiny.of("resolution")) == 2
    assert [p.settings.bands for p in tiny.of("bands")] == ["81", "rgb", "3", "6"]
    assert tiny.of("bands")[0].color is None
    assert effects_on(tiny) == ["emission", "direct", "soft_shadows", "indirect"]
    assert tiny.of("resolution")[1].settings.size == (16, 16)
    assert tiny.of("resolution")[1].error_map.kind == "stated"
    assert tiny.of("resolution")[1].true == {}


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
    assert process.returncode == 130
    assert list(tmp_path.iterdir()) == []


def test_a_study_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(files, "write_table", fail)
    monkeypatch.setattr(files, "write_page", lambda *_: "")
    with pytest.raises(OSError, match="disk full"):
        files.write_study(tmp_path / "box", Findings([], "6", OWN), None)
    assert list(tmp_path.iterdir()) == []


BAD = {
    "no scene": (["nowhere.obj"], "nowhere.obj"),
    "no bands": (["box.obj", "--bands", "nosuch"], "nosuch"),
    "a file": (["box.obj", "--output", "box.obj"], "this is a file"),
    "no folder": (["box.obj", "--output", "no/such/folder"], "create it"),
    "half a camera": (["box.obj", "--origin", "0,0,5"], "--target"),
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


@pytest.mark.parametrize("arguments", [["--minutes", "0"], ["--minutes", "x"], ["--size", "8"]])
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


def test_the_table_is_a_table():
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS)
    writer.writerow(point(off=0.01).row())
    assert len(next(csv.reader([text.getvalue()]))) == len(COLUMNS)
