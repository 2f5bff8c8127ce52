"""`error` is a promise: where a render stops, the true error is what it states, or less."""

import numpy as np
import pytest

import photonmap as pm

ASKED, SLACK, SIZE, SEEDS = 0.05, 1.15, (20, 20), 20


@pytest.mark.slow
@pytest.mark.parametrize("make", [pm.scenes.cornell_box, pm.scenes.two_rooms])
def test_the_true_error_is_the_one_asked_for(make):
    """At most 1.15 of it in 95% of runs; against 400 passes of another seed."""
    scene = make()
    truth = pm.render(scene, bands="rgb", size=SIZE, passes=400, seed=1000)
    valid = (truth.coverage == 1.0) & ~truth.emission.any(axis=-1)
    value = truth.radiance[valid].astype(float)
    norm = value**2 + 0.01 * value.mean(axis=0) ** 2
    kept = 0
    for seed in range(SEEDS):
        run = pm.render(scene, bands="rgb", size=SIZE, error=ASKED, seed=seed)
        assert run.record["error"] <= ASKED
        square = (run.radiance[valid] - value) ** 2 / norm
        kept += np.sqrt(square.mean()) <= SLACK * ASKED
    assert kept >= 0.95 * SEEDS
