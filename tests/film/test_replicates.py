"""Replicates: what their passes share, and errors that hold after any number of passes."""

import numpy as np
import pytest
from helpers.passes import setup_of

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.film import replicates
from photonmap.film.pooling import error_of, pool_errors, pool_means, take_in
from photonmap.film.replicates import replicate_size, weigh
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.kernels.core.passes import Film
from photonmap.runtime.workers import Workers

TRIALS = 20_000
CORRELATED = 0.8
"""Of a pass's deviation, what the next one of its replicate takes back."""


def test_replicates_get_longer():
    sizes = [replicate_size(index) for index in range(200)]
    assert sizes == 16 * [1] + 8 * [2] + 24 * [4] + 152 * [8]


def moments(passes, rng):
    """Mean and standard error after so many passes of many trials; the last replicate is shorter.

    The first pass of a pair deviates by x, the second by y − `CORRELATED` x.
    """
    mean, spread = np.zeros(TRIALS), np.zeros(TRIALS)
    count = 0
    while count < passes:
        taken = min(replicate_size(count), passes - count)
        values = rng.standard_normal((taken, TRIALS))
        values[1::2] -= CORRELATED * values[: taken - 1 : 2]
        weight = weigh(count, taken)
        count += taken
        take_in(values.mean(axis=0), count, mean, spread, weight)
    return mean, error_of(spread, np.float64(count))


@pytest.mark.parametrize("passes", [16, 18, 24, 32, 61, 64])
def test_errors_hold_for_any_number_of_passes(passes):
    """The mean square of the stated errors is the variance of the means, to its own error."""
    mean, error = moments(passes, np.random.default_rng(passes))
    assert (error**2).mean() == pytest.approx(mean.var(), rel=0.05 if passes % 2 else 0.03)


def test_runs_of_other_replicates_are_pooled_by_their_passes():
    rng, counts = np.random.default_rng(1), [np.full(TRIALS, float(n)) for n in (16, 20, 64)]
    means, errors = zip(*(moments(int(count[0]), rng) for count in counts), strict=True)
    error = pool_errors(counts, means, errors)
    assert (error**2).mean() == pytest.approx(pool_means(counts, means).var(), rel=0.03)


def test_two_passes_take_the_samples_of_one_that_has_twice_as_many(monkeypatch):
    """Each pixel's points go on: none twice, and none left out."""
    compiled = compile_scene(pm.scenes.cornell_box(), pm.Bands.rgb())
    with Workers(1) as workers:
        integrator = PhotonIntegrator(setup_of(compiled, workers, Film(12, 12, True)))
        maps = integrator.trace_photons(16)

        def direct(index):
            return integrator.run_camera_pass(index, maps).pixels.direct.copy()

        both = 0.5 * (direct(16) + direct(17))
        assert not np.array_equal(direct(16), direct(18))
        integrator.plan = integrator.plan._replace(samples=2 * integrator.plan.samples)
        monkeypatch.setattr(replicates, "SIZES", ())
        np.testing.assert_allclose(direct(16), both, rtol=1e-5)


@pytest.mark.slow
def test_a_render_states_the_spread_between_seeds(cornell):
    """Of direct light, whose variance is 0.6 of that of independent passes."""
    settings = {"bands": 1, "size": (20, 20), "effects": "direct", "passes": 64, "threads": 1}
    runs = [pm.render(cornell, **settings, seed=seed) for seed in range(40)]
    values = np.array([run.direct for run in runs], float)
    errors = np.array([run.errors["direct"] for run in runs], float)
    assert (errors**2).mean() == pytest.approx(values.var(axis=0, ddof=1).mean(), rel=0.1)
