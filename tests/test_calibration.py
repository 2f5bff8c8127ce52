"""Standard errors mean what they say: scores over many seeds follow Student's t."""

import numpy as np
import pytest
from scipy import stats

import photonmap as pm

SEEDS, PASSES, SIZE = 24, 16, 24


@pytest.mark.parametrize("name", ["direct", "indirect", "radiance", "shading"])
def test_scores(renders, name):
    """(I − truth) / SE, mapped through t with n − 1 degrees of freedom, has unit spread.

    The mean over all other seeds stands for the truth, so that slow bias does not enter.
    """
    images = np.array([getattr(render, name) for render in renders], float)
    errors = np.array([render.standard_error(name) for render in renders], float)
    judged = (renders[0].coverage == 1.0) & (errors.min(axis=(0, 3)) > 0)
    images, errors = images[:, judged], errors[:, judged]
    scores = []
    for seed in range(SEEDS):
        others = np.delete(images, seed, axis=0).mean(axis=0)
        noise = np.sqrt(np.delete(errors, seed, axis=0) ** 2).mean(axis=0) / np.sqrt(SEEDS - 1)
        t = (images[seed] - others) / np.hypot(errors[seed], noise)
        scores.append(stats.norm.ppf(np.clip(stats.t.cdf(t, PASSES - 1), 1e-9, 1 - 1e-9)))
    spread = np.std(scores)
    assert 0.93 < spread < 1.07
    assert abs(np.mean(scores)) < 0.1


@pytest.fixture(scope="module")
def renders(cornell):
    return [
        pm.render(cornell, bands=1, size=(SIZE, SIZE), passes=PASSES, photons=8192, seed=seed)
        for seed in range(SEEDS)
    ]
