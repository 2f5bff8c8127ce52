"""How a process ends: by signals, and with nobody to read what it prints."""

import json
import os
import shlex
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import photonmap as pm
from photonmap.commands import render as render_command
from photonmap.commands.main import main

SCENE = Path(pm.scenes.FOLDER) / "cornell_box.obj"
PHOTONMAP = [sys.executable, "-m", "photonmap"]
QUICK = ["--size", "16x12", "--passes", "2", "--photons", "1000"]
ENDLESS = ["--size", "32x32", "--error", "1e-6"]
FILES = ["cornell_box.exr", "cornell_box.json", "cornell_box.png"]


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def heed_signals():
    """Undo what a test run that was started under `nohup`, or in the background, ignores."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def start(*command, cwd, **streams):
    return subprocess.Popen(
        [*map(str, command)],
        cwd=cwd,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_signals,
        **streams,
    )


def wait_for_a_pass(process):
    assert any(line.startswith("pass ") for line in iter(process.stderr.readline, ""))


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, pytest.param(signal.SIGHUP, marks=pytest.mark.slow)]
)
def test_signals_keep_what_is_done(tmp_path, number):
    """Shells report 143 and 129."""
    process = start(*PHOTONMAP, SCENE, *ENDLESS, cwd=tmp_path)
    wait_for_a_pass(process)
    process.send_signal(number)
    process.communicate(timeout=60)
    assert process.returncode == -number
    assert files_in(tmp_path) == FILES
    record = json.loads((tmp_path / "cornell_box.json").read_text())
    assert record["interrupted"]
    assert pm.load_result(tmp_path / "cornell_box.exr").record["passes"] == record["passes"] >= 1


def test_views_that_were_written_are_counted(tmp_path, monkeypatch, capsys):
    """Ctrl-C before the next view has a pass; before the first one has, nothing is written."""
    box, left = pm.scenes.cornell_box(), []
    cameras = [replace(box.camera, name=name) for name in ("front", "left")]
    pm.save_scene(replace(box, camera=None, cameras=cameras), tmp_path / "box.obj")

    def render(*given):
        if not left.pop():
            raise KeyboardInterrupt

    monkeypatch.setattr(render_command, "_render", render)
    for views, said in (([False, True], "1 of 2 views are written"), ([False], "nothing written")):
        left[:] = views
        assert main([str(tmp_path / "box.obj"), "--camera", "all"]) == 130
        assert capsys.readouterr().err == f"photonmap: interrupted; {said}\n"


def test_ctrl_c_ends_the_loop_of_a_shell(tmp_path):
    """A terminal sends SIGINT to the shell as well, which asks how its child ended: as by 130."""
    again = "for i in 1 2 3; do " + shlex.join([*PHOTONMAP, str(SCENE), *ENDLESS]) + "; done"
    process = start("bash", "-c", again, cwd=tmp_path, start_new_session=True)
    wait_for_a_pass(process)
    os.killpg(process.pid, signal.SIGINT)
    _, rest = process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT
    assert "rendering" not in rest
    assert files_in(tmp_path) == FILES
    assert json.loads((tmp_path / "cornell_box.json").read_text())["interrupted"]


def test_ignored_signals_stay_ignored(tmp_path):
    """As under `nohup`."""
    few = [*PHOTONMAP, str(SCENE), *QUICK[:2], "--seconds", "0.1"]
    process = start("sh", "-c", f"trap '' HUP; exec {shlex.join(few)}", cwd=tmp_path)
    assert any(line.startswith("rendering") for line in iter(process.stderr.readline, ""))
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert not json.loads((tmp_path / "cornell_box.json").read_text())["interrupted"]


@pytest.mark.parametrize(
    "closed", ["both", "no stdout", pytest.param("no stderr", marks=pytest.mark.slow)]
)
def test_output_that_nobody_reads_costs_nothing(tmp_path, closed):
    """Pipes whose reader is gone, and streams that were closed before the start."""
    reader, writer = os.pipe()
    os.close(reader)
    names = {"both": ("stdout", "stderr")}.get(closed, (closed.removeprefix("no "),))
    streams = {name: writer if name in names else subprocess.PIPE for name in ("stdout", "stderr")}
    shut = {"no stdout": " >&-", "no stderr": " 2>&-"}.get(closed, "")
    line = shlex.join([*PHOTONMAP, str(SCENE), *QUICK]) + shut
    done = subprocess.run(
        ["sh", "-c", line], cwd=tmp_path, timeout=300, check=False, text=True, **streams
    )
    os.close(writer)
    assert done.returncode == 0
    assert "Errno" not in f"{done.stdout} {done.stderr}"
    assert files_in(tmp_path) == FILES


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is always full")
def test_a_table_that_cannot_be_printed_is_an_error(tmp_path):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*PHOTONMAP, "info", SCENE],
            stdout=full, stderr=subprocess.PIPE, text=True, cwd=tmp_path, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "photonmap: error: standard output was lost: No space left on device\n"


def test_missing_folders_are_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = ["--output", "some/where/box.exr", "--checkpoint", "other/box.checkpoint", "--quiet"]
    assert main([str(SCENE), *QUICK, *given]) == 0
    assert files_in(tmp_path / "some" / "where") == ["box.exr", "box.json", "box.png"]
    assert files_in(tmp_path / "other") == ["box.checkpoint"]
    merged = ["some/where/box.exr", "more.exr", "-o", "merged/box.exr", "--quiet"]
    assert main([str(SCENE), *QUICK, "--seed", "1", "--output", "more.exr", "--quiet"]) == 0
    assert main(["merge", *merged]) == 0
    assert len(files_in(tmp_path / "merged")) == 3
    assert main(["sensors", "--bands", "3", "--bounces", "1", "--csv", "tables/t.csv"]) == 0
    assert files_in(tmp_path / "tables") == ["t.csv"]
