"""Scenes open files in their folder and below it, and elsewhere only if asked for."""

import json

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.io.png import write_png
from photonmap.runtime.files import named_file

OBJ = "mtllib {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"
MTL = "newmtl red\nKd .5 .1 .1\n"
PLAIN = OBJ.format("red.mtl")
GLTF = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
}


def gltf(uri):
    return json.dumps(GLTF | {"buffers": [{"byteLength": 36, "uri": uri}]})


SCENES = {
    "MTL": {"s.obj": OBJ.format("{}/red.mtl")},
    "texture": {"s.obj": PLAIN, "red.mtl": "newmtl red\nmap_Kd {}/red.png\n"},
    "spectrum in MTL": {"s.obj": PLAIN, "red.mtl": "newmtl red\nKd spectral {}/red.csv\n"},
    "buffer": {"s.gltf": gltf("{}/red.bin")},
    "mesh": {"s.toml": 'mesh = "{}/red.obj"\n'},
    "spectrum": {
        "s.obj": PLAIN,
        "red.mtl": MTL,
        "s.toml": '[material.red]\nreflectance = "{}/red.csv"\n',
    },
    "metal": {
        "s.obj": PLAIN,
        "red.mtl": MTL,
        "s.toml": '[material.red]\nreflectance = 0\nglossy = "metal:{}/gold.csv"\n',
    },
    "sky": {
        "s.obj": PLAIN,
        "red.mtl": MTL,
        "s.toml": '[[light]]\ntype = "environment"\nfile = "{}/red.png"\n',
    },
    "Mitsuba": {
        "s.xml": """<scene version="3.0.0"><shape type="obj">
<string name="filename" value="{}/red.obj"/></shape></scene>"""
    },
}


@pytest.fixture(params=SCENES)
def scene(request, tmp_path):
    """The file of a scene, and what it says that lies in a folder beside its own."""
    shared, folder = tmp_path / "shared", tmp_path / "scene"
    shared.mkdir()
    folder.mkdir()
    (shared / "red.mtl").write_text(MTL)
    (shared / "red.obj").write_text(PLAIN)
    (shared / "red.csv").write_text("400,0.1\n700,0.5\n")
    (shared / "gold.csv").write_text("400,1.5,1.9\n700,0.2,3.8\n")
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    (shared / "red.bin").write_bytes(corners.tobytes())
    write_png(np.full((4, 8, 3), 128, np.uint8), shared / "red.png")

    def make(place):
        for name, text in SCENES[request.param].items():
            (folder / name).write_text(text.replace("{}", place))
        return folder / next(iter(sorted(SCENES[request.param], key=lambda n: n[0] != "s")))

    return make


@pytest.mark.parametrize("absolute", [False, True])
def test_files_elsewhere_are_not_opened(scene, tmp_path, absolute):
    place = str(tmp_path / "shared") if absolute else "../shared"
    path = scene(place)
    with pytest.raises(pm.InputError, match=r"lies outside of the folder .* --root") as error:
        pm.load_scene(path)
    assert "\n" not in str(error.value)
    assert pm.load_scene(path, root=tmp_path).meshes


def test_files_below_are_opened(scene, tmp_path):
    (tmp_path / "shared").rename(tmp_path / "scene" / "shared")
    assert pm.load_scene(scene("./shared/../shared")).meshes


def test_the_command_line(tmp_path, capsys):
    (tmp_path / "scene").mkdir()
    (tmp_path / "red.mtl").write_text(MTL)
    path = tmp_path / "scene" / "s.obj"
    path.write_text(OBJ.format("../red.mtl"))
    assert main(["info", str(path)]) == 2
    line = capsys.readouterr().err
    assert "s.obj:1: mtllib: '../red.mtl' lies outside of the folder" in line
    assert main(["info", str(path), "--root", str(tmp_path)]) == 0
    assert main(["info", str(path), "--root", str(tmp_path / "no")]) == 2
    assert "is no folder" in capsys.readouterr().err


def test_code_may_name_any_file(tmp_path):
    (tmp_path / "scene").mkdir()
    assert named_file(tmp_path / "scene", "../a.csv") == tmp_path / "scene" / "../a.csv"


@pytest.mark.parametrize("name", ["C:\\art\\wood.png", "/home/other/wood.png", "D:/art/wood.png"])
def test_images_of_absolute_names_are_taken_from_beside_the_file(tmp_path, name):
    texels = np.full((2, 2, 3), 128, np.uint8)
    write_png(texels, tmp_path / "wood.png")
    (tmp_path / "s.obj").write_text(PLAIN)
    (tmp_path / "red.mtl").write_text(f"newmtl red\nmap_Kd {name}\n")
    with pytest.warns(pm.SceneWarning, match=r"is an absolute name: .*wood\.png is taken") as found:
        (mesh,) = pm.load_scene(tmp_path / "s.obj").meshes
    assert str(found[0].message).startswith(f"'{name}' is")  # with its backslashes as they are
    assert mesh.material.is_textured
    (tmp_path / "wood.png").unlink()
    with pytest.raises(pm.InputError):
        pm.load_scene(tmp_path / "s.obj")


def test_images_of_absolute_names_are_opened_if_they_may_be(tmp_path):
    (tmp_path / "art").mkdir()
    for folder, value in ((tmp_path, 0), (tmp_path / "art", 255)):
        write_png(np.full((2, 2, 3), value, np.uint8), folder / "wood.png")
    (tmp_path / "s.obj").write_text(PLAIN)
    (tmp_path / "red.mtl").write_text(f"newmtl red\nmap_Kd {tmp_path / 'art' / 'wood.png'}\n")
    (mesh,) = pm.load_scene(tmp_path / "s.obj").meshes
    assert mesh.material.reflectance.mean[0] == pytest.approx(1.0)
