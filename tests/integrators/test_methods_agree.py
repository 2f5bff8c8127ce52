"""Photons and paths bring the same light, whatever surfaces are made of.

A room has up to four materials of one kind, which share code: each is a quarter of the image.
"""

from dataclasses import replace

import numpy as np
import pytest
from helpers.marks import slow
from helpers.passes import assert_methods_agree, excess, pass_means
from helpers.scenes import ball_room

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.core.records import METAL
from photonmap.scene import material as materials
from photonmap.spectra.bands import Bands

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*successive reflections"),
    pytest.mark.filterwarnings("ignore:.*photons were truncated"),
]
"""Nearly smooth facets keep some light in a ball for long."""

BULB = pm.PointLight((0.0, 0.4, 0.6), 0.3)
"""That no walk ever meets: its light comes by light samples alone."""
GLASS, PANE = pm.Material.glass(), pm.Material.pane()
GOLD = (0.95, 0.8, 0.5)
TINT = (0.9, 0.8, 0.7)


def image(seed, channels=1, low=0.0):
    return pm.Texture.of(np.random.default_rng(seed).uniform(low, 1.0, (8, 8, channels)))


BRUSH = pm.AnisotropyMap(
    pm.Texture.of(np.tile(np.array([(1.0, 0.5, 1.0), (0.2, 0.9, 0.3)], np.float32), (2, 1, 1)))
)
CAR = pm.Material("car", (0.2, 0.4, 0.7), glossy=0.04, roughness=0.4, coat=0.8)
JELLY = replace(GLASS, attenuation_color=(0.8, 0.5, 0.1), attenuation_distance=0.3)
STRETCHED = {"roughness": 0.2, "anisotropy": 0.6}
"""α is 0.04 across the tangent, and 0.39 along it."""
NARROW = [pm.Material.metal(glossy=GOLD, roughness=r) for r in np.sqrt([0.01, 0.05, 0.09])]
ROOMS = {
    "frosted glass": [
        replace(GLASS, roughness=roughness, tint=TINT) for roughness in (0.1, 0.3, 0.7, 1.0)
    ],
    "frosted panes": [
        replace(PANE, roughness=roughness, tint=TINT) for roughness in (0.1, 0.4, 0.6, 0.9)
    ],
    "narrow metal": NARROW,
    "metal": [pm.Material.metal("metal", GOLD, roughness) for roughness in (0.35, 0.5, 0.7, 1.0)],
    "plastic": [
        pm.Material.plastic("plastic", 0.6, 1.5, roughness) for roughness in (0.0, 0.1, 0.4, 1.0)
    ],
    "coats and sheens": [
        pm.Material("car", 0.0, glossy=(0.9, 0.3, 0.2), roughness=0.5, coat=1.0),
        pm.Material("tile", (0.2, 0.4, 0.7), coat=0.6, coat_roughness=0.4),
        pm.Material("velvet", (0.5, 0.1, 0.1), sheen=(0.8, 0.4, 0.6), sheen_roughness=0.4),
        pm.Material("satin", 0.3, glossy=0.04, roughness=0.4, sheen=0.7, sheen_roughness=0.3),
    ],
    "images": [
        replace(
            CAR,
            coat_roughness=image(3, low=0.1),
            relief=pm.BumpMap(image(4), 0.02),
            coat_relief=pm.NoRelief(),
        ),
        pm.Material("gloss", image(5, 3), glossy=image(6, 3), roughness=image(7, low=0.2)),
        replace(pm.Material.metal(glossy=GOLD, roughness=0.4), anisotropy=0.8),
    ],
    "anisotropic glass": [
        replace(GLASS, **STRETCHED, tint=TINT),
        replace(PANE, **STRETCHED, anisotropy_rotation=0.1, tint=TINT),
        replace(GLASS, roughness=image(2, low=0.2), anisotropy=0.8, anisotropy_map=BRUSH),
    ],
    "varied glass": [
        replace(GLASS, tint=image(4, 3, 0.5), roughness=image(5)),
        replace(GLASS, transmission=image(6), reflectance=GOLD, glossy=0.04, roughness=0.4),
        replace(PANE, tint=image(7, 3), transmission=0.6, reflectance=0.5),
    ],
    "smooth": [
        replace(GLASS, tint=TINT),
        replace(PANE, tint=TINT),
        JELLY,
        pm.Material("nickel", 0.0, mirror=pm.reflectance("metal:Ni")),
    ],
    "dispersion and absorption": [
        replace(GLASS, ior=1.6, abbe=6.0),
        replace(GLASS, ior=1.6, abbe=6.0, roughness=0.4),
        replace(JELLY, roughness=0.4),
    ],
}
PASSES = {"frosted glass": (20, 200), "anisotropic glass": (12, 80)}
PASSES |= dict.fromkeys(("frosted panes", "narrow metal"), (12, 100))
PASSES |= dict.fromkeys(("varied glass", "smooth", "dispersion and absorption"), (13, 75))
"""Of photons and of paths: more where few of them bring much of the light."""
SLOW = ("frosted glass", "varied glass")
"""Others share their code: anisotropic glass and frosted panes."""
LIT_BY_A_LAMP_ALONE = ("smooth", "varied glass", "dispersion and absorption")
"""Paths find no caustics of bulbs by smooth glass."""


@pytest.mark.parametrize("name", [slow(name)[0] if name in SLOW else name for name in ROOMS])
def test_balls(name):
    lights = [] if name in LIT_BY_A_LAMP_ALONE else [BULB]
    bands = "box:3" if "dispersion" in name else "rgb"
    passes = PASSES.get(name, (8, 60))
    assert_methods_agree(ball_room(*ROOMS[name], lights=lights), *passes, bands=bands)


WALLS = {
    "rough": pm.Material("wall", 0.6, diffuse_roughness=1.0),
    "plastic": pm.Material("wall", (0.6, 0.5, 0.3), glossy=0.04, roughness=1.0),
    "glossy": pm.Material("wall", (0.6, 0.5, 0.3), glossy=0.3, roughness=0.5),
}


def leaning():
    """Walls whose normals lean to all sides by up to 40°, in which light goes to and fro."""
    angle, azimuth = np.random.default_rng(3).uniform(
        [[[0.0]], [[0.0]]], [[[0.7]], [[6.3]]], (2, 8, 8)
    )
    x, y, z = np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)
    normals = 0.5 + 0.5 * np.stack([x, y, z], axis=2)
    relief = pm.NormalMap(pm.Texture.of(normals.astype(np.float32)))
    return pm.Material("wall", 0.5, relief=relief)


@pytest.mark.parametrize("name", WALLS)
def test_walls(name):
    """Between which light goes to and fro; beside rough ones, glass."""
    balls = [GLASS] if name == "rough" else []
    assert_methods_agree(ball_room(*balls, walls=WALLS[name]), 8, 60)


def test_walls_with_relief():
    """Veach's adjoint factor makes photons see the turned normals as paths do."""
    room = ball_room(walls=leaning())
    box = room.meshes[0].split_corners()
    box = replace(box, uv=box.vertices[:, :2] + box.vertices[:, 1:])
    assert_methods_agree(replace(room, meshes=[box, *room.meshes[1:]]))


def test_walls_of_another_material_are_noticed():
    """By the same comparison: walls that reflect 3% less, or are smooth in place of rough."""
    rough = WALLS["rough"]
    paths = pass_means(ball_room(walls=rough), "path", 100)
    for change in ({"reflectance": 0.97 * 0.6}, {"diffuse_roughness": 0.0}):
        room = ball_room(walls=replace(rough, **change))
        assert excess(pass_means(room, "photon", 12), paths) > 0.0


def test_narrow_metal_is_a_glossy_surface(monkeypatch):
    """Which walks follow, or whose lobe is sampled."""
    room = ball_room(*NARROW, lights=[BULB])
    assert METAL in compile_scene(room, Bands.rgb()).specular.kind
    narrow = pass_means(room, "path", 200)
    monkeypatch.setattr(materials, "NARROW_ALPHA", 0.0)
    assert compile_scene(room, Bands.rgb()).specular is None
    assert excess(narrow, pass_means(room, "path", 200, seed=2), bias=0.0) <= 0.0
