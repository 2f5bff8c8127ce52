"""The density by boxes from which caustic photons leave, against its samples (χ²)."""

import numpy as np
import pytest
from scipy import stats

from photonmap.integrators.photon_mapping.caustics import BOXES, PRIOR, even_guide, learn
from photonmap.kernels.caustics.photon_map import _guided
from photonmap.kernels.core import rng
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import CausticPhotons

SAMPLES = 200_000
SPHERES = np.array([(0.0, 0.0, 0.0, 0.1), (0.5, 0.0, 0.0, 0.1)])


@kernel
def sample(rows, columns, out):
    state = rng.stream(3, 1, 4)
    for i in range(len(out)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        point, density = _guided(rows, columns, (u, v))
        out[i, 0], out[i, 1], out[i, 2] = point[0], point[1], density


def pilot(emitted, arrived, spheres=0, seed=1):
    """Return photons from everywhere in the unit squares; functions of these give the rest."""
    places = np.random.default_rng(seed).random((SAMPLES, 4))
    origins = np.column_stack([places, np.broadcast_to(spheres, SAMPLES)]).astype(np.float32)
    empty = np.empty((0, 3), np.float32)
    columns = [np.broadcast_to(f(*places.T), SAMPLES) for f in (emitted, arrived)]
    return CausticPhotons(origins, *columns, *[empty] * 6)


def squares(guide):
    """Return the rows and columns of both unit squares."""
    return (
        (guide.position_rows, guide.position_columns),
        (guide.aim_rows, guide.aim_columns),
    )


def densities(rows, columns):
    """Return the density of each box, (B, B)."""
    return BOXES**2 * np.diff(rows, prepend=0.0)[:, None] * np.diff(columns, axis=1, prepend=0.0)


@pytest.mark.parametrize("square", [0, 1])
def test_samples_follow_their_density(square):
    photons = pilot(
        lambda x, y, s, t: 1.0 + x + np.sin(9.0 * y) ** 2 + 2.0 * s * t,
        lambda x, y, s, t: (x * y > 0.2) & (s > 0.3),
    )
    rows, columns = squares(learn(even_guide(SPHERES), photons))[square]
    out = np.empty((SAMPLES, 3))
    sample(rows, columns, out)
    counts = np.histogram2d(out[:, 0], out[:, 1], bins=BOXES, range=[[0, 1], [0, 1]])[0]
    density = densities(rows, columns)
    assert stats.chisquare(counts.ravel(), SAMPLES * density.ravel() / BOXES**2).pvalue > 1e-3
    boxes = np.minimum((out[:, :2] * BOXES).astype(int), BOXES - 1)
    np.testing.assert_allclose(out[:, 2], density[boxes[:, 0], boxes[:, 1]], rtol=1e-9)
    within = out[:, :2] * BOXES % 1.0
    assert stats.kstest(within.ravel(), "uniform").pvalue > 1e-3


def test_without_a_pilot_photons_leave_anywhere():
    for rows, columns in squares(even_guide(SPHERES)):
        np.testing.assert_allclose(densities(rows, columns), 1.0, atol=1e-12)


def test_density_follows_the_flux_that_leaves_and_the_root_of_what_arrives():
    photons = pilot(lambda x, y, s, t: np.where(x < 0.5, 1.0, 3.0), lambda x, y, s, t: t < 0.5)
    position, aim = (densities(*square) for square in squares(learn(even_guide(SPHERES), photons)))
    half, each = BOXES // 2, SAMPLES / BOXES**2
    seldom = np.sqrt(0.5 * PRIOR / (each + 0.5 * PRIOR))
    assert position[half:].mean() / position[:half].mean() == pytest.approx(3.0, rel=0.01)
    assert aim[:, half:].mean() / aim[:, :half].mean() == pytest.approx(seldom, rel=0.02)
    assert aim.std() / aim.mean() < 1.0


def test_spheres_that_send_nothing_on_get_fewer_photons():
    spheres = np.arange(SAMPLES) % 2
    photons = pilot(lambda *_: 1.0, lambda *_: spheres == 1, spheres)
    first, second = learn(even_guide(SPHERES), photons).importance
    assert second == 1.0
    assert first == pytest.approx(np.sqrt(PRIOR / SAMPLES), rel=0.01)


def test_a_pilot_that_emits_nothing_leaves_the_guide_even():
    guide = learn(even_guide(SPHERES), pilot(lambda *_: 0.0, lambda *_: False))
    for rows, columns in squares(guide):
        np.testing.assert_allclose(densities(rows, columns), 1.0, atol=1e-12)
