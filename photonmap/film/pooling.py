"""Means and their standard errors: over passes taken in one by one, and pooled over runs.

A spread is a sum of squared deviations from a mean, a co-moment a sum of products of deviations
of two quantities from their means (Welford 1962; Chan, Golub and LeVeque 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.film.replicates import ONE_PASS
from photonmap.kernels.film.moments import Weight, shift_ratio, welford_step

__all__ = [
    "error_of", "pool_comoments", "pool_errors", "pool_means", "shift_ratio", "spread_of",
    "sum_counts", "take_in", "variance_divisor",
]  # fmt: skip

Array = NDArray[Any]


def take_in(
    value: Array, count: int, mean: Array, spread: Array, weight: Weight = ONE_PASS
) -> None:
    """Take a value into a running mean of `count` passes with it, and its spread, in place."""
    new_mean, gain, _ = welford_step(value, mean, weight.part / count)
    mean[...] = new_mean
    spread *= weight.keep
    spread += gain * weight.gain


def pool_means(counts: Sequence[Array], means: Sequence[Array]) -> Array:
    """Return the mean over all passes of several runs; exactly the value where all are the same.

    Arrays, of the passes of each run and of its mean, are of shapes that broadcast.
    """
    total = np.zeros_like(means[0])
    for count, mean in zip(counts[1:], means[1:], strict=True):
        total += count * (mean - means[0])
    return means[0] + total / np.maximum(sum_counts(counts), 1.0)


def pool_comoments(
    counts: Sequence[Array], x: Sequence[Array], y: Sequence[Array], own: Sequence[Array]
) -> Array:
    """Return the co-moment over all passes of several runs, of counts as for `pool_means`.

    x and y are the means of both quantities in each run, twice the same for spreads; `own` is the
    co-moment within it.
    """
    mean_x, mean_y = pool_means(counts, x), pool_means(counts, y)
    total = np.zeros_like(mean_x)
    for count, x_of_run, y_of_run, within in zip(counts, x, y, own, strict=True):
        total += within + count * ((x_of_run - mean_x) * (y_of_run - mean_y))
    return total


def pool_errors(counts: Sequence[Array], means: Sequence[Array], errors: Sequence[Array]) -> Array:
    """Return the standard error of the mean over all passes of several runs, from that of each.

    What the error is does not matter where a run has one pass.
    """
    spreads = [spread_of(error, count) for error, count in zip(errors, counts, strict=True)]
    return error_of(pool_comoments(counts, means, means, spreads), sum_counts(counts))


def sum_counts(counts: Sequence[Array]) -> Array:
    """Return the number of all passes."""
    return np.sum(counts, axis=0)


def spread_of(error: Array, count: Array) -> Array:
    """Return the spread that a standard error of a mean of `count` passes stands for, float64."""
    known = np.where(count > 1.0, error, 0.0).astype(np.float64)
    return known**2 * variance_divisor(count)


def error_of(spread: Array, count: Array) -> Array:
    """Return the standard error of a mean of `count` passes; infinite before the second."""
    error = np.sqrt(np.maximum(spread, 0.0) / np.maximum(variance_divisor(count), 1.0))
    return np.where(count > 1.0, error, np.inf)


def variance_divisor(count: Any) -> Any:
    """Return n (n − 1), by which a spread over n passes is divided for the mean's variance."""
    return count * np.maximum(count - 1.0, 0.0)
