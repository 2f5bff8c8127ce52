"""Every sampler against its density (χ²)."""

import numpy as np
import pytest
from helpers.comparisons import chi_squared
from scipy import stats

from photonmap.kernels.core import rng, warp
from photonmap.kernels.core.jit import kernel

SAMPLES = 200_000
SIGNIFICANCE = 1e-4 / 8


@kernel
def sample_directions(which, n, out):
    state = rng.stream(5, which, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        x, y, z = 0.0, 0.0, 0.0
        if which == 0:
            x, y, z = warp.cosine_hemisphere(u, v)
        elif which == 1:
            x, y, z = warp.uniform_sphere(u, v)
        elif which == 2:
            x, y = warp.uniform_disk(u, v)
        else:
            x, y = warp.uniform_triangle(u, v)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


@pytest.mark.parametrize(("which", "pdf"), [(0, "cosine"), (1, "sphere")])
def test_directions(which, pdf):
    out = np.zeros((SAMPLES, 3))
    sample_directions(which, SAMPLES, out)
    np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0, atol=1e-12)
    z, phi = np.linspace(-1, 1, 21), np.linspace(-np.pi, np.pi, 17)
    counts = np.histogram2d(out[:, 2], np.arctan2(out[:, 1], out[:, 0]), (z, phi))[0]
    middle = 0.5 * (z[1:] + z[:-1])
    density = [
        warp.cosine_hemisphere_pdf(c) if pdf == "cosine" else warp.uniform_sphere_pdf()
        for c in middle
    ]
    cell = (z[1] - z[0]) * (phi[1] - phi[0])
    expected = SAMPLES * np.repeat(np.array(density)[:, None] * cell, len(phi) - 1, axis=1)
    assert expected.sum() == pytest.approx(SAMPLES, rel=1e-3)
    assert chi_squared(counts.ravel(), expected.ravel()) > SIGNIFICANCE


def test_disk():
    out = np.zeros((SAMPLES, 3))
    sample_directions(2, SAMPLES, out)
    edges, phi = np.linspace(0, 1, 11), np.linspace(-np.pi, np.pi, 13)
    radius = np.hypot(out[:, 0], out[:, 1])
    assert radius.max() <= 1.0
    counts = np.histogram2d(radius, np.arctan2(out[:, 1], out[:, 0]), (edges, phi))[0]
    areas = 0.5 * np.diff(edges**2)[:, None] * np.diff(phi)[None]
    assert chi_squared(
        counts.ravel(), SAMPLES * warp.uniform_disk_pdf() * areas.ravel()
    ) > SIGNIFICANCE  # fmt: skip


def test_triangle():
    out = np.zeros((SAMPLES, 3))
    sample_directions(3, SAMPLES, out)
    assert (out[:, :2] >= 0).all()
    assert (out[:, :2].sum(axis=1) <= 1).all()
    n = 10
    x, y = out[:, 0] * n, out[:, 1] * n
    cell = (x.astype(int) * n + y.astype(int)) * 2 + ((x % 1) + (y % 1) > 1)
    counts = np.bincount(cell.astype(int), minlength=2 * n * n)
    i, j = np.divmod(np.arange(2 * n * n) // 2, n)
    inside = i + j + np.arange(2 * n * n) % 2 < n
    area = 2.0
    expected = SAMPLES * warp.uniform_triangle_pdf(area) * np.where(inside, area / n**2, 0.0)
    assert chi_squared(counts, expected) > SIGNIFICANCE


@kernel
def take_turns(v, out):
    for i in range(len(v)):
        out[i, 0], out[i, 1] = warp.cos_sin_2pi(v[i])


def test_turns():
    v = np.append(np.linspace(0.0, 1.0, 10_001)[:-1], 1.0 - 2.0**-53)
    out = np.zeros((len(v), 2))
    take_turns(v, out)
    np.testing.assert_allclose(out[:, 0], np.cos(2.0 * np.pi * v), atol=1e-15)
    np.testing.assert_allclose(out[:, 1], np.sin(2.0 * np.pi * v), atol=1e-15)


@kernel
def sample_linear(a, b, n, out):
    state = rng.stream(7, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        out[i] = warp.linear(u, a, b)


@pytest.mark.parametrize(("a", "b"), [(1.0, 3.0), (2.0, 0.0), (0.0, 1e-9), (5.0, 5.0)])
def test_linear(a, b):
    out = np.zeros(SAMPLES)
    sample_linear(a, b, SAMPLES, out)
    assert out.min() >= 0.0
    assert out.max() <= 1.0
    edges = np.linspace(0.0, 1.0, 21)
    expected = [0.05 * warp.linear_pdf(x, a, b) for x in 0.5 * (edges[1:] + edges[:-1])]
    counts = np.histogram(out, edges)[0]
    assert chi_squared(counts, SAMPLES * np.array(expected)) > SIGNIFICANCE


@kernel
def sample_discrete(cdf, n, counts, renewed):
    state = rng.stream(6, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        index, v = warp.discrete(cdf, u)
        counts[index] += 1
        renewed[i] = v


def test_discrete():
    weights = np.array([0.0, 3.0, 0.0, 1.0, 5.0, 1e-3, 0.0])
    cdf = np.cumsum(weights) / weights.sum()
    counts, renewed = np.zeros(len(weights), np.int64), np.zeros(SAMPLES)
    sample_discrete(cdf, SAMPLES, counts, renewed)
    pdf = np.array([warp.discrete_pdf(cdf, i) for i in range(len(weights))])
    np.testing.assert_allclose(pdf, weights / weights.sum(), atol=1e-15)
    assert chi_squared(counts, SAMPLES * pdf) > SIGNIFICANCE
    assert stats.kstest(renewed, "uniform").pvalue > SIGNIFICANCE


def test_discrete_at_the_ends():
    cdf = np.array([0.0, 0.5, 0.5, 1.0, 1.0])
    assert warp.discrete(cdf, 0.0)[0] == 1
    assert warp.discrete(cdf, 0.5)[0] == 3
    assert warp.discrete(cdf, np.nextafter(1.0, 0.0))[0] == 3
