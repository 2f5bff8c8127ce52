"""Standard errors are calibrated, pixel by pixel and band by band."""

import numpy as np
import pytest
from helpers.scenes import balls_in_box
from scipy import stats

import photonmap as pm
from photonmap.film.budget import PASS_SAMPLES
from photonmap.film.variance_smoothing import (
    PRIOR,
    ROUNDING,
    SAMPLES,
    UNSEEN,
    smooth_error,
    widen_ratio,
)

PASSES, SEEDS, SIZE = 16, 24, 20
CALIBRATED = ("radiance", "direct", "indirect", "shading", "residual", "reflectance")


def test_neighbours_count_for_some_passes():
    error = np.zeros((3, 3, 1), np.float32)
    error[1, 1:, 0] = 2.0, 1.0
    steady = smooth_error(error, np.ones_like(error), 17)[..., 0]
    assert steady[1, 1] == pytest.approx(np.sqrt((4.0 * 16.0 + PRIOR) / (16.0 + PRIOR)))
    assert steady[0, 0] == pytest.approx(2.0 * np.sqrt(UNSEEN / 8.0 / (16.0 + UNSEEN)))


def test_errors_of_zero_stay_zero():
    zeros = np.zeros((2, 3, 2), np.float32)
    assert not smooth_error(zeros, zeros, 4).any()


def test_neighbours_without_spread_say_nothing_of_a_pixel_that_has_some():
    error, value = np.zeros((1, 4, 1), np.float32), np.ones((1, 4, 1), np.float32)
    error[0, 1:3] = 2.0
    steady = smooth_error(error, value, 17).ravel()
    assert steady[1:3] == pytest.approx(2.0)
    assert steady[[0, 3]] == pytest.approx(2.0 * np.sqrt(3 / 8 * UNSEEN / (16.0 + UNSEEN)))


def test_an_edge_that_no_pass_saw_may_be_there():
    """In half a sample of all, of what a neighbour shows."""
    error, value = np.zeros((2, 3, 3, 1), np.float32)
    value[:, 0] = 3.0
    steady = smooth_error(error, value, 10, edges=1.0)[..., 0]
    np.testing.assert_allclose(steady[:, :2], 1.5 / (10 * SAMPLES), rtol=1e-5)
    of_halves = smooth_error(error, value, 10, edges=0.5)[..., 0]
    np.testing.assert_allclose(of_halves[:, :2], 2.0 * steady[:, :2], rtol=1e-5)
    assert not steady[:, 2].any()
    assert not smooth_error(error, value, 10)[:, 1:].any()
    error[1, 0] = 1e-6
    varies = smooth_error(error, value, 10, edges=1.0)[..., 0]
    assert varies[1, 0] < 1e-5


def test_centres_have_no_edges(cornell):
    center = pm.render(cornell, bands="rgb", size=(16, 16), passes=3, pixel="center")
    for name in ("emission", "reflectance"):
        error, value = center.standard_error(name), center.buffers[name]
        assert (error <= 2.0 * ROUNDING * value).all()


@pytest.mark.slow
@pytest.mark.parametrize("size", PASS_SAMPLES)
def test_edges_that_few_samples_see(size):
    """Of a pixel at whose border a surface ends; with 16 samples, most passes miss that."""
    scene = balls_in_box()
    settings = {"bands": "rgb", "size": (40, 40), "effects": "direct", "adaptive": False}
    settings["pass_samples"] = size
    runs = [pm.render(scene, **settings, passes=PASSES, seed=200 + seed) for seed in range(SEEDS)]
    assert_calibrated("reflectance", *gather_runs(runs, "reflectance"))


def test_variances_go_with_brightness():
    error, value = np.ones((2, 1, 3, 1), np.float32)
    value[0, 1] = 4.0
    mean = value.mean()
    ratio = np.sqrt((16.0 + mean**2) / (1.0 + mean**2))
    steady = smooth_error(error, value, 17).ravel()
    assert steady[1] == pytest.approx(
        np.sqrt((16.0 + PRIOR * (0.75 * ratio + 0.25)) / (16.0 + PRIOR))
    )


def test_sums_are_rounded():
    error, value = np.zeros((2, 1, 3, 1), np.float32)
    value[:] = 0.7
    assert smooth_error(error, value, 17).ravel() == pytest.approx(0.7 * 2.0**-23)


def test_a_wall_beside_a_lamp_is_no_lamp():
    error, value = np.zeros((2, 1, 3, 1), np.float32)
    error[0, 0], value[0] = 500.0, [[1000.0], [1.0], [1.0]]
    assert 0.0 < smooth_error(error, value, 16)[0, 1, 0] < 0.5 * value.mean()


def test_the_edge_of_an_area_light_has_no_halo():
    error = np.array([[20.0, 0.1, 0.1]], np.float32)[..., None]
    value = np.array([[100.0, 1.0, 1.0]], np.float32)[..., None]
    emits = np.array([[True, False, False]])
    with_halo = smooth_error(error, value, 16)[0, 1, 0]
    without = smooth_error(error, value, 16, emits=emits)[0, :, 0]
    assert with_halo > 1.0
    np.testing.assert_allclose(without[1:], 0.1, rtol=1e-6)
    assert without[0] == pytest.approx(20.0)


def test_ratios_of_uncertain_denominators_are_wider():
    one = np.ones((1, 3, 1), np.float32)
    denominator = np.array([0.0, 1.0, 2.0], np.float32).reshape(1, 3, 1)
    widened = widen_ratio(one, one, denominator, one)
    np.testing.assert_allclose(widened.ravel(), [1.0, 3.0, 1.5])


def test_a_ratio_of_few_samples_may_be_what_neighbours_show():
    ratio = np.array([[0.0, 0.5, 0.4]], np.float32)[..., None]
    denominator = np.array([[0.0, 0.01, 0.5]], np.float32)[..., None]
    uncertain = np.array([[0.001, 0.01, 0.0]], np.float32)[..., None]
    nothing = np.zeros_like(ratio)
    widened = widen_ratio(nothing, ratio, denominator, uncertain).ravel()
    np.testing.assert_allclose(widened, [0.5, 0.25, 0.0])
    black = ratio + 0.1  # irradiance is known there
    assert widen_ratio(nothing, black, denominator, uncertain)[0, 0] == 0.0
    alone = np.zeros_like(denominator)  # a mirror
    assert not widen_ratio(nothing, ratio, alone, alone).any()


@pytest.fixture(
    scope="module",
    params=[("cornell", 1.0, PASSES), ("balls", 1.0, PASSES), ("cornell", 0.125, PASSES // 2)],
)
def runs(request):
    """Many seeds of one scene: buffer to what `gather_runs` returns."""
    name, size, passes = request.param
    scene = {"cornell": pm.scenes.cornell_box, "balls": balls_in_box}[name]()
    settings = {"bands": "rgb", "size": (SIZE, SIZE), "pass_samples": size}
    runs = [pm.render(scene, **settings, passes=passes, seed=seed) for seed in range(SEEDS)]
    names = set(runs[0].buffers) & set(CALIBRATED)
    return {name: gather_runs(runs, name) for name in names if np.ptp(runs[0].buffers[name]) > 0.0}


def gather_runs(runs, name):
    """Values and standard errors of a buffer, (S, H, W, N) both, and the degrees of freedom."""
    values = np.array([run.buffers[name] for run in runs], float)
    errors = np.array([run.standard_error(name) for run in runs], float)
    return values, errors, np.array([run.degrees_of_freedom(name) for run in runs])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*successive reflections")
def test_intervals_cover_the_truth(runs):
    """Deviations from the other seeds' mean are Student's t, or less: spread, and 95% intervals.

    Pixels of caustics, and lamps seen in mirrors, are rarer events than 16 passes show.
    """
    for name, gathered in runs.items():
        assert_calibrated(name, *gathered)


def assert_calibrated(name, values, errors, freedom):
    live = np.ptp(values, axis=0) > 4.0 * ROUNDING * np.abs(values).max(axis=0)
    others = (values.sum(axis=0) - values) / (SEEDS - 1)
    deviation = (values - others) / np.sqrt(1.0 + 1.0 / (SEEDS - 1))
    assert (np.abs(deviation) <= 4.0 * errors)[:, ~live].all()
    freedom = freedom.reshape(len(freedom), *freedom.shape[1:] or (1, 1), 1)
    t = deviation / np.maximum(errors, 1e-30)
    scores = stats.norm.ppf(stats.t.cdf(np.clip(t, -1e3, 1e3), freedom))[:, live]
    # errors of filtered indirect light, pooled over pixels, may be as good as known: t is normal
    known = t[:, live] if name in ("radiance", "indirect", "shading") else scores
    for least, those, most in ((0.0, known, 0.97), (0.93, scores, 1.0)):
        held = np.mean(np.abs(those) < stats.norm.ppf(0.975))
        assert least <= held <= most, (name, held)
    for least, those, most in ((0.9, known, 8.0), (0.0, scores, 1.1)):
        spread = np.clip(those, -8.0, 8.0).std()
        assert least <= spread <= most, (name, spread)
