"""The diffuse base of glossy surfaces, which the radiosity cache holds, and the lobe beside it."""

import numpy as np
import pytest
from bsdf_harness import (
    CASES,
    COSINES,
    NORMAL,
    ORIGIN,
    departure,
    evaluate,
    hemisphere,
    make_scene,
    number_of,
    sample,
)
from helpers.comparisons import assert_within
from helpers.scenes import closed_box, quad

import photonmap as pm
from photonmap.kernels.bsdf import glossy, models
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import Hit, SurfaceInteraction
from photonmap.kernels.integrators.cache_answer import fill_base_flux, has_base

HELD = [case for case in CASES if number_of(case) == models.GLOSSY and np.mean(case.albedo) > 0.0]
SAMPLES = 30_000
each_held = pytest.mark.parametrize(
    "case", HELD, ids=lambda case: f"{case.parameters}-{case.index}"
)


@kernel
def _fill_bases(scene, n, wi, wo, flux, passed, base):
    """Fill base, (n, N), with what cells say of the BSDF between directions."""
    hit = Hit(0, 0.3, 0.3, 1.0)
    for i in range(len(wi)):
        arrival = vec.scale(vec.row(wi, i), -2.0)
        at = SurfaceInteraction(ORIGIN, ORIGIN, n, n, 0, hit, arrival, models.GLOSSY)
        fill_base_flux(scene, at, 1.0, flux, base[i], passed)
        found = glossy.lobe_at(scene.geometry, scene.scattering, hit)
        passed[:] = 1.0
        glossy.multiply_transmitted(scene.scattering, found, vec.row(wo, i), n, passed)
        for band in range(base.shape[1]):
            base[i, band] *= passed[band] / np.pi


def base_between(case, wi, wo):
    wi, shape = np.ascontiguousarray(wi), (len(wi), len(case.albedo))
    wo = np.ascontiguousarray(np.broadcast_to(wo, wi.shape))
    base, (flux, passed) = np.empty(shape, np.float32), np.ones((2, shape[1]), np.float32)
    _fill_bases(make_scene(case), NORMAL, wi, wo, flux, passed, base)
    return base


def test_which_surfaces_have_one():
    for case in CASES:
        scene = make_scene(case)
        held = has_base(scene, 0)
        assert held == (case in HELD)


@each_held
def test_base_and_lobe_are_the_bsdf(case):
    for cosine in COSINES:
        wi, wo = hemisphere(cosine, 6, 12)[0], departure(cosine, 0.7)
        base, (lobe, _) = base_between(case, wi, wo), evaluate(case, wi, wo, glossy.LOBE)
        np.testing.assert_allclose(base + lobe, evaluate(case, wi, wo)[0], rtol=2e-5, atol=1e-7)
        assert (base > 0.0).all()


@each_held
def test_paths_that_go_on_bring_the_lobe(case):
    for cosine in COSINES:
        wo = departure(cosine)
        wi = sample(case, wo, key=3, count=SAMPLES, model=glossy.LOBE)
        values, density = evaluate(case, wi, wo, glossy.LOBE)
        used = density > 0.0
        brought = values * np.where(used, wi @ NORMAL / np.where(used, density, 1.0), 0.0)[:, None]
        away, solid_angles = hemisphere(cosine)
        lobe = evaluate(case, away, wo, glossy.LOBE)[0]
        expected = lobe.T @ ((away @ NORMAL) * solid_angles)
        error = brought.std(axis=0) / np.sqrt(SAMPLES)
        assert_within(brought.mean(axis=0), expected, error, 5.0, slack=2e-3)


def test_gather_rays_end_in_the_cache_where_all_is_glossy():
    """Few go on, by the lobe; without the cache, each would for several surfaces."""
    box = closed_box(pm.Material("wall", 0.6, glossy=0.04, roughness=1.0))
    lamp = quad((0.5, 0.5, 0.9), (0.5, 0.9, 0.9), (0.9, 0.9, 0.9), (0.9, 0.5, 0.9),
                pm.Material("lamp", 0.0, 20.0), "lamp")  # fmt: skip
    scene = pm.Scene([box, lamp], camera=pm.Camera((0.2, 0.3, 0.95), (0.0, -0.2, -1.0), fov=80.0))
    rays = pm.render(scene, bands=3, size=(12, 12), passes=4).record["rays_by_kind"]
    assert rays["walk"] < 1.2 * rays["gather"]
