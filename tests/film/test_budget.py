import math

import pytest

from photonmap.errors import InputError
from photonmap.film.budget import BUFFERS, CEILING, DEFAULT_ERROR, LEAST_PASSES, Budget, Goal
from photonmap.kernels.film.moments import GOAL_BUFFERS


def test_default():
    assert Budget.choose().goal == Goal(DEFAULT_ERROR)


def test_passes():
    budget = Budget.choose(passes=3)
    assert [budget.is_spent(n, 0.0, 1e9) for n in range(5)] == [False, False, False, True, True]


def test_seconds_begin_no_pass_that_would_end_late():
    budget = Budget.choose(seconds=10.0)
    assert not budget.is_spent(0, math.inf, 0.0)
    assert not budget.is_spent(4, math.inf, 7.9)
    assert budget.is_spent(4, math.inf, 8.1)


def test_a_budget_ends_at_what_comes_first():
    budget = Budget.choose(error=0.1, seconds=10.0)
    assert budget.is_spent(LEAST_PASSES, 0.1, 1.0)
    assert not budget.is_spent(LEAST_PASSES, 0.11, 1.0)
    assert budget.is_spent(4, math.inf, 8.1)
    assert budget.describe() == {"error": 0.1, "seconds": 10.0}
    passes = Budget.choose(error=0.1, passes=12)
    assert [passes.is_spent(count, 0.11, 1e9) for count in (11, 12)] == [False, True]
    assert passes.is_spent(LEAST_PASSES, 0.1, 1.0)


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"error": -1}, "error -1 must be positive"),
        ({"error": math.nan}, "error nan must be positive"),
        ({"error": "shade:0.1"}, "did you mean 'shading'"),
        ({"seconds": "16"}, "seconds '16' must be a positive and finite number"),
        ({"seconds": -1.0}, "seconds -1.0 must be a positive"),
    ],
)
def test_a_wrong_value_is_told_before_a_wrong_combination(other, named):
    with pytest.raises(InputError, match=named):
        Budget.choose(passes=1, **other)


def test_error_is_not_believed_too_early():
    budget = Budget.choose(error=0.1)
    assert not budget.is_spent(LEAST_PASSES - 1, 0.01, 1.0)
    assert budget.is_spent(LEAST_PASSES, 0.1, 1.0)
    assert not budget.is_spent(LEAST_PASSES, 0.11, 1.0)
    assert budget.is_spent(LEAST_PASSES, 0.11, CEILING)


@pytest.mark.parametrize(
    ("text", "goal", "described"),
    [
        (0.02, Goal(0.02), 0.02),
        ("0.02", Goal(0.02), 0.02),
        ("radiance:1e-2", Goal(0.01), 0.01),
        ("shading:0.02", Goal(0.02, "shading"), "shading:0.02"),
        ("indirect:p95:0.01", Goal(0.01, "indirect", 95.0), "indirect:p95:0.01"),
        ("radiance:p99.9:0.1", Goal(0.1, "radiance", 99.9), "radiance:p99.9:0.1"),
    ],
)
def test_goals(text, goal, described):
    assert Goal.parse(text) == goal
    assert Goal.parse(str(goal)) == goal
    assert Budget.choose(error=text).describe() == {"error": described}


def test_goals_are_of_the_buffers_that_kernels_judge():
    assert BUFFERS == GOAL_BUFFERS


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("little", "'little'"),
        ("", "''"),
        ("indirect:", "0.02"),
        ("indirect:95:0.01", "'95'"),
        ("indirect:p:0.01", "'p'"),
        ("indirect:p0:0.01", "'p0'"),
        ("indirect:p101:0.01", "'p101'"),
        ("indirect:pnan:0.01", "'pnan'"),
        ("indrect:0.01", "did you mean 'indirect'"),
        ("depth:0.01", "'depth:0.01'"),
        ("indirect:p95:0.01:1", "'indirect:p95:0.01:1'"),
        ("indirect:p95:-1", "positive"),
        ("nan", "positive"),
        ("inf", "positive"),
        ("2", "200%; write a fraction, as 0.02 for 2%"),
        ("indirect:p95:2", "200%"),
    ],
)
def test_bad_goals_are_told_in_one_line(text, named):
    with pytest.raises(InputError) as caught:
        Goal.parse(text)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "choice",
    [
        {"error": 0.0},
        {"error": "x"},
        {"seconds": math.nan},
        {"passes": 2.5},
    ],
)
def test_bad_choices(choice):
    with pytest.raises(InputError):
        Budget.choose(**choice)
