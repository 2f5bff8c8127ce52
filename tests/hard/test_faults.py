"""Faults from outside: full disks, folders that vanish, caches that rot, signals, little memory."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from helpers.limits import files_of_at_most
from helpers.marks import slow

import photonmap as pm
from photonmap.commands.main import main

SCENE = str(pm.scenes.FOLDER / "cornell_box.obj")
SMALL = ("--size", "32x32", "--passes", "2", "--quiet")
SUFFIXES = (".exr", ".json", ".png")


def start(*arguments, limits=(), code=None, **environment):
    """Start the command line, or a program, with limits of `resource`."""

    def restrict():
        for kind, value in limits:
            resource.setrlimit(kind, (value, value))

    program = ["-c", code] if code else ["-m", "photonmap"]
    return subprocess.Popen(
        [sys.executable, *program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
        preexec_fn=restrict,
    )


def run(*arguments, **options):
    """Run it to its end: exit code, and the lines it printed."""
    process = start(*arguments, **options)
    _, messages = process.communicate(timeout=300)
    return process.returncode, messages.splitlines()


def assert_refused(code, messages, message):
    assert code == 2
    assert len(messages) == 1
    assert messages[0].startswith("photonmap: error: ")
    assert message in messages[0]


def assert_whole_or_nothing(folder, name="out"):
    """Assert that all files of a render are there and sound, or none."""
    files = {path.suffix for path in folder.glob(f"{name}.*")}
    assert files in ({*SUFFIXES}, set())
    if files:
        result = pm.load_result(folder / f"{name}.exr")
        assert np.isfinite(result.radiance).all()
        assert json.loads((folder / f"{name}.json").read_text())["passes"] >= 1
        assert (folder / f"{name}.png").read_bytes()[-8:-4] == b"IEND"


def test_a_disk_that_is_full(tmp_path, capsys):
    """Writing fails half-way: nothing is left, and files of before stay as they were."""
    file = tmp_path / "out.exr"
    with files_of_at_most(20_000):
        code = main([SCENE, *SMALL, "--output", str(file)])
    assert_refused(code, capsys.readouterr().err.splitlines(), f"cannot write {file} (")
    assert not list(tmp_path.iterdir())
    assert main([SCENE, *SMALL, "--output", str(file)]) == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(before) == 3
    with files_of_at_most(20_000):
        assert main([SCENE, *SMALL, "--seed", "1", "--output", str(file)]) == 2
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_an_output_folder_that_vanishes(tmp_path, monkeypatch):
    """It is made again."""
    folder = tmp_path / "gone"
    folder.mkdir()
    module = sys.modules["photonmap.render"]
    render = module.render

    def render_and_vanish(*arguments, **options):
        result = render(*arguments, **options)
        shutil.rmtree(folder)
        return result

    monkeypatch.setattr(module, "render", render_and_vanish)
    assert main([SCENE, *SMALL, "--output", str(folder / "out.exr")]) == 0
    assert {path.suffix for path in folder.iterdir()} == set(SUFFIXES)


@pytest.mark.slow
def test_runs_that_write_the_same_file(tmp_path):
    """Whoever is last wins, file by file; each is whole."""
    runs = [
        start(SCENE, *SMALL, "--seed", seed, "--output", tmp_path / "out.exr") for seed in range(3)
    ]
    assert [process.wait(timeout=300) for process in runs] == [0, 0, 0]
    for process in runs:
        process.communicate()
    assert sorted(path.suffix for path in tmp_path.iterdir()) == sorted(SUFFIXES)
    assert_whole_or_nothing(tmp_path)


SMALL_KERNEL = "from photonmap.kernels.core import warp; print(warp.cosine_hemisphere_pdf(1.0))"


def test_a_cache_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("no folder")
    process = start(code=SMALL_KERNEL, NUMBA_CACHE_DIR=str(tmp_path / "file" / "cache"))
    messages, _ = process.communicate(timeout=300)
    assert float(messages) == pytest.approx(1.0 / np.pi)


@pytest.mark.parametrize("number", [signal.SIGINT, *slow(signal.SIGKILL)])
@pytest.mark.parametrize("seconds", [1.5, *slow(0.3, 2.0)])
def test_signals_at_any_moment(tmp_path, number, seconds):
    """What is written is whole, or not there; Ctrl-C keeps the passes that are complete."""
    process = start(SCENE, "--size", "96x96", "--seconds", 0.8, "--quiet", "--output",
                    tmp_path / "out.exr")  # fmt: skip
    time.sleep(seconds)
    process.send_signal(number)
    _, messages = process.communicate(timeout=300)
    expected = {0, 130, -signal.SIGINT} if number == signal.SIGINT else {0, -signal.SIGKILL}
    assert process.returncode in expected, messages
    assert_whole_or_nothing(tmp_path)


def test_a_limit_of_memory(tmp_path):
    """`ulimit -v`: refused before work begins, with numbers and a remedy."""
    limits = [(resource.RLIMIT_AS, 2 << 30)]
    code, messages = run(SCENE, "--size", "2048x2048", "--bands", 16, "--passes", 1, "--quiet",
                     "--output", tmp_path / "out.exr", limits=limits)  # fmt: skip
    assert_refused(code, messages, "use a smaller size, fewer bands or fewer photons")
    assert not list(tmp_path.iterdir())
