"""Samplers of lights: directions against their densities, and the power of photons."""

import numpy as np
import pytest
from helpers.comparisons import chi_squared
from helpers.scenes import closed_box, sky
from scipy import stats

import photonmap as pm
from photonmap.compile.lights.probabilities import EVEN
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.light_visibility import _only
from photonmap.kernels.core import rng, vec, warp
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.lights.environment import environment_pdf, sample_environment, texel_at
from photonmap.kernels.lights.photons import emit_photon
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
BLOCK = closed_box(pm.Material("block", 0.5), -0.5, 0.5)


@kernel
def sample_sky(environment, n, out, pdf):
    state = rng.stream(8, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        (x, y, z), texel = sample_environment(environment, u, v)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z
        pdf[i] = environment_pdf(environment, texel)


@kernel
def sample_cone(cosine, n, out):
    state = rng.stream(9, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        x, y, z = warp.uniform_cone(u, v, cosine)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


def _density(environment, direction):
    return environment_pdf(environment, texel_at(environment, direction))


def test_environment_sampler():
    """χ² of directions against the density, which is the light's, and exact texel by texel."""
    n, height = 200_000, 8
    texels = sky(height)
    environment = compile_scene(
        pm.Scene([BLOCK], [pm.EnvironmentLight(texels, 3.0, 33.0)]), RGB
    ).lights.environment
    out, pdf = np.zeros((n, 3)), np.zeros(n)
    sample_sky(environment, n, out, pdf)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    some = [tuple(map(float, d)) for d in out[:2000]]
    np.testing.assert_allclose([_density(environment, d) for d in some], pdf[:2000])
    assert _density(environment, _towards(1.5 / 8, 3.5 / 16, 33.0)) == 0.0

    solid = -np.diff(np.cos(np.linspace(0.0, np.pi, height + 1)))[:, None] * np.pi / height
    power = texels.astype(np.float32).mean(axis=2) * solid
    density = power / power.sum() / solid
    middles = [
        [_density(environment, _towards((r + 0.5) / 8, (c + 0.5) / 16, 33.0))
         for c in range(16)]
        for r in range(8)
    ]  # fmt: skip
    np.testing.assert_allclose(middles, density, rtol=1e-6, atol=1e-12)
    assert (np.array(middles) * solid).sum() == pytest.approx(1.0)
    # Half texels each way, so that places within texels are tested as well.
    theta = np.arccos(np.clip(out[:, 1], -1, 1))
    turn = (0.5 + np.arctan2(out[:, 0], -out[:, 2]) / (2 * np.pi) + 33.0 / 360.0) % 1.0
    counts = np.histogram2d(
        theta / np.pi, turn, (np.linspace(0, 1, 17), np.linspace(0, 1, 33))
    )[0]  # fmt: skip
    halves = -np.diff(np.cos(np.linspace(0.0, np.pi, 17)))[:, None] * np.pi / 16
    expected = n * np.repeat(np.repeat(density, 2, 0), 2, 1) * halves
    assert chi_squared(counts.ravel(), expected.ravel()) > 1e-4


def _towards(height, column, rotation):
    theta, phi = np.pi * height, 2 * np.pi * (column - 0.5) - np.radians(rotation)
    return (
        float(np.sin(theta) * np.sin(phi)),
        float(np.cos(theta)),
        float(-np.sin(theta) * np.cos(phi)),
    )


def test_poles_and_seams_are_texels():
    environment = compile_scene(
        pm.Scene([BLOCK], [pm.EnvironmentLight(sky())]), RGB
    ).lights.environment
    for direction in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (-0.0, 0.0, 1.0)):
        row, column = texel_at(environment, direction)
        assert 0 <= row < 8
        assert 0 <= column < 16


@pytest.mark.parametrize("degrees", [1.0, 30.0, 120.0])
def test_cone_sampler(degrees):
    n, cosine = 100_000, float(np.cos(np.radians(degrees)))
    out = np.zeros((n, 3))
    sample_cone(cosine, n, out)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    z, phi = np.linspace(cosine, 1.0, 11), np.linspace(-np.pi, np.pi, 17)
    counts = np.histogram2d(out[:, 2], np.arctan2(out[:, 1], out[:, 0]), (z, phi))[0]
    assert counts.sum() == n
    expected = n * warp.uniform_cone_pdf(cosine) * (z[1] - z[0]) * (phi[1] - phi[0])
    assert stats.chisquare(counts.ravel(), np.full(160, expected)).pvalue > 1e-4


@kernel
def sum_power(geometry, lights, n, flux, total, worst):
    for index in range(n):
        key = rng.stream(3, 0, 0)
        position = rng.sobol_2d(index, key)
        towards = rng.sobol_2d(index, rng.stream(3, 1, 0))
        _, direction = emit_photon(geometry, lights, position, towards, 1.0 / n, flux)
        emitter, _ = warp.discrete(lights.cdf, position[0])
        worst[0] = max(worst[0], abs(vec.dot(direction, direction) - 1.0))
        for band in range(len(flux)):
            total[emitter, band] += flux[band]


SCALE = 3.0
"""Of the block that the power's test lights, so that units matter."""


def sky_power(texels, radius):
    """∫ L dω times the disk."""
    solid = -np.diff(np.cos(np.linspace(0.0, np.pi, len(texels) + 1))) * np.pi / len(texels)
    return (texels * solid[:, None, None]).sum(axis=(0, 1)) * np.pi * radius**2


RADIUS = 1.001 * np.sqrt(3.0) / 2.0 * SCALE
POWERS = [
    (pm.PointLight((0, 0, 2), (1.0, 2.0, 3.0)), 4.0 * np.pi * np.array([1, 2, 3])),
    (
        pm.SpotLight((0, 0, 2), (0, 0, 0), (1.0, 2.0, 3.0), 25.0, 40.0),
        np.pi * (2.0 - np.cos(np.radians(25)) - np.cos(np.radians(40))) * np.array([1, 2, 3]),
    ),
    (
        pm.SpotLight((0, 0, 2), (0, 1, 0), 1.0, 90.0, 90.0),
        2.0 * np.pi * np.ones(3),
    ),
    (
        pm.DirectionalLight((1, -2, 0.5), (1.0, 2.0, 3.0)),
        np.pi * RADIUS**2 * np.array([1, 2, 3]),
    ),
    (pm.DomeLight(2.0), np.full(3, 2.0 * (2.0 * np.pi * RADIUS) ** 2)),
    (pm.EnvironmentLight(sky(), 2.0, 10.0), 2.0 * sky_power(sky(), RADIUS)),
]


@pytest.mark.parametrize(("light", "power"), POWERS)
def test_photons_carry_the_power(light, power):
    block = closed_box(pm.Material("block", 0.5), -SCALE / 2, SCALE / 2)
    compiled = compile_scene(pm.Scene([block], [light, pm.PointLight((1, 1, 1), 0.7)]), RGB)
    n, flux, total, worst = 1 << 18, np.zeros(3, np.float32), np.zeros((2, 3)), np.zeros(1)
    sum_power(compiled.geometry, compiled.lights, n, flux, total, worst)
    # Radiance scales with power, power with area as well.
    factor = compiled.power * compiled.size**2
    np.testing.assert_allclose(total[0] * factor, power, rtol=4e-3)
    np.testing.assert_allclose(total[1] * factor, 4.0 * np.pi * 0.7, rtol=4e-3)
    assert worst[0] < 1e-12
    assert total.mean(axis=1).sum() == pytest.approx(1.0, rel=1e-3)
    probabilities = np.diff(compiled.lights.cdf, prepend=0.0)
    share = 4.0 * np.pi * 0.7 / factor
    assert probabilities[1] == pytest.approx((1.0 - EVEN) * share + EVEN / 2, rel=1e-6)

    for member in range(2):
        alone = _only(compiled.lights, np.array([member]))
        total[:] = 0.0
        sum_power(compiled.geometry, alone, 1 << 16, flux, total, worst)
        truth = power if member == 0 else 4.0 * np.pi * 0.7
        np.testing.assert_allclose(total[0] * factor, truth, rtol=4e-3)
