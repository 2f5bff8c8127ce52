"""Textures of roughness and of glossy reflectances: against even ones, in pictures and buffers."""

from dataclasses import replace

import numpy as np
import pytest
from bsdf_harness import Case, departure, evaluate, hemisphere
from helpers.scenes import GREY, closed_box, quad

import photonmap as pm
from photonmap.compile.effects import plan_effects
from photonmap.compile.scene_arrays import compile_scene
from photonmap.errors import InputError
from photonmap.spectra.bands import Bands

UV = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
SMALL = {"bands": 3, "size": (12, 12), "threads": 2}
LEFT, RIGHT = 0.3, 0.7
"""Roughness of the two halves."""
DARK, BRIGHT = (0.04, 0.05, 0.06), (0.9, 0.7, 0.3)
"""At normal incidence; coloured, for numbers that are not follow Fresnel's equations."""


def halves(left, right):
    """Return a texture whose halves meet in a sharp edge."""
    texels = np.empty((1, 64, 3), np.float32)
    texels[:, :32], texels[:, 32:] = left, right
    return pm.Texture.of(texels, clamp=True)


def table(x0, x1, material, uv=None):
    mesh = quad((x0, -0.9, -0.9), (x0, -0.9, 0.9), (x1, -0.9, 0.9), (x1, -0.9, -0.9),
                material, "table")  # fmt: skip
    return mesh if uv is None else replace(mesh, uv=uv)


def room(*tables):
    lamp = quad((-0.6, 0.9, -0.8), (-0.2, 0.9, -0.8), (-0.2, 0.9, -0.4), (-0.6, 0.9, -0.4),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    camera = pm.Camera((0.0, 0.5, 0.95), (0.0, -0.9, -0.3), fov=80.0)
    return pm.Scene([closed_box(GREY), lamp, *tables], camera=camera)


TEXTURED = pm.Material(
    "textured",
    halves(0.6, 0.1),
    glossy=halves(DARK, BRIGHT),
    roughness=halves(LEFT, RIGHT),
)
PARTS = [
    pm.Material("left", (0.6,) * 3, glossy=DARK, roughness=LEFT),
    pm.Material("right", (0.1,) * 3, glossy=BRIGHT, roughness=RIGHT),
]
TURNED = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]])


def textured_room():
    return room(table(-0.9, 0.9, TEXTURED, TURNED))


def parted_room():
    return room(table(-0.9, 0.0, PARTS[0]), table(0.0, 0.9, PARTS[1]))


@pytest.mark.parametrize("alpha", [0.25, 0.01])
def test_an_even_texture_is_the_number(alpha):
    """At a step of the table to the digits of float32; between two, interpolated."""
    wi, _ = hemisphere(0.5)
    plain = Case("glossy", (alpha,), (0.2, 0.5, 0.8), (0.04, 0.3, 0.9))
    values, density = evaluate(plain, wi, departure(0.5))
    found, drawn = evaluate(plain._replace(is_textured=True), wi, departure(0.5))
    exact = alpha == 0.25
    scale = 1e-5 if exact else 5e-3
    np.testing.assert_allclose(found, values, rtol=scale, atol=scale * 0.05)
    np.testing.assert_allclose(drawn, density, rtol=2 * scale, atol=scale * 0.05)


def test_buffers_show_the_textures():
    names = ("roughness", "metallic", "specular_reflectance", "diffuse_fraction")
    settings = SMALL | {"size": (24, 24), "passes": 1, "buffers": names}
    found, truth = (pm.render(scene, **settings) for scene in (textured_room(), parted_room()))
    seen = truth.roughness < 1.0
    np.testing.assert_allclose(np.unique(truth.roughness[seen]), [LEFT, RIGHT], rtol=1e-6)
    for name in names:
        ours, theirs = found.buffers[name], truth.buffers[name]
        differs = ~np.isclose(ours, theirs, atol=2e-3)
        columns = np.unique(np.nonzero(differs)[1])
        assert set(columns) <= {11, 12}, name  # texels are interpolated where the halves meet
    np.testing.assert_array_equal(found.roughness[~seen], 1.0)


def test_left_out_textures_become_their_means():
    compiled = compile_scene(textured_room(), Bands.rgb())
    assert plan_effects(compiled, "auto", 3, 3).on("textures")
    bare = pm.render(textured_room(), **SMALL, passes=1, effects="direct,glossy")
    mean = replace(TEXTURED, reflectance=(0.35,) * 3, glossy=(0.47, 0.375, 0.18), roughness=0.5)
    plain = pm.render(
        room(table(-0.9, 0.9, mean)), **SMALL, passes=1, effects="direct,glossy"
    )  # fmt: skip
    np.testing.assert_allclose(bare.direct, plain.direct, rtol=1e-5)


def test_scenes_without_textured_lobes_have_no_tables_of_them():
    compiled = compile_scene(parted_room(), Bands.rgb())
    assert compiled.scattering.maps is None
    assert len(compiled.scattering.albedos) == len(compiled.material_names)


@pytest.mark.parametrize(
    ("material", "message"),
    [
        (pm.Material.metal(roughness=halves(0.1, 1.2)), "roughness: the texture reaches 1.2"),
        (pm.Material.metal(glossy=halves(0.1, 1.2)), "glossy: the texture reaches 1.2"),
    ],
)
def test_bad_textures(material, message):
    with pytest.raises(InputError, match=message):
        compile_scene(room(table(-0.9, 0.9, material, UV)), Bands.rgb())
