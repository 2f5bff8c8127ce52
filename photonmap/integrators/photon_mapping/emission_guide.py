"""Where caustic photons leave emitters: as a pilot run of them suggests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.lights.probabilities import make_cdf
from photonmap.kernels.core.passes import CausticPhotons, EmissionGuide

Floats = NDArray[np.float64]

BOXES = 32
"""Of a guide, along each side of a unit square."""
PRIOR = 8
"""Photons by which a box or sphere is taken to be like all others, beside those it sent."""
DARK = 0.05
"""Least flux that a box is taken to emit, in means over the boxes."""


def even_guide(spheres: Floats) -> EmissionGuide:
    """Return a guide that prefers no position, for spheres, (K, 4), to aim at."""
    even = _tables(np.ones(BOXES**2))
    return EmissionGuide(*even, *even, spheres, np.ones(len(spheres)))


def learn(guide: EmissionGuide, pilot: CausticPhotons) -> EmissionGuide:
    """Return a guide by photons traced with an even one.

    The variance is least where the density follows the root of the mean square: of photons that
    arrive with the flux they left with, this is their flux times the root of their fraction.
    """
    boxes = np.minimum((pilot.origins[:, :4] * BOXES).astype(int), BOXES - 1)
    squares = (_density(boxes[:, axes] @ [BOXES, 1], pilot) for axes in ([0, 1], [2, 3]))
    spheres = pilot.origins[:, 4].astype(int)
    importance = _arriving(spheres, pilot.arrived, len(guide.spheres))
    position, aim = map(_tables, squares)
    return EmissionGuide(*position, *aim, guide.spheres, importance / importance.max())


def _density(box: NDArray[np.int64], pilot: CausticPhotons) -> Floats:
    """Return how densely photons should leave, by boxes, (B²,)."""
    sent = np.bincount(box, pilot.emitted, BOXES**2) / _counts(box, BOXES**2)
    density = np.maximum(sent, DARK * sent.mean()) * _arriving(box, pilot.arrived, BOXES**2)
    return density if density.any() else np.ones_like(density)


def _counts(groups: NDArray[np.int64], size: int) -> Floats:
    return np.maximum(np.bincount(groups, minlength=size), 1)


def _arriving(groups: NDArray[np.int64], arrived: NDArray[np.bool_], size: int) -> Floats:
    """Return the root of the fraction of photons that arrive, by groups."""
    all_of_them = (arrived.sum() + 1) / (len(arrived) + 1)
    came = np.bincount(groups, arrived, size) + PRIOR * all_of_them
    return np.sqrt(came / (np.bincount(groups, minlength=size) + PRIOR))


def _tables(density: Floats) -> tuple[Floats, Floats]:
    """Return the CDF of rows, and of boxes within each row."""
    square = density.reshape(BOXES, BOXES)
    return make_cdf(square.sum(axis=1)), make_cdf(square)
