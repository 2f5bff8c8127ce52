"""WHDR on synthetic judgements: how often an estimate orders two reflectances wrongly.

S. Bell, K. Bala and N. Snavely, "Intrinsic images in the wild", ACM TOG 33(4), 2014, section 3.5.
Their judgements are people's; these are those of the true reflectance.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, Mask, paired, to_grey

DELTA = 0.10
"""Ratio minus 1 above which one of two reflectances is called darker."""
DISTANCE = 0.07
"""Least distance of two points over the longer side of the image."""
_DARKEST = 1e-10
"""Values below count as this."""


class OrdinalPairs(NamedTuple):
    """Pairs of pixels that are compared."""

    first: NDArray[np.int64]
    """(P, 2), row and column"""
    second: NDArray[np.int64]
    """(P, 2)"""


def ordinal_pairs(mask: Mask, distance: float = DISTANCE, seed: int = 0) -> OrdinalPairs:
    """Draw points that keep a distance, and pair neighbours, as the authors do.

    Points are a Poisson disk sample of the valid pixels, pairs the edges of their Delaunay
    triangulation.

    Parameters
    ----------
    mask : (H, W) bool
    distance : of points over the longer side of the image, at least
    seed : draws the points

    Raises
    ------
    InputError : fewer than three points fit, or they lie on a line
    """
    from scipy.spatial import Delaunay, QhullError

    points = _spread_points(np.asarray(mask, bool), distance, seed)
    try:
        triangles = Delaunay(points).simplices
    except (QhullError, ValueError):
        raise InputError(
            f"{len(points)} valid points {distance:g} of the image apart are no triangle; take "
            "larger images or a smaller distance"
        ) from None
    edges = np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
    edges = np.unique(edges, axis=0)
    return OrdinalPairs(points[edges[:, 0]], points[edges[:, 1]])


def _spread_points(mask: Mask, distance: float, seed: int) -> NDArray[np.int64]:
    """Return valid pixels in random order that keep a distance from all before: (P, 2)."""
    pixels = np.argwhere(mask)
    reach = distance * max(mask.shape)
    rng = np.random.Generator(np.random.PCG64(seed))
    free = mask.copy()
    rows, columns = np.ogrid[: mask.shape[0], : mask.shape[1]]
    kept = []
    for row, column in rng.permutation(pixels):
        if free[row, column]:
            kept.append((row, column))
            free &= (rows - row) ** 2 + (columns - column) ** 2 >= reach**2
    return np.array(kept, np.int64).reshape(-1, 2)


def whdr(
    truth: Any,
    estimate: Any,
    mask: Any = None,
    pairs: OrdinalPairs | None = None,
    weights: Any = None,
    delta: float = DELTA,
) -> float:
    """Return the share, by weight, of pairs that the estimate orders otherwise than the truth.

    Of two pixels, the first is darker if the ratio of the second to it exceeds 1 + δ, the second if
    the inverse does; otherwise they are equal. Bands are averaged first.

    Parameters
    ----------
    truth, estimate : reflectances, (H, W) or (H, W, C)
    mask : (H, W) bool, of the pixels that count; None for all
    pairs : that are compared; None draws them by `ordinal_pairs`
    weights : (P,) of the pairs; None for equal ones
    delta : δ

    Raises
    ------
    InputError : as `ordinal_pairs` and `arrays.paired` say
    """
    pair = paired(truth, estimate, mask)
    pairs = ordinal_pairs(pair.mask) if pairs is None else pairs
    wrong = _order(pair.truth, pairs, delta) != _order(pair.estimate, pairs, delta)
    return float(np.average(wrong, weights=weights))


def _order(image: Floats, pairs: OrdinalPairs, delta: float) -> NDArray[np.int64]:
    """Return 1 where the first pixel is darker, 2 where the second is, 0 where they are equal."""
    grey = np.maximum(to_grey(image), _DARKEST)
    first, second = (grey[points[:, 0], points[:, 1]] for points in pairs)
    return np.where(second / first > 1.0 + delta, 1, np.where(first / second > 1.0 + delta, 2, 0))
