"""Clusters of colours: few groups that stand for many pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats


def first_means(colors: Floats, count: int) -> Floats:
    """Split colours (P, C) at medians until there are `count` groups; return their means."""
    groups = [colors]
    spreads = [_spread(colors)]
    while len(groups) < count and max(spreads) > 0.0:
        widest = int(np.argmax(spreads))
        group = groups[widest]
        axis = int(np.argmax(group.var(axis=0)))
        order = np.argsort(group[:, axis], kind="stable")
        halves = [group[part] for part in np.array_split(order, 2)]
        groups[widest : widest + 1] = halves
        spreads[widest : widest + 1] = map(_spread, halves)
    return np.stack([group.mean(axis=0) for group in groups])


def _spread(colors: Floats) -> float:
    """Return the sum of squared distances of colours (P, C) to their mean."""
    return float(len(colors) * colors.var(axis=0).sum())


def nearest_means(colors: Floats, means: Floats) -> NDArray[Any]:
    """Return the nearest mean of each colour."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(means).query(colors)[1])


def means_of(colors: Floats, nearest: NDArray[Any], means: Floats) -> Floats:
    """Return the means of the colours of each cluster; clusters without any keep theirs."""
    counts = np.bincount(nearest, minlength=len(means))
    sums = np.stack([np.bincount(nearest, band, len(means)) for band in colors.T], axis=1)
    return np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], means)
