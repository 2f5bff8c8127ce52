"""PLY files: their properties, and what is refused."""

import struct

import numpy as np
import pytest
import trimesh
from helpers.meshes import TRIANGLE, areas, corners, ply, volume

from photonmap.errors import InputError, SceneWarning
from photonmap.scene.images import decode_srgb
from photonmap.scene.material import Material

pytestmark = pytest.mark.usefixtures("silence")


def test_ascii_ply_with_normals(read):
    table = np.c_[TRIANGLE, [[0, 0, 2], [0, 1, 0], [0, 0, 0]]]
    (mesh,) = read("part.ply", ply(table, [[0, 1, 2]], "x y z nx ny nz"))
    assert (mesh.name, mesh.material, mesh.uv) == ("part", Material("default"), None)
    assert mesh.vertices.tolist() == TRIANGLE.tolist()
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert mesh.normals.tolist() == [[0, 0, 2], [0, 1, 0], [0, 0, 0]]


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("names", ["s t", "u v", "texture_u texture_v"])
def test_ply_with_normals_and_uv(read, kind, names):
    table = np.arange(32, dtype=float).reshape(4, 8)
    (mesh,) = read("a.ply", ply(table, [[3, 1, 0], [0, 2, 3]], f"x y z nx ny nz {names}", kind))
    assert mesh.faces.tolist() == [[3, 1, 0], [0, 2, 3]]
    np.testing.assert_array_equal(np.c_[mesh.vertices, mesh.normals, mesh.uv], table)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_ply_of_trimesh(read, encoding):
    ball = trimesh.creation.icosphere(2)
    data = ball.export(file_type="ply", encoding=encoding, vertex_normal=True)
    (mesh,) = read("a.ply", data)
    assert volume(mesh) == pytest.approx(ball.volume, rel=1e-5)
    np.testing.assert_allclose(mesh.normals, ball.vertex_normals, atol=1e-6)
    (flat,) = read("a.ply", ball.export(file_type="ply", encoding=encoding, vertex_normal=False))
    assert flat.normals is None


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_ply_polygons_of_one_size(read, kind):
    dart = [[0, 0, 0], [2, 1, 0], [0, 2, 0], [0.5, 1, 0]]
    for turn in range(4):
        face = np.roll([0, 1, 2, 3], turn).tolist()
        (mesh,) = read("a.ply", ply(dart, [face], kind=kind))
        np.testing.assert_allclose(areas(mesh)[:, 2].sum(), 1.5)
        assert (areas(mesh)[:, 2] > 0).all()


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_polygons_of_several_sizes(read, kind):
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [3, 1, 0], [2, 2, 0]]
    (mesh,) = read("a.ply", ply(square, [[0, 1, 2, 3], [1, 4, 2], [1, 4, 5, 6, 2]], kind=kind))
    assert len(mesh.faces) == 6
    np.testing.assert_allclose(areas(mesh)[:, 2].sum(), 1 + 0.5 + 2.5)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_lists_among_other_properties(read, kind):
    """Lists of lengths of two bytes, of several sizes, with numbers before and behind them."""
    lists = "property list ushort short others\nproperty uchar red\nproperty uchar green\n"
    text = ply(TRIANGLE, [], lists=lists + "property uchar blue\n", kind=kind)
    head = text if isinstance(text, bytes) else text.encode()
    head = head.replace(b"element face 0", b"element face 2")
    rows = [([0, 1, 2], [-7, 300], [255, 0, 128]), ([2, 1, 0], [], [1, 2, 3])]
    order = ">" if "big" in kind else "<"
    for face, others, color in rows:
        if kind == "ascii":
            row = [3, *face, len(others), *others, *color]
            head += (" ".join(map(str, row)) + "\n").encode()
        else:
            counts = f"{order}B3iH{len(others)}h3B"
            head += struct.pack(counts, 3, *face, len(others), *others, *color)
    with pytest.warns(SceneWarning, match="not simulated: face property of 'others'$"):
        (mesh,) = read("a.ply", head)
    assert mesh.faces.tolist() == [[0, 1, 2], [2, 1, 0]]
    np.testing.assert_allclose(mesh.colors[0, 0], decode_srgb(np.array([255, 0, 128]) / 255))


def test_ply_small_faces_and_what_follows_the_last(read):
    data = ply(TRIANGLE, [[0, 1], [0, 1, 2], [2]], kind="binary_little_endian") + b"\0\0"
    message = (
        "not simulated: 2 values behind the last element; 2 faces of fewer than three corners$"
    )
    with pytest.warns(SceneWarning, match=message):
        (mesh,) = read("a.ply", data)
    assert mesh.faces.tolist() == [[0, 1, 2]]


def test_ply_faces_without_area_and_spare_vertices(read):
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [9, 9, 9], [2, 0, 0]]
    expected = r"a\.ply: not simulated: 1 faces without area; 2 vertices in no face$"
    with pytest.warns(SceneWarning, match=expected):
        (mesh,) = read("a.ply", ply(points, [[0, 1, 2, 3], [0, 1, 5]]))
    assert len(mesh.vertices) == 4
    assert mesh.vertices.max() == 1


def test_ply_texture_coordinates_of_corners(read):
    head = ply(np.c_[TRIANGLE, TRIANGLE], [], "x y z nx ny nz")
    head = head.replace("element face 0", "element face 2").replace(
        "end_header", "property list uchar float texcoord\nend_header"
    )
    faces = "3 0 1 2 6 0 0 1 0 0 1\n3 2 1 0 6 0.5 0.5 1 0 0 0.25\n"
    (mesh,) = read("a.ply", head + faces)
    np.testing.assert_array_equal(corners(mesh), TRIANGLE[[[0, 1, 2], [2, 1, 0]]])
    np.testing.assert_array_equal(mesh.normals, mesh.vertices)
    uv = [[[0, 0], [1, 0], [0, 1]], [[0.5, 0.5], [1, 0], [0, 0.25]]]
    assert mesh.uv[mesh.faces].tolist() == uv


def test_ply_names_what_is_not_simulated(read):
    text = ply(
        np.c_[TRIANGLE, np.ones(3)],
        [[0, 1, 2]],
        "x y z confidence",
        more="element edge 1\nproperty int vertex1\nproperty int vertex2\n"
        "comment TextureFile my wood.png\n",
    )
    with pytest.warns(SceneWarning) as record:
        read("a.ply", text + "0 1\n")
    (warning,) = record
    assert str(warning.message).endswith(
        "a.ply: not simulated: texture of 'my wood.png'; vertex property of 'confidence'; "
        "element of 'edge'"
    )


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ply(TRIANGLE, []), "has no triangles; export"),
        (ply([], []), "has no triangles; export"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace(" z\n", " w\n"), "is damaged.*lack x, y or z"),
        (ply(TRIANGLE, [[0, 1, 3]]), "mesh 'a': a face names vertex 3, but there are 3, counted"),
        (ply(TRIANGLE, [[0, 1, -1]]), "a face names vertex -1"),
        (ply([*TRIANGLE, [0, np.nan, 0]], [[0, 1, 2]]), r"vertex 3 is \(0, nan, 0\); export it"),
        (ply([*TRIANGLE, [0, 0, np.inf]], [[0, 1, 2, 3]]), r"vertex 3 is \(0, 0, inf\)"),
        (ply(TRIANGLE * 1e31, [[0, 1, 2]]), r"vertex 1 is \(1e\+31, 0, 0\).* up to 1e\+30"),
        (ply(np.c_[TRIANGLE, TRIANGLE * np.nan], [[0, 1, 2]], "x y z nx ny nz"), "normal 0 is"),
        (ply(np.c_[TRIANGLE, [[0, np.nan]] * 3], [[0, 1, 2]], "x y z s t"), "texture coordinate 0"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("vertex 3", "vertex 5"), "is damaged"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("face 1", "face 2"), "2 rows are announced, but"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("1.0", "x"), "11: 'x' is not a number; export it"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace(" 1.0 0", " 1_0 0"), "'1_0' is not a number"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("1.0", "x", 1), ""),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("end_header", ""), "is damaged"),
        (ply(TRIANGLE, [[0, 1, 2]], kind="binary_little_endian")[:-1], "1 rows are announced, but"),
        (ply(TRIANGLE, [[0, 1, 2], [0, 1]], kind="binary_big_endian")[:-8], "there are 1"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("3 0 1 2", "-3 0 1 2"), "a list has -3 items"),
        (ply(TRIANGLE, [[0] * 40000]), "face 0 has 40000 corners; export it with triangles"),
        (ply(TRIANGLE, [[0, 1]] * 2), "has no triangles; export"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("property float z", "property real z"), "is damaged"),
    ],
)
def test_ply_errors(read, data, message):
    if not message:
        assert len(read("a.ply", data)) == 1
        return
    with pytest.raises(InputError, match=r"a\.ply:.*" + message) as caught:
        read("a.ply", data)
    assert "\n" not in str(caught.value)


def far_away(distance, scale=1.0):
    """A ball of radius 1 at a distance from the origin, scaled."""
    ball = trimesh.creation.icosphere(2)
    return (ball.vertices * scale + distance), ball.faces


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_positions_that_32_bits_cannot_hold(read, kind):
    vertices, faces = far_away(1e6)
    lost = (
        r"a\.ply: mesh 'a' is 1e\+06 away from the origin, where positions in 32 bits are 0\.0625 "
        r"apart, 3\.1% of its size: its shape is coarse; centre it before export$"
    )
    with pytest.warns(SceneWarning, match=lost):
        read("a.ply", ply(vertices, faces.tolist(), kind=kind))


@pytest.mark.parametrize(
    "vertices",
    [far_away(0.0)[0], far_away(1e3)[0], far_away(1e6, 1e4)[0], far_away(1e6)[0].round()],
)
def test_positions_that_32_bits_can_hold(read, recwarn, vertices):
    """Near the origin; or large enough; or, far from it, on a grid of whole numbers."""
    faces = far_away(0.0)[1].tolist()
    read("a.ply", ply(vertices, faces))
    assert not [each for each in recwarn if "32 bits" in str(each.message)]
