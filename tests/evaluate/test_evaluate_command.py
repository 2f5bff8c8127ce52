"""The command: tables, files, exit codes; the page in a browser."""

import csv
import re
import shutil

import numpy as np
import pytest
from helpers import browser

from photonmap.commands.main import main
from photonmap.evaluate.report.tables import number
from photonmap.io.png import write_png
from photonmap.report import pages


def command(folder, *more):
    return main(["evaluate", str(folder), *map(str, more)])


@pytest.fixture
def in_tmp(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


LMSE = ("lmse", "mean")
METHODS = ["--method", "constant-shading,color-retinex,grey-world", "--draws", "2"]


@pytest.fixture(scope="module")
def report(known, tmp_path_factory):
    """The folder of a report, and what was printed."""
    folder = tmp_path_factory.mktemp("reports") / "report"
    assert command(known[0], *METHODS, "--metrics", "lmse,delta-e,angle", "--output", folder) == 0
    return folder


def test_tables_agree(report):
    scores, summary = rows(report / "scores.csv"), rows(report / "summary.csv")
    assert len(scores) == 2 * 6 * 4 + 6
    for row in summary:
        if row["figure"] != "mean":
            continue
        keys = ("method", "metric", "layer")
        of = [float(s["score"]) for s in scores if all(s[key] == row[key] for key in keys)]
        assert float(row["value"]) == pytest.approx(np.mean(of))
        assert float(row["low"]) <= float(row["value"]) <= float(row["high"])
        assert (row["scored"], row["failed"]) == ("6", "0")


def test_latex_shows_the_best_in_bold(report):
    tables = (report / "table.tex").read_text().split(r"\begin{tabular}")[1:]
    summary = {(s["method"], s["metric"], s["layer"]): s for s in rows(report / "summary.csv")}
    decompositions, illuminants = ([line for line in t.splitlines() if "&" in line] for t in tables)
    assert decompositions[0] == " & lmse & delta-e " + 2 * "\\"
    assert len(decompositions) == 1 + 2 * 2
    shown = {line.split(" & ")[0]: line for line in decompositions[1::2]}
    first, second = (
        float(summary[method, "lmse", "mean"]["value"])
        for method in ("constant-shading", "color-retinex")
    )
    best, other = sorted(shown, key=lambda m: float(summary[m, "lmse", "mean"]["value"]))
    assert rf"& \textbf{{{number(min(first, second))}}} &" in shown[best]
    assert f"& {number(max(first, second))} &" in shown[other]
    assert illuminants[0].count("angle, ") == 5
    assert all(line.count("&") == 5 for line in illuminants)


def test_the_default_folder_and_the_text(known, in_tmp, capsys):
    assert command(known[0], "--method", "constant-shading", "--metrics", "lmse,si-mse") == 0
    out, err = capsys.readouterr()
    head, line = out.splitlines()[:2]
    assert head.split() == ["lmse", "reflectance", "shading", "mean", "images"]
    assert re.fullmatch(r"constant-shading(  [\d.]+ \[[\d.]+, [\d.]+\]){3}  6 of 6", line)
    assert out.splitlines()[-1].endswith("known-evaluation/report.html")
    assert "6/6 scene-2-colored" in err
    assert "too narrow: they are over 3 scenes, fewer than 10." in out.splitlines()[-2]
    names = {"report.html", "scores.csv", "summary.csv", "table.tex"}
    assert {path.name for path in (in_tmp / "known-evaluation").iterdir()} == names
    assert command(known[0], "--method", "constant-shading", "--metrics", "lmse", "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_predictions_with_holes(known, in_tmp, capsys):
    """Two images are missing, one has another size; both are said, and exit code 1."""
    folder, layers = known
    for name in list(layers)[:4]:
        size = (24, 32, 3) if name != "scene-1-white" else (24, 30, 3)
        (in_tmp / "net" / name).mkdir(parents=True)
        grey = np.full(size, 128, np.uint8)
        write_png(grey, in_tmp / "net" / name / "reflectance.png")
    assert command(folder, "--predictions", "net", "--metrics", "lmse", "--png", "linear") == 1
    out, err = capsys.readouterr()
    assert "net   " in out
    assert "3 of 6, 3 failed" in out
    assert "PNG was read as linear (--png srgb reads it as sRGB)" in out
    assert "failed: net: scene-1-white: reflectance: the estimate is 30×24 in 3 bands" in err
    assert "failed: net: scene-2-white, scene-2-colored: net: there is no IMAGE/LAYER.png" in err
    scores = rows(in_tmp / "known-evaluation" / "scores.csv")
    assert [row["image"] for row in scores if row["why_none"]] == [
        "scene-1-white",
        "scene-2-white",
        "scene-2-colored",
    ]
    html = (in_tmp / "known-evaluation" / "report.html").read_text()
    assert "3 estimates are missing" in html


def test_logarithms_are_no_prediction(known, in_tmp, capsys):
    """Nor is the truth times −1, which a negative factor would bring to the truth."""
    folder, layers = known
    (in_tmp / "net").mkdir()
    for name in layers:
        reflectance = layers[name].reflectance[..., :3]
        minus = -reflectance if name == "scene-1-white" else np.log(0.5 * reflectance)
        np.savez(in_tmp / "net" / f"{name}.npz", reflectance=minus)
    assert command(folder, "--predictions", "net", "--metrics", "lmse", "--draws", "0") == 2
    message = "net: reflectance: the estimate is negative where the truth is brightest; give linear"
    assert message in capsys.readouterr().err


def test_layers_that_some_predictions_lack_are_counted(known, in_tmp, capsys):
    folder, layers = known
    (in_tmp / "net").mkdir()
    for place, name in enumerate(layers):
        found = {"reflectance": layers[name].reflectance[..., :3]}
        if place >= 2:
            found["shading"] = layers[name].shading[..., :3]
        np.savez(in_tmp / "net" / f"{name}.npz", **found)
    assert command(folder, "--predictions", "net", "--metrics", "lmse", "--draws", "0") == 0
    line = capsys.readouterr().out.splitlines()[1]
    assert re.fullmatch(r"net   \S+ \[[^]]+\]  (\S+ \[[^]]+\] 4 images +){2}6 of 6", line)
    html = (in_tmp / "known-evaluation" / "report.html").read_text()
    assert html.count("] 4 images</small>") == 2


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--method", "retinx"], "there is no method 'retinx'; did you mean 'retinex'?"),
        (["--metrics", "lsme"], "there is no metric 'lsme'; did you mean 'lmse'?"),
        (["--predictions", "nowhere"], "nowhere: is not a folder"),
        (["--method", "retinex,retinex"], "'retinex' is given twice"),
        (["--space", "xyz"], "argument --space: invalid choice"),
        (["--draws", "many"], "argument --draws: 'many' is not a whole number"),
        (["--draws", "-1"], "draws must be 0 or more; got -1"),
        (["--metrics", "delta-e", "--space", "bands"], "delta-e is defined in RGB only"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(known, in_tmp, capsys, more, message):
    assert command(known[0], *more) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert message in err
    assert not list(in_tmp.iterdir())


def test_the_report_of_the_data_set_stays(known, capsys):
    before = {path.name for path in known[0].iterdir()}
    assert command(known[0], "--output", known[0]) == 2
    assert "the data set has a report of its own; choose another" in capsys.readouterr().err
    assert {path.name for path in known[0].iterdir()} == before


def test_unfinished_sets_are_bad_input(known, in_tmp, capsys):
    shutil.copytree(known[0], in_tmp / "part")
    (in_tmp / "part" / "manifest.jsonl").write_text("")
    assert command("part", "--method", "retinex") == 2
    assert "part: the data set is not finished, 6 of 6 images are missing" in (
        capsys.readouterr().err
    )


def test_without_jinja_nothing_is_scored(known, in_tmp, capsys, monkeypatch):
    monkeypatch.setattr(pages, "find_spec", lambda name: None)
    assert command(known[0]) == 2
    assert "pip install 'photonmap[evaluate]'" in capsys.readouterr().err


def test_numbers_have_three_digits():
    values = [0.0123456, 12.3456, 1234.5, 0.0, 1.2e-7]
    assert [number(value) for value in values] == ["0.0123", "12.3", "1.2e+03", "0.00", "1.2e-07"]


def ends_of(report):
    """The images with the lowest and highest LMSE, or angle, by method."""
    found = {}
    for row in rows(report / "scores.csv"):
        if (row["metric"], row["layer"]) in (LMSE, ("angle", "illuminant")):
            found.setdefault(row["method"], []).append((float(row["score"]), row["image"]))
    assert len(found) == 3
    return {method: (min(scores)[1], max(scores)[1]) for method, scores in found.items()}


def test_the_page_is_complete(report):
    html = (report / "report.html").read_text()
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", html)
    assert html.count('<div class="case">') == 3 * 2
    assert 'id="metric-delta-e"' in html
    for method, (best, worst) in ends_of(report).items():
        shown = html.partition(f"<h3>{method}</h3>\n<div")[2].partition("<h3>")[0]
        assert re.findall(r"(best|worst): (\S+),", shown) == [("best", best), ("worst", worst)]
    assert "permutation test" in html
    scores = [s for s in rows(report / "scores.csv") if (s["metric"], s["layer"]) == LMSE]
    for method in ("constant-shading", "color-retinex"):
        of = [float(s["score"]) for s in scores if s["method"] == method]
        assert f">{number(np.mean(of[:2]))}</td>" in html.partition("<td>scene-0</td>")[2][:200]
        assert f">{number(of[5])}</td>" in html.partition("<td>scene-2-colored</td>")[2][:200]


@pytest.mark.skipif(browser.find() is None, reason="no Chromium here")
def test_the_page_in_a_browser(report):
    with browser.Page((report / "report.html").as_uri()) as shown:
        assert shown.errors == []
        assert {url.partition(":")[0] for url in shown.requests} <= {"file", "data"}
        column = (
            "[...document.querySelectorAll('#metric-lmse tbody tr')]"
            ".map(row => Number(row.cells[1].dataset.sort))"
        )
        head = "document.querySelectorAll('#metric-lmse th')[1]"
        shown.run(f"{head}.click()")
        values = shown.run(column)
        assert values == sorted(values)
        shown.run(f"{head}.click()")
        assert shown.run(column) == values[::-1]
        assert shown.run(f"{head}.getAttribute('aria-sort')") == "descending"
        assert shown.run("[...document.images].every(i => i.complete && i.naturalWidth > 0)")
