"""A disk without room names the file, the bytes it needs and a remedy; long names are refused."""

import errno
import os
import re
import shutil
import string
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.limits import files_of_at_most
from hypothesis import given, settings
from hypothesis import strategies as st

import photonmap as pm
from photonmap.capture.expose import expose
from photonmap.capture.photo import save_photo
from photonmap.commands.info import _write_thumbnail
from photonmap.commands.main import main
from photonmap.dataset.files.manifest import append_line
from photonmap.io.writers.scene_file import save_scene
from photonmap.results.files import check_output
from photonmap.results.result import Result
from photonmap.runtime import writing
from photonmap.runtime.checkpoint import MAGIC
from photonmap.runtime.kept_tables import kept_on_disk
from photonmap.spectra.bands import Bands
from photonmap.viewer.page import write_page

LONG = "a" * 252  # with the suffix .exr one byte too many
BOX = str(pm.scenes.FOLDER / "cornell_box.obj")


def make():
    rng, bands = np.random.default_rng(1), Bands.parse("550:550:20")
    image = rng.random((64, 64, bands.count), np.float32)
    return Result({"radiance": image, "emission": image}, {}, bands, {"passes": 1})


def _save_thumbnail(path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("photonmap.render"), "render", lambda *_, **__: make())
        _write_thumbnail(None, path)


WRITERS = {
    "a.exr": lambda path: make().save(path),
    "a.nc": lambda path: make().save(path),
    "a.hdr": lambda path: make().save(path),
    "alone.exr": lambda path: make().save_exr(path),
    "layers.exr": lambda path: make().save_layers(path),
    "a.html": lambda path: write_page([make()], ["a"], path),
    "photo": lambda path: save_photo(expose(make(), pm.Sensor(camera="550:550:20"), 0), path),
    "box.obj": lambda path: save_scene(pm.scenes.cornell_box(), path),
    "box.glb": lambda path: save_scene(pm.scenes.cornell_box(), path),
    "a.png": _save_thumbnail,
    "manifest.jsonl": lambda path: append_line(path.parent, {"name": "a" * 1000}),
}


@pytest.mark.parametrize("is_full", [True, False])
@pytest.mark.parametrize("name", WRITERS)
def test_every_writer_names_the_file_its_bytes_and_a_remedy(name, is_full, tmp_path, monkeypatch):
    """Whether the disk is full, or files may not be so large; what was there is left."""
    if name == "a.nc":
        pytest.importorskip("h5netcdf")
    if is_full:
        monkeypatch.setattr(writing, "_FULL", (errno.EFBIG,))
        monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=1000))
    if name.endswith(".exr"):
        (tmp_path / name).write_bytes(b"as before")
    with files_of_at_most(100), pytest.raises(OSError, match="cannot write") as caught:
        WRITERS[name](tmp_path / name)
    text = str(caught.value)
    assert text.startswith(f"cannot write {tmp_path / name} (")
    needed = float(text.partition("it needs ")[2].split()[2 if "more than" in text else 1])
    assert 1e-4 <= needed <= 1.0
    assert text.endswith("or choose another folder")
    remedies = "make room on this disk" if is_full else "raise the limit|check the disk"
    assert re.search(remedies, text)
    assert ".photonmap-" not in text
    left = [path for path in tmp_path.rglob("*") if path.name != "manifest.jsonl"]
    assert [path.read_bytes() for path in left] == [b"as before"] * name.endswith(".exr")


def test_what_a_link_leads_to_is_replaced(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link.exr").symlink_to(tmp_path / "there" / "file.exr")
    for _ in range(2):  # the file is missing at first
        make().save_exr(tmp_path / "link.exr")
        assert (tmp_path / "link.exr").is_symlink()
        assert pm.load_result(tmp_path / "there" / "file.exr").radiance.any()
    assert len([*tmp_path.rglob("*")]) == 3


@given(st.sampled_from([errno.ENOSPC, errno.EDQUOT]), st.none() | st.floats(1.0, 1e15))
def test_errors_of_full_disks_keep_their_number(number, size):
    expected = pytest.raises(OSError, match=r"^cannot write /x/a\.exr \(.*MB are free")
    with expected as caught, writing.naming_written("/x/a.exr", size):
        raise OSError(number, os.strerror(number), "/x/.photonmap-1/a.exr")
    assert caught.value.errno == errno.ENOSPC
    assert ".photonmap-" not in str(caught.value)
    assert any(sign in str(caught.value) for sign in writing.FULL)


def test_a_file_in_a_folder_of_drafts_is_told_as_the_folder(tmp_path, monkeypatch):
    """What it took counts as needed; its bytes are free again, and are so once."""
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=5000))
    expected = pytest.raises(
        OSError, match=r"image \(full: bands\.exr\): it needs more than 0\.012 "
    )
    with expected as caught, writing.drafts_beside(tmp_path / "image") as made:
        (made / "others").write_bytes(bytes(4000))
        with writing.replacing_target(made / "bands.exr", 1e6) as draft:
            draft.write_bytes(bytes(8000))
            raise OSError(f"full: {draft}")
    assert ", and 0.009 MB are free; make room" in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_other_errors_pass(tmp_path):
    with pytest.raises(PermissionError, match="denied"), writing.naming_written(tmp_path / "a"):
        raise PermissionError(errno.EACCES, "denied")


@settings(deadline=None, derandomize=True, max_examples=40)
@given(st.lists(st.text(string.ascii_letters + "é", min_size=1, max_size=300), min_size=1))
def test_names_are_refused_where_the_system_refuses_them(names):
    """Also those of folders that are to be made."""
    path = Path("/nowhere-at-all", *names)
    is_long = max(len(os.fsencode(name)) for name in names) > 255
    if is_long or len(os.fsencode(path)) > 4095:
        with pytest.raises(pm.InputError, match="too long for this disk; choose a shorter one"):
            writing.check_length(path)
    else:
        writing.check_length(path)


@pytest.mark.parametrize(
    "arguments",
    [
        [BOX, "--output", f"{LONG}.exr"],
        [BOX, "--output", f"{LONG[1:]}.exr"],  # FILE.json is longer
        [BOX, "--output", f"{LONG[8:]}.hdr", "--buffers", "shading"],  # of FILE-shading.error8.hdr
        [BOX, "--checkpoint", LONG],  # beside which .FILE.part is written
        [BOX, "--output", f"{LONG}{LONG}/a.exr"],
        [f"{LONG}.obj"],
        [f"{LONG}{LONG}"],
        ["convert", BOX, f"{LONG[:250]}.glb"],  # FILE.toml fits, the folder FILE_files does not
        ["info", BOX, "--thumbnail", f"{LONG}.png"],
        ["inspect", "a.exr", "--output", f"{LONG}.html"],
        ["sensor", "a.exr", "--output", f"{LONG}{LONG}"],
        ["dataset", f"{LONG}{LONG}"],
    ],
    ids=lambda arguments: " ".join(arguments)[-40:],
)
def test_long_names_on_the_command_line(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "too long for this disk; choose a shorter one" in line
    assert "Errno" not in line
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", [[], ["split", "--parts", "2"]], ids=["render", "split"])
def test_long_names_of_light_groups(command, tmp_path, monkeypatch, capsys):
    """ENVI has a file for each of their arrays; so has what is saved later."""
    box = pm.scenes.cornell_box()
    lamp = pm.PointLight((0.0, 0.5, 0.0), 1.0, LONG)
    (tmp_path / "box").mkdir()
    save_scene(replace(box, lights=[lamp]), tmp_path / "box" / "box.obj")
    monkeypatch.setattr("photonmap.integrators.render_loop.RenderLoop.run", None)
    given = [str(tmp_path / "box" / "box.toml"), "--per-light", "--output", str(tmp_path / "a.hdr")]
    assert main([*command, *given, "--size", "8x8", "--passes", "2", "--quiet"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "a-direct@aaaa" in line
    assert "too long for this disk; choose a shorter one" in line
    result = make()
    image = result.radiance
    split = replace(result, buffers={"radiance": image, f"direct@{LONG}": image})
    with pytest.raises(pm.InputError, match="too long for this disk; choose a shorter one"):
        split.save(tmp_path / "a.hdr")
    assert [file.name for file in tmp_path.iterdir()] == ["box"]


def test_long_labels_become_short_file_names(tmp_path):
    scene = pm.scenes.cornell_box()
    spectrum = pm.Spectrum([400.0, 700.0], [0.2, 0.8])
    named = replace(scene.meshes[0].material, name="long" * 100, reflectance=spectrum)
    meshes = [replace(scene.meshes[0], material=named), *scene.meshes[1:]]
    save_scene(replace(scene, meshes=meshes), tmp_path / "box.obj")
    assert max(len(path.name) for path in tmp_path.rglob("*")) < 120


@pytest.mark.parametrize("name", ["a.exr", "a.png", "a.json", "./b/../a.exr", "link.exr"])
def test_a_checkpoint_is_none_of_the_outputs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "b").mkdir()
    (tmp_path / "link.exr").symlink_to("a.exr")
    assert main([BOX, "--output", "a.exr", "--checkpoint", name, "--passes", "1"]) == 2
    assert "would be overwritten by the output" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b", "link.exr"]


def test_a_checkpoint_is_none_of_the_files_of_envi(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a.img", "a-direct.img"):
        assert main([BOX, "--output", "a.hdr", "--checkpoint", name]) == 2
        assert "would be overwritten by the output" in capsys.readouterr().err


def test_outputs_are_no_checkpoints(tmp_path):
    (tmp_path / "a.png").write_bytes(MAGIC + b"more")
    with pytest.raises(pm.InputError, match=r"a\.png: this is a checkpoint; remove it or choose"):
        check_output(tmp_path / "a.exr")


def test_tables_that_cannot_be_kept_leave_nothing(tmp_path):
    @kept_on_disk(lambda: tmp_path / "tables")
    def table(count):
        return np.arange(float(count))

    with files_of_at_most(100):
        assert table(1000)[-1] == 999.0
    assert not list((tmp_path / "tables").iterdir())
