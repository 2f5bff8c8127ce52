"""A file system of 1 MB that is really full, where the test may mount one.

What a full disk does elsewhere, by a limit of files' sizes, is in `test_faults`.
"""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest
from helpers.marks import slow
from test_faults import SCENE, assert_refused, run

import photonmap as pm

SIZE = "128x128"


@pytest.fixture
def disk(tmp_path):
    """A folder of 1 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if sys.platform != "linux" or os.geteuid() != 0 or not shutil.which("mount"):
        pytest.skip("only root may mount a file system")
    command = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    messages = subprocess.run(command, capture_output=True, text=True, check=False)
    if messages.returncode:
        pytest.skip(f"no file system may be mounted: {messages.stderr.strip()}")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def fill(folder, spare=0):
    """Leave so many bytes free."""
    room = shutil.disk_usage(folder).free - spare
    (folder / "filler").write_bytes(bytes(max(room, 0)))


@pytest.mark.parametrize("spare", slow(0, 300_000))
def test_the_images_of_a_render(disk, spare):
    """Wherever writing stops, the files of before stay as they were, and nothing is left over."""
    for name in ("out.exr", "out.png", "out.json"):
        (disk / name).write_bytes(b"as before")
    fill(disk, spare)
    arguments = (SCENE, "--size", SIZE, "--passes", 2, "--quiet")
    code, messages = run(*arguments, "--output", disk / "out.exr")
    assert code == 2
    assert len(messages) == 1
    assert messages[0].startswith(f"photonmap: error: cannot write {disk / 'out.exr'} (")
    assert re.search(r"it needs about [\d.]+ MB, and [\d.]+ MB are free; make room", messages[0])
    assert sorted(path.name for path in disk.iterdir()) == [
        "filler", "out.exr", "out.json", "out.png",
    ]  # fmt: skip
    assert all((disk / f"out.{kind}").read_bytes() == b"as before" for kind in ("exr", "json"))


@pytest.mark.slow
def test_a_checkpoint(disk, tmp_path):
    """A warning, and the render goes on; once there is room, it is saved and resumed."""
    arguments = (SCENE, "--size", SIZE, "--quiet", "--bands", 2, "--output", tmp_path / "out.exr")
    state = ("--checkpoint", disk / "box.checkpoint")
    code, messages = run(*arguments, *state, "--passes", 2)
    assert code == 0
    (message,) = messages
    place = re.escape(str(disk / "box.checkpoint"))
    assert re.match(
        rf"photonmap: warning: {place}: pass 2 was not saved: cannot write {place} \(No space left "
        r"on device\): it needs about [\d.]+ MB, and [\d.]+ MB are free; make room",
        message,
    )
    assert not list(disk.iterdir())
    small = (SCENE, "--size", "16x16", "--quiet", "--bands", 2, "--output", tmp_path / "out.exr")
    for passes in (1, 3):
        assert run(*small, *state, "--passes", passes, "--resume")[0] == 0
    whole = pm.render(pm.scenes.cornell_box(), bands=2, size=(16, 16), passes=3)
    resumed = pm.load_result(tmp_path / "out.exr")
    np.testing.assert_array_equal(resumed.radiance, whole.radiance)


@pytest.mark.slow
def test_the_checkpoint_of_before_stays(disk, tmp_path):
    small = (SCENE, "--size", "16x16", "--quiet", "--bands", 2, "--output", tmp_path / "out.exr",
             "--resume", "--checkpoint", disk / "box.checkpoint")  # fmt: skip
    run(*small, "--passes", 1)
    before = (disk / "box.checkpoint").read_bytes()
    fill(disk)
    code, messages = run(*small, "--passes", 2)
    assert code == 0
    assert "pass 2 was not saved" in messages[0]
    assert (disk / "box.checkpoint").read_bytes() == before


@pytest.mark.slow
def test_scratch_files(disk, tmp_path):
    code, messages = run(SCENE, "--size", SIZE, "--quiet", "--memory", "1K", "--output",
                     tmp_path / "out.exr", TMPDIR=str(disk))  # fmt: skip
    assert_refused(code, messages, f"GB in {disk}")
    assert not list(disk.iterdir())


@pytest.mark.slow
def test_a_data_set(disk):
    """Images that found room are whole; the first that does not ends the set for now."""
    folder = disk / "set"
    arguments = ("dataset", folder, "--size", "32x24", "--bands", 2, "--error", 0.9, "--quiet")
    fill(disk, 900_000)
    code, messages = run(*arguments)
    assert code == 1
    full, rest = (line for line in messages if "failed" in line)
    entries = [json.loads(line) for line in (folder / "manifest.jsonl").read_text().splitlines()]
    assert re.search(rf"cannot write {folder}/\S+ .*it needs more than [\d.]+ MB, and", full)
    others = int(re.search(r"and (\d+) more: not rendered, as the disk is full", rest)[1])
    assert len(entries) + 1 + 4 + others == 16
    assert 1 <= len(entries) <= 8
    for entry in entries:
        assert np.isfinite(pm.load_result(folder / entry["name"] / "bands.exr").radiance).all()
    assert not list(folder.glob(".photonmap-*"))
    (disk / "filler").unlink()
    subprocess.run(["mount", "-o", "remount,size=64m", str(disk)], check=True)
    code, messages = run(*arguments, "--resume")
    assert code == 0, messages
    assert run("dataset", "verify", folder, "--sample", 1)[0] == 0
