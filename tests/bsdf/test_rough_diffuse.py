"""Rough diffuse surfaces (EON): a white furnace, Lambert's law at roughness 0, closed forms."""

import numpy as np
import pytest
from bsdf_harness import (
    LAMBERTIAN,
    NORMAL,
    Case,
    departure,
    directional_albedo,
    evaluate,
    hemisphere,
)

from photonmap.kernels.bsdf import rough_diffuse

ROUGHNESSES = (0.0, 0.1, 0.5, 1.0)
COSINES = (1.0, 0.9, 0.6, 0.3, 0.05)
FAINT = 1e-6
"""An albedo at which light is scattered once: twice is a millionth of that."""


def rough(roughness, *albedo):
    return Case("rough diffuse", (roughness,), albedo)


@pytest.mark.parametrize("cosine", COSINES)
@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_white_furnace(roughness, cosine):
    """White surfaces return all light, from any angle; the quadrature is good to 1e-4."""
    assert directional_albedo(rough(roughness, 1.0), cosine) == pytest.approx(1.0, abs=1e-4)


def test_roughness_0_is_lambertian():
    wi, _ = hemisphere(0.4, heights=6, turns=12)
    for cosine in COSINES:
        wo = departure(cosine)
        values, density = evaluate(rough(0.0, *LAMBERTIAN.albedo), wi, wo)
        truth, true_density = evaluate(LAMBERTIAN, wi, wo)
        np.testing.assert_allclose(values, truth, rtol=5e-7)
        np.testing.assert_array_equal(density, true_density)
        np.testing.assert_allclose(truth, np.broadcast_to(LAMBERTIAN.albedo, truth.shape) / np.pi)


@pytest.mark.parametrize("cosine", COSINES)
@pytest.mark.parametrize("roughness", ROUGHNESSES[1:])
def test_single_scattering_is_that_of_the_paper(roughness, cosine):
    """Fujii's model: A (1 + r s / t) / π, with s = wi·wo - cos cos, t = max cos where s > 0."""
    wi, _ = hemisphere(cosine, heights=8, turns=16)
    wo, values = departure(cosine), evaluate(rough(roughness, FAINT), wi, departure(cosine))[0]
    cos_i, cos_o = wi @ NORMAL, float(np.dot(wo, NORMAL))
    s = wi @ wo - cos_i * cos_o
    t = np.where(s > 0.0, np.maximum(cos_i, cos_o), 1.0)
    level = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * np.pi)) * roughness)
    np.testing.assert_allclose(
        values[:, 0] / FAINT, level / np.pi * (1.0 + roughness * s / t), rtol=2e-5, atol=2e-6
    )


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_the_albedo_of_single_scattering_is_in_closed_form(roughness):
    """So is its mean over all directions, by which the second constant is known."""
    for cosine in COSINES:
        truth = rough_diffuse.directional_albedo(cosine, roughness)
        albedo = directional_albedo(rough(roughness, FAINT), cosine)[0] / FAINT
        assert albedo == pytest.approx(truth, rel=1e-4)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    cosines = 0.5 * (nodes + 1.0)
    each = [rough_diffuse.directional_albedo(cosine, roughness) for cosine in cosines]
    mean = np.sum(weights * cosines * each)
    level = 1.0 / (1.0 + rough_diffuse.DARKENING * roughness)
    assert mean == pytest.approx(level * (1.0 + rough_diffuse.MEAN_DARKENING * roughness), rel=1e-4)


def test_rough_surfaces_send_light_back():
    """A rough surface is brighter towards the light than beyond, the more so the rougher."""
    ratios = []
    for roughness in ROUGHNESSES:
        wo = departure(0.5)
        pair = np.stack([departure(0.5), departure(0.5, np.pi)])
        values, _ = evaluate(rough(roughness, 0.5), pair, wo)
        ratios.append(values[0, 0] / values[1, 0])
    assert ratios[0] == pytest.approx(1.0)
    assert (np.diff(ratios) > 0.05).all()


def test_dark_rough_surfaces_lose_what_bright_ones_keep():
    """Each further scattering multiplies by the albedo: ρ single + ρ² mean / (1 - ρ (1 - mean))."""
    roughness, cosine, rho = 0.8, 0.4, 0.6
    single = rough_diffuse.directional_albedo(cosine, roughness)
    level = 1.0 / (1.0 + rough_diffuse.DARKENING * roughness)
    mean = level * (1.0 + rough_diffuse.MEAN_DARKENING * roughness)
    again = rho * rho * mean / (1.0 - rho * (1.0 - mean)) * (1.0 - single)
    albedo = directional_albedo(rough(roughness, rho), cosine)[0]
    assert albedo == pytest.approx(rho * single + again, rel=1e-4)
