"""Attributes that are declared once: checks, TOML and MTL follow."""

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
import pytest

import photonmap as pm
from photonmap.io.readers import registry
from photonmap.io.readers.obj import mtl_models
from photonmap.scene.lights import LIGHTS, Light, check_light
from photonmap.scene.parameters import Emission, File, Number, Point, Text, Vector, parameters_of
from photonmap.scene.surfaces.layers import check_material
from photonmap.spectra.curves import Color

TRIANGLE = pm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.fixture
def lantern():
    """A kind of light that exists in this test alone."""

    @dataclass(frozen=True)
    class Lantern(Light):
        position: Annotated[Vector, Point()]
        profile: Annotated[
            str,
            File(
                "profile",
                key="file",
                read=Path.read_text,
                save=lambda text, path: Path(path).write_text(text),
                suffix=".ies",
            ),
        ]
        flux: Annotated[Color, Emission("radiant flux", "W")] = 1.0
        turns: Annotated[float, Number("number of turns", at_least=0.0, at_most=9.0)] = 0.0
        name: Annotated[str, Text()] = ""
        group: Annotated[str, Text()] = ""
        kind: ClassVar[str] = "lantern"

        def find_conflict(self):
            return ("turns", "is unlucky; choose another") if self.turns == self.flux else None

    yield Lantern
    del LIGHTS["lantern"]


def test_a_new_light_is_read_and_written_without_an_edit(lantern, tmp_path):
    light = lantern((0.0, 1.0, 2.0), "IESNA\n", (3.0, 2.0, 1.0), 4.0, "porch")
    assert (light.color, light.color_attribute) == ((3.0, 2.0, 1.0), "flux")
    pm.save_scene(pm.Scene([TRIANGLE], [light]), tmp_path / "a.obj")
    text = (tmp_path / "a.toml").read_text()
    assert 'type = "lantern"\nposition = [0.0, 1.0, 2.0]\nfile = "a_files/porch.ies"\n' in text
    assert pm.load_scene(tmp_path / "a.obj").lights == [light]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("turns = 10", r":6: .* turns: 10 is not a number of turns; give a number from 0 to 9"),
        ("turns = 1", r":6: light 'lantern': turns 1.0 is unlucky; choose another"),
        ("flux = -1", r":6: \[\[light\]\] flux: '-1' is not a light"),
        ("flux_ = 1", r":6: lantern light key 'flux_' is not known; did you mean 'flux'\?"),
        ("file = 3", r" is not valid TOML"),
    ],
)
def test_errors_follow_from_the_declaration(lantern, tmp_path, line, message):
    pm.save_scene(pm.Scene([TRIANGLE], [lantern((0, 0, 0), "")]), tmp_path / "a.obj")
    (tmp_path / "a_files" / "b.ies").write_text("")
    head = '\n[[light]]\ntype = "lantern"\nposition = [0, 0, 0]\nfile = "a_files/b.ies"\n'
    (tmp_path / "a.toml").write_text(head + line + "\n")
    with pytest.raises(pm.InputError, match=rf"a\.toml.*{message}"):
        pm.load_scene(tmp_path / "a.obj")


@pytest.mark.parametrize("kind", LIGHTS.values())
def test_every_attribute_of_a_light_is_declared(kind):
    assert list(parameters_of(kind)) == [field.name for field in fields(kind)]


def test_checked_lights_hold_plain_floats():
    light = check_light(pm.SpotLight(np.zeros(3), [0, 0, 1], inner=np.float32(10), outer=20))
    assert light == pm.SpotLight((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), inner=10.0, outer=20.0)
    assert all(type(x) is float for x in (*light.position, *light.target, light.inner, light.outer))


@pytest.mark.parametrize(
    ("material", "message"),
    [
        (pm.Material("a", ior=0.0), "'a': ior: 0.0 is not an index of refraction; give a number"),
        (pm.Material("a", ior="1.5"), "'a': ior: '1.5' is not an index of refraction"),
        (pm.Material("a", alpha=1.5), "'a': alpha: 1.5 is not an opacity; give a number from 0 to"),
        (pm.Material(3), "material 3: 3 is not a text; write it in quotes"),
    ],
)
def test_materials_check_themselves(material, message):
    with pytest.raises(pm.InputError, match=message):
        check_material(material)


def test_a_new_statement_of_mtl_needs_no_edit(monkeypatch):
    declared = {"tint": Number("part", mtl="Pt")}
    monkeypatch.setattr(mtl_models, "parameters_of", lambda described: declared)
    draft = mtl_models.Draft(numbers={"Pt": 0.25})
    assert mtl_models.make_material("a", draft).tint == 0.25


def test_a_toml_sets_the_opacity(tmp_path):
    pm.save_scene(pm.Scene([TRIANGLE]), tmp_path / "a.obj")
    (tmp_path / "a.toml").write_text("[material.grey]\nalpha = 0.25\n")
    (mesh,) = pm.load_scene(tmp_path / "a.obj").meshes
    assert mesh.material == pm.Material("grey", 0.5, alpha=0.25)


def test_readers_are_found_by_what_they_declare():
    known = (".glb", ".gltf", ".obj", ".off", ".ply", ".stl", ".toml")
    known += (".usd", ".usda", ".usdc", ".usdz", ".xml")
    assert registry.scene_suffixes() == known
    assert registry.mesh_suffixes() == tuple(name for name in known if name != ".toml")
    with pytest.raises(pm.InputError, match="missing_textures 'pink' is not a choice"):
        registry.ReadOptions("pink")


def test_a_scene_file_is_no_mesh(tmp_path):
    (tmp_path / "a.toml").write_text('\nmesh = "a.toml"\n')
    with pytest.raises(pm.InputError, match=r"a\.toml:2: mesh 'a.toml' is a scene file; name the"):
        pm.load_scene(tmp_path / "a.toml")


def test_lights_and_cameras_of_a_mesh_file_reach_the_scene(monkeypatch, tmp_path):
    camera, light = pm.Camera((0, 0, 1), (0, 0, 0)), pm.DomeLight(name="sky")

    def read(path, options):
        return pm.Scene([TRIANGLE], [light], camera)

    monkeypatch.setattr("photonmap.io.readers.off.read", read)
    (tmp_path / "a.toml").write_text('mesh = "a.off"\n[[light]]\ntype = "dome"\n')
    scene = pm.load_scene(tmp_path / "a.toml")
    assert (scene.lights, scene.camera) == ([light, pm.DomeLight()], camera)
    (tmp_path / "a.toml").write_text("[camera]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\n")
    assert pm.load_scene(tmp_path / "a.off").camera == pm.Camera((0, 0, 9), (0, 0, 0))


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (lambda text: int(text), r"a\.off: invalid literal .*'x\\ny'"),
        (lambda text: json.loads('{\n"a": 1,\n}'), r"a\.off:3: .*property name"),
        (lambda text: registry.ReadOptions("pink"), r"a\.off: missing_textures 'pink' is not"),
        (lambda text: pm.load_scene("b.ply"), r"b\.ply: cannot be read"),
    ],
)
@pytest.mark.parametrize("name", ["a.off", "a.toml"])
def test_errors_of_a_reader_name_its_file_and_line(monkeypatch, tmp_path, name, read, message):
    monkeypatch.setattr("photonmap.io.readers.off.read", lambda path, _: read(path.read_text()))
    (tmp_path / "a.off").write_text("x\ny")
    (tmp_path / "a.toml").write_text('mesh = "a.off"\n')
    with pytest.raises(pm.InputError, match=rf"^\S*{message}") as caught:
        pm.load_scene(tmp_path / name)
    assert "\n" not in str(caught.value)
