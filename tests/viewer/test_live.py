"""Images that are shown while they are rendered: watched, in a notebook, in tev."""

import socket
import struct
import sys
import threading
from types import ModuleType

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.runtime import progress
from photonmap.runtime.progress import Silent

SMALL = {"bands": 3, "size": (12, 9), "passes": 3, "photons": 2000}
BOX = str(pm.scenes.FOLDER / "cornell_box.obj")


@pytest.fixture(autouse=True)
def every_pass(monkeypatch):
    monkeypatch.setattr(progress, "_WATCH_EVERY", 0.0)
    monkeypatch.setattr(progress, "_WATCH_SHARE", 1e9)


def test_a_render_is_watched():
    seen = []
    box = pm.scenes.cornell_box()
    result = pm.render(box, **SMALL, watch=seen.append)
    assert [shown.record["passes"] for shown in seen] == [1, 2, 3]
    for name in ("radiance", "direct", "shading", "reflectance"):
        np.testing.assert_array_equal(seen[-1][name], result[name])
        assert (seen[0][name] != result[name]).any() or name == "reflectance"
    np.testing.assert_array_equal(seen[-1].preview(), result.preview())
    unwatched = pm.render(box, **SMALL)
    np.testing.assert_array_equal(unwatched.radiance, result.radiance)


def test_showing_takes_a_small_part_of_the_time(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress, "_WATCH_EVERY", 0.5)
    monkeypatch.setattr(progress, "_WATCH_SHARE", 0.05)
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    shown = []

    def show(result):
        shown.append(now[0])
        now[0] += 1.0

    watcher = progress.Watching(Silent(), show, lambda passes: passes)
    for second in range(100):
        now[0] = max(now[0], float(second))
        watcher.update(second + 1, 0.1, 0.5, float(second), 1e6)
    assert shown == [0.0, 21.0, 42.0, 63.0, 84.0]


class Display:
    """Stands for IPython's display."""

    def __init__(self):
        self.pictures = []

    def display(self, picture, display_id):
        assert display_id is True
        self.pictures.append(picture)
        return self

    def update(self, picture):
        self.pictures.append(picture)


@pytest.fixture
def notebook(monkeypatch):
    display = Display()
    module = ModuleType("IPython.display")
    module.Image, module.display = lambda data: data, display.display
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    return display


@pytest.mark.parametrize("buffer", ["radiance", "reflectance"])
def test_a_preview_is_refined_in_place(notebook, buffer):
    result = pm.preview(pm.scenes.cornell_box(), buffer, **SMALL)
    assert len(notebook.pictures) == 4
    assert all(picture.startswith(b"\x89PNG") for picture in notebook.pictures)
    assert len(set(notebook.pictures)) > 1 or buffer == "reflectance"
    if buffer == "radiance":
        assert notebook.pictures[-1] == result._repr_png_()
    assert result.record["passes"] == 3


@pytest.mark.parametrize(("buffer", "meant"), [("radianse", "mean 'radiance'"), ("depth", "")])
def test_a_preview_of_no_picture_is_refused_before_rendering(notebook, buffer, meant):
    with pytest.raises(pm.InputError, match=f"'{buffer}' has no bands that could be .*{meant}"):
        pm.preview(pm.scenes.cornell_box(), buffer, **SMALL)
    assert not notebook.pictures


def test_a_preview_needs_a_notebook(monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython.display", None)
    with pytest.raises(pm.InputError, match="needs IPython: pip install ipython"):
        pm.preview(pm.scenes.cornell_box())


class Server(threading.Thread):
    """Stands for tev: takes the packets of one connection."""

    def __init__(self):
        super().__init__(daemon=True)
        self._socket = socket.create_server(("localhost", 0))
        self.port, self.packets = self._socket.getsockname()[1], []
        self.start()

    def run(self):
        connection, _ = self._socket.accept()
        with connection, connection.makefile("rb") as stream:
            while head := stream.read(4):
                self.packets.append(stream.read(struct.unpack("<I", head)[0] - 4))

    def __exit__(self, *_):
        self.join(10.0)
        self._socket.close()

    def __enter__(self):
        return self


def test_tev_is_sent_passes(tmp_path, capsys):
    pytest.importorskip("tevclient")
    size = ["--size", "12x9", "--passes", "2", "--bands", "3", "--photons", "2000", "--quiet"]
    output = ["--output", str(tmp_path / "box.exr")]
    with Server() as tev:
        assert main([BOX, *size, *output, "--view", f"localhost:{tev.port}"]) == 0
    create, *updates = tev.packets
    assert create[0] == 4, "creates an image"
    assert b"box.exr\0" in create
    for channel in (b"R\0", b"direct.G\0", b"shading.B\0"):
        assert channel in create
    assert len(updates) == 3, "two passes and the result"
    assert {packet[0] for packet in updates} == {6}, "updates of pixels"
    result = pm.load_result(tmp_path / "box.exr")
    pixels = np.frombuffer(updates[-1][-12 * 9 * 15 * 4 :], np.float32).reshape(9, 12, 15)
    np.testing.assert_array_equal(pixels[..., :3], result.rgb())
    np.testing.assert_array_equal(pixels[..., 12:], result.rgb("reflectance"))
    assert not capsys.readouterr().err


@pytest.mark.filterwarnings("default::photonmap.SceneWarning")
def test_without_tev_the_render_goes_on(tmp_path, capsys):
    pytest.importorskip("tevclient")
    with socket.create_server(("localhost", 0)) as closed:
        port = closed.getsockname()[1]
    size = ["--size", "8", "--passes", "1", "--bands", "3", "--photons", "500", "--quiet"]
    output = ["--output", str(tmp_path / "box.exr")]
    assert main([BOX, *size, *output, "--view", f"localhost:{port}"]) == 0
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"tev cannot be reached at localhost:{port}" in error
    assert (tmp_path / "box.exr").exists()


def test_what_is_wrong_with_view(tmp_path, monkeypatch, capsys):
    assert main([BOX, "--output", str(tmp_path / "a.exr"), "--view", "nowhere"]) == 2
    assert "--view nowhere must be HOST:PORT" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "tevclient", None)
    assert main([BOX, "--output", str(tmp_path / "a.exr"), "--view"]) == 2
    assert "pip install 'photonmap[view]'" in capsys.readouterr().err
