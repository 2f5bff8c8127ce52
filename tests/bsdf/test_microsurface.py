"""Walks on a microsurface: densities, energy, reciprocity, and the limit of a smooth surface."""

import math

import numpy as np
import pytest
from scipy.special import beta as beta_function
from scipy.stats import chi2

from photonmap.kernels.bsdf import microsurface
from photonmap.kernels.core import rng, vec
from photonmap.kernels.core.jit import kernel

METAL = microsurface.METAL
GOLD = np.array([1.0, 0.8, 0.4], np.float32)
BELOW = [1.0, 1.0, -1.0]
PANE = -1.5
INDICES = [METAL, 1 / 1.5, 1 / 2.5, 1.5, PANE]
"""Of the side of wi over that of the other; of a pane minus its own."""
UNEVEN = [(0.6, 0.15), (0.1, 0.9)]
"""α along the first axis and the second"""


@kernel
def _scatter_all(alpha, eta, metal, wi, key, wo, weights):
    state = rng.stream(key, 0, 0)
    for i in range(len(wo)):
        numbers, state = rng.draw_three(state)
        out, _, state = microsurface.scatter(alpha, eta, metal, wi, numbers, state, weights[i])
        wo[i, 0], wo[i, 1], wo[i, 2] = out


@kernel
def _evaluate_all(alpha, eta, metal, wi, wo, key, weights, values):
    state = rng.stream(key, 1, 0)
    for i in range(len(wo)):
        pair = wi, vec.row(wo, i)
        state = microsurface.evaluate(alpha, eta, metal, pair, state, weights, values[i])


@kernel
def _single_all(alpha, eta, wi, wo, values):
    for i in range(len(wo)):
        values[i] = microsurface.single(alpha, eta, wi, vec.row(wo, i))[0]


NO_DIP = np.zeros((1, 0, 0), np.float32)


def widths(alpha):
    """Return α along both axes, as kernels take it."""
    return (True, *alpha) if isinstance(alpha, tuple) else (None, alpha, alpha)


def width_of(alpha):
    """Return about how wide a lobe is."""
    return float(np.sqrt(np.prod(np.broadcast_to(alpha, 2))))


def scatter(alpha, eta, wi, count=200_000, f0=GOLD, dip=NO_DIP):
    """Return directions, (n, 3), and what is left of a throughput of 1, (n, 3)."""
    wo, weights = np.empty((count, 3)), np.ones((count, 3), np.float32)
    _scatter_all(widths(alpha), eta, (f0, (dip, 0)), wi, np.uint64(7), wo, weights)
    return wo, weights.astype(float)


def evaluate(alpha, eta, wi, wo, f0=GOLD, dip=NO_DIP):
    """Return unbiased estimates of the density of each wo, (n, 3)."""
    wo = np.ascontiguousarray(wo, float)
    values, weights = np.empty((len(wo), 3), np.float32), np.empty(3, np.float32)
    _evaluate_all(widths(alpha), eta, (f0, (dip, 0)), wi, wo, np.uint64(3), weights, values)
    return values.astype(float)


def single(alpha, eta, wi, wo):
    """Return the density of each wo after one facet, (n,)."""
    wo = np.ascontiguousarray(wo, float)
    values = np.empty(len(wo))
    _single_all(widths(alpha), eta, wi, wo, values)
    return values


def at(cosine, azimuth=0.3):
    """Return a unit vector above the surface."""
    sine = math.sqrt(1.0 - cosine * cosine)
    return sine * math.cos(azimuth), sine * math.sin(azimuth), cosine


def on_the_sphere(count, seed=5):
    """Return uniform directions, (n, 3)."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def spread_around(axis, width, random, count):
    """Return directions about an axis, (n, 3), by Henyey and Greenstein's phase function."""
    g, u = 1.0 - min(width, 0.9), random.random(count)
    cosine = (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * u)) ** 2) / (2.0 * g)
    across = np.cross(axis, random.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return cosine[:, None] * axis + np.sqrt(1.0 - np.minimum(cosine**2, 1.0))[:, None] * across


def spread(axis, width, wo):
    """Return the density of `spread_around` (per steradian)."""
    g = 1.0 - min(width, 0.9)
    return (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * (wo @ axis)) ** 1.5)


def where_light_goes(alpha, eta, wi, count, seed=5):
    """Return directions, (n, 3), and their densities: everywhere, and more where lobes are."""
    (x, y, z), alpha = wi, width_of(alpha)
    lobes = [(np.array([-x, -y, z]), alpha)]
    squared = 1.0 - eta**2 * (1.0 - z**2)
    if eta == PANE:
        lobes.append((np.array([-x, -y, -z]), alpha))
    elif eta != METAL and squared > 0.0:
        below = np.array([-eta * x, -eta * y, -math.sqrt(squared)])
        lobes.append((below, alpha * abs(1.0 - eta)))
    random, share = np.random.default_rng(seed), 1.0 / (1 + len(lobes))
    part = int(count * share)
    parts = [on_the_sphere(part, seed)]
    parts += [spread_around(axis, width, random, part) for axis, width in lobes]
    wo = np.concatenate(parts)
    density = 1.0 / (4.0 * np.pi) + sum(spread(axis, width, wo) for axis, width in lobes)
    return wo, share * density


def cells(wo, heights=12, turns=8):
    """Return the cell of the sphere, of equal areas, in which each direction lies."""
    row = np.minimum(((wo[:, 2] + 1.0) * 0.5 * heights).astype(int), heights - 1)
    turn = ((np.arctan2(wo[:, 1], wo[:, 0]) / (2 * np.pi)) % 1.0 * turns).astype(int)
    return row * turns + np.minimum(turn, turns - 1)


def share_of_cells(wo, values):
    """Return the mean of values that fall into each cell, and its variance."""
    where, count = cells(wo), len(wo)
    mean = np.bincount(where, values, 96) / count
    return mean, (np.bincount(where, values**2, 96) / count - mean**2) / count


@pytest.mark.parametrize("cosine", [0.95, 0.4])
@pytest.mark.parametrize("eta", INDICES)
@pytest.mark.parametrize("alpha", [0.3, 1.0, UNEVEN[0]])
def test_walks_follow_their_density(alpha, eta, cosine):
    """χ² over cells of the sphere, of walks and of the mean density at random directions."""
    wi = at(cosine)
    walked, weights = scatter(alpha, eta, wi, 60_000)
    wo, density = where_light_goes(alpha, eta, wi, 150_000)
    estimates = evaluate(alpha, eta, wi, wo) / density[:, None]
    for band in (0, 2) if eta == METAL else (0,):
        found, error = share_of_cells(walked, weights[:, band])
        expected, other = share_of_cells(wo, estimates[:, band])
        used = found > 2e-3
        chi = ((found - expected)[used] ** 2 / (error + other)[used]).sum()
        assert used.sum() >= 5
        assert chi < chi2.ppf(0.9999, used.sum())
        allowed = 5.0 * np.sqrt((error + other)[~used].sum())
        assert abs(found[~used].sum() - expected[~used].sum()) <= allowed


@pytest.mark.parametrize("eta", [METAL, 1 / 1.1, 1 / 2.5, 1.1, 2.5, -1.1, -2.5])
@pytest.mark.parametrize("alpha", [1e-3, 0.1, 1.0, (1.0, 1e-3), (0.05, 0.3)])
def test_white_furnace(alpha, eta):
    """All light leaves, on unit vectors; and none by giving up the walk."""
    for cosine in (1.0, 0.6, 0.2, 0.05):
        wo, weights = scatter(alpha, eta, at(cosine), 10_000, np.ones(3, np.float32))
        assert (weights == 1.0).all()
        np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1.0, atol=1e-9)
        if eta == METAL:
            assert (wo[:, 2] >= 0.0).all()


@pytest.mark.parametrize("eta", INDICES)
@pytest.mark.parametrize("alpha", [1e-3, 0.05, 0.3, 1.0, *UNEVEN])
def test_densities_add_up_to_all_light(alpha, eta):
    """Within half a percent, with nothing of the walk but its densities."""
    for cosine in (0.9, 0.3):
        wi = at(cosine)
        count = 300_000 if alpha in UNEVEN else 100_000
        wo, density = where_light_goes(alpha, eta, wi, count)
        values = evaluate(alpha, eta, wi, wo, np.ones(3, np.float32))[:, 0] / density
        error = values.std() / np.sqrt(len(values))
        assert abs(values.mean() - 1.0) < 0.005 + 4.0 * error
        assert error < 0.01


def fresnel(cosine, eta):
    """Return Fresnel's reflectance, by the amplitudes of both polarisations."""
    beyond = np.sqrt(np.maximum(1.0 - eta**2 * (1.0 - cosine**2), 0.0))
    s = (eta * cosine - beyond) / (eta * cosine + beyond)
    p = (cosine - eta * beyond) / (cosine + eta * beyond)
    return np.where(beyond > 0.0, 0.5 * (s**2 + p**2), 1.0)


def smith(alpha, w):
    """Return Smith's Λ by α in the azimuth of w, (n, 3)."""
    along, across = np.broadcast_to(alpha, 2)
    x, y, z = np.moveaxis(w, -1, 0)
    azimuth = np.arctan2(y, x)
    alpha = np.hypot(along * np.cos(azimuth), across * np.sin(azimuth))
    return 0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / z**2 - 1.0)) - 1.0)


def walter(alpha, eta, wi, wo):
    """Return BSDF · cosine by equations 20 and 21 of Walter et al. 2007, with G2 over heights."""
    wi = np.asarray(wi)
    n_i, n_o = eta, 1.0
    reflects = wo[:, 2] > 0.0
    h = np.where(reflects[:, None], wi + wo, -(n_i * wi + n_o * wo))
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    h *= np.sign(h[:, 2:])
    i_h, o_h = h @ wi, (wo * h).sum(axis=1)
    along, across = np.broadcast_to(alpha, 2)
    slopes = (h[:, 0] / h[:, 2] / along) ** 2 + (h[:, 1] / h[:, 2] / across) ** 2
    d = 1.0 / (np.pi * along * across * h[:, 2] ** 4 * (1.0 + slopes) ** 2)
    a, b = smith(alpha, wi), smith(alpha, wo * np.where(reflects, 1.0, -1.0)[:, None])
    f = fresnel(i_h, eta)
    reflected = f * d / (1.0 + a + b) / (4.0 * wi[2])
    sent = np.abs(i_h * o_h) / wi[2] * n_o**2 * (1.0 - f) * beta_function(1 + a, 1 + b) * d
    sent /= (n_i * i_h + n_o * o_h) ** 2
    there = (i_h > 0.0) & (o_h * wo[:, 2] > 0.0)
    return np.where(there, np.where(reflects, reflected, sent), 0.0)


@pytest.mark.parametrize("eta", [1 / 1.1, 1 / 1.5, 1 / 2.5, 1.5, 2.5])
@pytest.mark.parametrize("alpha", [0.01, 0.2, 0.5, 1.0, (1.0, 0.01), *UNEVEN])
def test_single_scattering_is_walters(alpha, eta):
    for cosine in (1.0, 0.7, 0.1):
        wo = on_the_sphere(2000)
        expected = walter(alpha, eta, at(cosine), wo)
        np.testing.assert_allclose(single(alpha, eta, at(cosine), wo), expected, 1e-8, 1e-13)


@pytest.mark.parametrize("alpha", [0.7, (0.8, 0.3)])
@pytest.mark.parametrize("eta", [PANE, 1 / 1.5, 1.5, METAL])
def test_reciprocity(eta, alpha):
    """BSDF · n² of the side that light comes from is the same when light is turned round.

    Away from grazing angles: few walks make most of what facets of two widths scatter there.
    """
    rng_, many = np.random.default_rng(2), 50_000
    for wi, wo in zip(on_the_sphere(4, 3), on_the_sphere(4, 4), strict=True):
        wi, wo = wi * np.sign(wi[2]) * [1, 1, 1], wo * (rng_.choice([-1, 1]) if eta else 1)
        wi[2], wo[2] = abs(wi[2]), abs(wo[2]) if eta == METAL else wo[2]
        wi, wo = (w + [0.0, 0.0, 0.5 * np.sign(w[2])] for w in (wi, wo))
        wi, wo = (w / np.linalg.norm(w) for w in (wi, wo))
        through = wo[2] < 0.0
        other = 1.0 / eta if through and eta > 0.0 else eta
        there, back = (wo * BELOW, wi * BELOW) if through else (wo, wi)
        forth = evaluate(alpha, eta, tuple(wi), np.tile(wo, (many, 1)))
        back = evaluate(alpha, other, tuple(there), np.tile(back, (many, 1)))
        forth *= (eta**2 if through and eta > 0.0 else 1.0) / abs(wo[2])
        back /= wi[2]
        error = np.hypot(forth.std(axis=0), back.std(axis=0)) / np.sqrt(many)
        assert (np.abs(forth.mean(axis=0) - back.mean(axis=0)) <= 4.0 * error + 1e-6).all()


@pytest.mark.parametrize("eta", [1 / 1.5, 1.5, 1 / 2.5])
@pytest.mark.parametrize("cosine", [1.0, 0.8, 0.4])
def test_the_limit_is_smooth_glass(eta, cosine):
    wi = np.array(at(cosine))
    wo, _ = scatter(1e-3, eta, tuple(wi), 100_000)
    up = wo[:, 2] > 0.0
    expected = float(fresnel(np.array(cosine), eta))
    assert abs(up.mean() - expected) < 0.003
    np.testing.assert_allclose(np.median(wo[up], axis=0), wi * [-1, -1, 1], atol=2e-3)
    if expected < 1.0:
        sine = eta * math.hypot(wi[0], wi[1])
        below = [-eta * wi[0], -eta * wi[1], -math.sqrt(1.0 - sine * sine)]
        np.testing.assert_allclose(np.median(wo[~up], axis=0), below, atol=3e-3)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("cosine", [0.9, 0.3])
def test_a_pane_reflects_once_as_metal_times_what_both_sides_reflect(alpha, cosine):
    """And sends the mirror image of the rest through: R = 2 r / (1 + r) at each facet."""
    wi, wo = at(cosine), on_the_sphere(2000)
    wo[:, 2] = np.abs(wo[:, 2])
    of_metal = single(alpha, METAL, wi, wo)
    h = np.asarray(wi) + wo
    r = fresnel((h @ wi) / np.linalg.norm(h, axis=1), 1.0 / 1.5)
    both = 2.0 * r / (1.0 + r)
    np.testing.assert_allclose(single(alpha, PANE, wi, wo), both * of_metal, 1e-9, 1e-13)
    below = single(alpha, PANE, wi, wo * BELOW)
    np.testing.assert_allclose(below, (1.0 - both) * of_metal, 1e-9, 1e-13)


@pytest.mark.parametrize("cosine", [1.0, 0.4])
def test_the_limit_of_a_pane_lets_light_straight_on(cosine):
    wi = np.array(at(cosine))
    wo, _ = scatter(1e-3, PANE, tuple(wi), 100_000)
    up = wo[:, 2] > 0.0
    r = float(fresnel(np.array(cosine), 1.0 / 1.5))
    assert abs(up.mean() - 2.0 * r / (1.0 + r)) < 0.005
    np.testing.assert_allclose(np.median(wo[up], axis=0), wi * [-1, -1, 1], atol=2e-3)
    np.testing.assert_allclose(np.median(wo[~up], axis=0), -wi, atol=2e-3)


@pytest.mark.parametrize(("above", "toward"), [(0.3, 1.2), (1.2, 0.3), (0.7, 0.7)])
def test_light_that_metal_scatters_twice_leaves_no_specks(above, toward):
    """Far from the mirror's direction, where walks from one end alone spread by up to 16 means."""
    wi, wo = (math.sin(above), 0.0, math.cos(above)), (0.0, math.sin(toward), math.cos(toward))
    found = evaluate(0.05, METAL, wi, np.tile(wo, (100_000, 1)))[:, 0]
    assert found.std() < 6.0 * found.mean()


@pytest.mark.parametrize("eta", INDICES)
@pytest.mark.parametrize("alpha", [0.05, 0.4, 1.0])
def test_the_same_roughness_along_both_axes_is_that_in_all_directions(alpha, eta):
    """Walks of the same random numbers, but for a few that rounding sends elsewhere."""
    wi, wo = at(0.5), on_the_sphere(2000)
    np.testing.assert_allclose(
        single((alpha, alpha), eta, wi, wo), single(alpha, eta, wi, wo), 1e-9, 1e-13
    )
    walked, weights = scatter((alpha, alpha), eta, wi, 5000)
    others, rests = scatter(alpha, eta, wi, 5000)
    near = np.isclose(walked, others, atol=1e-7).all(axis=1)
    assert near.mean() > 0.999
    np.testing.assert_allclose(weights[near], rests[near], 1e-5)
    near = np.isclose(evaluate((alpha, alpha), eta, wi, wo), evaluate(alpha, eta, wi, wo), 1e-4)
    assert near.mean() > 0.99


@pytest.mark.parametrize("eta", INDICES)
def test_axes_may_be_exchanged(eta):
    """With light turned by 90 degrees."""
    wi, wo = np.array(at(0.5)), on_the_sphere(2000)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    here = single((0.6, 0.15), eta, tuple(wi), wo)
    there = single((0.15, 0.6), eta, tuple(turn @ wi), wo @ turn.T)
    np.testing.assert_allclose(there, here, 1e-9, 1e-13)
    assert not np.allclose(single((0.15, 0.6), eta, tuple(wi), wo), here)
