"""Hostile files: names that command a terminal, and work beyond a file's size."""

import json
import sys
import tracemalloc
import warnings
from importlib.util import find_spec

import hostile
import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.errors import InputError, naming, visible
from photonmap.io.readers.decoding import decode_file
from photonmap.runtime import bounds
from photonmap.runtime.bounds import Budget, read_npz
from photonmap.runtime.terminal import drawing, tolerant

STEPS = 64, 128, 256
"""Numbers by which files grow"""
SLOPE = 2.5
"""The most by which work may grow where a file is twice as large: 2, and logarithms"""
MEMORY = 300
"""The most bytes of memory for a byte of a file"""
SLACK = 200_000  # Bytes or calls that do not grow


@pytest.mark.parametrize("kind", hostile.named())
@pytest.mark.parametrize("more", [[], ["--json"]])
def test_names_of_files_do_not_command_the_terminal(kind, more, tmp_path, capsys):
    for name, data in hostile.named().items():
        (tmp_path / name).write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("always", pm.SceneWarning)
        code = main(["info", str(tmp_path / kind), *more])
    printed = capsys.readouterr()
    assert code == (0 if kind in ("names.gltf", "names.obj", "names.ply") else 2)
    shown = printed.out + printed.err
    assert not [hidden for hidden in hostile.HIDDEN if hidden in shown.replace("\n", "")]
    assert "\nphotonmap: error: none" not in shown
    errors = printed.err.splitlines()
    assert all(line.startswith(("photonmap: error: ", "photonmap: warning: ")) for line in errors)
    assert len([line for line in errors if "error: " in line[:20]]) == (code == 2)
    if code == 0:
        assert "owned" in shown
        assert "202e" in shown  # not left out, but shown
    if more and not code:
        names = [mesh["name"] for mesh in json.loads(printed.out)["meshes"]]
        assert names == (["names"] if kind == "names.ply" else names)
        assert kind != "names.gltf" or names == [hostile.LINES]


def test_names_of_files_do_not_command_the_terminal_in_warnings(tmp_path):
    for kind in ("names.gltf", "names.obj", "names.ply"):
        (tmp_path / kind).write_bytes(hostile.named()[kind])
        with pytest.warns(pm.SceneWarning) as said:
            pm.load_scene(tmp_path / kind)
        for each in said:
            assert "owned" in str(each.message)
            assert not [hidden for hidden in hostile.HIDDEN if hidden in str(each.message)]


def test_what_is_shown():
    assert visible("Ä 日本 \u200d \\ 'a'") == "Ä 日本 \u200d \\ 'a'"
    assert visible("\x1b\n\x7f\u202e\ud800") == "\\u001b\\n\\u007f\\u202e\\ud800"
    assert json.loads(f'"{visible(hostile.LINES)}"') == hostile.LINES
    assert visible(visible(hostile.LINES)) == visible(hostile.LINES)
    assert str(InputError("a\n b", "x\ny")) == "x\\ny: a b"
    with pytest.raises(InputError, match=r"^a\\nb: c$"), naming("a\nb"):
        raise InputError("c")
    assert len(str(InputError("x" * 10**6))) < 5000


def test_halves_of_characters_are_replaced(tmp_path, capsys):
    name = r'"\\\ud800\ud83d\ude00\udc00"'  # a backslash, a half, a whole character, a half
    text = hostile.gltf("NAME").replace(b'"NAME"', name.encode())
    (tmp_path / "a.gltf").write_bytes(text)
    assert main(["info", str(tmp_path / "a.gltf"), "--json"]) == 0
    (mesh,) = json.loads(capsys.readouterr().out)["meshes"]
    assert mesh["name"] == "\\\ufffd\U0001f600\ufffd"


def test_only_a_bar_draws(capsys):
    for wrap, wanted in ((tolerant, "\\u001b[2K\n"), (drawing, "\x1b[2K\n")):
        print("\x1b[2K", file=wrap(tolerant(sys.stdout)))
        assert capsys.readouterr().out == wanted


def load(scene):
    """Load a scene, which may be refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return pm.load_scene(scene)
        except InputError as error:
            return str(error)


def count_calls(work):
    """Return how many functions work calls and leaves, those in C among them."""
    calls = [0]

    def count(*event):
        calls[0] += 1

    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(None)
    return calls[0]


def count_bytes(work):
    """Return the most memory that work takes."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", hostile.GROWING)
def test_work_grows_as_the_file_does(kind, tmp_path):
    calls, taken, sizes = [], [], []
    for step in STEPS:
        folder = tmp_path / str(step)
        folder.mkdir()
        scene = hostile.write(folder, hostile.GROWING[kind](step))
        load(scene)  # what is imported or made once
        calls.append(count_calls(lambda scene=scene: load(scene)))
        taken.append(count_bytes(lambda scene=scene: load(scene)))
        sizes.append(sum(file.stat().st_size for file in folder.iterdir()))
    first, second = np.diff(calls)
    assert second <= SLOPE * max(first, 0) + 100
    first, second = np.diff(taken)
    assert second <= SLOPE * max(first, 0) + SLACK
    assert second <= MEMORY * (sizes[2] - sizes[1]) + SLACK


def test_rows_of_nothing_take_no_memory(tmp_path):
    scene = hostile.write(tmp_path, hostile.nothing())
    assert count_bytes(lambda: load(scene)) < 1e6
    assert len(load(scene).meshes[0].faces) == 1


def test_vertices_that_are_only_announced_take_no_memory(tmp_path):
    text = hostile.gltf("a").replace(b'"count": 3', b'"count": 1099511627776')
    said = load(hostile.write(tmp_path, {"a.gltf": text}))
    assert "accessor 0 takes bytes 0 to 13194139533312" in said


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("element vertex 3\n", "'vertex 3' is no element, or is there twice"),
        ("element other -3\n", "'other -3' is no element, or is there twice"),
        ("property list uchar int vertex_indices\n", "property 'vertex_indices' is there twice"),
    ],
)
def test_headers_of_ply_that_contradict_themselves(line, said, tmp_path):
    head = hostile.VERTEX.format(3) + hostile.FACE.format(1) + line
    text = hostile.PLY.format("ascii", head) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    assert said in load(hostile.write(tmp_path, {"a.ply": text}))


def test_arrays_that_nobody_needs_are_not_unpacked(tmp_path):
    cube = np.full((2, 2, 2), 0.5, np.float32)
    arrays = {"wavelengths": np.array([400.0, 700.0]), "cube": cube}
    path = tmp_path / "a.npz"
    path.write_bytes(hostile.npz({**arrays, "other": np.zeros(1 << 24)}))  # 128 MB
    assert count_bytes(lambda: pm.SpectralTexture.read(path)) < 1e6
    path.write_bytes(hostile.npz({"wavelengths": [400.0]}, {"cube": (40000, 5000, 100)}))
    with pytest.raises(InputError, match=r"a\.npz: needs 160\.0 GB of memory, .* times its size"):
        pm.SpectralTexture.read(path)
    path.write_bytes(hostile.npz({"wavelengths": [400.0]}, {"cube": (2, 2, 1)}))
    with pytest.raises(InputError, match=r"a\.npz: cannot be read \(EOF"):
        pm.SpectralTexture.read(path)
    path.write_bytes(hostile.npz({"wavelengths": [400.0], "cube": np.array([[[None]]])}))
    with pytest.raises(InputError, match="cube holds objects of Python"):
        pm.SpectralTexture.read(path)
    np.savez(path, **arrays)
    assert read_npz(path).keys() == arrays.keys()
    np.testing.assert_array_equal(read_npz(path)["cube"], cube)


def test_images_that_unpack_to_far_more(tmp_path, capfd):
    path = tmp_path / "a.png"
    for side, said in (
        (30000, "2574 MB image from a 65 byte file"),
        (9500, "needs 0.3 GB of memory"),
    ):
        path.write_bytes(hostile.png(side, side))
        with pytest.raises(InputError, match=rf"a\.png: .*{said}"):
            pm.Texture.read(path)
    for texels in (b"no zlib stream", b""):
        path.write_bytes(hostile.png(3, 3, texels))
        with pytest.raises(InputError, match="cannot be read as an image"):
            pm.Texture.read(path)
    assert capfd.readouterr().err == ""  # libraries' own lines do not precede ours


def test_a_lack_of_memory_is_called_so(tmp_path, capsys, monkeypatch):
    path = tmp_path / "a.ply"
    path.write_text("ply")
    said = r"a\.ply: needs 281475\.0 GB of memory, more than is free; close other programs"

    def decode(*arguments):
        return np.empty((1 << 40, 32))

    with pytest.raises(InputError, match=said):
        decode_file(path, decode)
    monkeypatch.setattr("photonmap.io.readers.ply.decoding.decode_file", decode)
    with pytest.raises(InputError, match=said):
        pm.load_scene(path)
    monkeypatch.setattr("photonmap.inspection.describe.inspect_file", decode)
    assert main(["info", str(path)]) == 2
    assert capsys.readouterr().err.startswith("photonmap: error: needs 281475.0 GB of memory")


def test_what_is_shown_several_times_fits_into_free_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "FREELY", 1000)
    monkeypatch.setattr("photonmap.runtime.storage.free_memory", lambda: 10**6)
    budget = Budget(tmp_path / "a.glb")
    budget.spend(900_000)
    with pytest.raises(InputError, match=r"a\.glb: .* needs more than the 0\.0 GB of memory"):
        budget.spend(200_000)
    many = [hostile.GROWING[kind](6000) for kind in ("glTF: nodes", "XML: shapes")]
    many += [hostile.instances(500), hostile.instances(0, 8)] if find_spec("pxr") else []
    for files in many:
        said = load(hostile.write(tmp_path, files))
        assert "needs more than the 0.0 GB of memory that are free" in said
