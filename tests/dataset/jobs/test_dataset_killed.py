"""A run that is killed from outside leaves whole images, and goes on without them."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from photonmap import dataset
from photonmap.commands.main import main
from photonmap.dataset.jobs.render_image import ENTRY
from photonmap.dataset.jobs.verify import verify
from photonmap.errors import InputError

ARGUMENTS = ["--size", "24x18", "--bands", "3", "--error", "0.3"]
PATIENCE = 300.0


@pytest.fixture
def preset(tmp_path):
    path = tmp_path / "three.toml"
    path.write_text('scenes = ["jug", "bowl"]\nilluminations = ["white", "two_mixed"]')
    return str(path)


def entries_of(folder):
    return {path.parent.name: path for path in folder.glob(f"*/{ENTRY}")}


def start_and_kill(folder, preset, *more):
    """Run the command until an image is there, and kill it."""
    command = [sys.executable, "-m", "photonmap", "dataset", str(folder), "--preset", preset]
    process = subprocess.Popen(
        [*command, *ARGUMENTS, *more], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        end = time.monotonic() + PATIENCE
        while not entries_of(folder):
            assert process.poll() is None
            assert time.monotonic() < end
            time.sleep(0.01)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()


@pytest.mark.slow
def test_workers_end_with_the_run(tmp_path, preset):
    """They do not wait for their images, but end at once, and leave no temporary folders."""
    pytest.importorskip("distributed")
    folder = tmp_path / "set"
    command = [sys.executable, "-m", "photonmap", "dataset", str(folder), "--preset", preset]
    large = ["--size", "640x480", "--error", "0.005", "--bands", "3", "--workers", "2"]
    process = subprocess.Popen([*command, *large], stderr=subprocess.PIPE, text=True)
    try:
        time.sleep(15.0)  # workers are at work, and far from the end
        start = time.monotonic()
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=PATIENCE)
        assert time.monotonic() - start < 3.0
    finally:
        process.kill()
    assert process.returncode == -signal.SIGTERM
    assert said.splitlines()[-1].endswith("continue with --resume")
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".photonmap-")]


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_killed_run_goes_on_with_what_is_missing(tmp_path, preset, workers):
    if workers != "1":
        pytest.importorskip("distributed")
    folder = tmp_path / "set"
    start_and_kill(folder, preset, "--workers", workers)
    before = {name: path.stat().st_mtime_ns for name, path in entries_of(folder).items()}
    assert before
    arguments = ["dataset", str(folder), "--preset", preset, *ARGUMENTS, "--quiet"]
    assert main([*arguments, "--resume"]) == 0
    after = {name: path.stat().st_mtime_ns for name, path in entries_of(folder).items()}
    assert len(after) == len(dataset.open(folder)) == 4
    assert {name: after[name] for name in before} == before
    assert not list(folder.glob(".photonmap-*"))
    assert verify(folder, sample=0) == []


@pytest.mark.parametrize("line", ['{"name": "jug', '{"name": "jug"}', "5"])
def test_a_manifest_that_was_cut_off_is_told(tmp_path, preset, line):
    folder = tmp_path / "set"
    folder.mkdir()
    head = {"format": "photonmap data set 1", "images": []}
    (folder / "manifest.json").write_text(json.dumps(head))
    (folder / "manifest.jsonl").write_text(line + "\n")
    with pytest.raises(InputError, match="run the data set again with --resume"):
        dataset.open(folder)
