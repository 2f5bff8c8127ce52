import base64
import json
import logging
import struct

import numpy as np
import pytest
import trimesh

from photonmap.errors import InputError, SceneWarning
from photonmap.readers.meshes import SUFFIXES, read_mesh
from photonmap.scene import Material

TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")


@pytest.fixture(autouse=True)
def _silence(capfd, caplog):
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
        return read_mesh(tmp_path / name)

    return read


def corners(mesh):
    """Corner positions of a mesh, (F, 3, 3)."""
    return mesh.vertices[mesh.faces]


def areas(mesh):
    """Vector areas of triangles, (F, 3)."""
    a, b, c = corners(mesh).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def volume(mesh):
    """Enclosed volume: positive where faces look outwards."""
    return np.linalg.det(corners(mesh)).sum() / 6


def test_suffixes(tmp_path):
    assert SUFFIXES == (".ply", ".stl", ".glb", ".gltf")
    with pytest.raises(InputError, match=r"a\.off: is of no known kind; supported: \.ply, \.stl"):
        read_mesh(tmp_path / "a.off")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_no_file(tmp_path, suffix):
    with pytest.raises(InputError, match=rf"none\{suffix}: cannot be read \(No such file"):
        read_mesh(tmp_path / f"none{suffix}")
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    with pytest.raises(InputError, match="is a directory; name a file"):
        read_mesh(folder)


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


# --- PLY ----------------------------------------------------------------------------------


def ply(vertices, faces, properties="x y z", kind="ascii", lists="", more=""):
    """Write a PLY file by hand."""
    vertices = np.asarray(vertices, "<f4")
    head = f"ply\nformat {kind} 1.0\nelement vertex {len(vertices)}\n"
    head += "".join(f"property float {name}\n" for name in properties.split())
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{lists}{more}"
    head += "end_header\n"
    if kind == "ascii":
        rows = [" ".join(map(repr, row)) for row in vertices.tolist()]
        rows += [f"{len(face)} {' '.join(map(str, face))}" if face else "0" for face in faces]
        return "\n".join([head + rows[0], *rows[1:], ""]) if rows else head
    order = ">" if "big" in kind else "<"
    body = vertices.astype(f"{order}f4").tobytes()
    for face in faces:
        body += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return head.encode() + body


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


def test_ascii_ply_polygons_of_several_sizes(read):
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [3, 1, 0], [2, 2, 0]]
    (mesh,) = read("a.ply", ply(square, [[0, 1, 2, 3], [1, 4, 2], [1, 4, 5, 6, 2]]))
    assert len(mesh.faces) == 6
    np.testing.assert_allclose(areas(mesh)[:, 2].sum(), 1 + 0.5 + 2.5)


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
        np.c_[TRIANGLE, np.ones((3, 4))],
        [[0, 1, 2]],
        "x y z red green blue confidence",
        more="element edge 1\nproperty int vertex1\nproperty int vertex2\n"
        "comment TextureFile my wood.png\n",
    )
    with pytest.warns(SceneWarning) as record:
        read("a.ply", text + "0 1\n")
    (told,) = record
    assert str(told.message).endswith(
        "a.ply: not simulated: texture of 'my wood.png'; vertex colours; "
        "vertex property of 'confidence'; element of 'edge'"
    )


def test_ply_face_colors(read):
    box = trimesh.creation.box()
    box.visual.face_colors = [255, 0, 0, 255]
    with pytest.warns(SceneWarning, match="not simulated: face colours$"):
        read("a.ply", box.export(file_type="ply"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ply(TRIANGLE, []), "has no triangles; export"),
        (ply([], []), "has no triangles; export"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace(" z\n", " w\n"), r"is damaged.*'z'"),
        (ply(TRIANGLE, [[0, 1, 3]]), "mesh 'a': a face names vertex 3, but there are 3, counted"),
        (ply(TRIANGLE, [[0, 1, -1]]), "a face names vertex -1"),
        (ply(TRIANGLE, [[0, 1, 2], [0, 1]]), "face 1 has 2 corners; export it with triangles"),
        (ply([*TRIANGLE, [0, np.nan, 0]], [[0, 1, 2]]), r"vertex 3 is \(0, nan, 0\); export it"),
        (ply([*TRIANGLE, [0, 0, np.inf]], [[0, 1, 2, 3]]), r"vertex 3 is \(0, 0, inf\)"),
        (ply(TRIANGLE * 1e31, [[0, 1, 2]]), r"vertex 1 is \(1e\+31, 0, 0\).* up to 1e\+30"),
        (ply(np.c_[TRIANGLE, TRIANGLE * np.nan], [[0, 1, 2]], "x y z nx ny nz"), "normal 0 is"),
        (ply(np.c_[TRIANGLE, [[0, np.nan]] * 3], [[0, 1, 2]], "x y z s t"), "texture coordinate 0"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("vertex 3", "vertex 5"), "is damaged"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("face 1", "face 2"), "2 rows are announced, 1 are"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("1.0", "x"), "is damaged"),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("1.0", "x", 1), ""),
        (ply(TRIANGLE, [[0, 1, 2]]).replace("end_header", ""), "is damaged"),
        (ply(TRIANGLE, [[0, 0, 0]] * 2, kind="binary_little_endian") + b"\0", "in binary; export"),
        (
            ply(TRIANGLE, [[0, 1, 2], [0, 1, 2, 0]], kind="binary_little_endian"),
            "polygons of several sizes in binary; export it again, triangulated or as ASCII",
        ),
        (
            ply(TRIANGLE, [[0, 1, 2, 0], [0, 1, 2], [0, 1, 2, 0, 1]], kind="binary_little_endian"),
            "lists of several sizes in binary",
        ),
    ],
)
def test_ply_errors(read, data, message):
    if not message:
        assert len(read("a.ply", data)) == 1
        return
    with pytest.raises(InputError, match=r"a\.ply: .*" + message) as caught:
        read("a.ply", data)
    assert "\n" not in str(caught.value)


# --- STL ----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
def test_stl_is_flat(read, kind):
    ball = trimesh.creation.icosphere(1)
    (mesh,) = read("part.stl", ball.export(file_type=kind))
    assert (mesh.name, mesh.material) == ("part", Material("default"))
    assert (mesh.normals, mesh.uv) == (None, None)
    np.testing.assert_allclose(corners(mesh), ball.triangles, atol=1e-6)


def facets(name, z=0):
    """One facet in ASCII."""
    rows = "".join(f"      vertex {x} {y} {z}\n" for x, y in ((0, 0), (1, 0), (0, 1)))
    text = f"  facet normal 0 0 1\n    outer loop\n{rows}    endloop\n  endfacet\n"
    return f"solid {name}\n{text}endsolid {name}\n"


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_stl_of_several_solids(read, newline):
    text = facets("Left") + facets("the right", 1) + facets("Left", 2) + facets("")
    left, right, *others = read("a.stl", text.replace("\n", newline))
    assert [mesh.name for mesh in others] == ["Left", "a"]
    assert (left.name, right.name) == ("Left", "the right")
    assert left.material is right.material
    assert right.vertices.tolist() == [[0, 0, 1], [1, 0, 1], [0, 1, 1]]


def test_stl_colors(read):
    data = bytearray(trimesh.creation.box().export(file_type="stl"))
    data[84 + 48] = 7
    with pytest.warns(SceneWarning, match="not simulated: colours in attribute bytes$"):
        read("a.stl", bytes(data))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b" " * 80 + struct.pack("<I", 0), "has no triangles"),
        (b" " * 80 + struct.pack("<I", 9) + b"\0" * 50, "no triangles|is damaged"),
        ("solid a\nendsolid a\n", "has no triangles"),
        (facets("a") + facets("b")[:-12], "is damaged: of 2 facets and 6 vertices 1 facets are"),
        (facets("a").replace("vertex 1 0 0\n", ""), "is damaged"),
        (facets("a").replace("1 0 0", "1 0 x"), "is damaged"),
        (facets("a").replace("1 0 0", "nan 0 0"), r"mesh 'a': vertex 1 is \(nan, 0, 0\)"),
        (facets("a").replace("1 0 0", "1e99 0 0"), r"vertex 1 is \(1e\+99, 0, 0\)"),
    ],
)
def test_stl_errors(read, data, message):
    with pytest.raises(InputError, match=r"a\.stl: .*(" + message + ")"):
        read("a.stl", data)


# --- glTF ---------------------------------------------------------------------------------


class Builder:
    """A glTF file by hand."""

    def __init__(self):
        self.blob = b""
        self.tree = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "part"}],
            "meshes": [{"primitives": []}],
            "accessors": [],
            "bufferViews": [],
        }

    def add(self, rows, **more):
        """Append an accessor."""
        rows = np.asarray(rows)
        rows = rows.astype("<f4") if rows.dtype == np.float64 else rows
        kinds = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": rows.nbytes}
        self.blob += rows.tobytes() + b"\0" * (-rows.nbytes % 4)
        self.tree["bufferViews"].append(view)
        shape = "SCALAR" if rows.ndim == 1 else f"VEC{rows.shape[1]}"
        accessor = {"bufferView": len(self.tree["accessors"]), "count": len(rows), "type": shape}
        accessor["componentType"] = kinds[rows.dtype.str[1:]]
        self.tree["accessors"].append(accessor | more)
        return len(self.tree["accessors"]) - 1

    def primitive(self, mesh=0, indices=None, more=(), **attributes):
        """Append a primitive to a mesh; attributes are rows, or accessors."""
        item = {
            "attributes": {
                name: rows if isinstance(rows, int) else self.add(rows)
                for name, rows in ({"POSITION": TRIANGLE} | attributes).items()
            }
        } | dict(more)
        if indices is not None:
            item["indices"] = self.add(np.asarray(indices, "<u2"))
        self.tree["meshes"][mesh]["primitives"].append(item)
        return self

    def gltf(self, uri=None):
        """Return the JSON; the buffer is in it, or in a file."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        tree = {**self.tree, "buffers": [{"uri": uri, "byteLength": len(self.blob)}]}
        return json.dumps(tree).encode()

    def glb(self):
        """Return the binary form."""
        tree = json.dumps({**self.tree, "buffers": [{"byteLength": len(self.blob)}]}).encode()
        tree += b" " * (-len(tree) % 4)
        chunks = struct.pack("<I4s", len(tree), b"JSON") + tree
        chunks += struct.pack("<I4s", len(self.blob), b"BIN\0") + self.blob
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@pytest.fixture
def build():
    return Builder()


def test_instances_with_transforms(read):
    box = trimesh.creation.box([1, 2, 3])
    scene = trimesh.Scene()
    move = trimesh.transformations.translation_matrix([5, 0, 0])
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    mirror = move @ turn @ np.diag([-2, 1, 0.5, 1])
    scene.add_geometry(box, node_name="plain", geom_name="box", transform=turn)
    scene.add_geometry(box, node_name="mirrored", geom_name="box", transform=mirror)
    meshes = {mesh.name: mesh for mesh in read("a.glb", scene.export(file_type="glb"))}
    plain, mirrored = meshes["plain"], meshes["mirrored"]
    assert plain.material is mirrored.material
    assert volume(plain) == pytest.approx(6)
    assert volume(mirrored) == pytest.approx(6)
    for mesh, matrix in ((plain, turn), (mirrored, mirror)):
        expected = trimesh.transform_points(box.vertices, matrix)
        np.testing.assert_allclose(mesh.vertices, expected, atol=1e-5)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_normals_turn_with_their_surface(read, build, kind):
    ball = trimesh.creation.icosphere(3)
    build.primitive(POSITION=ball.vertices, NORMAL=ball.vertices, indices=ball.faces.ravel())
    build.tree["nodes"] = [
        {"name": "root", "rotation": [0.5, 0.5, 0.5, 0.5], "children": [1, 2]},
        {"name": "stretched", "mesh": 0, "scale": [1, 2, 3]},
        {"name": "mirrored", "mesh": 0, "scale": [3, -1, 2], "translation": [1, 2, 3]},
    ]
    meshes = read(f"a.{kind}", getattr(build, kind)())
    assert [mesh.name for mesh in meshes] == ["stretched", "mirrored"]
    for mesh in meshes:
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, rtol=1e-6)
        flat = areas(mesh) / np.linalg.norm(areas(mesh), axis=1, keepdims=True)
        smooth = mesh.normals[mesh.faces].mean(1)
        assert np.einsum("fi,fi->f", flat, smooth).min() > 0.95
        assert volume(mesh) == pytest.approx(6 * ball.volume, rel=1e-5)


def test_flattened_node(read, build):
    build.primitive(NORMAL=np.tile([1.0, 0, 1], (3, 1)))
    build.tree["nodes"][0]["scale"] = [1, 1, 0]
    (mesh,) = read("a.glb", build.glb())
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_chain_of_nodes(read, build):
    build.primitive()
    build.tree["nodes"] = [
        {"translation": [1, 0, 0], "children": [1], "camera": 0},
        {"scale": [2, 2, 2], "children": [2]},
        {"matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1], "mesh": 0, "name": "leaf"},
        {"mesh": 0, "name": "not in the scene"},
    ]
    build.tree["cameras"] = [{"type": "orthographic"}]
    with pytest.warns(SceneWarning, match="not simulated: cameras$"):
        (mesh,) = read("a.glb", build.glb())
    assert mesh.name == "leaf"
    np.testing.assert_allclose(mesh.vertices, [[1, 6, 0], [1, 8, 0], [-1, 6, 0]])


def test_without_a_scene_all_nodes_show(read, build):
    build.primitive()
    build.tree["nodes"] += [{"mesh": 0, "translation": [0, 0, 1]}, {"children": [0]}]
    del build.tree["scene"], build.tree["scenes"]
    assert len(read("a.glb", build.glb())) == 2


def test_names(read, build):
    build.primitive().primitive()
    build.tree["meshes"].append({"primitives": [], "name": "lonely"})
    build.primitive(1)
    build.tree["nodes"] = [
        {"name": "part", "mesh": 0},
        {"name": "part", "mesh": 0},
        {"mesh": 1},
        {"mesh": 1},
        {"mesh": 0},
    ]
    build.tree["scenes"][0]["nodes"] = [4, 3, 2, 1, 0]
    names = [mesh.name for mesh in read("a.glb", build.glb())]
    assert names == ["part"] * 2 + ["part_1"] * 2 + ["lonely", "lonely_3"] + ["node"] * 2


def test_uv_counts_upwards(read, build):
    build.primitive(TEXCOORD_0=[[0.25, 0.0], [1, 0.75], [0, 1]])
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_allclose(mesh.uv, [[0.25, 1], [1, 0.25], [0, 0]])
    assert mesh.normals is None


def test_quantized(read, build):
    points = np.array([[0, 0, 0, 0], [32767, 0, 0, 0], [0, -32768, 0, 0]], "<i2")[:, :3].copy()
    uv = build.add(np.array([[0, 0], [65535, 0], [0, 13107]], "<u2"), normalized=True)
    normals = build.add(np.array([[0, 0, 127]] * 3, "i1"), normalized=True)
    build.primitive(POSITION=build.add(points, normalized=True), NORMAL=normals, TEXCOORD_0=uv)
    build.tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    (mesh,) = read("a.glb", build.glb())
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, -1, 0]]
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3
    np.testing.assert_allclose(mesh.uv, [[0, 1], [1, 1], [0, 0.8]])


def test_interleaved(read, build):
    table = np.c_[TRIANGLE, np.tile([0, 0, 1], (3, 1))].astype("<f4")
    build.tree["bufferViews"] = [{"buffer": 0, "byteLength": table.nbytes, "byteStride": 24}]
    build.blob = table.tobytes()
    accessor = {"bufferView": 0, "count": 3, "type": "VEC3", "componentType": 5126}
    build.tree["accessors"] = [accessor, accessor | {"byteOffset": 12}]
    build.primitive(POSITION=0, NORMAL=1)
    (mesh,) = read("a.glb", build.glb())
    np.testing.assert_array_equal(np.c_[mesh.vertices, mesh.normals], table)


def test_strip_and_shared_vertices(read, build):
    grid = build.add([[x, y, 0.0] for x in range(20) for y in (0, 1)])
    build.primitive(POSITION=grid, indices=[0, 2, 1, 3], more={"mode": 5})
    build.primitive(POSITION=grid, indices=[4, 6, 5])
    strip, triangle = read("a.glb", build.glb())
    assert (len(strip.vertices), len(triangle.vertices)) == (4, 3)
    assert areas(strip)[:, 2].tolist() == [0.5, 0.5]
    assert areas(triangle)[:, 2].tolist() == [0.5]


@pytest.mark.parametrize("name", ["my buffer.bin", "my%20buffer.bin"])
def test_buffer_in_a_file(read, build, tmp_path, name):
    build.primitive()
    (tmp_path / "my buffer.bin").write_bytes(build.blob)
    (mesh,) = read("a.gltf", build.gltf(name))
    assert mesh.vertices.tolist() == TRIANGLE.tolist()
    with pytest.raises(InputError, match=r"none\.bin: cannot be read"):
        read("a.gltf", build.gltf("none.bin"))


# --- glTF materials -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("item", "material", "told"),
    [
        ({"name": "a"}, Material("a"), None),
        ({}, Material("material_0"), None),
        (
            {"name": "a", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 1, 1]}},
            Material("a", (0.1, 0.2, 1.0)),
            "metallicFactor of 'a'",
        ),
        ({"pbrMetallicRoughness": {}}, Material("material_0", (1.0, 1.0, 1.0)), "metallicFactor"),
        (
            {"name": "a", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
            Material("a"),
            "textures of 'a'; metallicFactor of 'a'",
        ),
        ({"name": "a", "normalTexture": {"index": 0}}, Material("a"), "textures of 'a'"),
        ({"name": "a", "emissiveFactor": [0, 0, 1]}, Material("a"), "emissiveFactor of 'a'"),
        ({"name": "a", "emissiveFactor": [0, 0, 0]}, Material("a"), None),
        ({"name": "a", "alphaMode": "BLEND"}, Material("a"), "alphaMode of 'a'"),
        (
            {"name": "a", "extensions": {"KHR_materials_ior": {"ior": 1.4}}},
            Material("a"),
            "KHR_materials_ior of 'a'",
        ),
    ],
)
@pytest.mark.filterwarnings("default::photonmap.errors.SceneWarning")
def test_materials(read, build, recwarn, item, material, told):
    build.primitive(more={"material": 0})
    build.tree["materials"] = [item, {"name": "unused", "emissiveFactor": [1, 1, 1]}]
    (mesh,) = read("a.glb", build.glb())
    assert mesh.material == material
    messages = [str(warning.message) for warning in recwarn]
    if told is None:
        assert not messages
    else:
        (message,) = messages
        assert f"a.glb: not simulated: {told}" in message


def test_meshes_share_materials(read, build):
    for index in (0, 1, 0, None, None):
        build.primitive(more={} if index is None else {"material": index})
    build.tree["materials"] = [{"name": "a"}, {"name": "b"}]
    meshes = read("a.glb", build.glb())
    assert [mesh.material.name for mesh in meshes] == ["a", "b", "a", "default", "default"]
    assert meshes[0].material is meshes[2].material
    assert meshes[3].material is meshes[4].material
    assert meshes[3].material == Material("default", 0.5)


def test_material_of_trimesh(read):
    box = trimesh.creation.box()
    box.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(
            name="red", baseColorFactor=[255, 0, 0, 255], metallicFactor=0.0, roughnessFactor=1.0
        )
    )
    (mesh,) = read("a.glb", box.export(file_type="glb"))
    assert mesh.material == Material("red", (1.0, 0.0, 0.0))


def test_what_is_not_simulated_is_named_once(read, build):
    surface = {"metallicFactor": 0, "roughnessFactor": 0.5, "baseColorFactor": [1, 1, 1, 0.5]}
    colored = {"COLOR_0": np.ones((3, 4)), "more": {"material": 0, "targets": [{"POSITION": 0}]}}
    build.primitive(**colored).primitive(**colored).primitive(more={"mode": 1})
    build.tree["materials"] = [{"name": "glass", "pbrMetallicRoughness": surface}]
    lights = {"lights": [{"type": "point"}]}
    build.tree |= {
        "cameras": [{}],
        "animations": [{}],
        "skins": [{}],
        "images": [{"uri": "none.png"}],
        "extensions": {"KHR_lights_punctual": lights},
    }
    build.tree["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}, "EXT_x": {}}
    with pytest.warns(SceneWarning) as record:
        assert len(read("a.glb", build.glb())) == 2
    (told,) = record
    assert str(told.message).endswith(
        "a.glb: not simulated: cameras; animations; skins; lights; EXT_x; vertex colours; "
        "morph targets; points and lines; roughnessFactor of 'glass'; alpha of 'glass'"
    )


# --- glTF errors --------------------------------------------------------------------------


def change(*way, **values):
    """Make a change of a glTF tree: at a way of keys, put values."""

    def apply(build):
        item = build.tree
        for key in way:
            item = item[key]
        item.update(values)

    return apply


@pytest.mark.parametrize(
    ("apply", "message"),
    [
        (change("asset", version="1.0"), "is glTF '1.0'; export it as glTF 2.0"),
        (change(asset={}), "is glTF ''"),
        (change(asset=[]), "is damaged"),
        (change(extensionsRequired=["KHR_draco_mesh_compression"]), "needs 'KHR_draco.*without"),
        (change("accessors", 0, sparse={}), "has sparse or compressed vertices"),
        (change("accessors", 0, count=4), "is damaged"),
        (change("accessors", 0, count=10**12), "is damaged"),
        (change("accessors", 0, bufferView=9), "names bufferViews 9, but has 2; export"),
        (change("accessors", 0, componentType=1), "is damaged"),
        (change("accessors", 0, type="VEC2"), "is damaged"),
        (change("bufferViews", 0, byteLength=10**6), "is truncated: its buffers are too short"),
        (change("bufferViews", 0, buffer=1), "names buffers 1, but has 1"),
        (change("meshes", 0, "primitives", 0, indices=-1), "names accessors -1, but has 2"),
        (change("meshes", 0, "primitives", 0, mode=6), "triangle fans, which are not supported"),
        (change("meshes", 0, "primitives", 0, mode=0), "has no triangles"),
        (change("meshes", 0, "primitives", 0, material=0), "names materials 0, but has 0"),
        (change("meshes", 0, "primitives", 0, attributes={}), "is damaged"),
        (change("nodes", 0, mesh=1), "names meshes 1, but has 1"),
        (change("nodes", 0, children=[0]), "node 0 has two parents"),
        (change("nodes", 0, children=[True]), "names nodes True"),
        (change("nodes", 0, translation=[1, 2]), "is damaged"),
        (change("nodes", 0, translation=[float("nan"), 2, 3]), r"mesh 'part': vertex 0 is \(nan"),
        (change("scenes", 0, nodes=[]), "has no triangles"),
        (change(scene=3), "names scenes 3, but has 1"),
        (change(nodes=[]), "names nodes 0"),
        (change(meshes=[]), "names meshes 0"),
    ],
)
@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_gltf_errors(read, build, kind, apply, message):
    build.primitive(indices=[0, 1, 2])
    apply(build)
    with pytest.raises(InputError, match=rf"a\.{kind}: .*" + message) as caught:
        read(f"a.{kind}", getattr(build, kind)())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ({"POSITION": TRIANGLE * [1, np.nan, 1]}, r"mesh 'part': vertex 0 is \(nan"),
        ({"NORMAL": TRIANGLE * np.nan}, "normal 0 is"),
        ({"NORMAL": TRIANGLE[:2]}, "NORMAL has the wrong shape"),
        ({"TEXCOORD_0": [[0, np.inf]] * 3}, "texture coordinate 0 is"),
        ({"indices": [0, 1, 3]}, "a face names vertex 3, but there are 3"),
        ({"indices": [0, 1]}, "is damaged"),
    ],
)
def test_gltf_rows(read, build, rows, message):
    build.primitive(**rows)
    with pytest.raises(InputError, match=message):
        read("a.glb", build.glb())


@pytest.mark.parametrize("color", [[2, 0, 0, 1], [-1, 0, 0, 1], [0.5], ["x", 0, 0, 1]])
def test_base_color_that_is_no_reflectance(read, build, color):
    build.primitive(more={"material": 0})
    surface = {"baseColorFactor": color, "metallicFactor": 0}
    build.tree["materials"] = [{"name": "a", "pbrMetallicRoughness": surface}]
    with pytest.raises(
        InputError, match=r"material 'a': baseColorFactor .* is no reflectance; keep"
    ):
        read("a.glb", build.glb())


def test_glb_chunks(read, build):
    data = build.primitive(indices=[0, 1, 2]).glb()
    for end in (6, 12, 19, 25, len(data) // 2, len(data) - 1):
        with pytest.raises(InputError, match=r"is truncated|is damaged"):
            read("a.glb", data[:end])
    with pytest.raises(InputError, match="is glTF 1; export"):
        read("a.glb", data[:4] + b"\1" + data[5:])
    with pytest.raises(InputError, match="has no data for buffer 0"):
        read("a.gltf", build.gltf().replace(b'"uri"', b'"url"'))
    assert len(read("a.glb", data + b"more")) == 1


# --- damage -------------------------------------------------------------------------------


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
