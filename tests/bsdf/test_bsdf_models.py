"""What must hold of any BSDF: its sampler, its density, reciprocity and energy."""

import numpy as np
import pytest
from bsdf_harness import (
    CASES,
    COSINES,
    FRAME,
    NORMAL,
    SAMPLES,
    departure,
    directional_albedo,
    evaluate,
    hemisphere,
    number_of,
    sample,
    scatter,
    to_world,
)
from helpers.comparisons import assert_within, chi_squared

from photonmap.kernels.bsdf import models

SIGNIFICANCE = 1e-4 / (len(CASES) * len(COSINES))
"""Of one χ² test: 1e-4 for all of them together (Bonferroni)."""
SIGMAS = 5.0
"""Allowed standard errors of a mean: one in 1.7 million is beyond."""
HEIGHTS, TURNS, FINER = 10, 16, 16
"""Bins of the χ² test, even in cosine and azimuth, and parts of each to either side."""

each_case = pytest.mark.parametrize(
    "case",
    CASES,
    ids=lambda case: (
        f"{case.model}{case.parameters}"
        + (f"-coat{case.coat}" if case.coat[0] else "")
        + (f"-sheen{case.sheen}" if case.sheen[0] else "")
    ),
)
each_view = pytest.mark.parametrize("cosine", COSINES)


def test_every_model_has_a_case():
    covers = {"Lambertian": models.LAMBERTIAN, "coat": models.COATED, "sheen": models.SHEEN}
    tested = {number_of(case) for case in CASES}
    lacking = [name for name, number in (covers | models.MODELS).items() if number not in tested]
    assert not lacking, "add a line to CASES in bsdf_harness.py"


def random_directions(count, seed=7):
    """Return directions above the surface, even by solid angle, (n, 3)."""
    random = np.random.default_rng(seed)
    z, phi = random.uniform(0.001, 1.0, count), random.uniform(0.0, 2.0 * np.pi, count)
    r = np.sqrt(1.0 - z * z)
    return to_world(np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1))


def expected_in_bins(case, wo):
    """Return the part of samples that the density puts into each bin, (HEIGHTS · TURNS,)."""
    z = (np.arange(HEIGHTS * FINER) + 0.5) / (HEIGHTS * FINER)
    phi = ((np.arange(TURNS * FINER) + 0.5) / (TURNS * FINER) * 2.0 - 1.0) * np.pi
    z, phi = np.meshgrid(z, phi, indexing="ij")
    r = np.sqrt(1.0 - z * z)
    local = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)
    _, density = evaluate(case, to_world(local.reshape(-1, 3)), wo)
    parts = density.reshape(HEIGHTS, FINER, TURNS, FINER) * 2.0 * np.pi / z.size
    return parts.sum(axis=(1, 3)).ravel()


def fit_of_samples(case, wo):
    """Return the p-value of χ² of samples against the density: bins of the hemisphere, and lost."""
    local = sample(case, wo) @ FRAME.T
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), 1.0, atol=1e-9)
    edges = np.linspace(0.0, 1.0, HEIGHTS + 1), np.linspace(-np.pi, np.pi, TURNS + 1)
    counts = np.histogram2d(local[:, 2], np.arctan2(local[:, 1], local[:, 0]), edges)[0].ravel()
    share = expected_in_bins(case, wo)
    counts = np.append(counts, SAMPLES - counts.sum())
    expected = SAMPLES * np.append(share, max(1.0 - share.sum(), 0.0))
    return chi_squared(counts, expected)


@each_view
@each_case
def test_samples_follow_the_density(case, cosine):
    """χ² over bins of the hemisphere, and one for what is sampled below the horizon."""
    wo = departure(cosine, 0.7)
    assert fit_of_samples(case, wo) > SIGNIFICANCE


@each_view
@each_case
def test_the_density_integrates_to_what_is_sampled_above_the_horizon(case, cosine):
    """The integral is 1 at most; the quadrature is good to 1e-4."""
    wo = departure(cosine)
    wi, solid_angles = hemisphere(cosine)
    _, density = evaluate(case, wi, wo)
    total = density @ solid_angles
    assert (density >= 0.0).all()
    assert total <= 1.0 + 1e-4
    above = (sample(case, wo) @ NORMAL > 0.0).mean()
    error = np.sqrt(max(total * (1.0 - total), 0.0) / SAMPLES)
    assert abs(above - total) <= SIGMAS * error + 1e-4


@each_case
def test_below_the_horizon_the_density_is_0(case):
    _, density = evaluate(case, -random_directions(500), departure(0.6))
    assert (density == 0.0).all()


@each_case
def test_reciprocity(case):
    """f(wi, wo) = f(wo, wi), to the digits of float32."""
    wi, wo = random_directions(4000, 1), random_directions(4000, 2)
    forth, back = evaluate(case, wi, wo)[0], evaluate(case, wo, wi)[0]
    np.testing.assert_allclose(forth, back, rtol=2e-6, atol=1e-9)
    assert np.isfinite(forth).all()
    assert (forth >= 0.0).all()
    assert (forth.max(axis=0) > 0.0).all()


@each_view
@each_case
def test_no_more_is_reflected_than_arrives(case, cosine):
    """Directional albedos are 1 at most where diffuse albedos are, and rise with them."""
    albedo = directional_albedo(case, cosine)
    assert (albedo <= 1.0 + 2e-4).all()
    assert (np.diff(albedo) > 0.0).all()


@each_view
@each_case
def test_samples_estimate_what_is_reflected(case, cosine):
    """Means of BSDF · cosine / density, and of photons' flux, are the directional albedo."""
    truth, wo = directional_albedo(case, cosine), departure(cosine)
    wi = sample(case, wo, key=3)
    values, density = evaluate(case, wi, wo)
    used = density > 0.0
    cosines = np.maximum(wi @ NORMAL, 0.0)
    weights = np.zeros_like(values)
    weights[used] = values[used] * (cosines[used] / density[used])[:, None]
    for estimates in (weights, scatter(case, wo)):
        error = estimates.std(axis=0) / np.sqrt(SAMPLES)
        assert_within(estimates.mean(axis=0), truth, error, SIGMAS, slack=1e-4)
