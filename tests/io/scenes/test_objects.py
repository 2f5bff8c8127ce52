"""Materials of objects by name, in scene files and in code."""

import pytest

import photonmap as pm
from photonmap.errors import InputError
from photonmap.io.readers.scene_file import load_scene
from photonmap.spectra.metals import metal

ROOM = """mtllib room.mtl
v 0 0 0 1 0 0
v 1 0 0 0 1 0
v 0 1 0 0 0 1
o table
usemtl wood
f 1 2 3
usemtl brass
f 1 3 2
o kettle
usemtl wood
f 3 2 1
"""
STEEL = '[material.steel]\nreflectance = 0\nglossy = "metal:Au"\nroughness = 0.3\n'


@pytest.fixture
def room(tmp_path):
    def load(toml=""):
        (tmp_path / "room.mtl").write_text(
            "newmtl wood\nKd 0.6 0.4 0.2\nnewmtl brass\nKd 0.2 0 0\n"
        )
        (tmp_path / "room.obj").write_text(ROOM)
        (tmp_path / "room.toml").write_text(toml)
        return load_scene(tmp_path / "room.obj")

    return load


def materials(scene):
    """The material of each mesh."""
    return [(mesh.name, mesh.material.name) for mesh in scene.meshes]


def test_an_object_gets_a_material_of_the_file(room):
    scene = room('[object.kettle]\nmaterial = "brass"\n')
    assert materials(scene) == [("table", "wood"), ("table", "brass"), ("kettle", "brass")]
    assert scene.meshes[2].material is scene.meshes[1].material
    assert scene.meshes[2].material.reflectance == (0.2, 0, 0)
    assert scene.meshes[2].colors is None
    assert scene.meshes[0].colors is not None


def test_all_faces_of_an_object_get_a_new_material(room):
    scene = room('[object.table]\nmaterial = "steel"\n' + STEEL)
    assert materials(scene) == [("table", "steel"), ("table", "steel"), ("kettle", "wood")]
    (steel, other, wood) = (mesh.material for mesh in scene.meshes)
    assert steel is other
    assert (steel.reflectance, steel.roughness) == (0, 0.3)
    assert steel.glossy == metal("Au")
    assert wood.reflectance == (0.6, 0.4, 0.2)


def test_new_glass_has_no_reflectance(room):
    glass = room('object.kettle.material = "glass"\nmaterial.glass.ior = 1.5\n').meshes[2].material
    assert glass == pm.Material("glass", 0.0, ior=1.5)


def test_a_file_without_materials_gets_some(tmp_path):
    pm.save_scene(
        pm.Scene(pm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])), tmp_path / "a.obj"
    )
    (tmp_path / "b.toml").write_text('mesh = "a.obj"\n[object.mesh]\nmaterial = "steel"\n' + STEEL)
    (mesh,) = load_scene(tmp_path / "b.toml").meshes
    assert (mesh.material.name, mesh.material.roughness) == ("steel", 0.3)


def test_code_does_the_same(room):
    scene, steel = room(), pm.Material.metal("steel")
    painted = scene.with_materials({"table": steel})
    assert [mesh.material is steel for mesh in painted.meshes] == [True, True, False]
    assert materials(scene)[0] == ("table", "wood")
    assert painted.meshes[2] is scene.meshes[2]


def test_code_names_an_unknown_mesh(room):
    with pytest.raises(InputError, match="no mesh 'ketle'; did you mean 'kettle'"):
        room().with_materials({"ketle": pm.Material()})


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("\n[object.tabel]\n", r":2: object 'tabel' is not known; did you mean 'table'"),
        ("object = 3\n", r":1: object is not a section; write \[object.NAME\]"),
        ("[object.table]\n", r':1: \[object.table\] lacks material; add material = "NAME"'),
        ("[object.table]\nmaterial = 3\n", r":2: \[object.table\] material: 3 is not a name"),
        ("[object.table]\ncolor = 3\n", r":2: \[object.table\] key 'color' is not known"),
        (
            '[object.table]\nmaterial = "wod"\n',
            r":2: .* 'wod' is not known; did you mean 'wood'\? \(a new one needs a section \[mat",
        ),
        (
            '[object.kettle]\nmaterial = "brass"\n[object.table]\nmaterial = "brass"\n'
            "[material.wood]\nreflectance = 0.5\n",
            r":5: material 'wood' is not known",
        ),
    ],
)
def test_errors_name_their_line(room, toml, message):
    with pytest.raises(InputError, match=message):
        room(toml)
