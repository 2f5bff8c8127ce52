"""The diffuse base of glossy surfaces, which the radiosity cache holds, and the lobe beside it."""

import numpy as np
import pytest
from bsdf_harness import (
    CASES,
    COSINES,
    NORMAL,
    departure,
    evaluate,
    hemisphere,
    make_scene,
    number_of,
)
from helpers.scenes import closed_box, quad
from test_rough_renders import block_means, excess

import photonmap as pm
from photonmap.kernels.bsdf import glossy, glossy_base, models
from photonmap.kernels.core import rng, vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import Hit, SurfaceInteraction
from photonmap.kernels.integrators.cached_base import fill_base_flux, has_base

HELD = [case for case in CASES if number_of(case) == models.GLOSSY and np.mean(case.albedo) > 0.0]
SAMPLES = 50_000
each_held = pytest.mark.parametrize(
    "case", HELD, ids=lambda case: f"{case.parameters}-{case.index}"
)


@kernel
def split_bsdf(scene, n, wi, wo, flux, passed, base, lobe):
    """Fill base and lobe, (n, N): what cells and paths say of the BSDF between directions."""
    hit = Hit(0, 0.3, 0.3, 1.0)
    for i in range(len(wi)):
        arrival, departing = vec.scale(vec.row(wi, i), -2.0), vec.scale(vec.row(wo, i), -2.0)
        at = SurfaceInteraction((0.0, 0.0, 0.0), n, n, 0, hit, arrival, models.GLOSSY)
        fill_base_flux(scene, scene.scattering, at, 1.0, flux, base[i])
        maps = scene.scattering.maps
        found = glossy.lobe_at(scene.geometry, scene.scattering, maps, hit)
        passed[:] = 1.0
        glossy_base.pass_lobe(scene.scattering, maps, found, vec.row(wo, i), n, passed)
        for band in range(base.shape[1]):
            base[i, band] *= passed[band] / np.pi
        at = SurfaceInteraction((0.0, 0.0, 0.0), n, n, 0, hit, departing, models.LOBE)
        models.evaluate(scene, scene.scattering, at, vec.row(wi, i), lobe[i])


@kernel
def sample_lobe(scene, n, wo, values, weights):
    """Fill values, (n, N), with the lobe in directions drawn by it, times weights, (n,)."""
    hit, arrival = Hit(0, 0.3, 0.3, 1.0), vec.scale(wo, -2.0)
    surface = SurfaceInteraction((0.0, 0.0, 0.0), n, n, 0, hit, arrival, models.LOBE)
    state = rng.stream(3, 0, 0)
    for i in range(len(values)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        wi = models.sample(scene.geometry, scene.scattering, surface, u, v)
        density = models.pdf(scene.geometry, scene.scattering, surface, wi)
        models.evaluate(scene, scene.scattering, surface, wi, values[i])
        weights[i] = vec.dot(wi, n) / density if density > 0.0 else 0.0


def split(case, wi, wo):
    wi, shape = np.ascontiguousarray(wi), (len(wi), len(case.albedo))
    wo = np.ascontiguousarray(np.broadcast_to(wo, wi.shape))
    base, lobe = np.empty((2, *shape), np.float32)
    flux, passed = np.ones((2, shape[1]), np.float32)
    split_bsdf(make_scene(case), NORMAL, wi, wo, flux, passed, base, lobe)
    return base, lobe


def test_which_surfaces_have_one():
    for case in CASES:
        scene = make_scene(case)
        held = has_base(scene.geometry, scene.scattering, 0)
        assert held == (case in HELD)


@each_held
@pytest.mark.parametrize("cosine", COSINES)
def test_base_and_lobe_are_the_bsdf(case, cosine):
    wi, wo = hemisphere(cosine, 6, 12)[0], departure(cosine, 0.7)
    base, lobe = split(case, wi, wo)
    np.testing.assert_allclose(base + lobe, evaluate(case, wi, wo)[0], rtol=2e-5, atol=1e-7)
    assert (base > 0.0).all()


@each_held
@pytest.mark.parametrize("cosine", COSINES)
def test_paths_that_go_on_bring_the_lobe(case, cosine):
    wo = departure(cosine)
    values, weights = np.empty((SAMPLES, len(case.albedo)), np.float32), np.empty(SAMPLES)
    sample_lobe(make_scene(case), NORMAL, tuple(wo), values, weights)
    brought = values * weights[:, None]
    wi, solid_angles = hemisphere(cosine)
    expected = split(case, wi, wo)[1].T @ ((wi @ np.array(NORMAL)) * solid_angles)
    error = brought.std(axis=0) / np.sqrt(SAMPLES)
    assert (np.abs(brought.mean(axis=0) - expected) < 5.0 * error + 2e-3 * expected).all()


@pytest.mark.parametrize(("reflectance", "roughness"), [(0.04, 1.0), (0.3, 0.5)])
def test_photons_and_paths_agree_where_all_is_glossy(reflectance, roughness):
    glossy_wall = pm.Material("wall", (0.6, 0.5, 0.3), glossy=reflectance, roughness=roughness)
    lamp = quad((0.5, 0.5, 0.9), (0.5, 0.9, 0.9), (0.9, 0.9, 0.9), (0.9, 0.5, 0.9),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    camera = pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0)
    scene = pm.Scene([closed_box(glossy_wall), lamp], camera=camera)
    assert excess(block_means(scene, "photon"), block_means(scene, "path")) <= 0.0


def test_gather_rays_end_in_the_cache_where_all_is_glossy():
    """Few go on, by the lobe; without the cache, each would for several surfaces."""
    box = closed_box(pm.Material("wall", 0.6, glossy=0.04, roughness=1.0))
    lamp = quad((0.5, 0.5, 0.9), (0.5, 0.9, 0.9), (0.9, 0.9, 0.9), (0.9, 0.5, 0.9),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    scene = pm.Scene([box, lamp], camera=pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0))
    rays = pm.render(scene, bands=3, size=(12, 12), passes=4).record["rays_by_kind"]
    assert rays["walk"] < 1.2 * rays["gather"]
