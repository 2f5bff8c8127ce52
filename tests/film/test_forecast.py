"""The time that is left, forecast from passes of known pace and noise."""

import math

import pytest

import photonmap as pm
from photonmap.film.bias import FOOTPRINTS_HOLD
from photonmap.film.budget import Budget
from photonmap.film.forecast import Forecast


def test_passes_at_an_even_pace_after_a_slow_start():
    forecast = Forecast(Budget.choose(passes=50))
    for count in range(1, 51):
        assert forecast.total(count, math.inf, 3.0 + 2.0 * count, 3.0) == pytest.approx(103.0)
    assert [elapsed for elapsed, _ in forecast.pairs] == [5.0, 7.0, 11.0, 19.0, 35.0, 67.0]


def test_seconds_end_with_the_last_pass_that_fits():
    forecast = Forecast(Budget.choose(seconds=10.0))
    assert forecast.total(1, math.inf, 4.0, 1.0) == pytest.approx(8.0)
    assert forecast.total(3, math.inf, 9.0, 1.0) == pytest.approx(9.0)
    assert Forecast(Budget.choose(seconds=1.0)).total(1, math.inf, 4.0, 0.0) == 4.0


def test_an_error_falls_with_the_root_of_passes():
    forecast = Forecast(Budget.choose(error=0.02), sharing=False)
    assert forecast.total(1, math.inf, 1.0, 0.0) == math.inf
    assert forecast.pairs == []
    assert forecast.total(4, 0.1, 4.0, 0.0) == pytest.approx(100.0)
    assert forecast.total(3, 0.02, 3.0, 0.0) == pytest.approx(4.0)
    assert forecast.total(25, 0.04, 25.0, 0.0) == pytest.approx(100.0)


def test_an_error_falls_slower_where_windows_shrink():
    """The variance of pass i is (1 + i / hold)^(1/3): its sum over passes is known."""

    def error(passes):
        variance = sum((1.0 + i / FOOTPRINTS_HOLD) ** (1 / 3) for i in range(passes))
        return math.sqrt(variance) / passes

    limit = error(5000)
    forecast = Forecast(Budget.choose(error=limit))
    for count in (8, 64, 500, 4000):
        predicted = forecast.total(count, error(count), 0.1 * count, 0.0)
        assert predicted == pytest.approx(500.0, rel=0.02)


def test_an_error_that_takes_too_long_ends_with_the_time():
    forecast = Forecast(Budget.choose(error=1e-9))
    assert forecast.total(2, 1.0, 20.0, 0.0) == pytest.approx(3600.0)


def test_earlier_runs_count_but_not_their_pace():
    forecast = Forecast(Budget.choose(passes=100), count=60, elapsed=1000.0)
    assert forecast.total(62, 0.1, 1005.0, 1.0) == pytest.approx(1081.0)


def test_the_record_tells_what_was_predicted():
    result = pm.render(pm.scenes.cornell_box(), bands=1, size=(16, 16), passes=9)
    pairs = result.record["predicted_seconds"]
    assert len(pairs) == 4
    assert all(0.0 < elapsed <= total for elapsed, total in pairs)
