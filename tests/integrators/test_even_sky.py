"""What is white vanishes in an even sky: light samples and walks add up to all of it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.scenes import ball

import photonmap as pm

pytestmark = pytest.mark.filterwarnings("ignore:.*successive reflections")
GLASS, PANE = pm.Material.glass(), pm.Material.pane()
STRETCHED = {"roughness": 0.2, "anisotropy": 0.6}
FELT = pm.Material("felt", 1.0, sheen=(1.0, 0.3, 0.6), sheen_roughness=0.3)
WHITE = {"reflectance": 1.0, "glossy": 0.04}


def image(*values):
    """Return a texture of these columns."""
    return pm.Texture.of(np.tile(np.array(values, np.float32), (2, 1, 1)))


def noise(seed):
    return pm.Texture.of(np.random.default_rng(seed).uniform(0.0, 1.0, (8, 8, 1)))


BRUSH = pm.AnisotropyMap(image((1.0, 0.5, 1.0), (0.2, 0.9, 0.3)))
SKIES = {
    "frosted glass": [
        replace(GLASS, roughness=r, ior=i)
        for r, i in ((0.05, 2.5), (0.3, 1.1), (0.3, 2.5), (1.0, 1.5))
    ],
    "frosted panes": [
        replace(PANE, roughness=r, ior=i) for r in (0.05, 0.4, 1.0) for i in (1.1, 2.5)
    ],
    "surfaces": [
        pm.Material.metal(glossy=1.0, roughness=0.05),
        pm.Material.metal(glossy=1.0, roughness=0.3),
        pm.Material.plastic(reflectance=1.0, roughness=0.5),
        FELT,
    ],
    "anisotropic glass": [
        replace(GLASS, **STRETCHED),
        replace(PANE, **STRETCHED, anisotropy_rotation=0.1),
        replace(
            GLASS, roughness=image((0.2,), (0.6,)), anisotropy=0.8, anisotropy_map=BRUSH, ior=2.5
        ),
    ],
    "glass in part": [
        replace(GLASS, transmission=0.4, **WHITE),
        replace(GLASS, transmission=noise(1), roughness=noise(2), **WHITE),
        replace(PANE, transmission=noise(3), reflectance=1.0),
    ],
    "dispersion": [replace(GLASS, ior=1.6, abbe=6.0, roughness=r) for r in (0.0, 0.5)],
}
SKEWED = ("frosted glass", "frosted panes", "anisotropic glass")
"""Few walks make most of the light: it takes many passes before their spread shows its error."""
BY_PATHS_ALONE = "glass in part"
"""Photons linger within white walls."""


def assert_vanishes(materials, method, passes):
    """Assert that each ball is as bright as the sky: 4 standard errors of the mean, 0.3%."""
    materials = [replace(each, name=f"white {place}") for place, each in enumerate(materials)]
    balls = [
        ball(each, (place % 3 - 1.0, place // 3 - 1.0, 0.0), 0.45, name=f"ball {place}")
        for place, each in enumerate(materials)
    ]
    camera = pm.Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), height=3.0)
    scene = pm.Scene(balls, [pm.DomeLight(0.7)], camera)
    bands = "box:4" if materials[0].abbe else "rgb"
    result = pm.render(
        scene, bands=bands, size=(24, 24), passes=passes, photons=1000, method=method
    )
    for place in range(len(balls)):
        inside = (result.object_id == place + 1) & (result.coverage == 1.0)
        value, error = result.radiance[inside], result.errors["radiance"][inside].astype(float)
        assert inside.sum() > 20
        error = np.sqrt((error**2).sum()) / error.size
        assert error < 0.012 * 0.7
        assert abs(value.mean(dtype=float) - 0.7) < 4.0 * error + 0.003 * 0.7


@pytest.mark.parametrize(("method", "passes"), [("photon", 8), ("path", 48)])
@pytest.mark.parametrize("name", SKIES)
def test_white_balls(name, method, passes):
    if (name, method) != (BY_PATHS_ALONE, "photon"):
        assert_vanishes(SKIES[name], method, passes * (2 if name in SKEWED else 1))
