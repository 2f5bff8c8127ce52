"""glTF files: nodes, attributes, materials, and what is refused."""

import numpy as np
import pytest
import trimesh
from helpers.meshes import TRIANGLE, GltfBuilder, areas, volume
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.gltf.document import COPIES
from photonmap.io.readers.registry import read_file

pytestmark = pytest.mark.usefixtures("silence")


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


NUMBERS = st.floats(0.25, 2.0, width=32) | st.floats(-2.0, -0.25, width=32)


@settings(
    max_examples=40, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    st.lists(st.lists(NUMBERS, min_size=10, max_size=10), min_size=1, max_size=4),
    st.sets(st.sampled_from(["TRANSLATION", "ROTATION", "SCALE", "_ID"]), min_size=1),
    st.lists(NUMBERS, min_size=10, max_size=10),
    st.sampled_from([None, np.int8, np.int16]),
)
def test_copies_of_instancing(tmp_path, copies, names, outer, kind):
    """World = node · T · R · S, as the extension says; outsides stay outside; no mesh without."""
    build, box = GltfBuilder(), trimesh.creation.box([1, 2, 3])
    rows = np.array(copies)
    columns = {"TRANSLATION": rows[:, :3], "SCALE": rows[:, 3:6], "_ID": np.arange(len(rows)) / 4}
    columns["ROTATION"] = rows[:, 6:] / np.linalg.norm(rows[:, 6:], axis=1, keepdims=True)
    if kind is not None:
        columns["ROTATION"] = np.rint(columns["ROTATION"] * np.iinfo(kind).max).astype(kind)
    more = {"normalized": True} if kind is not None else {}
    used = {
        name: build.add(columns[name], **(more if name == "ROTATION" else {})) for name in names
    }
    build.primitive(POSITION=box.vertices, indices=box.faces.ravel())
    quaternion = np.array(outer[6:]) / np.linalg.norm(outer[6:])
    build.tree["nodes"] = [
        {"name": "grass", "mesh": 0, "extensions": {COPIES: {"attributes": used}},
         "translation": outer[:3], "scale": outer[3:6], "rotation": quaternion.tolist()},
    ]  # fmt: skip
    build.tree |= {"extensionsRequired": [COPIES], "extensionsUsed": [COPIES]}
    (tmp_path / "a.glb").write_bytes(build.glb())
    meshes = read_file(tmp_path / "a.glb").meshes
    assert [mesh.name for mesh in meshes] == [f"grass_{number}" for number in range(len(rows))]

    def placed(points, name_of, row):
        points = points * (row[3:6] if "SCALE" in name_of else 1.0)
        if "ROTATION" in name_of:
            points = Rotation.from_quat(row[6:]).apply(points)
        return points + (row[:3] if "TRANSLATION" in name_of else 0.0)

    everything = ("TRANSLATION", "ROTATION", "SCALE")
    for mesh, row in zip(meshes, rows, strict=True):
        wanted = placed(placed(box.vertices, names, row), everything, np.array(outer))
        np.testing.assert_allclose(mesh.vertices, wanted, atol=0.3 if kind is np.int8 else 1e-3)
        assert volume(mesh) > 0.0


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({}, "node 'part': EXT_mesh_gpu_instancing needs attributes of one count, and has none"),
        ({"SCALE": 0, "TRANSLATION": 1}, "of one count, and has attributes of 2 and 3 rows"),
        ({"TRANSLATION": 7}, "names accessors 7, but has"),
        ({"_ID": 3}, "EXT_mesh_gpu_instancing has accessor 3 without data; export it again"),
    ],
)
def test_copies_that_are_refused(read, build, attributes, message):
    build.add(np.ones((2, 3)))
    build.add(np.ones((3, 3)))
    build.primitive()
    zeros = {"type": "SCALAR", "componentType": 5126, "count": 60, "sparse": {"count": 0}}
    build.tree["accessors"].append(zeros)
    build.tree["nodes"][0]["extensions"] = {COPIES: {"attributes": attributes}}
    with pytest.raises(InputError, match=message):
        read("a.glb", build.glb())


def test_flattened_node(read, build):
    build.primitive(NORMAL=np.tile([1.0, 0, 1], (3, 1)))
    build.tree["nodes"][0]["scale"] = [1, 1, 0]
    (mesh,) = read("a.glb", build.glb())
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_chain_of_nodes(read, build):
    build.primitive()
    build.tree["nodes"] = [
        {"translation": [1, 0, 0], "children": [1]},
        {"scale": [2, 2, 2], "children": [2]},
        {"matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1], "mesh": 0, "name": "leaf"},
        {"mesh": 0, "name": "not in the scene"},
    ]
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


def test_strips_fans_and_shared_vertices(read, build):
    grid = build.add([[x, y, 0.0] for x in range(20) for y in (0, 1)])
    build.primitive(POSITION=grid, indices=[0, 2, 1, 3], more={"mode": 5})
    build.primitive(POSITION=grid, indices=[4, 6, 5])
    build.primitive(POSITION=grid, indices=[0, 2, 3, 1], more={"mode": 6})
    strip, triangle, fan = read("a.glb", build.glb())
    assert areas(fan)[:, 2].tolist() == [0.5, 0.5]
    assert (len(strip.vertices), len(triangle.vertices)) == (4, 3)
    assert areas(strip)[:, 2].tolist() == [0.5, 0.5]
    assert areas(triangle)[:, 2].tolist() == [0.5]


@pytest.mark.parametrize("name", ["my buffer.bin", "my%20buffer.bin"])
def test_buffer_in_a_file(read, build, tmp_path, name):
    build.primitive()
    (tmp_path / "my buffer.bin").write_bytes(build.blob)
    (mesh,) = read("a.gltf", build.gltf(name))
    assert mesh.vertices.tolist() == TRIANGLE.tolist()
    with pytest.raises(InputError, match=r"none\.bin: cannot be read.*; a.gltf names it$"):
        read("a.gltf", build.gltf("none.bin"))


def test_what_is_not_simulated_is_named_once(read, build):
    glass = {"more": {"material": 0}}
    build.primitive(**glass).primitive(**glass).primitive(more={"mode": 1})
    build.tree["materials"] = [{"name": "glass", "extensions": {"KHR_x": {}}}]
    build.tree |= {"animations": [{}], "images": [{"uri": "none.png"}]}
    build.tree["nodes"][0]["extensions"] = {"EXT_x": {}}
    build.tree["scenes"][0]["extensions"] = {"EXT_lights_image_based": {"light": 0}}
    build.tree["extensionsUsed"] = ["EXT_x", "KHR_x", "KHR_materials_ior", "KHR_materials_variants"]
    with pytest.warns(SceneWarning) as record:
        assert len(read("a.glb", build.glb())) == 2
    (warning,) = record
    assert str(warning.message).endswith(
        "a.glb: not simulated: animations; EXT_x; EXT_lights_image_based; KHR_x of 'glass'; "
        "KHR_materials_variants; points and lines"
    )


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
        (change("asset", minVersion="2.1"), "is glTF '2.1'; export it as glTF 2.0"),
        (change(asset=[]), "is damaged"),
        (change(extensionsRequired=["KHR_draco_mesh_compression"]), "needs 'KHR_draco.*without"),
        (change("accessors", 0, sparse={}), "is damaged"),
        (change("accessors", 0, bufferView=None), "names bufferViews None, but has 2"),
        (lambda build: build.tree["accessors"][0].pop("bufferView"), "has compressed vertices"),
        (
            change("accessors", 0, count=4),
            r"accessor 0 takes bytes 0 to 48 \(4 rows of 3 × 4 bytes\) of buffer view 0, .* 36;",
        ),
        (change("accessors", 0, count=10**12), "takes bytes 0 to 12000000000000 "),
        (change("accessors", 0, count=-1), r"accessor 0 takes bytes .* \(-1 rows"),
        (change("accessors", 0, byteOffset=4), "accessor 0 takes bytes 4 to 40 "),
        (change("accessors", 0, bufferView=9), "names bufferViews 9, but has 2; export"),
        (change("accessors", 0, componentType=1), "is damaged"),
        (change("accessors", 0, type="VEC2"), "is damaged"),
        (change("bufferViews", 0, byteLength=10**6), "view 0 takes bytes 0 to 1000000 of buffer 0"),
        (change("bufferViews", 0, buffer=1), "names buffers 1, but has 1"),
        (change("meshes", 0, "primitives", 0, indices=-1), "names accessors -1, but has 2"),
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


def differ(build, at, rows):
    """Replace rows of the first accessor."""
    build.tree["accessors"][0]["sparse"] = {
        "count": len(at),
        "indices": {"bufferView": build.add(np.array(at, "<u2")), "componentType": 5123},
        "values": {"bufferView": build.add(np.array(rows, float))},
    }


def test_sparse_accessors_differ_from_their_base_in_some_rows(read, build):
    build.primitive(indices=[0, 1, 2])
    differ(build, [0, 2], [[5, 6, 7], [1, 2, 3]])
    (mesh,) = read("a.glb", build.glb())
    assert mesh.vertices.tolist() == [[5, 6, 7], TRIANGLE[1].tolist(), [1, 2, 3]]


@pytest.mark.parametrize(
    ("at", "rows", "message"),
    [
        ([3], [[1, 2, 3]], "accessor 0 has 3 rows, and changes row 3"),
        ([0, 1], [[1, 2, 3]], "accessor 0 takes bytes 0 to 24 .* of buffer view 3, which has 12"),
    ],
)
def test_sparse_accessors_that_lack_rows(read, build, at, rows, message):
    build.primitive(indices=[0, 1, 2])
    differ(build, at, rows)
    with pytest.raises(InputError, match=rf"a\.glb: {message}"):
        read("a.glb", build.glb())


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ({"POSITION": TRIANGLE * [1, np.nan, 1]}, r"mesh 'part': vertex 0 is \(0, nan, 0"),
        ({"NORMAL": TRIANGLE * np.nan}, "normal 0 is"),
        ({"NORMAL": TRIANGLE[:2]}, "NORMAL has the wrong shape"),
        ({"TEXCOORD_0": [[0, np.inf]] * 3}, "texture coordinate 0 is"),
        ({"indices": [0, 1, 3]}, "a face names vertex 3, but there are 3"),
        ({"indices": [0, 1]}, "has no triangles"),
    ],
)
def test_gltf_rows(read, build, rows, message):
    build.primitive(**rows)
    with pytest.raises(InputError, match=message):
        read("a.glb", build.glb())


def test_glb_chunks(read, build):
    data = build.primitive(indices=[0, 1, 2]).glb()
    for end in (6, 12, 19, 25, len(data) // 2, len(data) - 1):
        with pytest.raises(InputError, match=r"is truncated|takes bytes"):
            read("a.glb", data[:end])
    with pytest.raises(InputError, match="is glTF 1; export"):
        read("a.glb", data[:4] + b"\1" + data[5:])
    with pytest.raises(InputError, match="has no data for buffer 0"):
        read("a.gltf", build.gltf().replace(b'"uri"', b'"url"'))
    assert len(read("a.glb", data + b"more")) == 1
