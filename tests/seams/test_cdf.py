"""Cumulative distributions: how they are made, taken apart, and drawn from."""

import numpy as np
import pytest
from helpers.comparisons import chi_squared
from scipy import stats

from photonmap.compile.lights.probabilities import make_cdf, probabilities_of
from photonmap.kernels.core import rng, warp
from photonmap.kernels.core.jit import kernel

SAMPLES = 100_000
SIGNIFICANCE = 1e-4 / 20
"""Of one of 20 tests at most: 1e-4 for all of them together (Bonferroni)."""
WEIGHTS = {
    "even": np.ones(7),
    "one item": np.array([3.0]),
    "zeros": np.array([0.0, 2.0, 0.0, 0.0, 1.0, 5.0, 0.0]),
    "far apart": np.array([1e-300, 1e-12, 1.0, 1e12, 1e-12]),
    "tiny": np.array([3.0, 1.0, 2.0]) * 1e-310,
}

each_kind = pytest.mark.parametrize("weights", WEIGHTS.values(), ids=WEIGHTS)


@kernel
def _draw_all(cdf, key, drawn, renewed):
    state = rng.stream(key, 0, 0)
    for i in range(len(renewed)):
        u, state = rng.draw(state)
        drawn[i], renewed[i] = warp.discrete(cdf, u)


def draw_all(cdf, key=4):
    """Return the item of each draw, and the random number that it leaves."""
    drawn, renewed = np.empty(SAMPLES, np.int64), np.empty(SAMPLES)
    _draw_all(cdf, np.uint64(key), drawn, renewed)
    return drawn, renewed


@each_kind
def test_a_cdf_rises_to_exactly_1(weights):
    cdf = make_cdf(weights)
    assert cdf.dtype == np.float64
    assert cdf.shape == weights.shape
    assert cdf[-1] == 1.0
    assert cdf[0] >= 0.0
    assert (np.diff(cdf) >= 0.0).all()
    assert (np.diff(cdf, prepend=0.0)[weights == 0.0] == 0.0).all()


@each_kind
def test_probabilities_are_in_proportion_to_weights(weights):
    truth = weights / weights.max() / (weights / weights.max()).sum()
    probabilities = probabilities_of(make_cdf(weights))
    np.testing.assert_allclose(probabilities, truth, atol=1e-15)
    assert probabilities.sum() == pytest.approx(1.0, abs=1e-15)
    each = [warp.discrete_pdf(make_cdf(weights), i) for i in range(len(weights))]
    np.testing.assert_array_equal(each, probabilities)


@each_kind
def test_items_are_drawn_as_often_as_they_weigh(weights):
    """χ²; those of weight 0 never are; of each item, what is left of the numbers is uniform."""
    cdf = make_cdf(weights)
    drawn, renewed = draw_all(cdf)
    counts = np.bincount(drawn, minlength=len(cdf))
    assert counts.shape == cdf.shape
    assert (counts[weights == 0.0] == 0).all()
    if np.count_nonzero(counts) > 1:
        assert chi_squared(counts, SAMPLES * probabilities_of(cdf)) > SIGNIFICANCE
    for item in np.flatnonzero(counts):
        assert stats.kstest(renewed[drawn == item], "uniform").pvalue > SIGNIFICANCE


@pytest.mark.parametrize("count", [10, 1000, 100_000])
def test_rounding_leaves_the_last_item_at_1(count):
    """Sums of many weights do not round to more or less than 1, and never fall."""
    cdf = make_cdf(np.random.default_rng(count).uniform(0.0, 1.0, count))
    assert cdf[-1] == 1.0
    assert cdf.max() == 1.0
    assert (np.diff(cdf) > 0.0).all()


def test_float32_weights_are_summed_in_float64():
    weights = np.full(1 << 20, 0.1, np.float32)
    cdf = make_cdf(weights)
    np.testing.assert_allclose(cdf[::4096], (np.arange(1 << 20)[::4096] + 1) / (1 << 20), rtol=1e-9)


def test_where_all_weights_are_0_so_is_the_cdf():
    """Rows of a map without light; the others are not touched by it."""
    rows = make_cdf(np.array([[1.0, 3.0], [0.0, 0.0], [0.0, 2.0]]))
    np.testing.assert_array_equal(rows, [[0.25, 1.0], [0.0, 0.0], [0.0, 1.0]])
    np.testing.assert_array_equal(probabilities_of(rows[0]), [0.25, 0.75])
    assert not make_cdf(np.zeros(3)).any()


def test_the_last_axis_counts():
    weights = np.random.default_rng(2).uniform(size=(3, 4, 5))
    whole = make_cdf(weights)
    for index in np.ndindex(3, 4):
        np.testing.assert_array_equal(whole[index], make_cdf(weights[index]))
