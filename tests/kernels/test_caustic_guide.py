"""The density by boxes from which caustic photons leave, against its samples (χ²)."""

import numpy as np
from scipy import stats

from photonmap.integrators.photon_mapping.caustics import BOXES, _build_guide
from photonmap.kernels.caustics.photon_map import _guided
from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel

SAMPLES = 200_000


@kernel
def sample(rows, columns, out):
    state = rng.stream(3, 1, 4)
    for i in range(len(out)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        point, density = _guided(rows, columns, (u, v))
        out[i, 0], out[i, 1], out[i, 2] = point[0], point[1], density


def test_samples_follow_their_density():
    origins = np.random.default_rng(1).normal(0.3, 0.05, (500, 4)).astype(np.float32)
    guide = _build_guide(origins.clip(0.0, 0.999))
    for rows, columns in (
        (guide.position_rows, guide.position_columns),
        (guide.direction_rows, guide.direction_columns),
    ):
        out = np.empty((SAMPLES, 3))
        sample(rows, columns, out)
        counts = np.histogram2d(out[:, 0], out[:, 1], bins=BOXES, range=[[0, 1], [0, 1]])[0]
        expected = SAMPLES * np.diff(rows, prepend=0.0)[:, None] * np.diff(columns, prepend=0.0)
        assert stats.chisquare(counts.ravel(), expected.ravel()).pvalue > 1e-3
        boxes = np.minimum((out[:, :2] * BOXES).astype(int), BOXES - 1)
        densities = expected[boxes[:, 0], boxes[:, 1]] * BOXES**2 / SAMPLES
        np.testing.assert_allclose(out[:, 2], densities, rtol=1e-9)
        within = out[:, :2] * BOXES % 1.0
        assert stats.kstest(within.ravel(), "uniform").pvalue > 1e-3


def test_without_a_pilot_photons_leave_anywhere():
    guide = _build_guide(np.empty((0, 4), np.float32))
    np.testing.assert_allclose(guide.position_rows, np.linspace(0, 1, BOXES + 1)[1:], atol=1e-12)
