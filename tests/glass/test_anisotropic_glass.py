"""Rough glass that is rougher along a tangent than across it: bodies, panes and images of it."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm
from photonmap.compile.effects import EFFECTS, leave_out, plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.scene.surfaces.layers import name_kind
from photonmap.spectra.bands import Bands

pytestmark = pytest.mark.filterwarnings("ignore:.*successive reflections")
RGB = Bands.rgb()
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
SEEDS = 6
LOOK = {"roughness": 0.2, "anisotropy": 0.6}
"""α is 0.04 across the tangent, and 0.39 along it"""
GLASS, PANE = pm.Material.glass("glass"), pm.Material.pane("pane")


def texture(*values):
    """Return a texture of these columns."""
    return pm.Texture.of(np.tile(np.array(values, np.float32), (2, 1, 1)))


def ball(material, x=0.0):
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=0.25)
    uv = 2.0 * sphere.vertices[:, :2] + 0.5
    return pm.Mesh(sphere.vertices + [x, -0.4, -0.2], sphere.faces, material, f"ball {x}", uv=uv)


def balls(*materials):
    """Return balls beside each other: one scene, since each set of materials is compiled anew."""
    return [ball(each, -0.6 + 0.6 * place) for place, each in enumerate(materials)]


BRUSH = pm.AnisotropyMap(texture((1.0, 0.5, 1.0), (0.2, 0.9, 0.3)))
MATERIALS = (
    replace(GLASS, **LOOK, tint=(0.9, 0.8, 0.7)),
    replace(PANE, **LOOK, anisotropy_rotation=0.1, tint=(0.8, 0.9, 0.9)),
    replace(GLASS, roughness=texture((0.2,), (0.6,)), anisotropy=0.8, anisotropy_map=BRUSH),
)


def room(*materials):
    corners = (-0.4, 0.9, -0.4), (0.4, 0.9, -0.4), (0.4, 0.9, 0.4), (-0.4, 0.9, 0.4)
    lamp = quad(*corners, pm.Material("lamp", 0.0, 20.0), "lamp")
    camera = pm.Camera((0.0, 0.1, 0.95), (0.0, -0.2, -1.0), fov=80.0)
    bulb = pm.PointLight((0.5, 0.5, 0.5), 0.3)
    return pm.Scene([closed_box(GREY), lamp, *balls(*materials)], [bulb], camera)


def window(look, uv=((0, 0), (1, 0), (1, 1), (0, 1))):
    """A lamp behind a frosted pane: u rises along x, and v along y."""
    lamp = quad((-0.1, -0.1, 0), (0.1, -0.1, 0), (0.1, 0.1, 0), (-0.1, 0.1, 0),
                pm.Material("lamp", 0.0, 1.0), "lamp")  # fmt: skip
    corners = np.array([[-9, -9, 1], [9, -9, 1], [9, 9, 1], [-9, 9, 1]], float)
    pane = pm.Mesh(corners, [[0, 1, 2], [0, 2, 3]], replace(PANE, **look), "pane", uv=uv)
    return pm.Scene([lamp, pane], camera=pm.Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), fov=60.0))


def spread(look, **mesh):
    """Return the mean of x² and of y² over the light in the picture."""
    settings = {"bands": 1, "size": (24, 24), "passes": 8, "seed": 3, "photons": 500}
    image = pm.render(window(look, **mesh), **settings).direct[..., 0].astype(float)
    squares = (np.arange(24) - 11.5) ** 2
    return np.array([image.sum(axis=0) @ squares, image.sum(axis=1) @ squares]) / image.sum()


def test_light_spreads_along_the_tangent():
    """And as an even pane spreads it by either α, where the lamp is seen straight on."""
    x, y = spread(LOOK)
    assert x > 5.0 * y
    np.testing.assert_allclose(spread(LOOK | {"anisotropy_rotation": 0.25}), (y, x), rtol=0.05)
    np.testing.assert_allclose(spread(LOOK, uv=((0, 0), (0, 1), (1, 1), (1, 0))), (y, x), rtol=0.05)
    brush = {"anisotropy_map": pm.AnisotropyMap(texture((0.5, 1.0, 0.5))), "anisotropy": 1.0}
    half = {"anisotropy": 0.5, "anisotropy_rotation": 0.25}
    np.testing.assert_allclose(spread(LOOK | brush), spread(LOOK | half), rtol=0.05)
    aslant = spread(LOOK | {"anisotropy_rotation": 0.125})
    assert aslant[0] == pytest.approx(aslant[1], rel=0.05)
    assert y < aslant[0] < x


def test_what_is_alike_in_all_directions_has_no_record():
    even = replace(GLASS, roughness=0.4)
    compiled = compile_scene(room(even), RGB)
    assert compiled.specular.anisotropy is None
    metal = pm.Material.metal("brushed", roughness=0.5)
    compiled = compile_scene(room(even, replace(metal, anisotropy=0.5)), RGB)
    assert compiled.specular.anisotropy is None
    assert compiled.scattering.anisotropy is not None
    for look in ({"anisotropy": 0.0, "anisotropy_rotation": 0.3}, {"anisotropy": 0.5, "ior": 1.0}):
        compiled = compile_scene(room(replace(GLASS, **look)), RGB)
        assert compiled.specular.alpha.size == 0
        assert compiled.specular.anisotropy is None


def test_the_record_of_anisotropic_glass():
    plain = pm.Material.metal("metal", roughness=0.5)
    compiled = compile_scene(room(*MATERIALS, plain), RGB)
    specular, names = compiled.specular, compiled.material_names
    rows = [place for place, name in enumerate(names) if name in ("glass", "pane")]
    np.testing.assert_allclose(specular.anisotropy.stretch[rows], [0.36, 0.36, 0.64])
    np.testing.assert_allclose(specular.alpha[rows], [0.04, 0.04, 0.16])
    assert (specular.maps.anisotropy[rows] >= 0).tolist() == [False, False, True]
    assert specular.anisotropy.stretch[names.index("metal")] == 0.0
    assert compiled.scattering.anisotropy is None
    assert len(compiled.scattering.albedos) > names.index("metal") + 1, "no next row to look up"
    assert name_kind(MATERIALS[0]) == "rough glass"
    assert name_kind(replace(PANE, anisotropy=0.5)) == "rough thin glass"
    assert not replace(PANE, anisotropy=0.5).is_pane


def test_effects_leave_it_out():
    compiled = compile_scene(room(*MATERIALS), RGB)
    for left_out, there in (("glossy", False), ("textures", True)):
        plan = plan_effects(compiled, frozenset(EFFECTS) - {left_out}, 3, 3)
        specular = leave_out(compiled, plan).specular
        assert ((specular is not None) and specular.anisotropy is not None) == there


def test_the_buffer_of_roughness_is_that_across():
    scene = room(*MATERIALS[:2])
    roughness = pm.render(scene, **SMALL, passes=1, buffers=["roughness"])["roughness"]
    is_glass = np.isclose(roughness, 0.2)
    assert is_glass.any()
    assert (roughness[~is_glass] == 1.0).all()


@pytest.mark.filterwarnings("ignore:textures of opacity")  # rounded to 16 bits
@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_files_keep_it(suffix, tmp_path):
    pm.save_scene(room(MATERIALS[1], MATERIALS[2]), tmp_path / f"scene{suffix}")
    found = [each.material for each in pm.load_scene(tmp_path / f"scene{suffix}").meshes]
    pane, glass = (each for each in found if each.ior is not None)
    assert (pane.thin, pane.roughness, pane.anisotropy) == pytest.approx((True, 0.2, 0.6))
    assert pane.anisotropy_rotation == pytest.approx(0.1)
    assert glass.anisotropy == pytest.approx(0.8)
    assert isinstance(glass.roughness, pm.Texture)
    np.testing.assert_allclose(
        glass.anisotropy_map.texture.image.linear(slice(None), slice(None)),
        BRUSH.texture.image.texels,
        atol=2e-5,
    )


def test_a_section_makes_glass_anisotropic(tmp_path):
    """Of a brushed metal that a section makes glass, the grain goes with the gloss."""
    brushed = replace(pm.Material.metal("metal"), anisotropy=0.5)
    pm.save_scene(room(brushed), tmp_path / "scene.obj")
    for more, anisotropy in (("", 0.0), ("roughness = 0.2\nanisotropy = 0.6\n", 0.6)):
        (tmp_path / "scene.toml").write_text(f"[material.metal]\nior = 1.5\n{more}")
        found = pm.load_scene(tmp_path / "scene.obj").meshes[-1].material
        assert (found.ior, found.anisotropy) == (1.5, anisotropy)
        assert found.is_anisotropic == (anisotropy > 0.0)
