"""Matter that is out of range, however it comes in: one line says where, what and what to do."""

import json

import pytest
import trimesh

import photonmap as pm
from photonmap.commands.main import main
from photonmap.scene.surfaces.layers import check_relative_indices

QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl m\nf 1 2 3 4\n"
MTL = {
    "Pr 1.5": r"m\.mtl:2: Pr 1.5 is not a roughness; give a number from 0 to 1",
    "Pr -0.1": r"m\.mtl:2: Pr -0.1 is not a roughness; give a number from 0 to 1",
    "aniso 2": r"m\.mtl:2: aniso 2.0 is not an anisotropy; give a number from 0 to 1",
    "abbe 0": r"m\.mtl:2: abbe 0.0 is not an Abbe number; give a number above 0",
    "outside 0": r"m\.mtl:2: outside 0.0 is not an index of refraction; give a number above 0",
    "Ni 0.5\nillum 7": r"m\.obj: material 'm': ior 0.5 is below 1, .* lies in none; give it rel",
}
TOML = {
    "roughness = 1.5": r"m\.toml:2: \[material.m\] roughness: 1.5 is not .* from 0 to 1",
    "glossy = -1": r"m\.toml:2: \[material.m\] glossy: '-1' is not .* between 0 and 1",
    "ior = 0": r"m\.toml:2: \[material.m\] ior: 0 is not .* above 0, such as 1.5",
    "metallic = 1.5": r"m\.toml:2: \[material.m\] metallic: 1.5 is not a metallic .* 0 to 1",
    "ior = 1.5\nmetallic = 1": r"m\.toml:3: \[material.m\] metallic: glass has none; leave out",
    "alpha = 1\nior = 0.5": r"m\.toml:3: material 'm': ior 0.5 is below 1, .* give it rel",
    "thin = true\nior = 0.9": r"m\.toml:3: material 'm': ior 0.9 is below 1, .* give it rel",
    "dispersion = { type = 'cauchy', a = 0.5, b = 0.001 }": r"m\.toml:2: .* ior 0.50.* is below 1",
    "dispersion = { type = 'cauchy', a = -1, b = 0 }": (
        r"m\.toml:2: \[material.m\] dispersion: a -1 is not .* above 0, such as 1.5"
    ),
    "diffuse_roughness = 0.5\nglossy = 0.04": (
        r"m\.toml:2: material 'm': glossy does not go with diffuse_roughness: only a Lambertian "
        r"base lies below; set diffuse_roughness to 0, or leave out glossy"
    ),
    "coat = 1\ndiffuse_roughness = 0.5": r"m\.toml:3: .* set diffuse_roughness to 0, or leave",
    "coat = 1\nmirror = 0.5": r"m\.toml:3: .* give glossy in place of mirror",
    "coat = 1\nsheen = 0.5": r"m\.toml:2: material 'm': sheen does not go with coat: one of them",
    "glossy = 'metal:k.csv'": r"k\.csv:3: n or k of the index is -1 at 700 nm; .* 0 and 1000 ",
    "dispersion = { type = 'cauchy', a = 'x', b = 0 }": r"m\.toml:2: .* a 'x' is not an index",
}
XML = {
    ("roughconductor", '<float name="alpha" value="1.5"/>'): r"xml:2: alpha 1.5 is not a rough",
    ("roughconductor", '<float name="alpha" value="-1"/>'): r"xml:3: alpha is -1; keep it at least",
    ("roughconductor", '<float name="k" value="-3"/>'): r"xml:3: k is -3; keep it at least 0",
    ("conductor", '<rgb name="eta" value="-1 1 1"/>'): r"xml:3: eta is -1; keep it at least 0",
    ("mask", '<float name="opacity" value="2"/>'): r"xml:3: opacity is 2; keep it within \[0, 1\]",
    ("principled", '<float name="eta" value="-3"/>'): r"xml:3: eta -3 is not above 0; correct it",
    ("dielectric", '<float name="int_ior" value="0.5"/>'): r"xml: material .* ior 0.499.* is below",
}
CLEAR = {
    "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
    "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1},
    },
}


def ball(radius, material):
    mesh = trimesh.creation.icosphere(subdivisions=1, radius=radius)
    return pm.Mesh(mesh.vertices, mesh.faces, material, "ball")


def refused(path, message, capsys):
    assert main(["info", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    with pytest.raises(pm.InputError, match=message):
        pm.load_scene(path)


def write(folder, mtl="", toml=""):
    (folder / "m.obj").write_text("mtllib m.mtl\n" + QUAD)
    (folder / "m.mtl").write_text(f"newmtl m\n{mtl}\n")
    (folder / "m.toml").write_text(toml)
    (folder / "k.csv").write_text("nm,n,k\n400,0.2,3\n700,0.3,-1\n")
    return folder / "m.obj"


@pytest.mark.parametrize("statement", MTL)
def test_mtl(tmp_path, capsys, statement):
    refused(write(tmp_path, statement), MTL[statement], capsys)


@pytest.mark.parametrize("key", TOML)
def test_toml(tmp_path, capsys, key):
    refused(write(tmp_path, "", f"[material.m]\n{key}\n"), TOML[key], capsys)


@pytest.mark.parametrize("line", ["roughness = 0.3", "anisotropy = 0.5"])
def test_a_roughness_of_what_is_not_glossy_is_named(tmp_path, line):
    message = (
        rf"m\.toml:2: \[material.m\] {line.split()[0]} has no effect on what is not glossy; add"
    )
    with pytest.warns(pm.SceneWarning, match=message):
        pm.load_scene(write(tmp_path, "", f"[material.m]\n{line}\n"))
    for more in ("glossy = 0.04", "ior = 1.5", "glossy = 'metal:Au'\nreflectance = 0"):
        pm.load_scene(write(tmp_path, "", f"[material.m]\n{line}\n{more}\n"))
    pm.load_scene(write(tmp_path, "", f"[material.m]\n{line.split()[0]} = 0\n"))


@pytest.mark.parametrize(
    ("line", "reason", "remedy"),
    [
        ("glossy_edge = 0.3", "what is not glossy; add glossy", "glossy = 0.5"),
        ("coat_roughness = 0.3", "what has no coat; add coat = 1", "coat = 1"),
        ("coat_ior = 1.7", "what has no coat; add coat = 1", "coat = 1"),
        ("sheen_roughness = 0.3", "what has no sheen; add sheen = 0.5", "sheen = 0.5"),
        ("abbe = 30\nthin = true\nior = 1.5", "thin glass, .* leave out one", "thin = false"),
        ("priority = 2\nthin = true\nior = 1.5", "thin glass, .* leave out one", "thin = false"),
    ],
)
def test_what_has_no_effect_is_named(tmp_path, line, reason, remedy):
    key = line.split()[0]
    with pytest.warns(pm.SceneWarning, match=rf"m\.toml:2: .*\] {key} has no effect on {reason}"):
        pm.load_scene(write(tmp_path, "", f"[material.m]\n{line}\n"))
    mended = line.replace("thin = true", "") + f"\n{remedy}"
    pm.load_scene(write(tmp_path, "", f"[material.m]\n{mended}\n"))


@pytest.mark.parametrize(("kind", "inside"), XML)
def test_mitsuba(tmp_path, capsys, kind, inside):
    path = tmp_path / "m.xml"
    inner = '\n<bsdf type="diffuse"/>' if kind == "mask" else ""
    bsdf = f'<bsdf type="{kind}">\n{inside}{inner}</bsdf>'
    shape = f'<scene version="3.0.0"><shape type="rectangle">\n{bsdf}</shape></scene>'
    path.write_text(shape)
    refused(path, XML[kind, inside], capsys)


@pytest.mark.parametrize("index", [0, 0.5, -1])
def test_gltf(tmp_path, capsys, index):
    pm.save_scene(pm.load_scene(write(tmp_path)), tmp_path / "m.gltf")
    tree = json.loads((tmp_path / "m.gltf").read_text())
    tree["materials"] = [CLEAR | {"name": "m"}]
    tree["materials"][0]["extensions"]["KHR_materials_ior"] = {"ior": index}
    (tmp_path / "m.gltf").write_text(json.dumps(tree))
    refused(tmp_path / "m.gltf", rf"m\.gltf: material 'm': ior {index:g}", capsys)


@pytest.mark.parametrize("index", [0.5, -1.0])
def test_the_coat_of_plastic_is_denser_than_air(index):
    message = rf"^material 'cup': ior: {index} is not an index .*; give a number from 1, such as"
    with pytest.raises(pm.InputError, match=message):
        pm.Material.plastic("cup", ior=index)


def test_an_index_below_1_needs_glass_around_it():
    bubble, glass = pm.Material.glass("bubble", 1.0 / 1.5), pm.Material.glass("glass", 1.5)
    inner = ball(0.3, bubble)
    check_relative_indices([inner, ball(0.5, glass)])
    vacuum = pm.Material.glass("vacuum", 1.0 / 1.000277)
    check_relative_indices([ball(0.3, vacuum)])
    for other in (pm.Material("wall"), pm.Material.pane(), bubble):
        lonely = [inner, ball(0.5, other)]
        with pytest.raises(pm.InputError, match=r"'bubble': ior 0.666667 is below 1"):
            check_relative_indices(lonely)
    with pytest.raises(pm.InputError, match=r"'bubble': ior 0.666667 is below 1"):
        pm.render(pm.Scene([inner], camera=pm.Camera((0, 0, 2), (0, 0, 0))), size=(4, 4), passes=1)
