import itertools

import numpy as np
import pytest

from photonmap.errors import InputError, SceneWarning
from photonmap.readers import wavefront
from photonmap.readers.decimals import parse_floats, parse_integers
from photonmap.readers.obj import _distinct, read_obj
from photonmap.scene import Material

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.fixture
def read(tmp_path):
    def read(text, **libraries):
        for name, library in libraries.items():
            (tmp_path / f"{name}.mtl").write_text(library)
        path = tmp_path / "scene.obj"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_obj(path)

    return read


def triangles(mesh):
    """Corner positions of a mesh, (F, 3, 3)."""
    return mesh.vertices[mesh.faces]


def areas(corners):
    """Vector areas of triangles, (F, 3)."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2


def contents(meshes):
    """Everything a file says, comparable with ==."""
    return [
        (mesh.name, mesh.material)
        + tuple(
            None if rows is None else rows[mesh.faces].tolist()
            for rows in (mesh.vertices, mesh.normals, mesh.uv)
        )
        for mesh in meshes
    ]


def polygon_obj(points):
    """One face of any number of corners."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, float).tolist()]
    return "\n".join([*lines, "f " + " ".join(map(str, range(1, len(lines) + 1))), ""])


def vector_area(points):
    """The shoelace formula in space."""
    return np.cross(points, np.roll(points, -1, 0)).sum(0) / 2


# --- polygons -----------------------------------------------------------------------------


def star(corners):
    """Spikes: star-shaped, but from no corner."""
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    radius = np.where(np.arange(corners) % 2, 0.3, 1.0)
    return np.c_[radius * np.cos(angle), radius * np.sin(angle)]


def comb(teeth):
    """Far from star-shaped."""
    x = np.arange(2 * teeth + 1)
    return np.r_[np.c_[x, np.where(x % 2, 0.1, 1.0)], [[2 * teeth, 0], [0, 0]]][::-1]


def regular(corners):
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    return np.c_[np.cos(angle), np.sin(angle)]


SHAPES = {
    "square": regular(4),
    "disc": regular(100),
    "dart": np.array([[0, 0], [2, 1], [0, 2], [0.5, 1]]),
    "star": star(14),
    "comb": comb(6),
    "collinear": np.array([[0, 0], [1, 0], [2, 0], [2, 2], [1, 2], [0, 2], [0, 1]]),
    "ell": np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]]),
    "repeated": np.array([[0, 0], [1, 0], [1, 1], [1, 1], [0, 1]]),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("winding", [1, -1])
def test_polygon_area_and_winding(read, shape, turn, winding):
    flat = np.roll(SHAPES[shape], turn, 0)[::winding]
    rotation, _ = np.linalg.qr(np.random.default_rng(turn).normal(size=(3, 3)))
    points = np.c_[flat, np.zeros(len(flat))] @ rotation + [3, -2, 7]
    (mesh,) = read(polygon_obj(points))
    pieces, whole = areas(triangles(mesh)), vector_area(points)
    normal = whole / np.linalg.norm(whole)
    assert (pieces @ normal > 0).all()
    np.testing.assert_allclose(pieces.sum(0), whole, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose((pieces @ normal).sum(), np.linalg.norm(whole), rtol=1e-12)


@pytest.mark.parametrize("dart", list(itertools.permutations(range(4))))
def test_every_order_of_a_concave_quad(read, dart):
    points = np.c_[SHAPES["dart"], np.zeros(4)][list(dart)]
    simple = abs(vector_area(points)[2]) == vector_area(np.c_[SHAPES["dart"], np.zeros(4)])[2]
    (mesh,) = read(polygon_obj(points))
    if simple:
        pieces = areas(triangles(mesh))[:, 2]
        assert np.abs(pieces).sum() == pytest.approx(abs(vector_area(points)[2]))


def test_bent_quad_keeps_its_corners(read):
    (mesh,) = read("v 0 0 0\nv 1 0 0\nv 1 1 0.3\nv 0 1 0\nf 1 2 3 4\n")
    assert len(mesh.vertices) == 4
    assert (areas(triangles(mesh))[:, 2] > 0).all()


def test_mixed_sizes_keep_their_order(read):
    (mesh,) = read(SQUARE + "v 2 0 0\nv 2 1 0\nf 2 5 6 3\nf 1 2 3\nf 1 3 4\nf 5 6 3 2\n")
    centres = triangles(mesh).mean(1)[:, 0]
    assert (centres[:2] > 1).all()
    assert (centres[2:4] < 1).all()
    assert (centres[4:] > 1).all()


def test_faces_without_area_are_left_out_and_counted(read):
    faces = "f 1 2 3\nf 1 1 2\nf 1 2 5\nf 4 4 4 4\nf 1 3 4 4\n"
    with pytest.warns(SceneWarning, match=r"scene\.obj: 3 of 5 faces have no area"):
        (mesh,) = read(SQUARE + "v 2 0 0\n" + faces)
    assert areas(triangles(mesh))[:, 2].tolist() == [0.5, 0.5]


def test_thin_is_not_degenerate(read):
    (mesh,) = read("v 0 0 0\nv 1 0 0\nv 0 1e-9 0\nf 1 2 3\n")
    assert len(mesh.faces) == 1


# --- numbers ------------------------------------------------------------------------------


FORMS = ["%.6f", "%.3f", "%g", "%+.2f", "%d", "%.15f", "%.17g", "%.9e"]
ODD = [".5", "-.5", "5.", "+5.", "-0", "007.250", "9007199254740993", "0." + "0" * 25 + "1"]


@pytest.mark.parametrize("forms", [FORMS[:6], FORMS])
@pytest.mark.parametrize("odd", [ODD[:6], ODD, ["1E3", "1e-320", "-2.5e+3"]])
def test_numbers_are_correctly_rounded(forms, odd):
    rng = np.random.default_rng(7)
    values = rng.normal(size=600) * 10.0 ** rng.integers(-9, 6, 600)
    words = [form % value for form, value in zip(itertools.cycle(forms), values, strict=False)]
    text = np.frombuffer((" " + " ".join(words + odd) + "\n").encode(), np.uint8)
    np.testing.assert_array_equal(parse_floats(text), [float(word) for word in words + odd])


@pytest.mark.parametrize(
    "words", ["1-2", "1 - 2", "1-2 - 3", "1 2 -", "1 2 -.", ".", "+ .", "1 .-5"]
)
def test_malformed_numbers(words):
    text = np.frombuffer(f" {words}\n".encode(), np.uint8)
    assert parse_floats(text) is None
    assert len(parse_integers(text)) != len(words.split())


def test_extra_components_are_ignored(read):
    text = "v 0 0 0 1\nv 1 0 0 0.5 0.5 nan\nv 0 1 0\nvt 0.5\nvt 0.1 0.2 0.3\nvn 0 0 1 7\n"
    (mesh,) = read(text + "f 1/1/1 2/2/1 3/2/1\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.uv.tolist() == [[0.5, 0], [0.1, 0.2], [0.1, 0.2]]
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_blocks_join(read, monkeypatch):
    rng = np.random.default_rng(3)
    lines = []
    for i in range(60):
        lines += [
            f"o {i % 7}",
            *(f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in rng.normal(size=(4, 3))),
        ]
        lines += ["vt 0.5 0.25", "vn 0 0 1", "f -4 -3 -2", f"f {4 * i + 1}/-1/-1 -1/1 -3//1"]
    whole = contents(read("\n".join(lines)))
    for size in (1, 50, 333):
        monkeypatch.setattr(wavefront, "BLOCK", size)
        assert contents(read("\n".join(lines))) == whole


# --- indices ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("corners", "uv", "normals"),
    [
        ("1 2 3", False, False),
        ("1/1 2/2 3/3", True, False),
        ("1//1 2//1 3//1", False, True),
        ("1/1/1 2/2/1 3/3/1", True, True),
        ("1/ 2// 3/", False, False),
        ("-4 -3 -2", False, False),
        ("-4/-3/-1 -3/-2/-1 -2/-1/-1", True, True),
        ("+1//-1 -3//1 3//+1", False, True),
    ],
)
def test_corner_forms(read, corners, uv, normals):
    (mesh,) = read(SQUARE + f"vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf {corners}\nf 1 3 4\n")
    first = mesh.faces[0]
    assert mesh.vertices[first].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert (mesh.uv is not None, mesh.normals is not None) == (uv, normals)
    if uv:
        assert mesh.uv[first].tolist() == [[0, 0], [1, 0], [1, 1]]
    if normals:
        assert mesh.normals[first].tolist() == [[0, 0, 1]] * 3
        assert mesh.normals[mesh.faces[1]].tolist() == [[0, 0, 0]] * 3


def test_relative_indices_count_from_their_line(read):
    relative = (
        SQUARE + "f -4 -3 -2 -1\nv 0 0 1\nvt 0 1\nv 1 0 1\nf -6/-1 -5 -1\nvt 1 1\nf -3 -1 -2/-1\n"
    )
    absolute = SQUARE + "f 1 2 3 4\nv 0 0 1\nvt 0 1\nv 1 0 1\nf 1/1 2 6\nvt 1 1\nf 4 6 5/2\n"
    assert contents(read(relative)) == contents(read(absolute))


def test_forward_reference(read):
    (mesh,) = read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n")
    assert areas(triangles(mesh)).tolist() == [[0, 0, 0.5]]


def test_vertices_are_split_only_where_needed(read):
    cube = "".join(f"v {x} {y} {z}\n" for x, y, z in itertools.product((0, 1), repeat=3))
    sides = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    normals = "vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n"
    flat = "".join("f " + " ".join(sides[i].split()) + "\n" for i in range(6))
    split = "".join(
        "f " + " ".join(f"{corner}//{i + 1}" for corner in sides[i].split()) + "\n"
        for i in range(6)
    )
    (shared,) = read(cube + flat)
    (apart,) = read(cube + normals + split)
    assert (len(shared.vertices), len(apart.vertices)) == (8, 24)
    np.testing.assert_array_equal(triangles(shared), triangles(apart))
    outward = areas(triangles(apart))
    np.testing.assert_allclose(2 * outward, apart.normals[apart.faces[:, 0]])
    inside = np.einsum("fi,fi->f", outward, triangles(apart).mean(1) - 0.5)
    assert (inside > 0).all()


@pytest.mark.parametrize("largest", [3, 2**31 - 2])
def test_distinct_rows(largest):
    rows = np.random.default_rng(5).choice([0, 1, largest - 1, largest], (200, 3)).astype(np.int32)
    distinct, which = _distinct(rows)
    np.testing.assert_array_equal(distinct, np.unique(rows, axis=0))
    np.testing.assert_array_equal(distinct[which], rows)


def test_unused_vertices_are_dropped_and_counted(read):
    with pytest.warns(SceneWarning, match=r"scene\.obj: 2 of 6 vertices are in no face"):
        (mesh,) = read("v 9 9 9\n" + SQUARE + "v 8 8 8\nf 2 3 4 5\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


# --- objects and materials ----------------------------------------------------------------


def test_one_mesh_for_each_object_and_material(read):
    text = (
        "mtllib a.mtl\n" + SQUARE + "f 1 2 3\ng side\nf 1 3 4\no red box\nusemtl bright red\n"
        "f 1 2 3\ng ignored\nusemtl b\nf 1 3 4\nusemtl bright red\nf 1 2 4\no\nf 2 3 4\n"
        "g\nf 2 3 4\n"
    )
    meshes = read(text, a="newmtl bright red\nKd 1 0 0\nnewmtl b\n")
    red = Material("bright red", (1, 0, 0))
    assert [(mesh.name, mesh.material, len(mesh.faces)) for mesh in meshes] == [
        ("scene", Material(), 1),
        ("side", Material(), 1),
        ("red box", red, 2),
        ("red box", Material("b"), 1),
        ("ignored", red, 1),
        ("scene", red, 1),
    ]


@pytest.mark.parametrize(
    "lines",
    ["mtllib my wood.mtl", "mtllib a.mtl b.mtl", "mtllib a.mtl\nmtllib b.mtl\nmtllib a.mtl"]
    + ["mtllib .\\b.mtl", "mtllib\tb.mtl  ", "mtllib a.mtl my wood.mtl\nmtllib my wood.mtl"],
)
def test_mtllib_forms(read, lines):
    wood = "newmtl wood\nKd 0.25\n"
    names = {"a": "newmtl stone\n", "b": wood, "my wood": wood}
    if "a.mtl my" in lines:
        names |= {"my": "newmtl my\n", "wood": "newmtl other\n"}
        lines = lines.replace("a.mtl my wood.mtl", "a.mtl wood.mtl")
    (mesh,) = read(f"{SQUARE}usemtl wood\nf 1 2 3 4\n{lines}\n", **names)
    assert mesh.material == Material("wood", (0.25, 0.25, 0.25))


def test_first_library_decides(read):
    text = f"mtllib a.mtl b.mtl\n{SQUARE}usemtl x\nf 1 2 3 4\n"
    (mesh,) = read(text, a="newmtl x\nKd 0.1\n", b="newmtl x\nKd 0.2\n")
    assert mesh.material.reflectance == (0.1, 0.1, 0.1)


def test_empty_usemtl_goes_back_to_the_default(read):
    meshes = read(f"mtllib a.mtl\n{SQUARE}usemtl x\nf 1 2 3\nusemtl\nf 1 3 4\n", a="newmtl x\n")
    assert [mesh.material.name for mesh in meshes] == ["x", "grey"]


def test_what_is_not_simulated_is_named_once(read):
    text = SQUARE + "s 1\nf 1 2 3 4\nl 1 2\nl 2 3\np 1\ncurv 0 1 1 2\nvp 1\ns off\nlod 3\n"
    with pytest.warns(SceneWarning) as record:
        read(text)
    assert len(record) == 1
    assert "scene.obj: 6 lines are not simulated" in str(record[0].message)
    assert "'l', 'p', 'curv', 'vp', 'lod'" in str(record[0].message)


# --- text ---------------------------------------------------------------------------------

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
def test_text_forms(tmp_path, read, change):
    (tmp_path / "tür.mtl").write_bytes(change("newmtl weiß\nKd 1 1 1\n"))
    (mesh,) = read(change(PLAIN))
    assert (mesh.name, mesh.material.name) == ("Haus für Kjell", "weiß")
    assert triangles(mesh).tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]


def test_blender_export(read):
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
    with pytest.warns(SceneWarning, match=r"a\.mtl: not simulated: 'Ns' .*; 'Ks' .*; 'Ni' of"):
        (mesh,) = read(text, a=library)
    assert mesh.name == "Cube.001"
    assert mesh.material == Material("Material.001", (0.8,) * 3, (0.0,) * 3)
    np.testing.assert_array_equal(areas(triangles(mesh)).sum(0), [0, 0, -4])
    np.testing.assert_array_equal(mesh.normals, [[0, 0, -1]] * 4)


def test_3ds_max_export(read):
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
    with pytest.warns(SceneWarning, match="'Ns' of 'Material_#25'; 'Ni' of 'Material_#25'$"):
        (mesh,) = read(text, a=library)
    assert (mesh.name, mesh.material.reflectance) == ("Box001", (0.588,) * 3)
    assert areas(triangles(mesh)).tolist() == [[0, 2, 0], [0, 2, 0]]


# --- errors -------------------------------------------------------------------------------

F = "f 1 2 3\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r": is empty; export"),
        ("# nothing\n", r": has no faces"),
        (SQUARE, r": has no faces"),
        ("v 0 0 0\n" * 3 + F, r": has no face with an area"),
        (SQUARE.encode() + b"\x00\x01", r":5: is no text file \(byte 0x00\); .*UTF-8"),
        (b"\x89PNG\r\n\x1a\n", r":2: is no text file \(byte 0x1a\)"),
        (SQUARE.encode("utf-16"), r":1: is no text file"),
        (SQUARE + "f 1 2 5\n", r":5: face corner '5' is outside the file's 4 vertices"),
        (SQUARE + F + "f 1 2 3/1\n", r":6: face corner '3/1' .* 0 texture coordinates"),
        (SQUARE + "f 1//1 2 3\n", r":5: face corner '1//1' .* 0 normals; count from 1"),
        (SQUARE + "\nf 1 0 3\n", r":6: face corner '0' is outside"),
        (SQUARE + "f 1 2 3/0\n", r":5: face corner '3/0' is outside"),
        (SQUARE + "f 1 2 -5\nv 0 0 0\n", r":5: face corner '-5' .* back from this line with -1"),
        (SQUARE + "f 1 2 99999999999999999999\n", r":5: face corner '99999999999999999999' is"),
        (SQUARE + "f 1 2 4294967297\n", r":5: face corner '4294967297' is outside"),
        (SQUARE + "f 1 2 -9223372036854775809\n", r":5: face corner '-9223372036854775809' is"),
        (SQUARE + "f 1 2\n", r":5: face of 2 corners; give it three or more"),
        (SQUARE + "f\n", r":5: face of 0 corners"),
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
        (SQUARE + "usemtl wood\n" + F, r":5: material 'wood' has no MTL file; add an mtllib line"),
        (SQUARE + "mtllib b.mtl\n" + F, r":5: MTL file 'b.mtl' is not beside .*mean 'lib.mtl'\?"),
        (SQUARE + "mtllib lib.mtl b c.mtl\n", r":5: MTL file 'b' is not beside"),
        (SQUARE + "mtllib " + "x" * 5000 + "\n", r":5: MTL file 'x{60}\.\.\.' is not beside"),
        (SQUARE + "mtllib\n", r":5: MTL file '' is not beside"),
        (SQUARE + "mtllib lib.mtl\nusemtl Wod\n" + F, r":6: material 'Wod' .*mean 'wood'\?"),
        (SQUARE + "mtllib lib.mtl\nusemtl " + "x" * 5000 + "\n", r":6: material 'x{60}\.\.\.'"),
    ],
)
def test_errors_name_line_value_and_remedy(read, text, message):
    with pytest.raises(InputError, match=r"scene\.obj" + message) as caught:
        read(text, lib="newmtl stone\nnewmtl wood\n")
    assert "\n" not in str(caught.value)


def test_error_in_a_library_names_that_file(read):
    with pytest.raises(InputError, match=r"lib\.mtl:2: Kd '2 0 0'"):
        read(f"mtllib lib.mtl\n{SQUARE}{F}", lib="newmtl a\nKd 2 0 0\n")


def test_no_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.obj: cannot be read \(No such file"):
        read_obj(tmp_path / "none.obj")
    with pytest.raises(InputError, match=r"is a directory; name an OBJ file"):
        read_obj(tmp_path)
    with pytest.raises(InputError, match=r"cannot be read"):
        read_obj("a\0b.obj")


@pytest.mark.filterwarnings("ignore::photonmap.errors.SceneWarning")
def test_damaged_files_end_in_meshes_or_an_input_error(read):
    rng = np.random.default_rng(11)
    whole = (
        PLAIN + "vn 0 0 1\nvt 0.5 0.5\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\nl 1 2\n"
    ).encode()
    alphabet = np.frombuffer(b"0123456789 \n\r\t\\/#-+.evnftlogusm\x00\xff", np.uint8)
    outcomes = set()
    for _ in range(400):
        damaged = np.frombuffer(whole, np.uint8).copy()
        places = rng.integers(len(damaged), size=rng.integers(1, 5))
        damaged[places] = rng.choice(alphabet, len(places))
        begin = rng.integers(20) if rng.random() < 0.2 else 0
        end = rng.integers(len(damaged)) if rng.random() < 0.2 else len(damaged)
        try:
            meshes = read(damaged[begin:end].tobytes(), tür="newmtl weiß\n")
        except InputError:
            outcomes.add("error")
            continue
        outcomes.add("meshes")
        for mesh in meshes:
            assert np.isfinite(mesh.vertices).all()
            assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))
    assert outcomes == {"error", "meshes"}
