"""Metallic fractions in code, TOML, MTL and glTF: the same numbers make the same arrays."""

import numpy as np
import pytest
from helpers.meshes import TRIANGLE

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.runtime.fingerprint import digest
from photonmap.spectra.bands import Bands

COLOR = (0.8, 0.4, 0.2)
UV = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]


def arrays(material):
    """Return a digest of all arrays of a material, in five bands."""
    mesh = pm.Mesh(TRIANGLE, [[0, 1, 2]], material, uv=UV)
    compiled = compile_scene(pm.Scene([mesh], [pm.DomeLight(1.0)]), Bands.parse(5))
    return digest((compiled.materials, compiled.specular, compiled.scattering, compiled.textures))


@pytest.mark.parametrize("roughness", [0.1, 0.4])
@pytest.mark.parametrize("metallic", [0.0, 0.3, 1.0])
def test_code_makes_what_files_make(metallic, roughness, wall, read, build):
    made = pm.Material.metallic_roughness("wall", COLOR, metallic, roughness)
    keys = f"reflectance = {list(COLOR)}\nroughness = {roughness}\nmetallic = {metallic}"
    build.primitive(TEXCOORD_0=UV, more={"material": 0})
    factors = {"metallicFactor": metallic, "roughnessFactor": roughness}
    factors["baseColorFactor"] = [*COLOR, 1.0]
    build.tree["materials"] = [{"name": "wall", "pbrMetallicRoughness": factors}]
    [mesh] = read("wall.glb", build.glb())
    assert wall(keys) == mesh.material == made
    assert arrays(wall(keys)) == arrays(mesh.material) == arrays(made)


def test_images_of_it_do_so_too(wall, tmp_path):
    image = '{ file = "a.png" }'
    found = wall(f"reflectance = {image}\nroughness = 0.3\nmetallic = {image}")
    color = pm.Texture.read(tmp_path / "a.png")
    share = pm.Texture.read(tmp_path / "a.png", linear=True)
    made = pm.Material.metallic_roughness("wall", color, share, 0.3)
    assert arrays(found) == arrays(made)


def test_keys_of_toml_and_statements_of_mtl(wall, tmp_path):
    """A share of metal of the surface's colour; the rest is a base of it, below a coat."""
    half = wall("reflectance = [0.8, 0.4, 0.2]\nroughness = 0.3\nmetallic = 0.5")
    assert half.reflectance == (0.4, 0.2, 0.1)
    np.testing.assert_allclose(half.glossy, np.array((0.4, 0.2, 0.1)) + 0.5 * 0.04, rtol=1e-12)
    whole = wall("reflectance = [0.8, 0.4, 0.2]\nroughness = 0.3\nmetallic = 1\nglossy = 0.1")
    assert (whole.reflectance, whole.glossy) == ((0.0,) * 3, (0.8, 0.4, 0.2))
    plastic = wall("roughness = 0.3\nmetallic = 0")
    assert (plastic.reflectance, plastic.roughness) == ((0.5,) * 3, 0.3)
    assert plastic.glossy == pytest.approx(0.04)
    image = 'file = "a.png"'
    found = wall(f"reflectance = {{ {image} }}\nroughness = 0.3\nmetallic = {{ {image} }}")
    mtl = tmp_path / "a.mtl"
    mtl.write_text("newmtl wall\nmap_Kd a.png\nPr 0.3\nmap_Pm a.png\n")
    wanted = wall("")
    assert found.roughness == wanted.roughness == 0.3
    for name in ("reflectance", "glossy"):
        ours, theirs = (getattr(look, name).image.texels for look in (found, wanted))
        np.testing.assert_array_equal(ours, theirs)


def test_metal_and_plastic_are_its_ends():
    whole = pm.Material.metallic_roughness("a", 0.7, 1.0, 0.3)
    assert arrays(whole) == arrays(pm.Material.metal("a", 0.7, 0.3))
    none = pm.Material.metallic_roughness("a", 0.7, 0.0, 0.3, ior=1.4)
    assert none == pm.Material.plastic("a", 0.7, 1.4, 0.3)


def test_whole_and_list_and_array_are_taken():
    wanted = pm.Material.metallic_roughness("a", COLOR, 1.0)
    for color in (list(COLOR), np.array(COLOR)):
        assert pm.Material.metallic_roughness("a", color, 1) == wanted


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        ({"metallic": 1.5}, "material 'a': metallic: 1.5 is not a metallic fraction; .* 0 to 1"),
        ({"base_color": "red"}, "material 'a': base_color: 'red' is not a reflectance; give a num"),
        ({"ior": 0.5}, "material 'a': ior: 0.5 is not an index of refraction"),
        (
            {"base_color": pm.SpectralTexture.from_palette(np.zeros((1, 1), np.int32), [0.4])},
            "material 'a': metallic: a reflectance of many spectra",
        ),
    ],
)
def test_bad_numbers_name_the_material(arguments, fault):
    with pytest.raises(InputError, match=fault):
        pm.Material.metallic_roughness("a", **arguments)
