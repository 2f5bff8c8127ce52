"""Intervals and tests for scores: over scenes, and over the errors of the ground truth itself.

Images of one scene in several lights are not independent, so that whole scenes are drawn, swapped
and counted, never single images.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats

LEVEL = 0.95  # Confidence of intervals
ENOUGH_SCENES = 10  # Scenes; over fewer, intervals of a bootstrap are too narrow
RESAMPLES = 1999  # Samples of scenes that a bootstrap draws
_SWAPS = 9999  # Largest number of ways to swap two methods that a test goes through

Statistic = Callable[[Floats], float]


class Interval(NamedTuple):
    """The ends of a confidence interval."""

    low: float
    high: float


def mean(values: Floats) -> float:
    """Return the mean of (K,) scores."""
    return float(np.mean(values))


def group_by_scene(values: Any, scenes: Sequence[str]) -> list[Floats]:
    """Return the finite ones of (K,) scores by scene, in order of appearance; nan is no score."""
    scores, names = np.asarray(values, np.float64), np.asarray(scenes, object)
    known = np.isfinite(scores)
    return [scores[known & (names == name)] for name in dict.fromkeys(names[known].tolist())]


def scene_interval(
    groups: Sequence[Floats], statistic: Statistic = mean, level: float = LEVEL, seed: int = 0
) -> Interval | None:
    """Return the bootstrap interval of a statistic of all scores when scenes are drawn anew.

    The percentile interval of B. Efron and R. J. Tibshirani, "An Introduction to the Bootstrap",
    1993, chapter 13, of clusters. It is too narrow for fewer than `ENOUGH_SCENES` scenes
    or so.

    Parameters
    ----------
    groups : scores of each scene, as `group_by_scene` returns them
    statistic : of (K,) scores
    level : confidence
    seed : draws the scenes

    Returns
    -------
    None with fewer than two scenes
    """
    from scipy.stats import bootstrap

    if len(groups) < 2:
        return None

    sums, counts = (np.array([each(group) for group in groups]) for each in (np.sum, np.size))

    def means(numbers: Any, axis: int = -1) -> Any:
        return sums[numbers].sum(axis=axis) / counts[numbers].sum(axis=axis)

    def of_scenes(numbers: Any) -> float:
        return statistic(np.concatenate([groups[int(number)] for number in numbers]))

    is_mean = statistic is mean
    found = bootstrap(
        (np.arange(len(groups)),),
        means if is_mean else of_scenes,
        n_resamples=RESAMPLES,
        vectorized=is_mean,
        confidence_level=level,
        method="percentile",
        rng=np.random.Generator(np.random.PCG64(seed)),
    ).confidence_interval
    return Interval(float(found.low), float(found.high))


def truth_interval(value: float, draws: Any, level: float = LEVEL) -> Interval | None:
    """Return the interval for the score against a truth without noise.

    The score was computed with a truth that has noise; each draw is the score with the same noise
    added once more. Noise thus shifts the draws from the score about as far as it has shifted the
    score, and spreads them as much: the basic interval of a parametric bootstrap, normal, with
    Student's t for the number of draws.

    Parameters
    ----------
    value : the score
    draws : (D,) scores with noise added
    level : confidence

    Returns
    -------
    None with fewer than two draws
    """
    from scipy.stats import t

    drawn = np.asarray(draws, np.float64)
    count = len(drawn)
    if count < 2:
        return None
    middle = 2.0 * value - float(drawn.mean())
    quantile = float(t.ppf(0.5 + level / 2.0, count - 1))
    half = quantile * float(drawn.std(ddof=1)) * (1.0 + 1.0 / count) ** 0.5
    return Interval(middle - half, middle + half)


def paired_test(first: Any, second: Any, scenes: Sequence[str], seed: int = 0) -> float:
    """Return the p-value of equal mean scores of two methods: a permutation test over scenes.

    Within each scene, the mean scores of the two are swapped or not; p is the share of all such
    choices with as great a mean difference, two-sided. All are gone through up to 13 scenes, and
    9999 drawn at random beyond. Not corrected for the number of comparisons.

    Parameters
    ----------
    first, second : (K,) scores of the same images; those where one is nan are left out
    scenes : of each of the K images
    seed : draws swaps

    Raises
    ------
    InputError : no image has a score from both
    """
    from scipy.stats import permutation_test

    one, two = (np.asarray(values, np.float64) for values in (first, second))
    both = np.isfinite(one) & np.isfinite(two)
    if not both.any():
        raise InputError("no image has a score from both methods, so they cannot be compared")
    names = np.asarray(scenes, object)[both].tolist()
    means = [
        np.array([group.mean() for group in group_by_scene(values[both], names)])
        for values in (one, two)
    ]
    if len(means[0]) < 2:
        return 1.0
    found = permutation_test(
        means,
        lambda a, b: np.mean(a - b),
        permutation_type="samples",
        n_resamples=_SWAPS,
        vectorized=False,
        rng=np.random.Generator(np.random.PCG64(seed)),
    )
    return float(found.pvalue)
