"""Colours of vertices and faces: how files hold them, and what becomes of them."""

import struct
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.meshes import TRIANGLE, ply

import photonmap as pm
from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.registry import GREY
from photonmap.io.readers.scene_file import load_scene
from photonmap.spectra.rgb_spaces import decode_srgb, encode_srgb

pytestmark = pytest.mark.usefixtures("silence")
BYTES = np.array([[255, 0, 128], [7, 90, 200], [0, 1, 254]])
LINEAR = decode_srgb(BYTES / 255)


def test_srgb_returns():
    values = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(decode_srgb(encode_srgb(values)), values, rtol=1e-6)
    np.testing.assert_array_equal(np.rint(encode_srgb(LINEAR) * 255), BYTES)


def colored_ply(kind, values, names, encoding):
    """Write the triangle with colours of one type; struct packs them by its letter."""
    letter = {"uchar": "B", "ushort": "H", "float": "f", "double": "d"}[kind]
    head = f"ply\nformat {encoding} 1.0\nelement vertex 3\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    head += "".join(f"property {kind} {name}\n" for name in names)
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    if encoding == "ascii":
        rows = [*np.c_[TRIANGLE, values].tolist()]
        plain = int if kind in ("uchar", "ushort") else float
        lines = [" ".join([*map(str, row[:3]), *(str(plain(v)) for v in row[3:])]) for row in rows]
        return "\n".join([head + lines[0], *lines[1:], "3 0 1 2", ""]).encode()
    body = b"".join(
        struct.pack(f"<3f{len(names)}{letter}", *point, *row)
        for point, row in zip(TRIANGLE.tolist(), np.asarray(values).tolist(), strict=True)
    )
    return head.encode() + body + struct.pack("<B3i", 3, 0, 1, 2)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("uchar", BYTES),
        ("ushort", BYTES * 257),
        ("float", BYTES / 255),
        ("double", BYTES / 255),
        ("float", BYTES),
    ],
)
@pytest.mark.parametrize("names", ["red green blue", "diffuse_red diffuse_green diffuse_blue"])
def test_ply_vertices(read, kind, values, names, encoding):
    (mesh,) = read("a.ply", colored_ply(kind, values, names.split(), encoding))
    np.testing.assert_allclose(mesh.colors, LINEAR, atol=1e-7)
    assert mesh.material == pm.Material("default")


def test_ply_opacity_is_named(read):
    names = ["red", "green", "blue", "alpha"]
    opaque = np.c_[BYTES, [255] * 3]
    (mesh,) = read("a.ply", colored_ply("uchar", opaque, names, "ascii"))
    np.testing.assert_allclose(mesh.colors, LINEAR)
    with pytest.warns(SceneWarning, match="not simulated: opacity of vertices$"):
        read("a.ply", colored_ply("uchar", np.c_[BYTES, [255, 254, 255]], names, "ascii"))


def test_ply_colors_out_of_range(read):
    values = BYTES / 255
    values[0] = [1.25, -0.5, 0.5]
    with pytest.warns(SceneWarning, match=r"not simulated: 1 colours of vertices outside \[0, 1\]"):
        (mesh,) = read("a.ply", colored_ply("float", values, ["red", "green", "blue"], "ascii"))
    np.testing.assert_allclose(mesh.colors[0], [1, 0, decode_srgb(np.array(0.5))], atol=1e-7)
    values[1] = np.nan
    with pytest.raises(InputError, match=r"a\.ply: mesh 'a': colour 1 is \(nan, nan, nan\)"):
        read(
            "a.ply", colored_ply("float", values, ["red", "green", "blue"], "binary_little_endian")
        )


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_ply_of_trimesh(read, encoding):
    box = trimesh.creation.box()
    colors = np.random.default_rng(1).integers(0, 256, (12, 4), np.uint8)
    colors[:, 3] = 255
    box.visual.face_colors = colors
    (mesh,) = read("a.ply", box.export(file_type="ply", encoding=encoding))
    np.testing.assert_allclose(mesh.colors, decode_srgb(colors[:, None, :3] / 255))
    ball = trimesh.creation.icosphere(1)
    colors = np.full((42, 4), 255, np.uint8)
    colors[:, 1] = np.arange(42)
    ball.visual.vertex_colors = colors
    (mesh,) = read("a.ply", ball.export(file_type="ply", encoding=encoding))
    np.testing.assert_allclose(mesh.colors, decode_srgb(colors[:, :3] / 255))


def test_ply_polygons_keep_the_colours_of_their_faces(read):
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]
    colors = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    text = ply(square, [], lists=colors).replace("element face 0", "element face 2")
    (mesh,) = read("a.ply", text + "4 0 1 2 3 255 0 128\n3 1 4 2 7 90 200\n")
    np.testing.assert_allclose(mesh.colors, LINEAR[[0, 0, 1], None])


def test_ply_colours_of_vertices_come_first(read):
    text = ply(np.c_[TRIANGLE, BYTES / 255], [], "x y z red green blue")
    text = text.replace("element face 0", "element face 1").replace(
        "end_header", "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header"
    )
    with pytest.warns(SceneWarning, match="not simulated: colours of faces beside those of vert"):
        (mesh,) = read("a.ply", text + "3 0 1 2 9 9 9\n")
    np.testing.assert_allclose(mesh.colors, LINEAR, atol=1e-7)


def test_ply_colours_follow_split_vertices(read):
    head = ply(np.c_[TRIANGLE, BYTES / 255], [], "x y z red green blue")
    head = head.replace("element face 0", "element face 2").replace(
        "end_header", "property list uchar float texcoord\nend_header"
    )
    (mesh,) = read("a.ply", head + "3 2 0 1 6 0 0 1 0 0 1\n3 0 1 2 6 1 1 1 0 0 1\n")
    wanted = LINEAR[[[2, 0, 1], [0, 1, 2]]]
    np.testing.assert_allclose(mesh.colors[mesh.faces], wanted, atol=1e-7)


@pytest.mark.parametrize("values", [BYTES, BYTES / 255, np.c_[BYTES, [255] * 3]])
def test_off_vertices(read, values):
    rows = np.c_[TRIANGLE.astype(int), values].tolist()
    lines = [" ".join(str(int(v) if v == int(v) else v) for v in row) for row in rows]
    (mesh,) = read("a.off", "\n".join(["COFF", "3 1 0", *lines, "3 0 1 2", ""]))
    np.testing.assert_allclose(mesh.colors, LINEAR)


def test_off_faces(read):
    points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n"
    text = f"OFF\n5 3 0\n{points}4 0 1 2 3 255 0 128\n3 1 4 2 7 90 200 255\n3 0 4 3\n"
    (mesh,) = read("a.off", text)
    wanted = [*LINEAR[[0, 0, 1]], [GREY] * 3]
    np.testing.assert_allclose(mesh.colors, np.array(wanted)[:, None])
    with pytest.warns(SceneWarning, match="colours of faces that are not three or four numbers$"):
        (mesh,) = read("a.off", text.replace(" 255 0 128", " 5"))
    np.testing.assert_allclose(mesh.colors[:3, 0], [[GREY] * 3] * 2 + [LINEAR[1]])
    with pytest.warns(SceneWarning, match="opacity of faces"):
        read("a.off", text.replace("200 255", "200 9"))
    with pytest.warns(SceneWarning, match="colours of faces beside those of vertices"):
        read("a.off", text.replace("0 0 0\n", "0 0 0 9 9 9\n", 1))
    with pytest.raises(InputError, match=r"a\.off:8: '4 0 1 2 3 255 x 128' ends in no colour"):
        read("a.off", text.replace("255 0 128", "255 x 128"))


def stl(attributes, header=b""):
    """Write triangles above one another with these attribute bytes."""
    data = header.ljust(80, b"\0") + struct.pack("<I", len(attributes))
    for z, attribute in enumerate(attributes):
        data += struct.pack("<12fH", 0, 0, 1, 0, 0, z, 1, 0, z, 0, 1, z, attribute)
    return data


def test_stl_by_viscam(read):
    (mesh,) = read("a.stl", stl([0x8000 | 31 << 10 | 16 << 5 | 8, 0x8000, 31]))
    wanted = [decode_srgb(np.array([31, 16, 8]) / 31), [0] * 3, [GREY] * 3]
    np.testing.assert_allclose(mesh.colors, np.array(wanted)[:, None])
    with pytest.warns(SceneWarning, match="not simulated: attribute bytes$"):
        (mesh,) = read("a.stl", stl([0, 7]))
    assert mesh.colors is None
    assert read("a.stl", stl([0, 0]))[0].colors is None


def test_stl_by_magics(read):
    header = b"made by hand COLOR=" + bytes([255, 0, 128, 255]) + b",MATERIAL="
    (mesh,) = read("a.stl", stl([31 | 16 << 5 | 8 << 10, 0x8000], header))
    wanted = [decode_srgb(np.array([31, 16, 8]) / 31), LINEAR[0]]
    np.testing.assert_allclose(mesh.colors, np.array(wanted)[:, None])
    (mesh,) = read("a.stl", stl([0, 0], header))
    np.testing.assert_allclose(mesh.colors, np.tile(LINEAR[0], (2, 1, 1)))


def obj(colors, more=""):
    rows = [" ".join(map(str, row)) for row in np.c_[TRIANGLE, colors].tolist()]
    return "".join(f"v {row}\n" for row in rows) + more + "f 1 2 3\n"


@pytest.mark.parametrize("values", [BYTES / 255, BYTES])
def test_obj_vertices(read_obj, values):
    (mesh,) = read_obj(obj(values))
    np.testing.assert_allclose(mesh.colors, LINEAR)
    (mesh,) = read_obj(obj(np.c_[values, [1, 1, 1]]) + "v 0 0 1\nf 1 2 4\n")
    np.testing.assert_allclose(mesh.colors, [*LINEAR, [GREY] * 3])


def test_obj_blocks_with_and_without_colours(read_obj, monkeypatch):
    monkeypatch.setattr("photonmap.io.readers.obj.lines.BLOCK", 20)
    plain = "o plain\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no colored\n"
    first, second = read_obj(plain + obj(BYTES / 255).replace("f 1 2 3", "f 4 5 6"))
    assert first.colors is None
    np.testing.assert_allclose(second.colors, LINEAR)


def test_obj_colours_and_materials(read_obj):
    library = "newmtl paint\nKd 0.2 0.2 0.2\nKs 0.1 0.1 0.1\nNs 50\nnewmtl glass\nillum 4\nNi 1.5\n"
    head = "mtllib a.mtl\nusemtl "
    (mesh,) = read_obj(obj(BYTES / 255, head + "paint\n"), a=library)
    assert mesh.material.is_glossy
    np.testing.assert_allclose(mesh.colors, LINEAR)
    expected = r"colours of vertices are not used in 1 of 1 meshes, .* glass: 'glass'$"
    with pytest.warns(SceneWarning, match=expected):
        (mesh,) = read_obj(obj(BYTES / 255, head + "glass\n"), a=library)
    assert mesh.colors is None


@pytest.mark.parametrize("file", ["a.ply", "a.toml"])
def test_toml_replaces_colours_by_a_reflectance(tmp_path, file):
    text = ply(np.c_[TRIANGLE, BYTES / 255], [[0, 1, 2]], "x y z red green blue")
    (tmp_path / "a.ply").write_text(text)
    toml = 'mesh = "a.ply"\n[material.default]\n'
    (tmp_path / "a.toml").write_text(toml + "diffuse_roughness = 0.5\n")
    (mesh,) = load_scene(tmp_path / file).meshes
    np.testing.assert_allclose(mesh.colors, LINEAR, atol=1e-7)
    assert mesh.material == pm.Material("default", diffuse_roughness=0.5)
    for key in ("reflectance = 0.25", "ior = 1.5"):
        (tmp_path / "a.toml").write_text(toml + key)
        (mesh,) = load_scene(tmp_path / file).meshes
        assert mesh.colors is None


@pytest.mark.parametrize(("suffix", "atol"), [("obj", 1e-9), ("glb", 1e-7)])
def test_saved_colours_return(tmp_path, suffix, atol):
    ball = trimesh.creation.icosphere(1)
    rng = np.random.default_rng(3)
    paint = pm.Material.plastic("paint")
    vertices = pm.Mesh(ball.vertices, ball.faces, paint, "a", colors=rng.random((42, 3)))
    faces = replace(vertices, name="b", colors=rng.random((80, 1, 3)), normals=ball.vertices)
    plain = replace(vertices, name="c", colors=None)
    pm.save_scene(pm.Scene([vertices, faces, plain]), tmp_path / f"ball.{suffix}")
    first, second, third = load_scene(tmp_path / f"ball.{suffix}").meshes
    np.testing.assert_array_equal(first.faces, vertices.faces)
    np.testing.assert_allclose(first.colors, vertices.colors, atol=atol)
    corners = faces.vertices[faces.faces]
    np.testing.assert_allclose(second.vertices[second.faces], corners, atol=1e-6)
    np.testing.assert_allclose(second.normals, second.vertices, atol=1e-6)
    np.testing.assert_allclose(second.colors[second.faces], faces.colors.repeat(3, 1), atol=atol)
    assert third.colors is None
    for mesh in (first, third):
        np.testing.assert_allclose(mesh.material.glossy, paint.glossy, rtol=1e-6)
        assert mesh.material.roughness == paint.roughness
    np.testing.assert_allclose(third.material.reflectance, 0.5, rtol=1e-6)


def test_recolored_surfaces_lose_their_colours():
    from photonmap.dataset.scenes.recolor import recolor

    mesh = pm.Mesh(TRIANGLE, [[0, 1, 2]], pm.Material("a"), colors=LINEAR)
    (kept,) = recolor(pm.Scene([mesh]), materials=["b"]).meshes
    assert kept.colors is mesh.colors
    assert recolor(pm.Scene([mesh])).meshes[0].colors is None


def two_triangles():
    return trimesh.Trimesh([*TRIANGLE, [1, 1, 0]], [[0, 1, 2], [1, 3, 2]], process=False)


def test_trimesh_colours():
    shape = two_triangles()
    shape.visual.vertex_colors = np.c_[np.vstack([BYTES, BYTES[:1]]), [255] * 4]
    mesh = pm.Mesh.from_trimesh(shape)
    np.testing.assert_allclose(mesh.colors, LINEAR[[0, 1, 2, 0]])
    shape.visual.face_colors = np.c_[BYTES[:2], [255] * 2]
    mesh = pm.Mesh.from_trimesh(shape)
    np.testing.assert_allclose(mesh.colors, LINEAR[:2, None])
    assert mesh.material == pm.Material()
    paint = pm.Material("paint", 0.25)
    painted = pm.Mesh.from_trimesh(shape, paint)
    assert (painted.material, painted.colors) == (paint, None)
    assert pm.Mesh.from_trimesh(two_triangles()).colors is None


def test_trimesh_textures():
    image = pytest.importorskip("PIL.Image").fromarray(BYTES.astype(np.uint8)[None])
    shape, uv = two_triangles(), np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]])
    shape.visual = trimesh.visual.TextureVisuals(uv=uv, image=image)
    mesh = pm.Mesh.from_trimesh(shape)
    np.testing.assert_array_equal(mesh.uv, uv)
    np.testing.assert_array_equal(mesh.material.reflectance.image.texels, BYTES[None])
    assert mesh.material.reflectance.factor == (1.0, 1.0, 1.0)
    look = trimesh.visual.material.PBRMaterial(
        "wood", baseColorTexture=image, baseColorFactor=[51, 102, 255, 255]
    )
    shape.visual = trimesh.visual.TextureVisuals(uv=uv, material=look)
    mesh = pm.Mesh.from_trimesh(shape)
    assert mesh.material.name == "wood"
    np.testing.assert_allclose(mesh.material.reflectance.factor, [0.2, 0.4, 1])
    look.baseColorTexture = None
    np.testing.assert_allclose(pm.Mesh.from_trimesh(shape).material.reflectance, [0.2, 0.4, 1])


def test_trimesh_scenes():
    shape = two_triangles()
    shape.visual.vertex_colors = np.c_[np.vstack([BYTES, BYTES[:1]]), [255] * 4]
    scene = trimesh.Scene()
    scene.add_geometry(shape, node_name="left", geom_name="shape")
    mirror = np.diag([-1.0, 1, 1, 1])
    scene.graph.update("right", geometry="shape", matrix=mirror)
    scene.add_geometry(trimesh.PointCloud(TRIANGLE))
    with pytest.warns(SceneWarning, match="scene 'scene': 1 geometries that are no meshes are"):
        found = pm.Scene.from_trimesh(scene, smooth=True)
    assert found.camera is None
    left, right = found.meshes
    assert (left.name, right.name) == ("left", "right")
    assert left.material is right.material
    np.testing.assert_allclose(right.vertices, left.vertices * [-1, 1, 1])
    np.testing.assert_allclose(left.normals, [[0, 0, 1]] * 4)
    np.testing.assert_allclose(right.normals, [[0, 0, 1]] * 4)
    np.testing.assert_allclose(right.colors, left.colors)


def test_trimesh_cameras():
    scene = trimesh.Scene(trimesh.creation.box())
    scene.camera = trimesh.scene.Camera(fov=(60, 40))
    matrix = trimesh.transformations.euler_matrix(0.1, 0.2, 0.3)
    matrix[:3, 3] = [1, 2, 3]
    scene.camera_transform = matrix
    camera = pm.Scene.from_trimesh(scene).camera
    assert camera.fov == 40
    np.testing.assert_allclose(camera.origin, [1, 2, 3])
    np.testing.assert_allclose(np.subtract(camera.target, camera.origin), -matrix[:3, 2])
    np.testing.assert_allclose(camera.up, matrix[:3, 1])
