"""Shares of lights: their standard errors beside how they scatter over seeds."""

import numpy as np
import pytest

import photonmap as pm
from photonmap.dataset.files.derived_buffers import with_derived
from photonmap.dataset.scenes.build import build_scene
from photonmap.dataset.scenes.illumination import Illumination
from photonmap.results.relighting import _covariances, share_errors, shares_of

SEEDS, PASSES = 6, 8
LIGHTS = ("planck:2700", "daylight:7000", "LED-B3")


@pytest.fixture(scope="module", params=[pytest.param(2, marks=pytest.mark.slow), 3])
def runs(request):
    """The same jug under some lights, with many seeds."""
    colors = LIGHTS[: request.param]
    scene = build_scene("jug", seed=0, illumination=Illumination("some", colors))
    options = {"bands": 3, "size": (24, 18), "passes": PASSES, "photons": 2000, "per_light": True}
    return [with_derived(pm.render(scene, seed=seed, **options), scene) for seed in range(SEEDS)]


def lights_of(result):
    return list(result.per_light)


def shares(result):
    return shares_of({light: split["shading"] for light, split in result.per_light.items()})


def test_errors_are_those_of_the_scatter(runs):
    """Intervals of 95% hold the mean of the other seeds in at least so many of the pixels.

    The bands' errors are added as if fully correlated, so that it may be more, and errors may be
    larger than the scatter, but not by much.
    """
    lit = lights_of(runs[0])
    pure = runs[0].buffers["pure"] & runs[0].buffers["valid"]
    assert pure.sum() > 100
    held, ratios = [], []
    for light in lit:
        values = np.array([shares(run)[light] for run in runs], np.float64)[:, pure]
        errors = np.array([share_errors(run, lit)[light] for run in runs], np.float64)[:, pure]
        noisy = errors.mean(axis=0) > 1e-5
        if not noisy.any():
            continue
        others = (values.sum(axis=0) - values) / (SEEDS - 1)
        spread = np.sqrt(1.0 + 1.0 / (SEEDS - 1))
        held.append((np.abs(values - others) <= 2.13 * spread * errors)[:, noisy].mean())
        scatter = values.var(axis=0, ddof=1)[noisy].mean()
        ratios.append((errors[:, noisy] ** 2).mean() / scatter)
    assert len(held) >= 2
    assert np.mean(held) > 0.93, held
    assert 0.8 < np.mean(ratios) < 2.0, ratios


def test_shares_add_up_and_so_do_covariances(runs):
    for run in runs[:2]:
        whole = np.sum([*shares(run).values()], axis=0)
        seen = run.shading.sum(axis=-1) > 0.0
        np.testing.assert_allclose(whole[seen], 1.0, atol=1e-6)
        names = [f"shading@{light}" for light in lights_of(run)]
        errors = np.array([run.standard_error(name) for name in names], np.float64)
        of_whole = run.standard_error("shading").astype(np.float64)
        total = _covariances(errors, of_whole).sum(axis=0)
        least = (errors**2 - errors * (errors.sum(axis=0) - errors)).sum(axis=0)
        possible = (of_whole <= errors.sum(axis=0)) & (of_whole**2 >= least)
        possible &= (errors > 0.0).all(axis=0)
        assert possible.mean() > 0.5
        np.testing.assert_allclose(total[possible], of_whole[possible] ** 2, rtol=1e-6, atol=1e-12)


def test_two_lights_of_known_covariance():
    """Pairs of normal values: the error of the share is that of a million of them."""
    rng = np.random.default_rng(1)
    covariance = np.array([[4e-4, -1.5e-4], [-1.5e-4, 1e-4]])
    drawn = rng.multivariate_normal((2.0, 1.0), covariance, 1_000_000)
    truth = (drawn[:, 0] / drawn.sum(axis=1)).std()
    pixel = np.ones((1, 1, 1), np.float32)
    whole = np.sqrt(covariance.sum())
    errors = {"shading@a": 2e-2 * pixel, "shading@b": 1e-2 * pixel, "shading": whole * pixel}
    buffers = {"shading": 3.0 * pixel, "shading@a": 2.0 * pixel, "shading@b": pixel}

    class Known(pm.Result):
        """A result whose errors need no smoothing."""

        def standard_error(self, name):
            return self.errors[name]

    result = Known(buffers, errors, pm.Bands.parse("1"), {})
    found = share_errors(result, ["a", "b"])
    assert found["a"].item() == pytest.approx(truth, rel=0.01)
    assert found["b"].item() == pytest.approx(truth, rel=0.01)


def test_lean_files_have_no_errors_of_lights(runs):
    whole = runs[0]
    errors = {name: error for name, error in whole.errors.items() if "@" not in name}
    lean = pm.Result(whole.buffers, errors, whole.bands, whole.record)
    with pytest.raises(pm.InputError, match="make the set with --full"):
        share_errors(lean, lights_of(whole))
