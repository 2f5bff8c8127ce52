"""Images larger than memory: arrays on disk hold the same bits, and leave nothing behind."""

import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from helpers.limits import files_of_at_most
from helpers.marks import slow
from helpers.scenes import balls_in_box
from test_faults import SCENE, assert_refused, run, start

import photonmap as pm
from photonmap.commands.main import main

SIDE = int(os.environ.get("PHOTONMAP_SIDE", "0"))
"""Of the large image, 8192 in `make fuzz`."""


def assert_identical(result, other):
    for images, others in ((result.buffers, other.buffers), (result.errors, other.errors)):
        assert list(images) == list(others)
        for name, image in images.items():
            np.testing.assert_array_equal(image, others[name], err_msg=name)


@pytest.mark.parametrize(
    "options",
    [
        {"passes": 14, "size": (45, 48)},
        {"passes": 1, "per_light": True},
        {"error": "indirect:p90:0.4", "pixel": "center"},
        {"passes": 2, "method": "path"},
    ],
    ids=["focused and probed", "by lights", "percentile", "paths"],
)
@pytest.mark.parametrize("scene", [pm.scenes.cornell_box(), *slow(balls_in_box())])
@pytest.mark.filterwarnings("ignore:.*successive reflections")
def test_arrays_on_disk_hold_the_same_bits(scene, options, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    options = {"bands": 3, "size": (48, 48), "photons": 5000, **options}
    result = pm.render(scene, memory=1, **options)
    assert not list(tmp_path.iterdir())
    assert_identical(result, pm.render(scene, **options))
    result.save(tmp_path / "mapped.exr")
    assert_identical(pm.load_result(tmp_path / "mapped.exr"), result)


def test_a_checkpoint_goes_from_disk_to_memory(tmp_path):
    options = {"bands": 2, "size": (32, 32), "checkpoint": tmp_path / "box.checkpoint"}
    box = pm.scenes.cornell_box()
    pm.render(box, passes=3, memory=1, **options)
    resumed = pm.render(box, passes=9, resume=True, **options)
    assert_identical(resumed, pm.render(box, bands=2, size=(32, 32), passes=9))


@pytest.mark.filterwarnings("ignore:.*successive reflections")
def test_chosen_buffers_are_those_of_all():
    options = {"bands": 3, "size": (16, 16), "passes": 3, "per_light": True}
    scene = balls_in_box()
    whole = pm.render(scene, **options)
    for names in (["radiance"], ["shading", "depth"], ["caustics", "passes"]):
        some = pm.render(scene, buffers=names, **options)
        wanted = [name for name in whole.buffers if name.partition("@")[0] in names]
        assert list(some.buffers) == wanted
        for name in wanted:
            np.testing.assert_array_equal(some.buffers[name], whole.buffers[name])
        for name, error in some.errors.items():
            np.testing.assert_array_equal(error, whole.errors[name])
        assert set(some.errors) == set(wanted) & set(whole.errors)


@pytest.mark.parametrize(
    ("names", "message"),
    [(["glow"], "no buffer 'glow'"), ([], "no buffer was chosen"), (["caustics"], "ask for")],
)
def test_buffers_that_there_are_not(names, message):
    with pytest.raises(pm.InputError, match=message):
        pm.render(pm.scenes.cornell_box(), size=(4, 4), passes=1, buffers=names)


@pytest.mark.parametrize("memory", [0, -1, float("nan"), float("inf")])
def test_amounts_that_are_none(memory):
    with pytest.raises(pm.InputError, match=r"memory .* must be a number of bytes above 0"):
        pm.render(pm.scenes.cornell_box(), memory=memory)


def large(side, bands, folder, *more):
    return (
        SCENE, "--size", f"{side}x{side}", "--bands", bands, "--photons", 50_000,
        "--buffers", "radiance", "--quiet", "--output", folder / "out.exr", *more,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the limit is Linux's")
def test_more_than_memory(tmp_path):
    """1 GB of arrays and 1 GB of RAM in all: done with `--memory`, and refused without."""
    limits = [(resource.RLIMIT_DATA, 1 << 30)]
    environment = {"TMPDIR": str(tmp_path)}
    refused = run(*large(1024, 8, tmp_path), limits=limits, **environment)
    assert_refused(*refused, "or keep arrays on disk")
    code, messages = run(
        *large(1024, 8, tmp_path, "--passes", 1, "--memory", "512M"), limits=limits, **environment
    )
    assert code == 0, messages
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".exr", ".json", ".png"]
    assert np.isfinite(pm.load_result(tmp_path / "out.exr").radiance).all()


@pytest.mark.slow
def test_killed_amid_scratch_files(tmp_path):
    environment = {"TMPDIR": str(tmp_path)}
    process = start(*large(256, 3, tmp_path, "--memory", "1K", "--seconds", 60), **environment)
    time.sleep(3.0)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    assert not list(tmp_path.iterdir())


def test_a_disk_too_full_for_scratch_files(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with files_of_at_most(20_000):
        code = main([*map(str, large(64, 3, tmp_path, "--memory", "1K"))])
    assert_refused(code, capsys.readouterr().err.splitlines(), "make room there, or set TMPDIR")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not SIDE, reason="takes 50 GB of disk: make fuzz")
def test_an_image_of_8192_lines(tmp_path):
    """Radiance in 3 bands, with 4 GB of RAM in all."""
    folder = Path(tempfile.gettempdir())
    if shutil.disk_usage(folder).free < 50e9:
        pytest.skip(f"{folder} has less than 50 GB of room")
    before = set(folder.iterdir())
    limits = [(resource.RLIMIT_DATA, 4 << 30)]
    process = start(*large(SIDE, 3, tmp_path, "--passes", 2, "--memory", "4G"), limits=limits)
    _, messages = process.communicate(timeout=7200)
    assert process.returncode == 0, messages
    result = pm.load_result(tmp_path / "out.exr")
    assert result.size == (SIDE, SIDE)
    assert set(result.buffers) == {"radiance"}
    assert all(np.isfinite(line).all() for line in result.radiance)
    assert not {path for path in set(folder.iterdir()) - before if "photonmap-" in path.name}
