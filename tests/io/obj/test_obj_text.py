"""OBJ files as text: encodings, exporters, errors and damage."""

import re

import numpy as np
import pytest
from helpers.meshes import areas, corners

from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.registry import read_file
from photonmap.scene.material import Material

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


PLAIN = "mtllib tür.mtl\no Haus für Kjell\n" + SQUARE + "usemtl weiß\nf 1 2 3\nf 1 3 4\n"


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r").encode(),
        lambda text: text.encode("latin-1"),
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.replace(" ", "\t").replace("Haus\tfür\tKjell", "Haus für Kjell").encode(),
        lambda text: text.replace("\n", " # ends with \\\n").encode(),
        lambda text: ("#\n# 1 2 3 \\\n" + text.replace("0\n", "0#x\n")).encode(),
        lambda text: text.replace(" 2 ", " \\\n 2 \\ \r\n\t").encode(),
        lambda text: text.replace("\n", "\n\\\n").encode(),
        lambda text: text.replace("\n", "\n \t ").replace(" v", "\n\n  v").encode(),
        lambda text: text.rstrip().encode(),
        lambda text: (text + "\\").encode(),
    ],
    ids=[
        "crlf",
        "cr",
        "latin-1",
        "bom",
        "tabs",
        "trailing",
        "comments",
        "continued",
        "joined",
        "indented",
    ]
    + ["no end", "open end"],
)
def test_text_forms(tmp_path, read_obj, change):
    (tmp_path / "tür.mtl").write_bytes(change("newmtl weiß\nKd 1 1 1\n"))
    (mesh,) = read_obj(change(PLAIN))
    assert (mesh.name, mesh.material.name) == ("Haus für Kjell", "weiß")
    assert mesh.material.reflectance == (1.0, 1.0, 1.0)
    assert corners(mesh).tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]


def test_blender_export(read_obj):
    text = """# Blender 4.2.0
# www.blender.org
mtllib a.mtl
o Cube.001
v 1.000000 1.000000 -1.000000
v 1.000000 -1.000000 -1.000000
v -1.000000 -1.000000 -1.000000
v -1.000000 1.000000 -1.000000
vn -0.0000 -0.0000 -1.0000
vt 0.625000 0.500000
vt 0.375000 0.500000
vt 0.375000 0.750000
vt 0.625000 0.750000
s 0
usemtl Material.001
f 1/1/1 2/2/1 3/3/1 4/4/1
"""
    library = """# Blender 4.2.0 MTL File: 'None'
# www.blender.org

newmtl Material.001
Ns 250.000000
Ka 1.000000 1.000000 1.000000
Kd 0.800000 0.800000 0.800000
Ks 0.500000 0.500000 0.500000
Ke 0.000000 0.000000 0.000000
Ni 1.450000
d 1.000000
illum 2
"""
    (mesh,) = read_obj(text, a=library)
    assert mesh.name == "Cube.001"
    emission = (0.0,) * 3
    assert mesh.material == Material(
        "Material.001", (0.8,) * 3, emission, glossy=0.04, roughness=0.5
    )
    np.testing.assert_array_equal(areas(mesh).sum(0), [0, 0, -4])
    np.testing.assert_array_equal(mesh.normals, [[0, 0, -1]] * 4)


def test_3ds_max_export(read_obj):
    text = (
        "# 3ds Max Wavefront OBJ Exporter v0.97b - (c)2007 guruware\r\n\r\nmtllib a.mtl\r\n"
        "#\r\n# object Box001\r\n#\r\n\r\n"
        "v  -1.0000 0.0000 1.0000\r\nv  1.0000 0.0000 1.0000\r\nv  1.0000 0.0000 -1.0000\r\n"
        "v  -1.0000 0.0000 -1.0000\r\n# 4 vertices\r\n\r\nvn 0.0000 1.0000 -0.0000\r\n"
        "# 1 vertex normals\r\n\r\nvt 0.0000 0.0000 0.0000\r\n# 1 texture coords\r\n\r\n"
        "g Box001\r\nusemtl Material_#25\r\ns 1\r\nf 1/1/1 2/1/1 3/1/1 \r\ns 2\r\n"
        "f\t3/1/1\t4/1/1\t1/1/1 \r\n# 0 polygons - 2 triangles\r\n\r\n"
    )
    library = (
        "newmtl Material_#25\r\n\tNs 10.0000\r\n\tNi 1.5000\r\n\td 1.0000\r\n\tTr 0.0000\r\n"
        "\tTf 1.0000 1.0000 1.0000 \r\n\tillum 2\r\n\tKa 0.5880 0.5880 0.5880\r\n"
        "\tKd 0.5880 0.5880 0.5880\r\n\tKs 0.0000 0.0000 0.0000\r\n\tKe 0.0000 0.0000 0.0000\r\n"
    )
    (mesh,) = read_obj(text, a=library)
    assert (mesh.name, mesh.material.reflectance) == ("Box001", (0.588,) * 3)
    assert areas(mesh).tolist() == [[0, 2, 0], [0, 2, 0]]


F = "f 1 2 3\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r": is empty; save"),
        ("# nothing\n", r": has no faces"),
        (SQUARE, r": has no faces"),
        ("v 0 0 0\n" * 3 + F, r": has no face with an area"),
        (SQUARE.encode() + b"\x00\x01", r":5: is not a text file \(byte 0x00\); .*UTF-8"),
        (b"\x89PNG\r\n\x1a\n", r":2: is not a text file \(byte 0x1a\)"),
        (SQUARE.encode("utf-16-le"), r":1: is not a text file"),
        (SQUARE + "f 1 2 5\n", r":5: face corner '5' is outside the file's 4 vertices"),
        (SQUARE + F + "f 1 2 3/1\n", r":6: face corner '3/1' .* 0 texture coordinates"),
        (SQUARE + "f 1//1 2 3\n", r":5: face corner '1//1' .* 0 normals; count from 1"),
        (SQUARE + "\nf 1 0 3\n", r":6: face corner '0' is outside"),
        (SQUARE + "f 1 2 3/0\n", r":5: face corner '3/0' is outside"),
        (SQUARE + "f 1 2 -5\nv 0 0 0\n", r":5: face corner '-5' .* back from this line with -1"),
        (SQUARE + "f 1 2 99999999999999999999\n", r":5: face corner '99999999999999999999' is"),
        (SQUARE + "f 1 2 4294967297\n", r":5: face corner '4294967297' is outside"),
        (SQUARE + "f 1 2 -9223372036854775809\n", r":5: face corner '-9223372036854775809' is"),
        (SQUARE + "f 1 2 x\n", r":5: face corner 'x' is malformed; write v, v/vt"),
        (SQUARE + "f 1 2 3.0\n", r":5: face corner '3.0' is malformed"),
        (SQUARE + "f 1 2 /3\n", r":5: face corner '/3' is malformed"),
        (SQUARE + "f 1 2 3///1\n", r":5: face corner '3///1' is malformed"),
        (SQUARE + "f 1 2 3/1//1\n", r":5: face corner '3/1//1' is malformed"),
        (SQUARE + "f 1 2 3/1/1/1\n", r":5: face corner '3/1/1/1' is malformed"),
        (SQUARE + "f 1 2 3/1/1//\n", r":5: face corner '3/1/1//' is malformed"),
        (SQUARE + "f 1 2 3//1/1\n", r":5: face corner '3//1/1' is malformed"),
        (SQUARE + "f 1 2 1-3\n", r":5: face corner '1-3' is malformed"),
        (SQUARE + "f 1 2 --3\n", r":5: face corner '--3' is malformed"),
        (SQUARE + "f 1 2 1-3 - 3\n", r":5: face corner '1-3' is malformed"),
        (SQUARE + "f 1 2 -\n", r":5: face corner '-' is malformed"),
        (SQUARE + "f" + " 1" * 40000 + "\n", r":5: face of 40000 corners; divide it"),
        ("# a\nv 0 0\n" + F, r":2: vertex of 2 numbers; write 3 or more"),
        ("v\n" + F, r":1: vertex of 0 numbers"),
        (SQUARE + "vt\n", r":5: texture coordinate of 0 numbers; write 1 or more"),
        (SQUARE + "v 0 nan 0\n", r":5: vertex has 'nan'; write finite decimals"),
        (SQUARE + "v 0 0 -inf\n", r":5: vertex has '-inf'"),
        (SQUARE + "v 0 0 1e999\n", r":5: vertex has '1e999'"),
        (SQUARE + "v 0 0 1e31\n", r":5: vertex has '1e31'; .* up to 1e\+30"),
        (SQUARE + "v 0 0 1,5\n", r":5: vertex has '1,5'"),
        (SQUARE + "v 0 0 1_0\n", r":5: vertex has '1_0'"),
        (SQUARE + "v 0 0 0x1\n", r":5: vertex has '0x1'"),
        (SQUARE + "v 0 0 1.2.3\n", r":5: vertex has '1.2.3'"),
        (SQUARE + "v 0 0 .\n", r":5: vertex has '\.'"),
        (SQUARE + "v 0 0 .-5\n", r":5: vertex has '\.-5'"),
        (SQUARE + "v 0 1-2\n", r":5: vertex of 2 numbers"),
        (SQUARE + "v 0 0 1-2\n", r":5: vertex has '1-2'"),
        (SQUARE + "v 0 0 0 x\n", r":5: vertex has 'x'"),
        (SQUARE + "vn 0 0 nan\n", r":5: normal has 'nan'"),
        (SQUARE + "vt inf\n", r":5: texture coordinate has 'inf'"),
        (SQUARE + "v 0 \\\n 0 \\\n 0\n# \\\nv x 0 0\n", r":9: vertex has 'x'"),
        (SQUARE.replace("\n", "\r\n") + "v x 0 0\n", r":5: vertex has 'x'"),
        ("\n\n  " + SQUARE + "  v x 0 0\n", r":7: vertex has 'x'"),
        (SQUARE + "f 1 2\n", r": has no faces"),
    ],
)
def test_errors_name_line_value_and_remedy(read_obj, text, message):
    with pytest.raises(InputError, match=r"scene\.obj" + message) as caught:
        read_obj(text, lib="newmtl stone\nnewmtl wood\n")
    assert "\n" not in str(caught.value)


def test_error_in_a_library_names_that_file(read_obj):
    with pytest.raises(InputError, match=r"lib\.mtl:2: Kd '2 0 0'"):
        read_obj(f"mtllib lib.mtl\n{SQUARE}usemtl a\n{F}", lib="newmtl a\nKd 2 0 0\n")


def test_no_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.obj: cannot be read \(No such file"):
        read_file(tmp_path / "none.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(InputError, match=r"is a directory; name a file"):
        read_file(tmp_path / "folder.obj")
    with pytest.raises(InputError, match=r"cannot be read"):
        read_file("a\0b.obj")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mtllib b.mtl\n", r":5: MTL file 'b\.mtl' is not beside the OBJ; .*mean 'lib\.mtl'\?"),
        ("mtllib lib.mtl b c.mtl\n", r":5: MTL file 'b' is not beside"),
        ("mtllib " + "x" * 5000 + "\n", r":5: MTL file 'x{60}\.\.\.' is not beside"),
        ("mtllib none.mtl\n", r":5: MTL file 'none\.mtl' is empty; export it again"),
        (
            "usemtl a\nf 1 2 3\nusemtl b\n",
            ": 2 of 2 materials are in no MTL file .* grey: 'a', 'b'$",
        ),
        ("mtllib lib.mtl\nusemtl Wod\n", r": 1 of 1 materials .*: 'Wod'; did you mean 'wood'\?"),
        ("usemtl " + "x" * 5000 + "\n", r": .* grey: 'x{60}\.\.\.'"),
        ("f 1 2\nf\nf 1\n", ": 3 lines are not simulated: 'f of fewer than three corners'$"),
    ],
)
def test_what_is_missing_is_named(read_obj, text, message):
    with pytest.warns(SceneWarning) as record:
        mesh, *_ = read_obj(SQUARE + text + F, lib="newmtl stone\nnewmtl wood\n", none="")
    assert any(re.search(r"scene\.obj" + message, str(each.message)) for each in record)
    assert mesh.material.reflectance == 0.5


def test_grey_materials_have_their_names(read_obj):
    with pytest.warns(SceneWarning):
        first, second = read_obj(SQUARE + f"usemtl a\n{F}usemtl b\n{F}")
    assert (first.material.name, second.material.name) == ("a", "b")


def test_faces_of_two_corners_between_others(read_obj):
    with pytest.warns(SceneWarning, match="1 lines are not simulated"):
        (mesh,) = read_obj(SQUARE + "f -4 -3 -2\nf 1 2\nf 2 3 4\n")
    (wanted,) = read_obj(SQUARE + "f 1 2 3\nf 2 3 4\n")
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], wanted.vertices[wanted.faces])


@pytest.mark.parametrize("order", ["little", "big"])
def test_utf_16(read_obj, order):
    text = "\ufeff" + SQUARE.replace("\n", "\r\n") + "o Würfel\nf 1 2 3 4\n"
    (mesh,) = read_obj(text.encode("utf-16-le" if order == "little" else "utf-16-be"))
    assert mesh.name == "Würfel"
