"""Samplers of lights: directions against their densities, and the power of photons."""

import numpy as np
import pytest
from helpers.comparisons import chi_squared
from helpers.scenes import closed_box, sky
from scipy import stats

import photonmap as pm
from photonmap.compile.lights.probabilities import EVEN
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.missing_light import _only
from photonmap.kernels.core import rng, vec, warp
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.lights.emission import emit_photon
from photonmap.kernels.lights.environment import (
    ALL_AROUND,
    cell_of_normal,
    environment_pdf,
    sample_environment,
    texel_at,
)
from photonmap.spectra.bands import Bands

RGB = Bands.rgb()
BLOCK = closed_box(pm.Material("block", 0.5), -0.5, 0.5)


@kernel
def sample_sky(environment, cell, n, out, pdf):
    state = rng.stream(8, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        (x, y, z), texel, pdf[i, 0] = sample_environment(environment, cell, u, v)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z
        pdf[i, 1] = environment_pdf(environment, cell, texel)
        pdf[i, 2], pdf[i, 3] = texel


@kernel
def sample_cone(cosine, n, out):
    state = rng.stream(9, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        x, y, z = warp.uniform_cone(u, v, cosine)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


def _density(environment, direction, cell=ALL_AROUND):
    return environment_pdf(environment, cell, texel_at(environment, direction))


def test_environment_sampler():
    """χ² of directions against the density, which is the light's, and exact texel by texel."""
    n, height = 200_000, 8
    texels = sky(height)
    environment = compile_scene(
        pm.Scene([BLOCK], [pm.EnvironmentLight(texels, 3.0, 33.0)]), RGB
    ).lights.environment
    out, pdf = np.zeros((n, 3)), np.zeros((n, 4))
    sample_sky(environment, ALL_AROUND, n, out, pdf)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    some = [tuple(map(float, d)) for d in out[:2000]]
    np.testing.assert_allclose(pdf[:, 0], pdf[:, 1], rtol=1e-12)
    np.testing.assert_allclose([_density(environment, d) for d in some], pdf[:2000, 0])
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


NORMALS = {
    "up": (0.0, 1.0, 0.0),
    "down": (0.0, -1.0, 0.0),
    "wall": (0.0, 0.0, -1.0),
    "slope": (0.48, 0.6, 0.64),
    "overhang": (-0.8, -0.36, 0.48),
}


@pytest.mark.parametrize("normal", NORMALS.values(), ids=NORMALS)
@pytest.mark.parametrize("shape", [(8, 16), (37, 74), (1, 2)])
def test_environment_towards_a_surface(normal, shape):
    """Estimates of irradiance are right, and spread little; by light alone, by 1.3 at least."""
    n = 100_000
    texels = np.random.default_rng(5).uniform(0.0, 1.0, (*shape, 3)) ** 4
    environment = compile_scene(
        pm.Scene([BLOCK], [pm.EnvironmentLight(texels, 3.0, 33.0)]), RGB
    ).lights.environment
    cell = cell_of_normal(normal)
    out, pdf = np.zeros((n, 3)), np.zeros((n, 4))
    sample_sky(environment, cell, n, out, pdf)
    np.testing.assert_allclose(pdf[:, 0], pdf[:, 1], rtol=1e-12)

    rows, columns = environment.columns.shape
    solid = -np.diff(environment.cosines)[:, None] * 2.0 * np.pi / columns
    middles = [
        [_towards((r + 0.5) / rows, (c + 0.5) / columns, 33.0) for c in range(columns)]
        for r in range(rows)
    ]
    density = np.array([[_density(environment, d, cell) for d in row] for row in middles])
    assert (density * solid).sum() == pytest.approx(1.0)
    cosines = np.maximum(np.array(middles) @ normal, 0.0)
    assert (density[(cosines > 0.0) & (environment.texels.mean(axis=2) > 0.0)] > 0.0).all()

    light = environment.texels.mean(axis=2, dtype=float)
    cosine = out @ np.array(normal)
    assert np.mean(cosine <= 0.0) < 0.06
    row, column = pdf[:, 2:].astype(int).T
    estimates = np.maximum(cosine, 0.0) * light[row, column] / pdf[:, 0]
    spread = estimates.std() / estimates.mean()
    assert spread < 0.4
    fine = _irradiance(environment, light, normal)
    assert abs(estimates.mean() / fine - 1.0) < 4.0 * spread / np.sqrt(n)


def _irradiance(environment, light, normal, parts=40):
    """Return the irradiance of a map by quadrature, each texel in parts."""
    rows, columns = light.shape
    theta = (np.arange(rows * parts) + 0.5) * np.pi / (rows * parts)
    turn = (np.arange(columns * parts) + 0.5) / (columns * parts) - 0.5 - environment.rotation
    phi = 2.0 * np.pi * turn
    cosine = np.sin(theta)[:, None] * (normal[0] * np.sin(phi) - normal[2] * np.cos(phi))
    cosine = np.maximum(cosine + normal[1] * np.cos(theta)[:, None], 0.0) * np.sin(theta)[:, None]
    each = cosine.reshape(rows, parts, columns, parts).sum(axis=(1, 3))
    return (each * light).sum() * 2.0 * np.pi**2 / (rows * columns * parts**2)


def test_surface_below_a_sky_that_is_dark_there():
    """What faces away from all light gets no sample."""
    texels = np.ones((16, 32, 3))
    texels[4:] = 0.0
    environment = compile_scene(
        pm.Scene([BLOCK], [pm.EnvironmentLight(texels)]), RGB
    ).lights.environment
    out, pdf = np.zeros((1000, 3)), np.zeros((1000, 4))
    sample_sky(environment, cell_of_normal((0.0, -1.0, 0.0)), 1000, out, pdf)
    assert not pdf[:, :2].any()


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
        assert 0 <= row < environment.columns.shape[0]
        assert 0 <= column < environment.columns.shape[1]


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
