"""Experiments: on scores that are made up, on degraded truths, and by the command."""

import csv
from dataclasses import replace
from itertools import permutations
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import browser
from scipy.stats import ttest_1samp

import photonmap as pm
from photonmap import InputError, evaluate
from photonmap.commands.main import main
from photonmap.evaluate.bench.images import (
    COLORS_OF_LIGHT,
    COMPLEX,
    CONTENTS,
    OBJECT,
    Kind,
    Truth,
    in_direct_light,
    kind_of,
)
from photonmap.evaluate.bench.measure import Column, Measured, checked, choose_metrics, measure
from photonmap.evaluate.bench.scores import MethodScores
from photonmap.evaluate.experiments import degradations, paper_table, run_experiments
from photonmap.evaluate.experiments.lmse import cost_table, sample_tables, scenes_needed


def truth_of(reflectance, shading):
    mask = np.ones(reflectance.shape[:2], bool)
    regions = np.tile(np.arange(reflectance.shape[1]) // 8 + 1, (reflectance.shape[0], 1))
    return Truth("one", "scene", reflectance * shading, reflectance, shading, regions, mask, {})


def patches(size=(32, 40), bands=3):
    rng = np.random.default_rng(4)
    colors = rng.uniform(0.2, 0.9, (5, bands))
    reflectance = np.broadcast_to(colors[np.arange(size[1]) // 8], (*size, bands))
    return reflectance, np.linspace(0.3, 1.0, size[0])[:, None, None] * np.ones((*size, bands))


def evaluation_of(scores, kinds, scenes, draws=None):
    """An evaluation with an LMSE for reflectance, shading and both of each image, by method."""
    names = [f"image-{place}" for place in range(len(kinds))]
    methods = []
    for method, (reflectance, shading) in scores.items():
        found = MethodScores(method)
        for name, r, s in zip(names, reflectance, shading, strict=True):
            layers = {"reflectance": r, "shading": s, "mean": (r + s) / 2}
            columns = {Column("lmse-color", layer): value for layer, value in layers.items()}
            found.measured[name] = Measured(columns, {})
            if draws:
                found.draws[name] = [{c: v + draws for c, v in columns.items()}]
        methods.append(found)
    return evaluate.Evaluation("made up", "rgb", names, scenes, kinds, methods)


def test_kinds_of_images():
    def kind(scene, *colors):
        return kind_of(SimpleNamespace(entry={"job": {"scene": scene, "colors": colors}}))

    assert kind("vase", "D65") == Kind(OBJECT, "white")
    assert kind("study", "HPS") == Kind(COMPLEX, "one colour")
    assert kind("study", "D65", "planck:2300") == Kind(COMPLEX, "two lights")
    assert kind("room.obj") == Kind("", "")


@pytest.mark.parametrize("space", ["bands", "rgb"])
def test_direct_light_alone(space):
    """Direct light falls off downwards; indirect light, to the right, is left out."""
    reflectance, seen = (layer.astype(np.float32) for layer in patches(bands=4))
    indirect = np.linspace(0.0, 1.0, 40, dtype=np.float32)[None, :, None] * reflectance
    direct = reflectance * seen
    buffers = {
        "radiance": direct + indirect, "direct": direct, "indirect": indirect,
        "reflectance": reflectance, "shading": seen + indirect / reflectance,
        "emission": np.zeros_like(direct),
    }  # fmt: skip
    bands = pm.Bands.parse(4)
    image = SimpleNamespace(result=pm.Result(buffers, {}, bands, {}), folder="folder")
    whole = truth_of(*(a.astype(float) for a in (reflectance, buffers["shading"])))
    found = in_direct_light(image, whole, space)
    assert found.mask.all()
    ratio = found.shading / found.shading[:, :1]
    np.testing.assert_allclose(ratio, 1.0, rtol=1e-4)
    np.testing.assert_allclose(
        found.shading[:, 0].mean(axis=-1) / found.shading[-1, 0].mean(),
        seen[:, 0, 0] / seen[-1, 0, 0],
        rtol=1e-4,
    )
    if space == "bands":
        ratio = found.radiance / (reflectance * found.shading)
        np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-4)
    black = dict(buffers, reflectance=reflectance.copy())
    black["reflectance"][3, 4, 1] = 0.0
    black["direct"] = black["reflectance"] * seen
    black["indirect"] = black["reflectance"] * (indirect / reflectance)
    black["radiance"] = black["direct"] + black["indirect"]
    image.result = pm.Result(black, {}, bands, {})
    assert not in_direct_light(image, whole, space).mask[3, 4]
    glossy = dict(buffers, residual=0.1 * direct)
    image.result = pm.Result(glossy, {}, bands, {})
    with pytest.raises(InputError, match=r"not diffuse.*--materials lambertian"):
        in_direct_light(image, whole, space)


def test_direct_light_that_fluoresces_is_no_shading():
    reflectance, seen = (layer.astype(np.float32) for layer in patches(bands=4))
    zero, direct = np.zeros_like(reflectance), reflectance * seen
    buffers = {
        "radiance": 1.5 * direct, "direct": 1.2 * direct, "indirect": 0.3 * direct,
        "fluorescence": 0.5 * direct, "reflectance": reflectance, "shading": seen,
        "emission": zero, "residual": zero,
    }  # fmt: skip
    bands, whole = pm.Bands.parse(4), truth_of(reflectance.astype(float), seen.astype(float))
    image = SimpleNamespace(result=pm.Result(buffers, {}, bands, {}), folder="folder")
    with pytest.raises(InputError, match=r"fluoresce.* fluorescence_direct to --buffers"):
        in_direct_light(image, whole, "bands")
    buffers["fluorescence_direct"] = 0.2 * direct
    image.result = pm.Result(buffers, {}, bands, {})
    found = in_direct_light(image, whole, "bands")
    for layer, wanted in (("shading", seen), ("radiance", 1.2 * direct)):
        ratio = getattr(found, layer) / wanted
        np.testing.assert_allclose(ratio, ratio.flat[0], rtol=1e-5)


def papers_evaluation(rows):
    kinds = [Kind(content, light) for content in CONTENTS for light in COLORS_OF_LIGHT]
    scores = {
        name: (
            list(paper_table._PAPER.values())[row][:6],
            list(paper_table._PAPER.values())[row][6:],
        )
        for name, row in rows.items()
    }
    return evaluation_of(scores, kinds, [f"scene-{place}" for place in range(6)])


def test_the_papers_own_figures_agree_with_the_paper():
    table = paper_table.paper_tables(papers_evaluation({"sirfs": 0, "gehler": 1, "serra": 2}))[0]
    assert len(table.heads) == 13
    assert [name for name, _ in table.rows][:3] == ["sirfs", "gehler", "serra"]
    for (_, ours), (_, theirs) in zip(table.rows[:3], table.rows[3:], strict=True):
        np.testing.assert_allclose([c.value for c in ours], [c.value for c in theirs])
    for line in table.findings[:3]:
        assert "in the paper for 3 of 3 methods, here for 3 of 3." in line, line
    assert table.findings[3] == "sirfs and gehler rank as in the paper in 11 of 11 columns."


def test_disagreement_with_the_paper_is_said():
    table = paper_table.paper_tables(papers_evaluation({"sirfs": 1, "gehler": 0}))[0]
    assert table.findings[3] == "sirfs and gehler rank as in the paper in 0 of 11 columns."
    flat = evaluation_of(
        {"mine": ([0.1] * 6, [0.1] * 6)}, papers_evaluation({}).kinds, list("abcdef")
    )
    assert "here for 0 of 1." in paper_table.paper_tables(flat)[0].findings[0]
    half = evaluation_of({"mine": ([0.1] * 6, [np.nan] * 6)}, flat.kinds, list("abcdef"))
    assert list(paper_table.paper_tables(half)[0].findings) == []
    unknown = [Kind("", "")] * 2
    nothing = evaluation_of({"m": ([1, 2], [3, 4])}, unknown, ["a", "b"])
    assert paper_table.paper_tables(nothing) == []


def test_costs_are_mean_changes():
    """In three lights; indirect light costs 0.01, colour 0.02, the second light −0.005."""
    lights, scenes = list(COLORS_OF_LIGHT) * 6, [f"scene-{place // 3}" for place in range(18)]
    kinds = [Kind(OBJECT, light) for light in lights]
    steps = np.array([0.0, 0.02, 0.015] * 6)
    base = np.repeat(np.linspace(0.1, 0.2, 6), 3)

    def made(extra, draws=None):
        both = base + steps + extra
        return evaluation_of({"mine": (both, both)}, kinds, scenes, draws)

    table = cost_table(made(0.0, 0.003), made(-0.01), made(0.004))
    name, cells = table.rows[0]
    assert name == "mine"
    values = [cell.value for cell in cells]
    np.testing.assert_allclose(
        values, [base.mean() + steps.mean(), 0.01, 0.02, -0.005, 0.004, 0.003], atol=1e-12
    )
    assert "p 0.0312" in cells[1].note  # 2 of 2⁶ ways to swap six scenes
    assert (
        "Interreflection: raises the error of 1 of 1 methods and lowers that of 0"
        in (table.findings[0])
    )
    assert "lowers that of 1" in table.findings[2]


def test_the_number_of_scenes_has_the_power_it_promises():
    rng = np.random.default_rng(0)
    sample = rng.normal(0.3, 1.0, 100_000)
    needed = round(scenes_needed(sample))
    assert needed == pytest.approx((2.80159 / 0.3) ** 2, rel=0.03)
    trials = rng.normal(0.3, 1.0, (4000, needed))
    found = (ttest_1samp(trials, 0.0, axis=1).pvalue < 0.05).mean()
    assert found == pytest.approx(0.8, abs=0.03)


def test_rankings_by_few_scenes():
    """The first method is better by far in all scenes, the other two alternate."""
    first = np.full(8, 0.1)
    second = np.array([0.5, 0.6] * 4)
    third = np.array([0.6, 0.51] * 4)
    scores = {"a": (first, first), "b": (second, second), "c": (third, third)}
    names = [f"scene-{place}" for place in range(8)]
    stability, pairs = sample_tables(evaluation_of(scores, [Kind("", "")] * 8, names))
    assert stability.rows[0][0] == "1"
    assert stability.rows[0][1][0].value == pytest.approx((1 + 1 + 0.5) / 3, abs=0.03)
    assert stability.rows[0][1][1].value == pytest.approx(2 / 3)
    needed = {name: cells[1].value for name, cells in pairs.rows}
    assert needed["a and c"] <= 3 < 8 < needed["b and c"]
    assert pairs.findings == ["8 scenes are enough for 2 of 3 pairs."]


def test_degradations_keep_what_they_do_not_touch():
    reflectance, shading = patches()
    truth = truth_of(reflectance, shading)
    moving = [degradations.DEGRADATIONS[name] for name in ("bleed", "tint", "wrong scale")]
    for degrade in moving:
        found = degrade(truth, (reflectance, shading), 4)
        np.testing.assert_allclose(found[0] * found[1], truth.radiance)
        assert not np.allclose(found[1], shading)
    for first, second in permutations(moving, 2):  # none takes back a part of another
        one_way = second(truth, first(truth, (reflectance, shading), 4), 2)
        other_way = first(truth, second(truth, (reflectance, shading), 2), 4)
        np.testing.assert_allclose(one_way, other_way)
    flat = replace(truth, reflectance=np.ones_like(reflectance), mask=truth.mask.copy())
    flat.mask[:4] = False
    blurred = degradations.DEGRADATIONS["blur"](flat, (flat.reflectance, flat.shading), 8)
    np.testing.assert_allclose(blurred[0][flat.mask], 1.0)


def test_metrics_that_order_degradations():
    """LMSE sees each of them get worse; chromaticity cannot see a wrong scale."""
    metrics = choose_metrics(["lmse", "albedo-chromaticity", "angle"], "rgb")
    test = degradations.OrderTest(metrics)
    truth = truth_of(*patches())
    test.add(truth)
    table = test.table()
    shares = {name: [cell.value for cell in cells] for name, cells in table.rows}
    assert set(shares) == {"lmse", "albedo-chromaticity"}
    assert shares["lmse"][:4] == [1.0] * 4
    assert shares["albedo-chromaticity"][3] == 0.0
    assert "Wrong scale is missed more often than seen by albedo-chromaticity." in table.findings
    assert degradations.rightly([0.0, 1.0, 1.0, 2.0, 1.5]) == 0.5
    perfect = evaluate.Estimate(truth.reflectance, truth.shading)
    assert measure(checked(perfect, truth), truth, metrics).scores[Column("lmse", "mean")] < 1e-12


@pytest.fixture(scope="module")
def report(known, tmp_path_factory):
    """Degradations are measured by two metrics alone."""
    folder = tmp_path_factory.mktemp("reports") / "report"
    arguments = ["--method", "constant-shading,color-retinex,grey-world", "--draws", "1"]
    metrics = ["--metrics", "lmse-color,angle", "--experiments", "--quiet"]
    metrics += ["--costs-of", "color-retinex"]
    with pytest.MonkeyPatch.context() as patch:
        two = choose_metrics(["lmse-color", "dssim"], "rgb")
        patch.setattr(run_experiments, "choose_metrics", lambda *_: two)
        command = ["evaluate", str(known[0]), *arguments, *metrics, "--output", str(folder)]
        assert main(command) == 0
    return folder


TABLES = ("costs", "ranking-by-scenes", "scenes-by-pair", "degradations")


def test_the_command_writes_experiments(report):
    html = (report / "report.html").read_text()
    for name in TABLES:
        assert f'<table id="{name}"' in html
        tabular = (report / f"{name}.tex").read_text()
        with (report / f"{name}.csv").open(newline="") as file:
            rows = list(csv.reader(file))
        assert tabular.count("\\\\\n") == len(rows)
    with (report / "costs.csv").open(newline="") as file:
        costs = list(csv.DictReader(file))
    assert [row["method"] for row in costs] == ["constant-shading", "color-retinex"]
    assert costs[0]["interreflection"] == costs[0]["bands for RGB"] == ""
    assert float(costs[1]["interreflection"]) == pytest.approx(0.0, abs=1e-4)  # there is none
    assert float(costs[1]["bands for RGB"]) != 0.0
    for row in costs:  # lights are of unknown kind
        assert row["one colour for white"] == ""


@pytest.mark.skipif(browser.find() is None, reason="no Chromium here")
def test_experiments_in_a_browser(report):
    with browser.Page((report / "report.html").as_uri()) as shown:
        assert shown.errors == []
        for name in TABLES:
            shown.run(f"document.querySelectorAll('#{name} th')[1].click()")
            values = shown.run(
                f"[...document.querySelectorAll('#{name} tbody tr')]"
                ".map(row => Number(row.cells[1].dataset.sort))"
            )
            assert values == sorted(values)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--experiments", "--space", "bands"], "compare with RGB and all light"),
        (["--experiments", "--light", "direct"], "compare with RGB and all light"),
        (["--experiments", "--metrics", "lmse"], "need the metric lmse-color; add it to --metrics"),
        (["--costs-of", "retinex"], "--costs-of needs --experiments; add it"),
        (
            ["--method", "retinex", "--experiments", "--costs-of", "retinx"],
            "--costs-of retinx is not scored; did you mean 'retinex'?",
        ),
        (["--light", "indirect"], "argument --light: invalid choice"),
    ],
)
def test_experiments_that_cannot_be(known, tmp_path, monkeypatch, capsys, more, message):
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", str(known[0]), *more]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert len(err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_direct_light_by_the_command(known, tmp_path, capsys):
    arguments = ["--method", "constant-shading", "--metrics", "lmse", "--light", "direct"]
    assert main(["evaluate", str(known[0]), *arguments, "--output", str(tmp_path / "r")]) == 0
    assert "those of direct light alone" in capsys.readouterr().out
