"""The command `sensors`: its tables, files and plots."""

import argparse
import csv
from pathlib import Path

import numpy as np
import pytest

from photonmap.commands import sensors as command
from photonmap.errors import InputError
from photonmap.report import plots
from photonmap.runtime import writing


def run(*arguments):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    command.run(parser.parse_args(list(map(str, arguments))))


@pytest.fixture
def reflectances(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "some.csv"
    path.write_text("nm,red,blue,grey\n380,.2,.8,.5\n550,.3,.4,.5\n780,.9,.3,.5\n")
    return path


def test_the_command_prints_and_writes(reflectances, capsys, tmp_path):
    run("--reflectances", reflectances, "--bands", "3,box:2", "--bounces", 3, "--csv", "out.csv")
    text = capsys.readouterr().out
    assert "3 reflectances" in text
    assert "some.csv" in text
    assert "D65" in text
    assert "Eq. 4" in text
    assert "regression" in text
    with Path("out.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["bands", "bounces", "mean_percent", "max_percent"]
    assert [row[:2] for row in rows[1:]] == [[b, m] for b in ("3", "box:2") for m in "123"]
    for row in rows[1:]:
        assert all(0.0 < float(cell) < 100.0 and len(cell.strip("0.")) >= 4 for cell in row[2:])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.csv", "some.csv"]


def test_one_bounce_has_no_rows_of_two(reflectances, capsys):
    counts = {}
    for most in (1, 2):
        run("--reflectances", reflectances, "--bands", "box:2", "--bounces", most)
        rows = [line.split() for line in capsys.readouterr().out.splitlines()]
        counts[most] = [row[1] for row in rows if row[:1] == ["box:2"]]
    assert counts[1] == ["1", "1"]
    assert counts[2] == ["1", "2", "2", "1", "2"]  # within the bands, of Eq. 4, and of ΔE2000


def test_the_command_takes_its_set_from_the_environment(reflectances, capsys, monkeypatch):
    monkeypatch.setenv("PHOTONMAP_MUNSELL", str(reflectances))
    run("--bands", "1", "--bounces", 1, "--illuminant", "A", "--range", "450:650", "--dark", 0)
    text = capsys.readouterr().out
    assert f"3 reflectances, {reflectances}" in text
    assert "illuminant A" in text


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--bands", "rgb"], "rgb"),
        (["--bands", "3,nosuch"], "nosuch"),
        (["--bands", "0"], "0"),
        (["--range", "700:400"], "700"),
        (["--illuminant", "nosuch"], "nosuch"),
        (["--illuminant", "0"], "emits nothing"),
        (["--dark", "95"], "too dark"),
        (["--csv", "some.csv/x.csv"], "Not a directory"),
        (["--csv", "."], "folder"),
        (["--plot", "some.csv/x.png"], "Not a directory"),
        (["--plot", "x.gif"], ".svg"),
        (["--reflectances", "nowhere.csv"], "nowhere.csv"),
        (["--munsell", "nowhere.npz"], "nowhere.npz"),
    ],
)
def test_bad_input(reflectances, capsys, arguments, named):
    given = [] if {"--reflectances", "--munsell"} & {*arguments} else [reflectances]
    with pytest.raises(InputError) as error:
        run(*(["--reflectances", *given] if given else []), *arguments)
    assert named in str(error.value)
    assert capsys.readouterr().out == ""
    assert [path.name for path in Path.cwd().iterdir()] == ["some.csv"]


@pytest.mark.parametrize(
    "arguments",
    [["--range", "400"], ["--bounces", "17"], ["--bounces", "x"], ["--dark=-1"], ["--step", "0"]],
)
def test_bad_flags(arguments, capsys):
    with pytest.raises(SystemExit):
        run(*arguments)
    assert arguments[0].partition("=")[0] in capsys.readouterr().err


@pytest.mark.parametrize("bounces", [1, 2])
@pytest.mark.parametrize("suffix", plots.SUFFIXES)
def test_plots(reflectances, suffix, bounces):
    pytest.importorskip("matplotlib")
    counts = "--bands", "1,2", "--bounces", bounces
    run("--reflectances", reflectances, *counts, "--plot", "x" + suffix)
    head = Path("x" + suffix).read_bytes()[:200]
    assert {".png": b"PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix] in head
    assert len(list(Path.cwd().iterdir())) == 2


def test_plots_say_what_they_need(monkeypatch, tmp_path):
    monkeypatch.setattr(plots, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="plots need matplotlib"):
        plots.check_plot(tmp_path / "x.png")


def test_labels_move_apart():
    assert plots.apart([0.0, 1.0, 1.0, 3.0], 0.5) == [0.0, 0.75, 1.25, 3.0]
    assert np.diff(plots.apart([0.0, 0.1, 0.2, 0.3], 1.0)) == pytest.approx(1.0)


def test_a_broken_write_leaves_nothing(tmp_path):
    (tmp_path / "x.csv").write_text("old")
    with pytest.raises(FileNotFoundError), writing.replacing(tmp_path / "x.csv") as part:
        part.with_name("y").rename(part)
    assert (tmp_path / "x.csv").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1
