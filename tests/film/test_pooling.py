"""Means, spreads and ratios of passes and of pooled runs, against NumPy over all passes at once."""

import numpy as np
import pytest

from photonmap.film.pooling import (
    error_of,
    pool_comoments,
    pool_errors,
    pool_means,
    shift_ratio,
    spread_of,
    sum_counts,
    take_in,
    variance_divisor,
)

RNG = np.random.default_rng(12)
X, Y = RNG.random((9, 4)) + 1.0, RNG.random((9, 4)) + 0.5
RUNS = (slice(0, 3), slice(3, 4), slice(4, 9))
COUNTS = [np.full(4, float(run.stop - run.start)) for run in RUNS]


def comoment(x, y):
    return ((x - x.mean(axis=0)) * (y - y.mean(axis=0))).sum(axis=0)


def means(values):
    return [values[run].mean(axis=0) for run in RUNS]


def own(x, y):
    return [comoment(x[run], y[run]) for run in RUNS]


def test_values_are_taken_in_one_by_one():
    mean, spread = np.zeros(4), np.zeros(4)
    for count, value in enumerate(X, start=1):
        take_in(value, count, mean, spread)
    np.testing.assert_allclose(mean, X.mean(axis=0))
    np.testing.assert_allclose(spread, comoment(X, X))


def test_runs_are_pooled():
    np.testing.assert_array_equal(sum_counts(COUNTS), 9.0)
    np.testing.assert_allclose(pool_means(COUNTS, means(X)), X.mean(axis=0))
    pooled = pool_comoments(COUNTS, means(X), means(Y), own(X, Y))
    np.testing.assert_allclose(pooled, comoment(X, Y))
    errors = [error_of(spread, n) for spread, n in zip(own(X, X), COUNTS, strict=True)]
    expected = X.std(axis=0, ddof=1) / 3.0
    np.testing.assert_allclose(pool_errors(COUNTS, means(X), errors), expected)


def test_equal_means_pool_to_exactly_themselves():
    value = np.float64(0.1)
    assert pool_means([np.array(3.0), np.array(7.0)], [value, value]) == value


@pytest.mark.parametrize("count", [0.0, 1.0])
def test_an_error_needs_two_passes(count):
    count = np.array(count)
    assert error_of(np.array(1.0), count) == np.inf
    assert spread_of(np.array(np.inf), count) == 0.0
    assert variance_divisor(count) == 0.0


def test_errors_and_spreads_are_inverse():
    count, spread = np.array(5.0), np.array(0.3)
    np.testing.assert_allclose(spread_of(error_of(spread, count), count), spread)


@pytest.mark.parametrize("old", [0.0, 0.7])
def test_the_spread_of_a_ratio_is_that_of_its_linearisation(old):
    new = X.mean(axis=0) / Y.mean(axis=0)
    start = comoment(X - old * Y, X - old * Y)
    shifted = shift_ratio(start, comoment(X, Y), comoment(Y, Y), old, new)
    np.testing.assert_allclose(shifted, comoment(X - new * Y, X - new * Y))
