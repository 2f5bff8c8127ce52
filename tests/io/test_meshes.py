"""Mesh files of every kind: what is none of them, truncated or damaged."""

import numpy as np
import pytest
import trimesh
from helpers.meshes import TRIANGLE, facets, ply

from photonmap.errors import InputError
from photonmap.io.readers.registry import read_file

pytestmark = pytest.mark.usefixtures("silence")
SUFFIXES = (".ply", ".stl", ".glb", ".gltf")


def test_unknown_suffix(tmp_path):
    with pytest.raises(
        InputError, match=r"a\.fbx: is of an unknown kind; supported: \.glb, \.gltf"
    ):
        read_file(tmp_path / "a.fbx")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_no_file(tmp_path, suffix):
    with pytest.raises(InputError, match=rf"none\{suffix}: cannot be read \(No such file"):
        read_file(tmp_path / f"none{suffix}")
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    with pytest.raises(InputError, match="is a directory; name a file"):
        read_file(folder)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "data", [b"", b"hello\n", b"\x00" * 200, b"\xff\xfe\x00" * 90, b"[1]", b'{"a": 1}', b"ply\n"]
)
def test_wrong_content(read, suffix, data):
    with pytest.raises(InputError, match=rf"a\{suffix}: .*; (export|save|name)") as caught:
        read(f"a{suffix}", data)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["ply", "stl", "glb"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_content_of_another_suffix(read, kind, suffix):
    data = trimesh.creation.box().export(file_type=kind)
    if suffix == f".{kind}":
        assert len(read(f"a{suffix}", data)) == 1
    else:
        with pytest.raises(InputError, match=rf"a\{suffix}: "):
            read(f"a{suffix}", data)


@pytest.mark.parametrize("kind", ["ply", "stl", "stl_ascii"])
def test_truncated(read, kind):
    data = trimesh.creation.icosphere(1).export(file_type=kind)
    data = data.encode() if isinstance(data, str) else data
    for part in (0.01, 0.1, 0.5, 0.9):
        with pytest.raises(InputError, match=r"; (export|name|save)"):
            read(f"a.{kind[:3]}", data[: int(part * len(data))])


@pytest.mark.filterwarnings("ignore::photonmap.errors.SceneWarning")
@pytest.mark.parametrize("kind", ["ply", "ascii.ply", "stl", "ascii.stl", "glb", "gltf"])
def test_damaged_files_end_in_meshes_or_an_input_error(read, build, kind):
    rng = np.random.default_rng(5)
    build.primitive(indices=[0, 1, 2], NORMAL=TRIANGLE + 1, TEXCOORD_0=TRIANGLE[:, :2])
    box = trimesh.creation.box()
    whole = {
        "ply": lambda: ply(TRIANGLE, [[0, 1, 2], [2, 1, 0]], kind="binary_little_endian"),
        "ascii.ply": lambda: ply(TRIANGLE, [[0, 1, 2], [0, 2, 1, 0]]).encode(),
        "stl": lambda: box.export(file_type="stl")[:84] + b"\0" * 600,
        "ascii.stl": lambda: (facets("a") + facets("b")).encode(),
        "glb": build.glb,
        "gltf": build.gltf,
    }[kind]()
    outcomes = set()
    for _ in range(150):
        damaged = np.frombuffer(whole, np.uint8).copy()
        places = rng.integers(len(damaged), size=rng.integers(1, 4))
        damaged[places] = rng.choice(np.frombuffer(b'0123456789 -."[]{}\n\0\xff', np.uint8))
        end = rng.integers(len(damaged)) if rng.random() < 0.2 else len(damaged)
        try:
            meshes = read(f"a.{kind[-4:].lstrip('.').split('.')[-1]}", damaged[:end].tobytes())
        except InputError:
            outcomes.add("error")
            continue
        outcomes.add("meshes")
        for mesh in meshes:
            assert np.isfinite(mesh.vertices).all()
            assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))
    assert outcomes == {"error", "meshes"}
