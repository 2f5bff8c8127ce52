"""OBJ files: polygons, numbers, indices, groups and libraries."""

import itertools

import numpy as np
import pytest
from helpers.meshes import areas, corners

from photonmap.errors import SceneWarning
from photonmap.io.readers.decoding import parse_floats, parse_integers
from photonmap.io.readers.obj import _distinct
from photonmap.scene.material import Material

CORNERS = list(itertools.product((-1, 1), repeat=3))
FACES = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
VERTICES = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)


def cube(*groups):
    """Return a cube whose faces have these `s` lines, as text."""
    faces = (f"{group}f {face}\n" for group, face in zip(groups, FACES, strict=True))
    return VERTICES + "".join(faces)


def normals(mesh):
    """Return the unit normals of corners by the vertex they stand at, each once."""
    found = {}
    for at, normal in zip(mesh.vertices.tolist(), mesh.unit_normals.tolist(), strict=True):
        found.setdefault(tuple(at), set()).add(tuple(np.round(normal, 12)))
    return found


@pytest.mark.parametrize("group", ["1", "2", "Body"])
def test_a_smoothed_cube_has_its_diagonals(read_obj, group):
    (mesh,) = read_obj(cube(f"s {group}\n", *[""] * 5))
    assert len(mesh.vertices) == 8
    np.testing.assert_allclose(mesh.unit_normals, mesh.vertices / np.sqrt(3.0), atol=1e-14)


def test_angles_weigh_so_that_the_division_into_triangles_does_not_matter(read_obj):
    divided = cube(*[""] * 6)
    for face in FACES:
        a, b, c, d = face.split()
        divided = divided.replace(f"f {face}\n", f"f {a} {b} {c}\nf {a} {c} {d}\n")
    (mesh,) = read_obj(divided.replace("f ", "s 1\nf ", 1))
    np.testing.assert_allclose(mesh.unit_normals, mesh.vertices / np.sqrt(3.0), atol=1e-14)


@pytest.mark.parametrize("off", ["s off\n", "s 0\n", "s Off\n", "s\n", ""])
def test_without_a_group_faces_are_flat(read_obj, off):
    (mesh,) = read_obj(cube(off, *[""] * 5))
    assert mesh.normals is None
    (mesh,) = read_obj(cube("s 1\n", off or "s off\n", *[""] * 4))
    assert np.count_nonzero(mesh.normals.any(axis=1)) == 4


def test_groups_meet_at_an_edge(read_obj):
    """Two rings of two faces each: at a vertex each group has the mean of its own faces."""
    (mesh,) = read_obj(cube("s 1\n", "s 2\n", "s 1\n", "s 2\n", "s off\n", ""))
    half = np.round(np.sqrt(0.5), 12)
    assert normals(mesh)[-1.0, -1.0, -1.0] == {(-half, -half, 0.0), (0.0, 0.0, 0.0)}
    assert normals(mesh)[-1.0, 1.0, -1.0] == {(-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)}


def test_normals_of_the_file_are_kept(read_obj):
    text = cube("s 1\n", *[""] * 5).replace("f 1 2 4 3", "f 1//1 2//1 4//1 3//1")
    (mesh,) = read_obj(text.replace("s 1", "vn 0 0 1\ns 1"))
    assert (0.0, 0.0, 1.0) in normals(mesh)[-1.0, -1.0, -1.0]
    half = np.round(np.sqrt(0.5), 12)
    assert (0.0, -half, -half) in normals(mesh)[-1.0, -1.0, -1.0]


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


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
def test_polygon_area_and_winding(read_obj, shape, turn, winding):
    flat = np.roll(SHAPES[shape], turn, 0)[::winding]
    rotation, _ = np.linalg.qr(np.random.default_rng(turn).normal(size=(3, 3)))
    points = np.c_[flat, np.zeros(len(flat))] @ rotation + [3, -2, 7]
    (mesh,) = read_obj(polygon_obj(points))
    pieces, whole = areas(mesh), vector_area(points)
    normal = whole / np.linalg.norm(whole)
    assert (pieces @ normal > 0).all()
    np.testing.assert_allclose(pieces.sum(0), whole, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose((pieces @ normal).sum(), np.linalg.norm(whole), rtol=1e-12)


@pytest.mark.parametrize("dart", list(itertools.permutations(range(4))))
def test_every_order_of_a_concave_quad(read_obj, dart):
    points = np.c_[SHAPES["dart"], np.zeros(4)][list(dart)]
    simple = abs(vector_area(points)[2]) == vector_area(np.c_[SHAPES["dart"], np.zeros(4)])[2]
    (mesh,) = read_obj(polygon_obj(points))
    if simple:
        pieces = areas(mesh)[:, 2]
        assert np.abs(pieces).sum() == pytest.approx(abs(vector_area(points)[2]))


def test_bent_quad_keeps_its_corners(read_obj):
    (mesh,) = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0.3\nv 0 1 0\nf 1 2 3 4\n")
    assert len(mesh.vertices) == 4
    assert (areas(mesh)[:, 2] > 0).all()


def test_mixed_sizes_keep_their_order(read_obj):
    (mesh,) = read_obj(SQUARE + "v 2 0 0\nv 2 1 0\nf 2 5 6 3\nf 1 2 3\nf 1 3 4\nf 5 6 3 2\n")
    centres = corners(mesh).mean(1)[:, 0]
    assert (centres[:2] > 1).all()
    assert (centres[2:4] < 1).all()
    assert (centres[4:] > 1).all()


def test_faces_without_area_are_left_out_and_counted(read_obj):
    faces = "f 1 2 3\nf 1 1 2\nf 1 2 5\nf 4 4 4 4\nf 1 3 4 4\n"
    with pytest.warns(SceneWarning, match=r"scene\.obj: 3 of 5 faces have no area"):
        (mesh,) = read_obj(SQUARE + "v 2 0 0\n" + faces)
    assert areas(mesh)[:, 2].tolist() == [0.5, 0.5]


def test_thin_is_not_degenerate(read_obj):
    (mesh,) = read_obj("v 0 0 0\nv 1 0 0\nv 0 1e-9 0\nf 1 2 3\n")
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


def test_extra_components_are_ignored(read_obj):
    text = "v 0 0 0 1\nv 1 0 0 0.5 0.5 nan\nv 0 1 0\nvt 0.5\nvt 0.1 0.2 0.3\nvn 0 0 1 7\n"
    (mesh,) = read_obj(text + "f 1/1/1 2/2/1 3/2/1\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.uv.tolist() == [[0.5, 0], [0.1, 0.2], [0.1, 0.2]]
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_blocks_join(read_obj, monkeypatch):
    rng = np.random.default_rng(3)
    lines = []
    for i in range(60):
        lines += [
            f"o {i % 7}",
            *(f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in rng.normal(size=(4, 3))),
        ]
        lines += ["vt 0.5 0.25", "vn 0 0 1", "f -4 -3 -2", f"f {4 * i + 1}/-1/-1 -1/1 -3//1"]
    whole = contents(read_obj("\n".join(lines)))
    for size in (1, 50, 333):
        monkeypatch.setattr("photonmap.io.readers.obj.lines.BLOCK", size)
        assert contents(read_obj("\n".join(lines))) == whole


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
def test_corner_forms(read_obj, corners, uv, normals):
    (mesh,) = read_obj(SQUARE + f"vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf {corners}\nf 1 3 4\n")
    first = mesh.faces[0]
    assert mesh.vertices[first].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert (mesh.uv is not None, mesh.normals is not None) == (uv, normals)
    if uv:
        assert mesh.uv[first].tolist() == [[0, 0], [1, 0], [1, 1]]
    if normals:
        assert mesh.normals[first].tolist() == [[0, 0, 1]] * 3
        assert mesh.normals[mesh.faces[1]].tolist() == [[0, 0, 0]] * 3


def test_relative_indices_count_from_their_line(read_obj):
    relative = (
        SQUARE + "f -4 -3 -2 -1\nv 0 0 1\nvt 0 1\nv 1 0 1\nf -6/-1 -5 -1\nvt 1 1\nf -3 -1 -2/-1\n"
    )
    absolute = SQUARE + "f 1 2 3 4\nv 0 0 1\nvt 0 1\nv 1 0 1\nf 1/1 2 6\nvt 1 1\nf 4 6 5/2\n"
    assert contents(read_obj(relative)) == contents(read_obj(absolute))


def test_forward_reference(read_obj):
    (mesh,) = read_obj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n")
    assert areas(mesh).tolist() == [[0, 0, 0.5]]


def test_vertices_are_split_only_where_needed(read_obj):
    cube = "".join(f"v {x} {y} {z}\n" for x, y, z in itertools.product((0, 1), repeat=3))
    sides = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    normals = "vn -1 0 0\nvn 1 0 0\nvn 0 -1 0\nvn 0 1 0\nvn 0 0 -1\nvn 0 0 1\n"
    flat = "".join("f " + " ".join(sides[i].split()) + "\n" for i in range(6))
    split = "".join(
        "f " + " ".join(f"{corner}//{i + 1}" for corner in sides[i].split()) + "\n"
        for i in range(6)
    )
    (shared,) = read_obj(cube + flat)
    (apart,) = read_obj(cube + normals + split)
    assert (len(shared.vertices), len(apart.vertices)) == (8, 24)
    np.testing.assert_array_equal(corners(shared), corners(apart))
    outward = areas(apart)
    np.testing.assert_allclose(2 * outward, apart.normals[apart.faces[:, 0]])
    inside = np.einsum("fi,fi->f", outward, corners(apart).mean(1) - 0.5)
    assert (inside > 0).all()


@pytest.mark.parametrize("largest", [3, 2**31 - 2])
def test_distinct_rows(largest):
    rows = np.random.default_rng(5).choice([0, 1, largest - 1, largest], (200, 3)).astype(np.int32)
    distinct, which = _distinct(rows)
    np.testing.assert_array_equal(distinct, np.unique(rows, axis=0))
    np.testing.assert_array_equal(distinct[which], rows)


def test_unused_vertices_are_dropped_and_counted(read_obj):
    with pytest.warns(SceneWarning, match=r"scene\.obj: 2 of 6 vertices are in no face"):
        (mesh,) = read_obj("v 9 9 9\n" + SQUARE + "v 8 8 8\nf 2 3 4 5\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


# --- objects and materials ----------------------------------------------------------------


def test_what_is_said_of_unused_materials_is_not_read(read_obj, recwarn):
    """Errors, missing images and all; but their names are suggested for those that are missing."""
    bad = "newmtl unused\nKd 1.5 1.5 1.5\nmap_Kd none.png\nmap_Bump none.png\nsharpness 9\n"
    text = "mtllib a.mtl\n" + SQUARE + "usemtl unused\nusemtl {}\nf 1 2 3 4\n"
    (mesh,) = read_obj(text.format("wall"), a=bad + "newmtl wall\nKd 0.25\n")
    assert mesh.material == Material("wall", (0.25,) * 3)
    assert not recwarn.list
    with pytest.warns(SceneWarning, match="1 of 1 materials .* did you mean 'unused'"):
        read_obj(text.format("unusd"), a=bad)
    with pytest.raises(ValueError, match=r"a\.mtl:2: Kd '1.5 1.5 1.5' is not a reflectance"):
        read_obj(text.format("unused"), a=bad)


def test_one_mesh_for_each_object_and_material(read_obj):
    text = (
        "mtllib a.mtl\n" + SQUARE + "f 1 2 3\ng side\nf 1 3 4\no red box\nusemtl bright red\n"
        "f 1 2 3\ng ignored\nusemtl b\nf 1 3 4\nusemtl bright red\nf 1 2 4\no\nf 2 3 4\n"
        "g\nf 2 3 4\n"
    )
    meshes = read_obj(text, a="newmtl bright red\nKd 1 0 0\nnewmtl b\n")
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
def test_mtllib_forms(read_obj, lines):
    wood = "newmtl wood\nKd 0.25\n"
    names = {"a": "newmtl stone\n", "b": wood, "my wood": wood}
    if "a.mtl my" in lines:
        names |= {"my": "newmtl my\n", "wood": "newmtl other\n"}
        lines = lines.replace("a.mtl my wood.mtl", "a.mtl wood.mtl")
    (mesh,) = read_obj(f"{SQUARE}usemtl wood\nf 1 2 3 4\n{lines}\n", **names)
    assert mesh.material == Material("wood", (0.25, 0.25, 0.25))


def test_first_library_decides(read_obj):
    text = f"mtllib a.mtl b.mtl\n{SQUARE}usemtl x\nf 1 2 3 4\n"
    (mesh,) = read_obj(text, a="newmtl x\nKd 0.1\n", b="newmtl x\nKd 0.2\n")
    assert mesh.material.reflectance == (0.1, 0.1, 0.1)


def test_empty_usemtl_goes_back_to_the_default(read_obj):
    meshes = read_obj(f"mtllib a.mtl\n{SQUARE}usemtl x\nf 1 2 3\nusemtl\nf 1 3 4\n", a="newmtl x\n")
    assert [mesh.material.name for mesh in meshes] == ["x", "grey"]


def test_weights_of_vertices(read_obj):
    """A weight of 1 changes nothing; others, and colours that are not opaque, are named."""
    (mesh,) = read_obj("v 0 0 0 1\nv 1 0 0 1.0\nv 0 1 0\nf 1 2 3\n")
    assert mesh.colors is None
    with pytest.warns(SceneWarning, match="2 lines are not simulated: 'v with a weight, or with"):
        (mesh,) = read_obj("v 0 0 0 0.5\nv 1 0 0 1 1 0 0\nv 0 1 0 0 1 0\nf 1 2 3\n")
    np.testing.assert_allclose(mesh.colors, [[0.5] * 3, [1, 1, 0], [0, 1, 0]])


def test_what_is_not_simulated_is_named_once(read_obj):
    text = SQUARE + "s 1\nf 1 2 3 4\nl 1 2\nl 2 3\np 1\ncurv 0 1 1 2\nvp 1\ns off\nlod 3\n"
    with pytest.warns(SceneWarning) as record:
        read_obj(text)
    assert len(record) == 1
    assert "scene.obj: 6 lines are not simulated" in str(record[0].message)
    assert "'l', 'p', 'curv', 'vp', 'lod'" in str(record[0].message)
