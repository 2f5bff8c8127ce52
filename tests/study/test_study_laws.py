"""Laws, corrections and the recommendation of a study, on synthetic data and made-up points."""

import csv
import io
import math

import numpy as np
import pytest

from photonmap.film.budget import LEAST_PASSES
from photonmap.study import measure
from photonmap.study.convergence import (
    PATH,
    Correction,
    Cost,
    Findings,
    Law,
    Power,
    change_beyond_noise,
    duration,
    fit_cost,
    fit_power,
    laws,
    pareto_front,
    percent,
    recommend,
    total_error,
    two_digits,
)
from photonmap.study.errors import ColorError
from photonmap.study.measure import COLUMNS, Point, Settings

OWN = {"radiance": 0.001, "direct": 0.001, "indirect": 0.001, "shading": 0.001}


def point(sweep="passes", bands="6", passes=16, error=0.02, seconds=1.0, off=None, **more):
    """A made-up point, stated and true alike; `off` is the colour error of its bands."""
    settings = Settings(
        bands=bands, passes=passes, photons=1000, method="path" if sweep == "path" else "photon"
    )
    errors = dict.fromkeys(OWN, error)
    color = off and ColorError(1.0, 2.0, 1.5, 3.0, off, off, off, 2.0 * off)
    given = {"label": f"{passes} passes", "rays": None, "photons": 1000 * passes, "wall": seconds}
    return Point(
        **{"sweep": sweep, "settings": settings, "seconds": seconds, "processor": 2.0 * seconds}
        | {"stated": errors, "true": errors, "mean_difference": 0.0, "color": color}
        | given
        | more
    )


def law(label, factor=0.1, each=0.1, spectral=0.0, indirect=math.nan, most=1000):
    return Law(label, Power(factor, -0.5), Cost(0.0, each), most, spectral, indirect)


def test_a_power_is_found_exactly():
    x = np.array([1.0, 2.0, 5.0, 100.0])
    found = fit_power(x, 3.0 * x**-0.5)
    assert found.factor == pytest.approx(3.0)
    assert found.exponent == pytest.approx(-0.5)
    assert found.uncertainty == pytest.approx(0.0, abs=1e-9)
    assert found.inverse(found.at(7.0)) == pytest.approx(7.0)


def test_the_uncertainty_of_slopes_is_honest():
    # 400 fits of 8 points: Student's t with 6 degrees of freedom, P(|t| > 3.707) = 1%.
    rng = np.random.default_rng(5)
    x = 2.0 ** np.arange(8)
    missed = 0
    for _ in range(400):
        found = fit_power(x, 0.2 * x**-0.5 * np.exp(rng.normal(0.0, 0.1, 8)))
        missed += abs(found.exponent + 0.5) > 3.707 * found.uncertainty
    assert missed <= 13  # binomial(400, 0.01) exceeds it with probability 1e-4


@pytest.mark.parametrize("x", [[], [1.0], [2.0, 2.0], [1.0, 0.0], [1.0, math.nan]])
def test_no_power_from_too_little(x):
    assert fit_power(x, [1.0] * len(x)) is None


def test_two_points_have_a_slope_without_uncertainty():
    found = fit_power([1.0, 4.0], [1.0, 0.5])
    assert found.exponent == pytest.approx(-0.5)
    assert math.isnan(found.uncertainty)


def test_costs():
    passes = [2, 8, 64]
    found = fit_cost(passes, [0.3 + 0.05 * count for count in passes])
    assert found.setup == pytest.approx(0.3)
    assert found.seconds(100) == pytest.approx(5.3)
    assert fit_cost([1, 2], [1.0, 5.0]).setup == 0.0  # never negative
    assert fit_cost([4], [2.0]) == Cost(0.0, 0.5)


def test_the_pareto_front():
    costs, errors = [1.0, 2.0, 2.0, 3.0, 4.0], [5.0, 4.0, 3.0, 3.5, 1.0]
    assert pareto_front(costs, errors) == [0, 2, 4]
    assert pareto_front([], []) == []


def test_estimates_know_where_they_were_measured():
    some = law("6 bands", factor=0.1, each=0.5, most=100)
    near, far, least = (some.seconds_to(target) for target in (0.0101, 0.00501, 0.9))
    assert (near.passes, near.extrapolated) == (99, False)
    assert (far.passes, far.extrapolated) == (399, True)
    assert far.seconds == pytest.approx(199.5)
    assert least.passes == LEAST_PASSES  # what --error never stops before
    assert law("3 bands", spectral=0.03).total_after(0.625 * 10) == pytest.approx(
        math.hypot(0.1 / math.sqrt(62.5), 0.03)
    )


def made_up():
    """Points of 3, 6 and 81 bands whose laws are known: 6 bands have error² · seconds = 0.01."""
    found = [
        point(passes=n, error=0.4 / math.sqrt(n), seconds=n / 16) for n in (2, 4, 8, 16, 32, 64)
    ]
    for bands, slower, off in (("81", 2.0, None), ("3", 0.5, 0.03), ("6", 1.0, 0.01)):
        found += [
            point("bands", bands, n, 0.4 / math.sqrt(n), slower * n / 16, off) for n in (8, 32)
        ]
    return found + [
        point("path", passes=n, error=4.0 / math.sqrt(n), seconds=n / 32) for n in (2, 8, 32)
    ]


def test_laws_of_made_up_points():
    three, six, many, path = laws(made_up(), "6", Correction())
    assert [some.label for some in (three, six, many, path)] == [
        "3 bands", "6 bands", "81 bands", PATH,
    ]  # fmt: skip
    assert six.noise.exponent == pytest.approx(-0.5)
    assert six.seconds_to(0.02).seconds == pytest.approx(25.0, rel=0.01)
    assert six.seconds_to(0.02).extrapolated
    assert three.cost.each == pytest.approx(0.5 * six.cost.each)
    assert many.cost.each == pytest.approx(2.0 * six.cost.each)
    assert (three.spectral, three.indirect) == (0.03, 0.06)
    assert path.seconds_to(0.1).seconds == pytest.approx(50.0, rel=0.01)
    assert laws([], "6", Correction()) == []


def test_the_recommendation_in_words():
    first, *rest = recommend(laws(made_up(), "6", Correction()), "6")
    assert first == (
        "1% error in shading: 100 s (extrapolated) with 6 bands, "
        "2.0% colour error in indirect light; "
        "50% of that time with 3 bands, but 6.0% colour error in indirect light; "
        "path tracing: 83 min (extrapolated)."
    )
    assert rest[0] == (
        "5% error in shading: 4.0 s with 6 bands; path tracing: 3.3 min (extrapolated)."
    )
    assert rest[-2] == (
        "However long the render, the colour error of shading never falls below 3.0% with 3 bands, "
        "1.0% with 6 bands."
    )
    assert rest[-1].startswith(
        "Noise and colour error of shading combined are smallest with 3 bands, from "
    )
    assert " on with 6 bands" in rest[-1]
    assert recommend([], "6") == []


def test_the_recommendation_of_more_bands():
    found = [law("6 bands", indirect=0.03), law("31 bands", each=0.12, indirect=0.001)]
    first = recommend(found, "6")[0]
    assert "; 1.2 times the time with 31 bands, 0.10% colour error in indirect light." in first
    assert "path" not in first


def test_numbers_in_words():
    assert [two_digits(value) for value in (0.0, 0.0123, 0.1, 9.94, 12.3, 1234.0)] == [
        "0", "0.012", "0.10", "9.9", "12", "1234",
    ]  # fmt: skip
    assert [duration(value) for value in (0.5, 119.0, 121.0, 7300.0)] == [
        "0.50 s", "119 s", "2.0 min", "2.0 h",
    ]  # fmt: skip
    assert percent(0.041) == "4.1%"


def test_stated_errors_are_corrected_where_the_truth_is_unknown():
    true = dict.fromkeys(OWN, 0.04)
    points = [point(error=0.02, true=true), point(error=0.02, true=dict.fromkeys(OWN, 0.0005))]
    found = Correction.measure(points, own_error=0.001)
    assert found.ratio == 2.0
    assert found.error(points[0]) == 0.04
    assert found.error(points[1]) == 0.04  # below the reference's own error: stated, corrected
    assert Correction.measure([], 0.001).ratio == 1.0
    total = total_error(points[0], found, {"6": (0.03, 0.1)})
    assert total == pytest.approx(0.05)


def test_findings_of_made_up_points():
    found = Findings(made_up(), "6", OWN)
    assert found.slope("passes", "shading").exponent == pytest.approx(-0.5)
    assert found.slope("path", "shading", by_passes=True).exponent == pytest.approx(-0.5)
    assert {p.settings.passes for _, p in found.most_passes("bands")} == {32}
    assert found.bias.settings.passes == 32
    seconds = [p.seconds for _, p in found.front]
    assert seconds == sorted(seconds)
    assert {p.settings.bands for _, p in found.front} == {"3", "6"}


def test_a_change_is_told_from_noise():
    noise = dict.fromkeys(OWN, 0.03)
    assert change_beyond_noise(point(stated=noise, true=dict.fromkeys(OWN, 0.05))) == pytest.approx(
        0.04
    )
    assert change_beyond_noise(point(stated=noise, true=dict.fromkeys(OWN, 0.031))) is None


def test_the_clock():
    points = [point(seconds=8.0)]
    assert measure.choose_clock(points, 0.02, threads=2) == points
    assert measure.choose_clock(points, 0.6, threads=4)[0].seconds == 4.0
    described = measure.describe_machine()
    assert described["processors"] >= 1
    assert described["processor"]
    with measure.BackgroundLoad() as others:
        pass
    assert others.share >= 0.0


def test_the_table_is_a_table():
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS)
    writer.writerow(point(off=0.01).row())
    assert len(next(csv.reader([text.getvalue()]))) == len(COLUMNS)
