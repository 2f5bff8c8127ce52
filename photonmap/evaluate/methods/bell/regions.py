"""Regions of equal reflectance: their parts, and intensities for which shading joins them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats

_Labels = NDArray[np.int64]

_ROUNDS = 10
"""Of reweighted least squares."""
_LEAST = 1e-3
"""Residual of log shading below which weights stay the same."""
_HOLD = 1e-6
"""Weight that holds intensities where they were, for regions that touch no other."""


def connected_regions(labels: _Labels) -> _Labels:
    """Return the numbers of 4-connected parts of equal labels (H, W); −1 for negative labels."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = _neighbours(np.arange(labels.size).reshape(labels.shape))
    same = labels.ravel()[first] == labels.ravel()[second]
    links = (np.ones(same.sum()), (first[same], second[same]))
    _, parts = connected_components(coo_array(links, shape=(labels.size,) * 2), directed=False)
    inside = labels.ravel() >= 0
    regions = np.full(labels.size, -1, np.int64)
    regions[inside] = np.unique(parts[inside], return_inverse=True)[1]
    return regions.reshape(labels.shape)


def matched_intensities(log_image: Floats, regions: _Labels, start: Floats) -> Floats:
    """Return log intensities of regions that lower Σ |log s_i − log s_j| across their borders.

    Parameters
    ----------
    log_image : (H, W)
    regions : (H, W) numbers of regions, negative where there is none
    start : (R,) log intensities; the median over pixels stays that of these
    """
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.linalg import spsolve

    first, second = _neighbours(np.arange(regions.size).reshape(regions.shape))
    of = regions.ravel()
    across = (of[first] >= 0) & (of[second] >= 0) & (of[first] != of[second])
    a, b = of[first[across]], of[second[across]]
    step = (log_image.ravel()[first] - log_image.ravel()[second])[across]
    count = len(start)
    found = start
    for _ in range(_ROUNDS):
        weight = 1.0 / np.maximum(np.abs(step - found[a] + found[b]), _LEAST)
        degree = np.bincount(a, weight, count) + np.bincount(b, weight, count) + _HOLD
        links = coo_array((np.tile(weight, 2), (np.append(a, b), np.append(b, a))), (count,) * 2)
        wanted = np.bincount(a, weight * step, count) - np.bincount(b, weight * step, count)
        matrix = (diags_array(degree) - links).tocsc()
        found = np.atleast_1d(spsolve(matrix, wanted + _HOLD * start))
    inside = of[of >= 0]
    return np.asarray(found + np.median(start[inside]) - np.median(found[inside]))


def _neighbours(numbers: _Labels) -> tuple[_Labels, _Labels]:
    """Return the numbers of pixels (H, W) and of those below and to the right of them."""
    first = np.concatenate([numbers[:-1].ravel(), numbers[:, :-1].ravel()])
    return first, np.concatenate([numbers[1:].ravel(), numbers[:, 1:].ravel()])
