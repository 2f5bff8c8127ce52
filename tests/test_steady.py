"""Standard errors are calibrated, pixel by pixel and band by band."""

import numpy as np
import pytest
from scipy import stats

import photonmap as pm
from photonmap.steady import PRIOR, steady_errors

PASSES, SEEDS, SIZE = 16, 24, 20


def test_neighbours_count_for_some_passes():
    error = np.zeros((9, 1), np.float32)
    error[4] = 2.0
    images = {"direct": error}
    steady = steady_errors(images, images, np.full(9, 17, np.uint32), (3, 3))["direct"]
    assert steady[4, 0] == pytest.approx(2.0 * np.sqrt(16.0 / (16.0 + PRIOR)))
    assert steady[1, 0] == pytest.approx(2.0 * np.sqrt(PRIOR / 8.0 / (16.0 + PRIOR)))


def test_errors_of_zero_stay_zero():
    images = {"indirect": np.zeros((6, 2), np.float32)}
    assert not steady_errors(images, images, np.full(6, 4, np.uint32), (2, 3))["indirect"].any()


@pytest.fixture(scope="module", params=["cornell", "balls"])
def runs(request):
    """Many seeds of one scene: buffer to (values, errors), each (S, H, W, N)."""
    scene = {"cornell": pm.scenes.cornell_box, "balls": pm.scenes.cornell_balls}[request.param]()
    runs = [
        pm.render(scene, bands="rgb", size=(SIZE, SIZE), passes=PASSES, seed=seed)
        for seed in range(SEEDS)
    ]
    names = set(runs[0].buffers) & {"radiance", "direct", "indirect", "shading", "residual"}
    return {
        name: (
            np.array([run.buffers[name] for run in runs], float),
            np.array([run.standard_error(name) for run in runs], float),
        )
        for name in names
        if np.ptp(runs[0].buffers[name]) > 0.0
    }


def test_intervals_cover_the_truth(runs):
    """Deviations from the other seeds' mean are Student's t: their spread, and 95% intervals."""
    for name, (values, errors) in runs.items():
        live = np.ptp(values, axis=0) > 0.0
        others = (values.sum(axis=0) - values) / (SEEDS - 1)
        deviation = (values - others) / np.sqrt(1.0 + 1.0 / (SEEDS - 1))
        t = deviation[:, live] / np.maximum(errors[:, live], 1e-30)
        normal = stats.norm.ppf(stats.t.cdf(np.clip(t, -1e3, 1e3), PASSES - 1))
        covered = (np.abs(t) < stats.t.ppf(0.975, PASSES - 1)).mean()
        assert 0.93 <= covered <= 0.97, (name, covered)
        assert 0.9 <= np.clip(normal, -8.0, 8.0).std() <= 1.1, name
