"""Mesh files of every kind: what is none of them, or truncated."""

import pytest
import trimesh

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
