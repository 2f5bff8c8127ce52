"""Intervals hold the truth as often as they state; tests have the p-values of counting by hand."""

import numpy as np
import pytest
from scipy.stats import binom

from photonmap import InputError
from photonmap.evaluate import intervals


def test_scores_are_grouped_by_scene():
    groups = intervals.group_by_scene([1.0, 2.0, np.nan, 4.0, np.nan], list("abaac"))
    assert [group.tolist() for group in groups] == [[1.0, 4.0], [2.0]]


def test_interval_of_two_scenes_by_hand():
    """Means are 1, 2 and 3 with probabilities 1/4, 1/2 and 1/4."""
    groups = [np.array([1.0]), np.array([3.0])]
    assert intervals.scene_interval(groups, level=0.9) == (1.0, 3.0)
    assert intervals.scene_interval(groups, level=0.4) == (2.0, 2.0)
    assert intervals.scene_interval(groups[:1]) is None


def test_interval_draws_scenes_not_images():
    """Ten equal images of a scene are no more evidence than one."""
    rng = np.random.default_rng(0)
    values = rng.normal(size=20)
    one = intervals.scene_interval([values[i : i + 1] for i in range(20)])
    ten = intervals.scene_interval([np.full(10, value) for value in values])
    assert one == pytest.approx(ten)


def test_interval_holds_the_mean_as_often_as_stated(monkeypatch):
    """Of 40 scenes, a percentile interval is short by a few per cent: (n − 1) / n, and z for t."""
    monkeypatch.setattr(intervals, "RESAMPLES", 199)
    rng = np.random.default_rng(1)
    trials, held = 150, 0
    for trial in range(trials):
        scenes = rng.normal(size=40)
        groups = [scene + 0.1 * rng.normal(size=3) for scene in scenes]
        low, high = intervals.scene_interval(groups, level=0.8, seed=trial)
        held += low <= 0.0 <= high
    low, high = binom.interval(0.999, trials, 0.78)
    assert low <= held <= high


def test_means_in_one_go_are_those_one_by_one():
    groups = [np.arange(1.0 + number) for number in range(6)]
    at_once = intervals.scene_interval(groups)
    assert at_once == pytest.approx(intervals.scene_interval(groups, lambda v: float(v.mean())))


def test_statistic_other_than_the_mean():
    groups = [np.array([float(i)]) for i in range(9)]
    found = intervals.scene_interval(groups, lambda values: float(np.max(values)))
    assert found.high == 8.0
    assert found.low < 8.0


def test_truth_interval_removes_the_noise_of_the_truth():
    """The estimate is exact; with a truth of noise σ its error is σ², with draws 2σ²."""
    rng = np.random.default_rng(2)
    sigma, pixels = 0.3, 2000
    held = 0
    for _ in range(200):
        noise = sigma * rng.normal(size=pixels)
        value = np.mean(noise**2)
        draws = [np.mean((noise + sigma * rng.normal(size=pixels)) ** 2) for _ in range(8)]
        low, high = intervals.truth_interval(value, draws)
        assert high < 0.3 * value
        held += low <= 0.0 <= high
    assert held >= 180


def test_truth_interval_by_hand():
    """Two draws 1 apart: t of one degree of freedom is 1 at 50%; √½ √(3/2)."""
    low, high = intervals.truth_interval(4.0, [4.5, 5.5], level=0.5)
    assert (low + high) / 2 == pytest.approx(3.0)
    assert (high - low) / 2 == pytest.approx((0.5 * 1.5) ** 0.5)
    assert intervals.truth_interval(4.0, [5.0]) is None


def test_paired_test_by_counting():
    """3 scenes: of 8 ways to swap, 2 have as great a difference as all in one direction."""
    first, second = [1.0, 2.0, 3.0, 3.0], [2.0, 3.5, 4.0, 4.0]
    assert intervals.paired_test(first, second, list("abcc")) == pytest.approx(2 / 8)
    assert intervals.paired_test(first, second, list("aaaa")) == 1.0
    assert intervals.paired_test(first, first, list("abcc")) == 1.0
    ten = np.arange(10.0)
    scenes = [str(number) for number in range(10)]
    assert intervals.paired_test(ten, ten + 1.0 + ten, scenes) == pytest.approx(2 / 1024)


def test_paired_test_leaves_out_what_one_lacks():
    first, second = [1.0, 2.0, 3.0, np.nan], [2.0, 3.5, 4.0, 99.0]
    assert intervals.paired_test(first, second, list("abcd")) == pytest.approx(2 / 8)
    with pytest.raises(InputError, match="no image has a score from both"):
        intervals.paired_test([np.nan, 1.0], [1.0, np.nan], list("ab"))
