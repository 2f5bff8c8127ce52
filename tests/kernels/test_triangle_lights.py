"""Samples of emitting triangles: closed forms, densities, and how little they vary."""

import numpy as np
import pytest
from scipy import stats

from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.records import Geometry
from photonmap.kernels.lights.triangle import (
    corners_from,
    mean_irradiance_factor,
    sample_triangle_light,
)

SAMPLES = 100_000
SIGNIFICANCE = 1e-4

PLACES = {
    "above": ((0.5, 0.0, 0.4), (0.0, 1.0, 0.0)),
    "aside": ((0.9, 0.3, 0.1), (-0.6, 0.8, 0.0)),
    "one corner up": ((0.1, 0.2, 0.1), (1.0, 0.0, 0.0)),
    "two corners up": ((-0.08, 0.0, 0.0), (1.0, 0.0, 0.0)),
    "near": ((0.0, 0.97, 0.0), (0.0, 1.0, 0.0)),
}
CORNERS = np.array([[-0.16, 1.0, -0.12], [0.28, 1.0, -0.08], [-0.04, 1.0, 0.24]])


def lamp():
    """A triangle at height 1 that shines down."""
    empty = {name: np.zeros(0) for name in Geometry._fields}
    return Geometry(**empty)._replace(
        scene=0,
        vertices=CORNERS,
        triangles=np.array([[0, 1, 2]], np.int32),
        normals=np.array([[0.0, -1.0, 0.0]]),
        material=np.zeros(1, np.int32),
        emitter=np.zeros(1, np.int32),
        shading_normals=np.zeros((0, 3)),
        alpha=None,
    )


@kernel
def take_samples(geometry, point, ns, n, out):
    corners = corners_from(geometry, 0, point, ns)
    state = rng.stream(3, 0, 0)
    for i in range(n):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        out[i, 0], out[i, 1], out[i, 2] = sample_triangle_light(corners, u, v)
    return mean_irradiance_factor(corners)


def sampled(point, ns):
    out = np.zeros((SAMPLES, 3))
    mean = take_samples(lamp(), point, ns, SAMPLES, out)
    return out[:, 0], out[:, 1], out[:, 2], mean


def sent(point, ns, b1, b2):
    """What comes to a point from places on the lamp, cos θ cos θ' / r²; 0 below the horizon."""
    place = CORNERS[0] + np.outer(b1, CORNERS[1] - CORNERS[0])
    place += np.outer(b2, CORNERS[2] - CORNERS[0])
    step = place - np.array(point)
    squared = np.square(step).sum(axis=1)
    return np.maximum(step @ np.array(ns), 0.0) * step[:, 1] / squared**2


def irradiance(point, ns):
    """Lambert's formula for a polygon (Baum et al. 1989), cut off at the horizon."""
    steps = CORNERS - np.array(point)
    heights = steps @ np.array(ns)
    polygon = []
    for i in range(3):
        j = (i + 1) % 3
        if heights[i] > 0.0:
            polygon.append(steps[i])
        if heights[i] * heights[j] < 0.0:
            t = heights[i] / (heights[i] - heights[j])
            polygon.append(steps[i] + t * (steps[j] - steps[i]))
    unit = [p / np.linalg.norm(p) for p in polygon]
    total = 0.0
    for a, b in zip(unit, unit[1:] + unit[:1], strict=True):
        normal = np.cross(a, b)
        total += np.arccos(np.clip(a @ b, -1, 1)) * normal @ np.array(ns) / np.linalg.norm(normal)
    return abs(0.5 * total)


@pytest.mark.parametrize("place", PLACES)
def test_samples_give_the_closed_form(place):
    point, ns = PLACES[place]
    b1, b2, density, _ = sampled(point, ns)
    area = 0.5 * np.linalg.norm(np.cross(CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0]))
    estimates = area * sent(point, ns, b1, b2) / density
    error = estimates.std() / np.sqrt(SAMPLES)
    assert abs(estimates.mean() - irradiance(point, ns)) < 4.0 * error + 1e-12


@pytest.mark.parametrize("place", ["above", "aside", "one corner up", "two corners up"])
def test_samples_vary_less_than_even_ones(place):
    """Their variance is a tenth of that of places spread evenly, or less."""
    point, ns = PLACES[place]
    b1, b2, density, mean = sampled(point, ns)
    estimates = sent(point, ns, b1, b2) / density
    random = np.random.default_rng(9).random((2, SAMPLES))
    even = sent(point, ns, *np.where(random.sum(axis=0) > 1.0, 1.0 - random, random))
    assert estimates.var() < 0.1 * even.var()
    assert mean == pytest.approx(estimates.mean(), rel=0.2)


@pytest.mark.parametrize("place", PLACES)
def test_samples_have_their_density(place):
    """χ² over the cells of a grid; none lies outside of the triangle or below the horizon."""
    point, ns = PLACES[place]
    b1, b2, density, _ = sampled(point, ns)
    assert (density > 0.0).all()
    assert min(b1.min(), b2.min(), (1.0 - b1 - b2).min()) >= -1e-12
    assert (sent(point, ns, b1, b2) > 0.0).mean() > 0.9999
    n = 6
    cell = np.minimum((b1 * n).astype(int), n - 1) * n + np.minimum((b2 * n).astype(int), n - 1)
    # 1 / density sums to the lit area of each cell, in units of the triangle's; so compare with
    # that of samples spread evenly.
    random = np.random.default_rng(8).random((2, 4 * SAMPLES))
    flip = random.sum(axis=0) > 1.0
    c1, c2 = np.where(flip, 1.0 - random, random)
    lit = sent(point, ns, c1, c2) > 0.0
    even = np.minimum((c1 * n).astype(int), n - 1) * n + np.minimum((c2 * n).astype(int), n - 1)
    areas = np.bincount(even[lit], minlength=n * n) / len(c1)
    weighed = np.bincount(cell, 1.0 / density, minlength=n * n) / SAMPLES
    squares = np.bincount(cell, 1.0 / density**2, minlength=n * n) / SAMPLES
    variance = (squares - weighed**2) / SAMPLES + areas * (1.0 - areas) / len(c1)
    busy = np.bincount(cell, minlength=n * n) > 100
    score = ((weighed - areas)[busy] ** 2 / variance[busy]).sum()
    assert stats.chi2.sf(score, busy.sum()) > SIGNIFICANCE


def test_a_lamp_below_the_horizon_gets_no_samples():
    for point, ns in (((0.0, 2.0, 0.0), (0.0, 1.0, 0.0)), ((0.0, 0.0, 0.0), (0.0, -1.0, 0.0))):
        _, _, density, mean = sampled(point, ns)
        assert mean == 0.0
        assert not density.any()
