"""Files written and read by the tests of readers."""

import logging

import numpy as np
import pytest
from helpers.meshes import GltfBuilder

from photonmap.io.png import encode_png
from photonmap.io.readers.registry import read_file
from photonmap.io.readers.scene_file import load_scene


@pytest.fixture
def silence(capfd, caplog):
    """Nothing is logged, nor written."""
    with caplog.at_level(logging.DEBUG, "trimesh"):
        yield
    assert not caplog.records
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def read(tmp_path):
    """Write a file and read it."""

    def read(name, data):
        (tmp_path / name).write_bytes(data.encode() if isinstance(data, str) else data)
        return read_file(tmp_path / name).meshes

    return read


@pytest.fixture
def read_obj(tmp_path):
    """Write an OBJ file and its libraries, and read it."""

    def read(text, **libraries):
        for name, library in libraries.items():
            (tmp_path / f"{name}.mtl").write_text(library)
        path = tmp_path / "scene.obj"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_file(path).meshes

    return read


@pytest.fixture
def build():
    """A glTF file to be written."""
    return GltfBuilder()


@pytest.fixture
def load(tmp_path):
    def load(toml=None, name="room.obj"):
        (tmp_path / name).write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        if toml is not None:
            toml = toml if isinstance(toml, bytes) else toml.encode()
            (tmp_path / "room.toml").write_bytes(toml)
        return load_scene(tmp_path / name)

    return load


@pytest.fixture
def wall(tmp_path):
    """Read the material of a TOML scene from the keys of its section, beside the image a.png."""
    texels = np.array([[[51, 102, 153], [204, 102, 0]]], np.uint8)
    (tmp_path / "a.png").write_bytes(encode_png(texels))
    rows = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{rows}usemtl wall\nf 1/1 2/2 3/3\n")
    (tmp_path / "a.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\n")

    def read(keys):
        (tmp_path / "a.toml").write_text(f"[material.wall]\n{keys}\n")
        return load_scene(tmp_path / "a.obj").meshes[0].material

    return read
