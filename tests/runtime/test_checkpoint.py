"""A render that was killed goes on as if nothing had happened."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import photonmap as pm
from photonmap.runtime import checkpoint as module
from photonmap.runtime import progress

BOX = pm.scenes.cornell_box()
MIRROR = pm.Material.polished("mirror", 0.8)
GLASS = pm.Material.glass("glass", 1.5)
LAMP = pm.PointLight((0.5, 0.2, 0.6), (0.0, 0.1, 0.9), name="blue")
ALWAYS = "import photonmap.runtime.checkpoint as c; c.EVERY = 0.0; c.MOST_SHARE = 1e9; "


def with_blocks(large, small):
    blocks = {"large_box": large, "small_box": small}
    meshes = [
        pm.Mesh(m.vertices, m.faces, blocks.get(m.name) or m.material, m.name) for m in BOX.meshes
    ]
    return pm.Scene(meshes, [LAMP], BOX.camera)


SCENES = {
    "box": (BOX, {"bands": 3}),
    "center": (BOX, {"bands": 2, "pixel": "center", "threads": 1}),
    "path": (BOX, {"bands": 1, "method": "path"}),
    "bands that are equal": (pm.scenes.furnace(), {"bands": 4}),
    "mirror and glass": (with_blocks(MIRROR, GLASS), {"bands": 2}),
    "light by light": (with_blocks(MIRROR, None), {"bands": 2, "per_light": True}),
    "holes": (with_blocks(pm.Material("lace", 0.5, alpha=0.5), None), {"bands": 1}),
}


def assert_same(one, other):
    assert list(one.buffers) == list(other.buffers)
    assert list(one.errors) == list(other.errors)
    for name, image in one.buffers.items():
        np.testing.assert_array_equal(image, other.buffers[name], err_msg=name)
    for name, image in one.errors.items():
        np.testing.assert_array_equal(image, other.errors[name], err_msg=name)
    assert list(one.block_errors) == list(other.block_errors)
    for name, image in one.block_errors.items():
        np.testing.assert_array_equal(image, other.block_errors[name], err_msg=name)
    for name in ("passes", "photons", "photons_stored", "rays_by_kind", "error", "unresolved"):
        assert one.record[name] == other.record[name]


@pytest.fixture
def always(monkeypatch):
    """Save after every pass."""
    monkeypatch.setattr(module, "EVERY", 0.0)
    monkeypatch.setattr(module, "MOST_SHARE", 1e9)


@pytest.mark.parametrize("name", SCENES)
def test_a_render_goes_on_bit_for_bit(name, tmp_path):
    """Some over the pass in which the store's cells shrink first, and within a replicate, too."""
    scene, settings = SCENES[name]
    settings = {**settings, "size": (20, 16), "photons": 2000, "seed": 5}
    file = tmp_path / "state"
    middle, last = (17, 18) if name in ("box", "mirror and glass") else (4, 6)
    whole = pm.render(scene, passes=last, **settings)
    for passes, earlier in ((1, 0), (middle, 1), (last, middle)):
        resume = passes > 1
        part = pm.render(scene, passes=passes, checkpoint=file, resume=resume, **settings)
        assert part.record["resumed"] == earlier
    assert_same(part, whole)
    assert part.record["seconds"]["checkpoint"] > 0.0
    assert_same(pm.render(scene, passes=last, checkpoint=file, resume=True, **settings), whole)


def test_an_error_is_reached_after_the_same_passes(tmp_path):
    settings = {"bands": 1, "size": (16, 16), "seed": 1, "pass_samples": 1.0}
    whole = pm.render(BOX, error="indirect:p90:0.04", **settings)
    file = tmp_path / "state"
    pm.render(BOX, passes=5, checkpoint=file, **settings)
    part = pm.render(BOX, error="indirect:p90:0.04", checkpoint=file, resume=True, **settings)
    assert_same(part, whole)
    assert part.record["passes"] > 16


SMALL = ["--size", "24x24", "--passes", "60", "--photons", "500"]


def test_kill_at_any_moment(tmp_path):
    file = tmp_path / "cornell_box.checkpoint"
    code = ALWAYS + "from photonmap.commands.main import main; raise SystemExit(main())"
    scene = Path(pm.scenes.FOLDER) / "cornell_box.obj"
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(scene), *SMALL, "--checkpoint"],
        cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    while process.poll() is None and not file.exists():
        time.sleep(0.001)
    time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert not (tmp_path / "cornell_box.exr").exists()
    with file.open("rb") as opened:
        passes = module._read_head(opened)["state"]["passes"]
    assert passes < 60
    settings = {"size": (24, 24), "passes": passes + 3, "photons": 500}
    assert_same(
        pm.render(BOX, checkpoint=file, resume=True, **settings), pm.render(BOX, **settings)
    )
    assert not list(tmp_path.glob(".*part"))


def test_more_passes_than_asked_for_are_told(tmp_path):
    settings = {"bands": 1, "size": (8, 8), "checkpoint": tmp_path / "state"}
    pm.render(BOX, passes=5, **settings)
    pm.render(BOX, passes=5, resume=True, **settings)
    with pytest.warns(pm.SceneWarning, match="state: has 5 passes, more than the 3 that were aske"):
        part = pm.render(BOX, passes=3, resume=True, **settings)
    assert part.record["passes"] == 5


def test_ctrl_c_saves_what_is_done(tmp_path):
    class Interrupter(progress.Silent):
        def __init__(self):
            self.stages = []

        def stage(self, name):
            self.stages.append(name)

        def update(self, passes, *rest):
            if passes == 3:
                threading.Timer(0.005, os.kill, (os.getpid(), signal.SIGINT)).start()

    settings = {"bands": 1, "size": (32, 32), "checkpoint": tmp_path / "state"}
    shown = Interrupter()
    part = pm.render(BOX, passes=10_000, progress=shown, **settings)
    assert part.record["interrupted"]
    assert shown.stages[-1] == "interrupted"
    assert "again to discard" in progress.STAGES["interrupted"]
    passes = part.record["passes"] + 2
    again = pm.render(BOX, passes=passes, resume=True, **settings)
    assert again.record["resumed"] == part.record["passes"]
    assert_same(again, pm.render(BOX, bands=1, size=(32, 32), passes=passes))


def changed(name, **attributes):
    """The Cornell box with the material of a mesh changed."""
    wall = next(mesh.material for mesh in BOX.meshes if mesh.name == name)
    other = replace(wall, **attributes)
    meshes = [
        pm.Mesh(m.vertices, m.faces, other if m.material is wall else m.material, m.name)
        for m in BOX.meshes
    ]
    return pm.Scene(meshes, BOX.lights, BOX.camera)


OTHERS = {
    "seed": (BOX, {"seed": 1}, "seed 0 there, 1 here"),
    "bands": (BOX, {"bands": 3}, "bands 2 there, 3 here"),
    "curves": (BOX, {"bands": "box:2"}, "other band curves"),
    "size": (BOX, {"size": (8, 9)}, "size 8x8 there, 8x9 here"),
    "pixel": (BOX, {"pixel": "center"}, "pixel box there, center here"),
    "photons": (BOX, {"photons": 7}, "photons 16384 there, 7 here"),
    "method": (BOX, {"method": "path"}, "method photon there, path here"),
    "effects": (BOX, {"effects": ["direct"]}, "effects auto there, direct here"),
    "lights": (BOX, {"per_light": True}, "per_light False there, True here"),
    "camera": (
        pm.Scene(BOX.meshes, [], pm.Camera((0, 0, 4), (0, 0, 0))), {}, "render: other camera;",
    ),
    "material": (changed("back", reflectance=0.1), {}, "render: other materials;"),
    "light": (changed("light", emission=2.0), {}, "render: other lights;"),
}  # fmt: skip


@pytest.mark.parametrize("case", OTHERS)
def test_another_render_is_told_apart(case, tmp_path):
    settings = {"bands": 2, "size": (8, 8), "passes": 1, "checkpoint": tmp_path / "state"}
    pm.render(BOX, **settings)
    before = (tmp_path / "state").read_bytes()
    scene, changes, named = OTHERS[case]
    with pytest.raises(pm.InputError) as caught:
        pm.render(scene, **{**settings, **changes}, resume=True)
    assert named in str(caught.value)
    assert str(caught.value).endswith("or start from scratch without resuming")
    assert str(tmp_path / "state") in str(caught.value)
    assert (tmp_path / "state").read_bytes() == before


def test_damage_is_found(tmp_path):
    file = tmp_path / "state"
    settings = {"bands": 1, "size": (4, 4), "checkpoint": file}
    pm.render(BOX, passes=1, **settings)
    whole = file.read_bytes()
    rng = np.random.default_rng(4)
    flipped = []
    for place in rng.integers(len(module.MAGIC), len(whole), 40):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        flipped.append(bytes(damaged))
    cuts = [whole[: int(length)] for length in rng.integers(0, len(whole), 20)]
    cuts = [cut for cut in cuts if len(cut) >= len(module.MAGIC)]
    for damaged in (b"", *flipped, *cuts, whole + b"more"):
        file.write_bytes(damaged)
        with pytest.raises(pm.InputError, match="damaged") as caught:
            pm.render(BOX, passes=2, resume=True, **settings)
        assert "\n" not in str(caught.value)


def test_a_full_disk_is_a_warning(tmp_path, monkeypatch, always):
    def full(file, *rest):
        file.write(b"some")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    file = tmp_path / "state"
    settings = {"bands": 1, "size": (8, 8)}
    pm.render(BOX, passes=1, checkpoint=file, **settings)
    before = file.read_bytes()
    monkeypatch.setattr(module, "_write_all", full)
    said = (
        r"pass 2 was not saved: cannot write .*state \(No space left.*\): it needs about [\d.]+ MB"
    )
    with pytest.warns(pm.SceneWarning, match=said):
        result = pm.render(BOX, passes=2, checkpoint=file, resume=True, **settings)
    assert_same(result, pm.render(BOX, passes=2, **settings))
    assert file.read_bytes() == before
    assert list(tmp_path.iterdir()) == [file]


def test_an_interrupted_save_is_a_warning(tmp_path, monkeypatch):
    def interrupted(*rest):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "_write_all", interrupted)
    with pytest.warns(pm.SceneWarning, match="pass 2 was not saved: interrupted"):
        pm.render(BOX, bands=1, size=(8, 8), passes=2, checkpoint=tmp_path / "state")
    assert not list(tmp_path.iterdir())


def test_without_a_checkpoint_it_starts_anew_and_says_so(tmp_path):
    file = tmp_path / "state"
    with pytest.warns(pm.SceneWarning, match="there is no checkpoint yet; starting from scratch"):
        result = pm.render(BOX, bands=1, size=(8, 8), passes=1, checkpoint=file, resume=True)
    assert result.record["resumed"] == 0
    assert file.exists()


def test_places_where_no_checkpoint_can_be(tmp_path):
    (tmp_path / "image.exr").write_bytes(b"picture")
    for path, named in (
        (tmp_path, "folder"),
        (tmp_path / "image.exr" / "state", "Not a directory"),
        (tmp_path / "image.exr", "not a checkpoint"),
    ):
        with pytest.raises(pm.InputError, match=named):
            pm.render(BOX, size=(4, 4), passes=1, checkpoint=path)
    assert (tmp_path / "image.exr").read_bytes() == b"picture"
    with pytest.raises(pm.InputError, match="name its file"):
        pm.render(BOX, size=(4, 4), passes=1, resume=True)


def test_saving_is_rare_where_it_takes_long(tmp_path):
    checkpoint = module.Checkpoint(tmp_path / "state", {})
    checkpoint.save({"a": np.zeros(4)}, {"passes": 1})
    assert checkpoint._next >= time.monotonic() + 0.9 * module.EVERY
    checkpoint.save_if_due({"a": np.ones(4)}, {"passes": 2})
    values = np.full(4, 2.0)
    assert checkpoint.load(lambda state: {"a": values}) == {"passes": 1}
    np.testing.assert_array_equal(values, 0.0)
