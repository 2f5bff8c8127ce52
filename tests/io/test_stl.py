"""STL files, binary and ASCII."""

import struct

import numpy as np
import pytest
import trimesh
from helpers.meshes import corners, facets

from photonmap.errors import InputError
from photonmap.scene.material import Material

pytestmark = pytest.mark.usefixtures("silence")


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_is_flat(read, kind):
    ball = trimesh.creation.icosphere(1)
    (mesh,) = read("part.stl", ball.export(file_type=kind))
    assert (mesh.name, mesh.material) == ("part", Material("default"))
    assert (mesh.normals, mesh.uv) == (None, None)
    np.testing.assert_allclose(corners(mesh), ball.triangles, atol=1e-6)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_stl_of_several_solids(read, newline):
    text = facets("Left") + facets("the right", 1) + facets("Left", 2) + facets("")
    left, right, *others = read("a.stl", text.replace("\n", newline))
    assert [mesh.name for mesh in others] == ["Left", "a"]
    assert (left.name, right.name) == ("Left", "the right")
    assert left.material is right.material
    assert right.vertices.tolist() == [[0, 0, 1], [1, 0, 1], [0, 1, 1]]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b" " * 80 + struct.pack("<I", 0), "has no triangles"),
        (b" " * 80 + struct.pack("<I", 9) + b"\0" * 50, "no triangles|is damaged"),
        ("solid a\nendsolid a\n", "has no triangles"),
        (facets("a") + facets("b")[:-12], r"is damaged: 1 of 2 facets \(6 vertices\) are"),
        (facets("a").replace("vertex 1 0 0\n", ""), "is damaged"),
        (facets("a").replace("1 0 0", "1 0 x"), "5: 'x' is not a number; export it again"),
        (facets("a").replace("1 0 0", "1 0"), "5: vertex has 2 numbers, not 3"),
        (facets("a").replace("1 0 0", "nan 0 0"), r"mesh 'a': vertex 1 is \(nan, 0, 0\)"),
        (facets("a").replace("1 0 0", "1e99 0 0"), r"vertex 1 is \(1e\+99, 0, 0\)"),
    ],
)
def test_stl_errors(read, data, message):
    with pytest.raises(InputError, match=r"a\.stl:.*(" + message + ")"):
        read("a.stl", data)
