"""The command `info`: what is in a file, in numbers that are known otherwise."""

import json
import subprocess
import sys

import numpy as np
import pytest

import photonmap as pm
from photonmap.commands.main import main
from photonmap.inspection.describe import (
    describe_materials,
    describe_mesh,
    describe_scene,
    find_remedy,
    guess_unit,
)
from photonmap.inspection.text import _warning_lines
from photonmap.scene.surfaces.layers import name_kind

from helpers.scenes import quad  # isort: skip

FOLDER = pm.scenes.FOLDER


def info(capsys, *arguments):
    assert main(["info", *map(str, arguments), "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


def test_the_cornell_box(capsys):
    about = info(capsys, f"{FOLDER}/cornell_box.obj", "--bands", "rgb")
    assert list(about) == [
        "file", "files", "format", "totals", "bounds", "unit", "meshes", "materials", "lights",
        "area_lights", "cameras", "framed_camera", "bands", "effects", "warnings",
    ]  # fmt: skip
    assert about["format"] == "Wavefront OBJ"
    assert [path.rpartition("/")[2] for path in about["files"]] == [
        "cornell_box.obj", "cornell_box.toml",
    ]  # fmt: skip
    box = pm.scenes.cornell_box()
    assert about["totals"]["triangles"] == sum(len(mesh.faces) for mesh in box.meshes) == 36
    assert about["totals"]["meshes"] == 8
    vertices = np.concatenate([mesh.vertices for mesh in box.meshes])
    np.testing.assert_allclose(about["bounds"]["size"], np.ptp(vertices, axis=0))
    (lamp,) = about["area_lights"]
    mesh = next(mesh for mesh in box.meshes if mesh.name == "light")
    a, b, c = mesh.vertices[mesh.faces].swapaxes(0, 1)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert lamp["area"] == pytest.approx(area, rel=1e-6)
    power = np.pi * area * np.mean(mesh.material.emission)  # of a Lambertian emitter
    assert lamp["power"] == pytest.approx(power, rel=1e-6)
    assert lamp["share"] == 1.0
    assert about["totals"]["power"] == pytest.approx(power, rel=1e-6)
    (camera,) = about["cameras"]
    assert (camera["kind"], camera["origin"]) == ("pinhole", [0, 0, 3.9])
    assert about["framed_camera"] is None
    assert about["effects"]["indirect"]["on"]
    assert not about["effects"]["transmission"]["on"]
    assert about["warnings"] == []


def test_powers_of_lights():
    """In scene units: 4π I of a point, 2π (1 - cos) I of a sharp cone, the share of each."""
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    lights = [
        pm.PointLight((0, 1, 0), 2.0, "lamp"),
        pm.SpotLight((0, 3, 0), (0, 0, 0), 5.0, 60.0, 60.0, "stage"),
        pm.PointLight((0, 2, 0), 0.0),
        pm.DirectionalLight((0, -2, 0), 1.0, "sun"),
        pm.EnvironmentLight(np.zeros((2, 4, 3)), name="sky", group="outside"),
    ]
    about = describe_scene(pm.Scene([floor], lights), pm.Bands.gaussian(3))
    lamp, stage, dark, sun, sky = about["lights"]
    assert lamp["power"] == pytest.approx(8 * np.pi)
    assert stage["power"] == pytest.approx(np.pi * 5.0)
    assert (stage["kind"], stage["direction"], stage["outer"]) == ("spot", [0, -1, 0], 60.0)
    assert (dark["name"], dark["power"], dark["share"]) == ("point", 0.0, 0.0)
    assert sun["power"] == pytest.approx(np.pi * 2.0, rel=0.01)  # the disk around the floor
    assert (sky["image"], sky["group"], sky["power"]) == ([2, 4, 3], "outside", 0.0)
    assert sum(light["share"] for light in about["lights"]) == pytest.approx(1.0)
    assert about["cameras"] == []
    assert about["framed_camera"]["kind"] == "pinhole"


@pytest.mark.parametrize(
    ("material", "kind"),
    [
        (pm.Material(), "diffuse"),
        (pm.Material("a", 0.0), "black"),
        (pm.Material("a", diffuse_roughness=0.5), "rough diffuse"),
        (pm.Material.polished(), "mirror"),
        (pm.Material("a", 0.5, mirror=0.1), "mirror over diffuse"),
        (pm.Material("a", 0.0, coat=1.0), "coated black"),
        (pm.Material("a", 0.5, glossy=0.04, coat=0.5), "coated gloss over diffuse"),
        (pm.Material("a", sheen=0.3, diffuse_roughness=0.5), "sheen over rough diffuse"),
        (pm.Material.glass(), "glass"),
        (pm.Material("a", 0.8, ior=1.5, transmission=0.5), "part glass, part diffuse"),
        (
            pm.Material("a", 0.0, ior=1.5, transmission=0.5, glossy=0.9, roughness=0.3, thin=True),
            "part rough thin glass, part metal",
        ),
        (pm.Material.metal(), "metal"),
        (pm.Material.plastic(), "gloss over diffuse"),
        (pm.Material("a", pm.Texture.of(np.zeros((2, 2, 3)))), "black"),
    ],
)
def test_kinds_of_materials(material, kind):
    assert name_kind(material) == kind


def test_attributes_of_materials():
    texels = np.full((3, 5, 3), 255, np.uint8)
    red = pm.Spectrum([400, 700], [0.1, 0.9])
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    materials = [
        pm.Material("wood", pm.Texture.of(texels), (0.0, 0.0, 0.0), alpha=0.5),
        pm.Material("red", red, emission=(1.0, 2.0, 3.0)),
        pm.Material.glass("pane", 1.4),
    ]
    meshes = [pm.Mesh(panel.vertices, panel.faces, material) for material in materials]
    wood, curve, pane = describe_materials([*meshes, meshes[0]])
    texture = {"width": 5, "height": 3, "channels": 3, "bits": 8, "mean": [1.0, 1.0, 1.0]}
    assert wood == {
        "name": "wood", "kind": "diffuse", "triangles": 4, "reflectance": {"texture": texture},
        "alpha": 0.5,
    }  # fmt: skip
    assert curve["reflectance"] == {"spectrum": {"samples": 2, "range_nm": [400.0, 700.0]}}
    assert curve["emission"] == [1.0, 2.0, 3.0]
    assert pane == {"name": "pane", "kind": "glass", "triangles": 2, "ior": 1.4}


def test_smooth_and_flat():
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    up = np.tile([0.0, 1.0, 0.0], (4, 1))
    bent = up + [[0.1, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    found = [
        describe_mesh(pm.Mesh(floor.vertices, floor.faces, normals=normals))
        for normals in (None, up, bent)
    ]
    assert [(each["normals"], each["smooth"]) for each in found] == [
        (False, False), (True, False), (True, True),
    ]  # fmt: skip


def test_colors_of_meshes():
    """They stand in place of the reflectance, which is shown with the material."""
    floor = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    found = [
        describe_mesh(pm.Mesh(floor.vertices, floor.faces, colors=np.broadcast_to(0.25, shape)))
        for shape in ((4, 3), (2, 1, 3), (2, 3, 3))
    ]
    assert [each["colors"] for each in found] == [
        {"of": owners, "mean": [0.25] * 3} for owners in ("vertices", "faces", "corners of faces")
    ]
    assert describe_mesh(floor)["colors"] is None


def test_text_of_a_painted_mesh_far_away(capsys, tmp_path):
    """Points keep the digits that tell them apart, and cameras have their heading."""
    (tmp_path / "a.obj").write_text(
        "v 1000000.25 0 0 0 0 1\nv 1000001.5 0 0 0 0 1\nv 1000000.25 1 0 0 0 1\nf 1 2 3\n"
    )
    assert main(["info", str(tmp_path / "a.obj")]) == 0
    text = capsys.readouterr().out
    assert "bounds (1000000.25, 0, 0) to (1000001.5, 1, 0), size (1.25, 1, 0)" in text
    assert "colours of vertices in place of the reflectance, mean (0, 0, 1)" in text
    assert "cameras:\n  no camera given: seen from the front right, above, at (100000" in text


def test_lenses_in_words(capsys, tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    pose = "[[camera]]\norigin = [0, 0, 4]\ntarget = [0, 0, 0]\n"
    (tmp_path / "a.toml").write_text(
        f'{pose}name = "a"\nlens = {{ radius = 0.1, focus = 4 }}\n{pose}name = "b"\n'
        "lens = { f_number = 2.8, focal_length = 0.05, focus = 4, blades = 6, rotation = 10 }\n"
    )
    assert main(["info", str(tmp_path / "a.obj")]) == 0
    disk, polygon = (line for line in capsys.readouterr().out.splitlines() if " lens " in line)
    assert disk.endswith("fov 40, thin lens of radius 0.1, sharp at distance 4")
    assert polygon.endswith(
        "thin lens f/2.8 of focal length 0.05, sharp at distance 4, 6 blades, turned by 10°"
    )


def test_no_names_of_python_in_the_text(capsys, tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
    (tmp_path / "a.toml").write_text("[material.a]\nior = 1.5\nthin = true\n")
    assert main(["info", str(tmp_path / "a.obj")]) == 0
    text = capsys.readouterr().out
    assert "thin yes" in text
    assert not {"None", "True", "False"} & set(text.split())


@pytest.mark.parametrize(
    ("longest", "unit", "metres"),
    [(2.0, "metres", 2), (20, "metres", 20), (560, "centimetres", 5.6), (4000, "millimetres", 4)],
)
def test_units_are_guessed_by_size(longest, unit, metres):
    guess = guess_unit([0.1, longest, 1.0])
    assert guess["guess"] == unit
    assert guess["metres"] == pytest.approx(metres)
    assert "the format does not say" in guess["why"]
    assert "glTF prescribes metres" in guess_unit([longest], ".glb")["why"]
    assert guess_unit([0.0, 0.0, 0.0])["guess"] is guess_unit([1e9])["guess"] is None


@pytest.fixture
def sloppy(tmp_path):
    """A file with much that is not simulated."""
    (tmp_path / "room.mtl").write_text("newmtl a\nKd 0.5 0.5 0.5\nbump none.png\nPc 1\n")
    (tmp_path / "room.obj").write_text(
        "mtllib room.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nf 1 1 1\nl 1 2\n"
    )
    return tmp_path / "room.obj"


def test_every_warning_has_a_remedy(capsys, sloppy):
    warnings = info(capsys, sloppy)["warnings"]
    assert len(warnings) == 5
    remedies = {each["message"].partition("room.")[2]: each["remedy"] for each in warnings}
    assert all("compare a render" not in remedy for remedy in remedies.values()), remedies
    assert any("put the images" in remedy for remedy in remedies.values())
    assert any("polygons" in remedy for remedy in remedies.values())


def test_materials_of_one_name_are_told_apart_by_their_meshes():
    panel = quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    one, other = (pm.Material("paint", reflectance) for reflectance in (0.2, 0.4))
    uses = (("a", one), ("b", other), ("c", other), ("b", other), ("d", pm.Material("wood")))
    meshes = [pm.Mesh(panel.vertices, panel.faces, use, name) for name, use in uses]
    described = describe_materials(meshes)
    assert [each.get("meshes") for each in described] == [["a"], ["b", "c"], None]


def test_warnings_of_one_remedy_stand_together():
    told = [("a", "bake"), ("b", "unwrap"), ("c", "bake")]
    about = [{"message": message, "remedy": remedy} for message, remedy in told]
    shown = ["  a", "  c", "    what to do about these 2: bake", "  b", "    what to do: unwrap"]
    assert [*_warning_lines(about)] == shown


def test_an_unknown_warning_has_one_too():
    assert find_remedy("something new") == "compare a render with what it should show"


def test_remedies_stand_in_the_order_of_what_they_mend():
    message = "room.gltf: not simulated: sheen of 'cloth'; range of 'lamp'; KHR_materials_x of 'a'"
    sheen, falls_off, extension = find_remedy(message).split("; ")
    assert sheen.startswith("give sheen")
    assert falls_off.startswith("nothing: light falls off")
    assert extension.startswith("describe the surface")


def test_text(capsys, sloppy):
    assert main(["info", str(sloppy)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for part in (
        "1 mesh, 1 triangle, 3 vertices, 1 material",
        "probably metres, a guess: the longest side would be 1 m",
        "room  a  1 triangle  3 vertices  no uv  flat, no normals",
        "a  coated diffuse  1 triangle  reflectance (0.5, 0.5, 0.5), coat 1",
        "no camera given: seen from the front right",
        "warnings: 5",
        "what to do: put the images",
    ):
        assert part in out, out


def test_long_tables_are_cut(capsys, tmp_path):
    triangles = "".join(f"o part{n}\nf 1 2 {3 + n % 2}\n" for n in range(50))
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\n" + triangles)
    assert main(["info", str(tmp_path / "a.obj")]) == 0
    assert "and 10 more: --json lists all" in capsys.readouterr().out
    assert len(info(capsys, tmp_path / "a.obj")["meshes"]) == 50


def test_thumbnail(capsys, tmp_path, monkeypatch):
    import OpenImageIO

    quick = {"size": (16, 12), "passes": 2}
    monkeypatch.setattr("photonmap.commands.info._THUMBNAIL", quick)
    assert main(["convert", f"{FOLDER}/furnace.obj", str(tmp_path / "a.glb"), "--quiet"]) == 0
    assert main(["info", str(tmp_path / "a.glb"), "--thumbnail"]) == 0
    pixels = OpenImageIO.ImageBuf(str(tmp_path / "a-thumbnail.png")).get_pixels()
    assert pixels.shape == (12, 16, 3)
    assert pixels.max() > 0.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.obj"], "none.obj: cannot be read"),
        (["a.xyz"], "is of an unknown kind"),
        ([f"{FOLDER}/furnace.obj", "--thumbnail", "x.jpg"], "must end in .png"),
        ([f"{FOLDER}/furnace.obj", "--thumbnail", "no/x.png"], "the folder no does not exist"),
        ([f"{FOLDER}/furnace.obj", "--camera", "left"], "there is no camera 'left'"),
    ],
)
def test_errors(capsys, monkeypatch, tmp_path, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(["info", *arguments]) == 2
    out, err = capsys.readouterr()
    assert (out, len(err.splitlines())) == ("", 1)
    assert message in err


def test_no_kernel_is_compiled():
    code = (
        "from photonmap.commands.main import main; import numba.core.registry as registry;"
        f"main(['info', '{FOLDER}/cornell_box.obj']);"
        "from photonmap.kernels.integrators import camera_pass as module;"
        "compiled = [k for k in vars(module).values() if getattr(k, 'signatures', ())];"
        "assert not compiled, compiled"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_remedies_fit_the_format():
    """A file of glTF need not be exported as glTF."""
    uv = "no texture coordinates in 'n' of material 'a': the mean of their textures is used"
    assert find_remedy(uv) == "unwrap the meshes, and export texture coordinates"
    lost = "{}: not simulated: texture of metallic of 'gold'"
    assert find_remedy(lost.format("a.xml")).startswith("export it as glTF")
    assert "glTF" not in find_remedy(lost.format("a.gltf"))
    named = find_remedy("a.ply: not simulated: texture of 'skin.png'")
    assert named == "give it as reflectance = { file = … } in [material.default] of a TOML file"


def test_errors_of_a_scene_name_its_file(capsys, tmp_path):
    """Also those that are found when all of it is read; but not those of what code adds to it."""
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    both = 2 * "[[light]]\ntype = 'dome'\n"
    (tmp_path / "a.toml").write_text(both)
    assert main(["info", str(tmp_path / "a.obj")]) == 2
    assert "a.toml: a scene has one dome or environment at most" in capsys.readouterr().err
    (tmp_path / "a.toml").write_text("[[light]]\ntype = 'dome'\nradiance = 0\n")
    assert main(["info", str(tmp_path / "a.obj")]) == 2
    assert "a.toml: all lights are off, being 0" in capsys.readouterr().err
    (tmp_path / "a.toml").write_text("[[light]]\ntype = 'dome'\nname = 'a@b.error'\n")
    given = ["--per-light", "--quiet", "--output", str(tmp_path / "b.exr")]
    assert main([str(tmp_path / "a.obj"), *given]) == 2
    assert "a.toml: light group 'a@b.error' ends as standard" in capsys.readouterr().err
    scene = pm.scenes.cornell_box()
    scene.lights += [pm.DomeLight(), pm.DomeLight()]
    with pytest.raises(pm.InputError, match=r"^a scene has one dome or environment at most"):
        describe_scene(scene, pm.Bands.rgb())
