"""The command `convert`: any scene that can be read, as OBJ or glTF; no input is replaced."""

import numpy as np
import pytest
import trimesh

import photonmap as pm
from photonmap.commands.main import main

BOX = f"{pm.scenes.FOLDER}/cornell_box.obj"


def convert(*arguments):
    return main(["convert", *map(str, arguments)])


@pytest.mark.parametrize("suffix", ["ply", "stl", "off", "obj", "glb"])
def test_every_format_is_converted(tmp_path, capsys, suffix):
    source = tmp_path / f"box.{suffix}"
    trimesh.creation.box((1.0, 2.0, 0.5)).export(source)
    read = pm.load_scene(source)
    for name in ("a.obj", "b.glb", "c.gltf"):
        assert convert(source, tmp_path / name) == 0
        assert str(tmp_path / name) in capsys.readouterr().out.splitlines()
        (wanted,), (found,) = read.meshes, pm.load_scene(tmp_path / name).meshes
        rows = [m.vertices[m.faces].reshape(-1, 9) for m in (wanted, found)]
        np.testing.assert_array_equal(*rows)


def test_there_and_back(tmp_path):
    box = pm.scenes.cornell_box()
    assert convert(BOX, tmp_path / "box.glb", "--quiet") == 0
    assert convert(tmp_path / "box.glb", tmp_path / "again.obj", "--quiet") == 0
    again = pm.load_scene(tmp_path / "again.obj")
    for wanted, found in zip(box.meshes, again.meshes, strict=True):
        assert (wanted.name, wanted.material.name) == (found.name, found.material.name)
        np.testing.assert_allclose(found.vertices, wanted.vertices, atol=1e-7)
        np.testing.assert_allclose(
            np.ones(3) * found.material.reflectance, np.ones(3) * wanted.material.reflectance
        )
        assert found.material.emission == wanted.material.emission
    np.testing.assert_allclose(again.camera.origin, box.camera.origin)


def test_quiet_and_help(tmp_path, capsys):
    assert convert(BOX, tmp_path / "a.glb", "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "convert  Convert a scene" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("room.obj", "room.toml: is a file of the scene itself; choose another name"),
        ("mesh.obj", "mesh.obj: is a file of the scene itself"),
        ("room.glb", "room.toml: is a file of the scene itself"),
        ("./x/../mesh.obj", "mesh.obj: is a file of the scene"),
        ("other.glb", "other.toml: exists, but other.glb does not; rename one of them"),
        ("spare.gltf", "spare.bin: exists, but spare.gltf does not"),
        ("kept.obj", "kept_files: exists, but kept.obj does not"),
        ("a.ply", "a.ply: does not end in one of .obj, .glb, .gltf"),
    ],
)
def test_what_is_refused(tmp_path, capsys, monkeypatch, output, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "room.toml").write_text('mesh = "mesh.obj"\n')
    (tmp_path / "other.toml").write_text("")
    (tmp_path / "spare.bin").write_text("")
    (tmp_path / "kept_files").mkdir()
    (tmp_path / "x").mkdir()
    before = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
    assert convert("room.toml", output) == 2
    out, err = capsys.readouterr()
    assert (out, len(err.splitlines())) == ("", 1)
    assert message in err
    assert before == {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}


def test_an_earlier_conversion_is_replaced(tmp_path):
    (tmp_path / "sky.toml").write_text(f'mesh = "{BOX}"\n[[light]]\ntype = "dome"\n')
    assert convert(tmp_path / "sky.toml", tmp_path / "room.glb", "--quiet", "--root", "/") == 0
    assert len(pm.load_scene(tmp_path / "room.glb").lights) == 1
    assert convert(BOX, tmp_path / "room.glb", "--quiet") == 0
    assert pm.load_scene(tmp_path / "room.glb").lights == []


def test_lights_in_toml_replace_those_of_the_mesh_file(tmp_path):
    panel = pm.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [[0, 1, 2]])
    lights = [pm.PointLight((0, 1, 0), (1.0, 1.0, 1.0), name) for name in ("a", "b")]
    pm.save_scene(pm.Scene([panel], lights), tmp_path / "room.glb")
    (tmp_path / "room.toml").write_text(
        '[[light]]\ntype = "point"\nposition = [0, 9, 0]\nintensity = 5\nname = "a"\n'
        '[[light]]\ntype = "point"\nposition = [0, 7, 0]\n'
    )
    found = pm.load_scene(tmp_path / "room.glb").lights
    assert [(light.name, light.position[1]) for light in found] == [("b", 1), ("a", 9), ("", 7)]
