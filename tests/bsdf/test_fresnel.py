"""Fresnel's equations of plastic, varnish and clear coats, and which lobes follow them."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.scenes import quad
from test_metals import born_wolf

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.core import fresnel
from photonmap.scene.surfaces.fresnel import SCHLICK_MEAN, lobe_index, mean_rise, rise
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
COSINES = np.linspace(0.0, 1.0, 201)[1:]
PLASTIC = pm.Material.plastic("plate", 0.3, 1.5, 0.3)


@pytest.mark.parametrize("index", [0.0, 1.0, 1.2, 1.5, 3.0])
def test_kernels_and_tables_rise_alike(index):
    found = [fresnel.rise(cosine, index) for cosine in COSINES.tolist()]
    np.testing.assert_allclose(found, rise(COSINES, index), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("index", [1.2, 1.5, 3.0])
def test_reflectance_is_that_of_maxwells_equations(index):
    f0 = ((index - 1.0) / (index + 1.0)) ** 2
    reflectance = f0 + (1.0 - f0) * rise(COSINES, index)
    np.testing.assert_allclose(reflectance, born_wolf(index, 0.0, COSINES), rtol=1e-9)


def test_without_an_index_it_is_schlicks_formula():
    np.testing.assert_allclose(rise(COSINES, 0.0), (1.0 - COSINES) ** 5)
    assert mean_rise(0.0) == SCHLICK_MEAN


def test_mean_over_all_angles():
    """0.0918 of index 1.5: D. B. Judd, "Fresnel reflection of diffusely incident light", 1942."""
    assert 0.04 + 0.96 * mean_rise(1.5) == pytest.approx(0.0918, abs=5e-5)
    fine = (np.arange(200_000) + 0.5) / 200_000
    for index in (1.1, 1.5, 2.5):
        assert mean_rise(index) == pytest.approx(2.0 * (fine * rise(fine, index)).mean(), abs=1e-6)


@pytest.mark.parametrize("index", [1.0, 1.3, 1.5, 2.4])
def test_index_of_a_reflectance(index):
    assert lobe_index(((index - 1.0) / (index + 1.0)) ** 2) == pytest.approx(index, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "index"),
    [
        ({}, 1.5),
        ({"glossy": (0.04, 0.04, 0.04)}, 1.5),
        ({"glossy": 0.25}, 3.0),
        ({"glossy": 0.3}, 0.0),
        ({"glossy": (0.04, 0.05, 0.06)}, 0.0),
        ({"glossy_edge": 0.5}, 0.0),
        ({"glossy": pm.Texture.of(np.full((2, 2, 3), 0.04, np.float32))}, 0.0),
    ],
)
def test_which_lobes_are_those_of_dielectrics(change, index):
    scene = plate(replace(PLASTIC, **change), 0.0)
    found = compile_scene(scene, RGB).scattering.parameters[0, 3]
    assert found == pytest.approx(index, abs=1e-4)


def plate(look, degrees):
    """Return a plate below an even sky, seen from an angle to its normal."""
    corners, angle = ((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), np.radians(degrees)
    origin = 0.0, 20.0 * np.cos(angle), 20.0 * np.sin(angle)
    camera = pm.Camera(origin, (0, 0, 0), (0.0, 1.0, -1.0), 0.05)
    mesh = replace(quad(*corners, look, "plate"), uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]))
    return pm.Scene([mesh], [pm.DomeLight(1.0)], camera)


@pytest.mark.parametrize("degrees", [0, 60, 80, 86])
@pytest.mark.parametrize("index", [1.3, 1.5, 2.0])
def test_smooth_plastic_under_a_sky(index, degrees):
    """Over a base that is nearly black; Schlick's formula differs by up to 0.06 at these angles."""
    scene = plate(pm.Material.plastic("plate", 1e-6, index, 0.0), degrees)
    result = pm.render(scene, bands="rgb", size=(4, 4), passes=8, threads=2)
    expected = born_wolf(index, 0.0, np.cos(np.radians(degrees)))
    assert result.radiance.mean() == pytest.approx(expected, abs=0.003)


@pytest.mark.parametrize("degrees", [60, 80])
def test_smooth_coats_under_a_sky(degrees):
    """A black base below a clear coat shows the coat alone."""
    look = pm.Material("plate", 0.0, coat=1.0, coat_roughness=0.0, coat_ior=1.5)
    result = pm.render(plate(look, degrees), bands="rgb", size=(4, 4), passes=8, threads=2)
    expected = born_wolf(1.5, 0.0, np.cos(np.radians(degrees)))
    assert result.radiance.mean() == pytest.approx(expected, abs=0.003)


def test_roughness_by_an_image_is_that_by_a_number():
    """Each index has steps of roughness of its own: of two plastics and a coat."""
    image = pm.Texture.of(np.full((2, 2, 3), 0.5, np.float32))
    looks = [
        pm.Material.plastic("plate", 0.3, 1.3, 0.5),
        pm.Material.plastic("plate", 0.3, 2.0, 0.5),
        pm.Material("plate", 0.3, coat=1.0, coat_roughness=0.5, coat_ior=1.7),
    ]
    by_image = [
        replace(look, coat_roughness=image) if look.is_coated else replace(look, roughness=image)
        for look in looks
    ]
    hidden = [
        replace(
            plate(look, 0).meshes[0],
            vertices=plate(look, 0).meshes[0].vertices - [0.0, 50.0 + place, 0.0],
            material=replace(look, name=f"hidden {place}"),
        )
        for place, look in enumerate(by_image)
    ]
    for look, varied in zip(looks, by_image, strict=True):
        scene = plate(varied, 75)
        scene = replace(scene, meshes=[*hidden, *scene.meshes])
        one, two = (
            pm.render(each, bands="rgb", size=(4, 4), passes=16, threads=2).radiance.mean()
            for each in (plate(look, 75), scene)
        )
        assert two == pytest.approx(one, rel=0.01)
