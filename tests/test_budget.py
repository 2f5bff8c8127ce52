import math

import pytest

from photonmap.budget import CEILING, DEFAULT_ERROR, LEAST_PASSES, Budget
from photonmap.errors import InputError


def test_default():
    assert Budget.choose().error == DEFAULT_ERROR


def test_passes():
    budget = Budget.choose(passes=3)
    assert [budget.is_spent(n, 0.0, 1e9) for n in range(5)] == [False, False, False, True, True]
    assert budget.fraction(1, math.inf, 5.0) == pytest.approx(1 / 3)


def test_seconds_begin_no_pass_that_would_end_late():
    budget = Budget.choose(seconds=10.0)
    assert not budget.is_spent(0, math.inf, 0.0)
    assert not budget.is_spent(4, math.inf, 7.9)
    assert budget.is_spent(4, math.inf, 8.1)
    assert budget.fraction(4, math.inf, 5.0) == pytest.approx(0.5)


def test_error_is_not_believed_too_early():
    budget = Budget.choose(error=0.1)
    assert not budget.is_spent(LEAST_PASSES - 1, 0.01, 1.0)
    assert budget.is_spent(LEAST_PASSES, 0.1, 1.0)
    assert not budget.is_spent(LEAST_PASSES, 0.11, 1.0)
    assert budget.is_spent(LEAST_PASSES, 0.11, CEILING)
    assert budget.fraction(1, math.inf, 1.0) == 0.0
    assert budget.fraction(20, 0.2, 1.0) == pytest.approx(1 / 4)


@pytest.mark.parametrize(
    "choice",
    [{"passes": 1, "seconds": 1.0}, {"error": 0.0}, {"seconds": math.nan}, {"passes": 2.5}],
)
def test_bad_choices(choice):
    with pytest.raises(InputError):
        Budget.choose(**choice)
