"""Scene files: the camera, materials, and the meshes that they name."""

import base64
import json

import numpy as np
import pytest
import trimesh

from photonmap.errors import InputError
from photonmap.io.readers.scene_file import load_scene
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.material import Material
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.munsell import munsell
from photonmap.spectra.names import light as named_light

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
CAMERA = "[camera]\norigin = [0, 1, 5]\ntarget = [0.5, 0, 0]\n"


@pytest.mark.parametrize("toml", [None, "", "# no camera\n"])
def test_without_camera(load, toml):
    scene = load(toml)
    assert (scene.name, scene.camera, scene.lights) == ("room", None, [])
    assert [mesh.name for mesh in scene.meshes] == ["room"]


@pytest.mark.parametrize(
    ("toml", "up", "fov"),
    [
        (CAMERA, (0, 1, 0), 40),
        (CAMERA + "up = [0, 0, 2]\nfov = 90\n", (0, 0, 2), 90),
        ("\ufeff" + CAMERA.replace("\n", "\r\n"), (0, 1, 0), 40),
        ("camera = {origin = [0, 1, 5], target = [0.5, 0, 0]}", (0, 1, 0), 40),
    ],
)
def test_camera(load, toml, up, fov):
    camera = load(toml).camera
    assert camera == Camera((0, 1, 5), (0.5, 0, 0), up, fov)
    assert all(type(x) is float for x in (*camera.origin, *camera.target, *camera.up, camera.fov))


def test_suffix_in_capitals(load):
    assert load(CAMERA, "room.OBJ").camera is not None


@pytest.mark.parametrize("name", ["room.fbx", "room", "obj"])
def test_unknown_kind(load, name):
    every = (
        r"\.glb, \.gltf, \.obj, \.off, \.ply, \.stl, \.toml, \.usd, \.usda, \.usdc, \.usdz, \.xml"
    )
    with pytest.raises(InputError, match=rf"{name}: .*supported: {every}$"):
        load(name=name)


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        (CAMERA + "[cameras]\n", r":4: section 'cameras' .*did you mean 'camera'\?"),
        (CAMERA + "fow = 3\n", r":4: \[camera\] key 'fow' .*did you mean 'fov'\?"),
        ("# camera.\n\n[Camera]\n", r":3: section 'Camera' .*'camera'\?"),
        ("camera = 3\n", r":1: camera is not a section; write \[camera\]"),
        ("\n[[camera]]\nfov = 3\n", r":2: \[\[camera\]\] lacks origin"),
        (
            "[camera]\ntarget = [0, 0, 0]\n",
            r":1: \[camera\] lacks origin; add origin = \[x, y, z\]",
        ),
        ("[camera]\norigin = [0, 0, 0]\n", r":1: \[camera\] lacks target"),
        (CAMERA + "[[camera]]\n", r":4: has both \[camera\] and \[\[camera\]\]; write \[\[camera"),
        ("[[camera]]\n[camera]\n", r":2: has both \[camera\] and \[\[camera\]\]"),
        (CAMERA + CAMERA, r":4: has \[camera\] 2 times; write \[\[camera\]\] above each"),
        (CAMERA + "fov = \n", r":4: is not valid TOML: Invalid value"),
        (CAMERA + "fov = [1,\n", r":4: is not valid TOML"),
        (CAMERA + "fov = 3\nfov = 4\n", r":5: is not valid TOML"),
        ("x = " + "[" * 100_000, r": is not valid TOML"),
        (CAMERA + "fov = " + "9" * 5000 + "\n", r": is not valid TOML"),
        (CAMERA + "fov = 0x" + "f" * 5000 + "\n", r":4: camera fov a number of thousands"),
        (CAMERA.encode() + b"# T\xfcr\n", r":4: is not in UTF-8"),
        (CAMERA + "fov = 180\n", r":4: camera fov 180 .*degrees above 0 and below 180$"),
        (CAMERA + "fov = 0\n", r":4: camera fov 0 "),
        (CAMERA + "fov = nan\n", r":4: camera fov nan "),
        (CAMERA + "fov = true\n", r":4: camera fov True "),
        (CAMERA + 'fov = "wide"\n', r":4: camera fov 'wide' "),
        (CAMERA + "up = [0, 0, 0]\n", r":4: camera up \[0, 0, 0\] has no length"),
        (CAMERA + "up = [-1, 2, 10]\n", r":4: camera up .*parallel to the view"),
        (CAMERA + "up = [0, 1]\n", r":4: camera up \[0, 1\] .*three finite numbers"),
        (CAMERA.replace("5]", "inf]"), r":2: camera origin \[0, 1, inf\] .*three finite numbers"),
        (CAMERA.replace("[0, 1, 5]", "3"), r":2: camera origin 3 .*three finite numbers"),
        (CAMERA.replace("0.5", '"x"'), r":3: camera target \['x', 0, 0\] .*three finite"),
        (CAMERA.replace("[0, 1, 5]", "[0.5, 0, 0]"), r":3: camera target .*move one of them"),
    ],
)
def test_errors_name_line_value_and_remedy(load, toml, message):
    with pytest.raises(InputError, match=r"room\.toml" + message):
        load(toml)


def test_toml_is_a_directory(load, tmp_path):
    (tmp_path / "room.toml").mkdir()
    with pytest.raises(InputError, match=r"room\.toml: cannot be read"):
        load()


def test_missing_scene(tmp_path):
    with pytest.raises(InputError, match=r"none\.obj: cannot be read"):
        load_scene(tmp_path / "none.obj")


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e29])
def test_camera_of_any_scale(scale):
    origin, target = (0.0, 0.0, -scale), (0.0, 0.0, scale)
    camera = check_camera(Camera(origin, target, (0.0, scale, 0.0)))
    assert (camera.origin, camera.target) == (origin, target)


def test_camera_takes_arrays():
    camera = check_camera(Camera(np.zeros(3), np.ones(3, np.float32), [0, 1, 0], np.float64(30)))
    assert camera == Camera((0, 0, 0), (1, 1, 1), (0, 1, 0), 30)


def test_camera_without_file():
    with pytest.raises(InputError, match=r"^camera fov 200"):
        check_camera(Camera((0, 0, 0), (0, 0, 1), fov=200))


MATERIALS = """newmtl wall
Kd 0.5 0.5 0.5
newmtl lamp
Ke 1 1 1
"""
ROOM = (
    "mtllib room.mtl\no a\nusemtl wall\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    "o b\nusemtl lamp\nf 1 3 2\no c\nusemtl wall\nf 3 2 1\n"
)


@pytest.fixture
def room(tmp_path):
    def load(toml, name="room.obj", mtl=MATERIALS):
        (tmp_path / "room.mtl").write_text(mtl)
        (tmp_path / "room.obj").write_text(ROOM)
        (tmp_path / "chip.csv").write_text("400,0.1\n700,0.9\n")
        (tmp_path / name).with_suffix(".toml").write_text(toml)
        return {m.name: m.material for m in load_scene(tmp_path / name).meshes}

    return load


@pytest.mark.parametrize(
    ("value", "color"),
    [
        ("0.25", 0.25),
        ("1", 1.0),
        ("[0.1, 0.2, 0.3]", (0.1, 0.2, 0.3)),
        ('"0.5 0.5"', 0.25),
        ('"chip.csv"', Spectrum([400, 700], [0.1, 0.9])),
        ('"munsell:5R 5/10"', munsell("5R 5/10")),
    ],
)
def test_a_toml_colours_materials(room, value, color):
    materials = room(f"[material.wall]\nreflectance = {value}\n")
    assert materials["a"].reflectance == color
    assert materials["c"] is materials["a"]
    assert materials["b"].emission == (1, 1, 1)


def test_a_toml_lights_lamps_and_quotes_names(room):
    materials = room('[material."lamp"]\nemission = "D65 3"\nreflectance = 0.1\n')
    assert materials["b"].emission == 3 * named_light("D65")
    assert materials["b"].reflectance == 0.1
    assert materials["a"].reflectance == (0.5, 0.5, 0.5)


def test_a_toml_names_its_mesh(room):
    materials = room('mesh = "room.obj"\n[material.wall]\nreflectance = 0.1\n', "variant.toml")
    assert materials["a"].reflectance == 0.1


@pytest.mark.parametrize(
    ("toml", "name", "message"),
    [
        ("[material.wal]\n", "room.obj", r":1: material 'wal' is not known; did you mean 'wall'"),
        ("\nmaterial = 3\n", "room.obj", r":2: material is not a section; write \[material.NAME\]"),
        ("[material]\nwall = 3\n", "room.obj", r":2: material.wall is not a section; write \[mat"),
        ("[material.wall]\nkd = 1\n", "room.obj", r":2: \[material.wall\] key 'kd' is not known"),
        (
            "[material.lamp]\nreflectance = 0.5\n[material.wall]\nreflectance = 1.5\n",
            "room.obj",
            r"room.toml:4: \[material.wall\] reflectance: '1.5' is not a reflectance",
        ),
        (
            "[material.wall]\nemission = [1, 2]\n",
            "room.obj",
            r":2: .*\[1, 2\] is not a colour; write",
        ),
        ("[material.wall]\nemission = true\n", "room.obj", r":2: .*True is not a colour"),
        ("[material.wall]\nemission = -1\n", "room.obj", r":2: .*'-1' is not a light"),
        (
            "[material.wall]\nmirror = 1.5\n",
            "room.obj",
            r":2: .* mirror: '1.5' is not a reflectance",
        ),
        (
            "[material.wall]\nior = 2\ntint = -1\n",
            "room.obj",
            r":3: .* tint: '-1' is not a reflecta",
        ),
        ("[material.wall]\ntint = 0.5\n", "room.obj", r":2: .*only glass has one; add ior = 1.5"),
        (
            "[material.wall]\nior = 0\n",
            "room.obj",
            r"toml:2: \[material.wall\] ior: 0 is not an index",
        ),
        ("\n[material.wall]\nior = nan\n", "room.obj", r":3: .*nan is not an index of refraction"),
        ("[material.wall]\nior = true\n", "room.obj", r":2: .*True is not an index of refraction"),
        (
            '[material.wall]\nior = "glass"\n',
            "room.obj",
            r":2: .*'glass' is not an index of refract",
        ),
        (
            "[material.wall]\nior = 1.5\nmirror = 0.5\n",
            "room.obj",
            r":3: \[material.wall\] mirror: glass has none; leave out mirror or ior",
        ),
        ('[material.wall]\nreflectance = "x.csv"\n', "room.obj", r":2: .*x.csv: cannot be read"),
        ("[camera]\n", "variant.toml", r'variant.toml: names no mesh; add mesh = "FILE.obj"'),
        ("mesh = 3\n", "variant.toml", r":1: mesh 3 is not a name"),
        ('mesh = "no.obj"\n', "variant.toml", r"variant.toml:1: mesh: .*no.obj: cannot be read"),
        ('mesh = "room.fbx"\n', "variant.toml", r"room.fbx: is of an unknown kind"),
        ('mesh = "other.obj"\n', "room.obj", r":1: names another mesh than room.obj; render room"),
    ],
)
def test_errors_in_materials_name_their_line(room, toml, name, message):
    with pytest.raises(InputError, match=message):
        room(toml, name)


def test_of_several_meshes_beside_a_toml_file_none_is_taken(room, tmp_path):
    assert room("", "room.toml") == room("")
    (tmp_path / "room.ply").write_bytes(b"")
    with pytest.raises(InputError, match=r"beside it are 'room.obj', 'room.ply'; add mesh"):
        load_scene(tmp_path / "room.toml")


@pytest.mark.parametrize("name", ["room.ply", "room.stl", "room.glb", "room.gltf"])
def test_other_kinds_of_meshes(tmp_path, name):
    shape = trimesh.creation.box((1, 2, 3))
    (tmp_path / name).write_bytes(exported(shape, name))
    (mesh,) = load_scene(tmp_path / name).meshes
    assert mesh.material.name == "default"
    assert mesh.material.reflectance == 0.5
    assert np.ptp(mesh.vertices, axis=0).tolist() == [1, 2, 3]
    (tmp_path / "room.toml").write_text("[material.default]\nreflectance = [0.1, 0.2, 0.3]\n")
    (mesh,) = load_scene(tmp_path / name).meshes
    assert mesh.material == Material("default", (0.1, 0.2, 0.3))
    (beside,) = load_scene(tmp_path / "room.toml").meshes
    assert beside.material == mesh.material
    (tmp_path / "other.toml").write_text(f'mesh = "{name}"\n[material.default]\nmirror = 0.4\n')
    (mesh,) = load_scene(tmp_path / "other.toml").meshes
    assert mesh.material == Material("default", 0.5, mirror=0.4)


def exported(shape, name):
    """Give the file of a shape that has no material of its own."""
    shape = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if not name.endswith(".gltf"):
        return shape.export(file_type=name.partition(".")[2])
    data = np.concatenate([shape.faces.astype("<u4").ravel(), shape.vertices.astype("<f4").ravel()
                           .view("<u4")]).tobytes()  # fmt: skip
    views = [(0, 144, 5125, 36, "SCALAR"), (144, 96, 5126, 8, "VEC3")]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    tree = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
        "accessors": [
            {"bufferView": index, "componentType": kind, "count": count, "type": shape}
            for index, (_, _, kind, count, shape) in enumerate(views)
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": at, "byteLength": size} for at, size, *_ in views
        ],
        "buffers": [{"byteLength": len(data), "uri": uri}],
    }
    return json.dumps(tree).encode()


GLASS = """newmtl wall
illum 7
Ni 1.5
newmtl lamp
illum 3
Kd 0.2 0.2 0.2
Ks 0.5 0.5 0.5
"""


def test_a_toml_makes_mirrors_and_glass(room):
    materials = room("[material.wall]\nmirror = [0.1, 0.2, 0.3]\n[material.lamp]\nior = 1.33\n")
    assert materials["a"] == Material("wall", (0.5, 0.5, 0.5), mirror=(0.1, 0.2, 0.3))
    assert materials["b"] == Material("lamp", 0.0, (1, 1, 1), ior=1.33)
    materials = room(
        '[material.wall]\ntint = "chip.csv"\nior = 2\nreflectance = 0\nmirror = [0, 0, 0]\n'
        "[material.lamp]\nmirror = 0.5\nreflectance = 0.25\nemission = 0\n"
    )
    tint = Spectrum([400, 700], [0.1, 0.9])
    assert materials["a"] == Material("wall", 0.0, mirror=(0, 0, 0), ior=2.0, tint=tint)
    assert materials["b"] == Material("lamp", 0.25, mirror=0.5)


def test_a_toml_changes_mirrors_and_glass_of_the_mtl(room):
    materials = room("[material.wall]\ntint = 0.9\n[material.lamp]\nior = 1.4\n", mtl=GLASS)
    assert materials["a"] == Material("wall", 0.0, ior=1.5, tint=0.9)
    assert materials["b"] == Material("lamp", 0.0, ior=1.4)
    with pytest.raises(InputError, match=r"room.toml:2: .*wall\] reflectance: glass has none"):
        room("[material.wall]\nreflectance = 0.9\n", mtl=GLASS)


def test_a_missing_toml(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_scene(tmp_path / "none.toml")
