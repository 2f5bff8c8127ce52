"""Damaged files of every kind are read, or refused in one line."""

import random
import warnings

import numpy as np
import pytest
import trimesh
from helpers.meshes import TRIANGLE, facets, ply

from photonmap.errors import InputError
from photonmap.io.readers.registry import read_file

OBJ = """mtllib a.mtl
usemtl wall
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vn 0 0 1
vt 0.5 0.5
f 1/1/1 2/1/1 3/1/1 4/1/1
f -1 -2 -3
l 1 2
"""
SCENE = b"""<?xml version="1.0"?>
<scene version="3.0.0">
  <default name="spp" value="16"/>
  <!-- a room -->
  <sensor type="perspective" id="view">
    <float name="fov" value="45.5"/>
    <transform name="to_world"><lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="64"/></film>
  </sensor>
  <bsdf type="twosided" id="wall"><bsdf type="diffuse">
    <rgb name="reflectance" value="0.2, 0.25, 0.7"/>
  </bsdf></bsdf>
  <bsdf type="roughconductor" id="gold"><string name="material" value="Au"/>
    <float name="alpha" value="0.1"/></bsdf>
  <shape type="cube"><transform name="to_world"><scale x="2" y="1.5"/><rotate y="1" angle="30"/>
    </transform><ref id="wall"/></shape>
  <shape type="rectangle" id="lamp"><emitter type="area">
    <spectrum name="radiance" value="400:1, 700:2.5"/></emitter></shape>
  <shape type="disk"><point name="center" x="1" y="0" z="2"/><ref id="gold"/></shape>
  <emitter type="point"><point name="position" x="0" y="3" z="0"/></emitter>
</scene>
"""


WHOLE = {
    "ascii.off": lambda build: (
        b"COFF\n3 1 3\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n"
    ),
    "binary.ply": lambda build: ply(TRIANGLE, [[0, 1, 2], [2, 1, 0]], kind="binary_little_endian"),
    "ascii.ply": lambda build: ply(TRIANGLE, [[0, 1, 2], [0, 2, 1, 0]]).encode(),
    "binary.stl": lambda build: trimesh.creation.box().export(file_type="stl"),
    "ascii.stl": lambda build: (facets("a") + facets("b")).encode(),
    "binary.glb": lambda build: build.glb(),
    "ascii.gltf": lambda build: build.gltf(),
    "ascii.obj": lambda build: OBJ.encode(),
    "ascii.xml": lambda build: SCENE,
}


def damaged(data, rng):
    """Change, drop, repeat or insert some bytes; half of the time digits alone, which stay text."""
    data = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        if not data:
            break
        at = rng.randrange(len(data))
        match rng.randrange(7):
            case 0:
                data[at] = rng.randrange(256)
            case 1:
                del data[at : at + rng.randint(1, 12)]
            case 2:
                data[at:at] = data[at : at + rng.randint(1, 40)]
            case 3 if rng.random() < 0.3:
                del data[max(at, 1) :]
            case _:
                digits = [i for i, byte in enumerate(data) if chr(byte).isdigit()]
                data[rng.choice(digits or [at])] = ord(rng.choice("0123456789-.e, $/"))
    return bytes(data)


@pytest.mark.parametrize("kind", WHOLE)
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, build, kind):
    build.primitive(NORMAL=TRIANGLE + 1, TEXCOORD_0=TRIANGLE[:, :2], indices=[0, 1, 2])
    build.tree["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0.5}, "name": "a"}]
    build.tree["meshes"][0]["primitives"][0]["material"] = 0
    build.tree["nodes"] = [{"children": [1]}, {"mesh": 0, "translation": [1, 2, 3]}]
    (tmp_path / "a.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\n")
    path, rng, refused = tmp_path / f"a.{kind.partition('.')[2]}", random.Random(5), []
    whole, count = WHOLE[kind](build), 40 if kind == "ascii.xml" else 200
    path.write_bytes(whole)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert read_file(path).meshes
        for _ in range(count):
            path.write_bytes(damaged(whole, rng))
            try:
                meshes = read_file(path).meshes
            except InputError as error:
                refused.append(str(error))
                continue
            for mesh in meshes:
                assert np.isfinite(mesh.vertices).all()
                assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))
    assert all(str(path) in line and "\n" not in line for line in refused)
    assert 0 < len(refused) < count
