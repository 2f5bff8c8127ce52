"""The image whose differences between neighbours are closest to given ones."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats, Mask


def differences(image: Floats) -> tuple[Floats, Floats]:
    """Return the differences to the next pixel, downwards (H − 1, W, …) and right (H, W − 1, …)."""
    return np.diff(image, axis=0), np.diff(image, axis=1)


def neighbours(mask: Mask) -> NDArray[np.int64]:
    """Return the pairs (2, E) of neighbours in a mask by the numbers of its pixels, second first.

    Their order is that of `steps_of`: those below each other, then those side by side.
    """
    number = np.cumsum(mask).reshape(mask.shape) - 1
    below, beside = mask[:-1] & mask[1:], mask[:, :-1] & mask[:, 1:]
    second = np.concatenate([number[1:][below], number[:, 1:][beside]])
    first = np.concatenate([number[:-1][below], number[:, :-1][beside]])
    return np.stack([second, first])


def steps_of(down: Floats, right: Floats, mask: Mask) -> Floats:
    """Return those of `differences` that are between the `neighbours` of a mask: (E,)."""
    return np.concatenate([down[mask[:-1] & mask[1:]], right[mask[:, :-1] & mask[:, 1:]]])


def integrate(down: Floats, right: Floats, mask: Mask) -> Floats:
    """Return the image that minimises the squared residuals of its differences within a mask.

    Differences are as `differences` returns them. The image, (H, W) float64, is determined up to a
    constant for each connected part of the mask, of 4-neighbours; the mean of each part is 0, and
    so is all outside of the mask.
    """
    system = _system(mask.tobytes(), mask.shape)
    values = system.factors.solve(system.incidence.T @ steps_of(down, right, mask))
    means = np.bincount(system.parts, values) / np.bincount(system.parts)
    image = np.zeros(mask.shape)
    image[mask] = values - means[system.parts]
    return image


class _System(NamedTuple):
    """The normal equations of a mask."""

    factors: Any  # of the Laplacian, with one pixel of each part held at 0
    incidence: Any  # (edges, pixels) sparse, 1 and −1
    parts: NDArray[np.int64]  # (pixels,) connected part of each


@lru_cache(maxsize=2)
def _system(mask_bytes: bytes, shape: tuple[int, int]) -> _System:
    """Factorise the equations of a mask once for many right-hand sides.

    To hold a pixel at 0 is to add 1 to its diagonal: within a part, the equations add up to 0, so
    that this one says it is 0.
    """
    from scipy.sparse import diags_array
    from scipy.sparse.csgraph import connected_components

    mask = np.frombuffer(mask_bytes, bool).reshape(shape)
    ends = neighbours(mask)
    edges, pixels = ends.shape[1], int(mask.sum())
    incidence = weighted_differences(ends[0], ends[1], np.ones(edges), pixels)
    laplacian = incidence.T @ incidence
    _, parts = connected_components(laplacian, directed=False)
    held = np.zeros(pixels)
    held[np.unique(parts, return_index=True)[1]] = 1.0
    factors = factorised(laplacian + diags_array(held))
    return _System(factors, incidence, parts.astype(np.int64))


def factorised(matrix: Any) -> Any:
    """Return the factors of a sparse symmetric positive definite matrix."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    options = {"SymmetricMode": True}
    return splu(
        csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    )


def weighted_differences(
    plus: NDArray[np.int64], minus: NDArray[np.int64], weights: Floats, width: int
) -> Any:
    """Return the sparse matrix (E, width) of weighted differences between two entries each."""
    from scipy.sparse import csc_array

    rows = np.tile(np.arange(len(plus)), 2)
    columns, values = np.concatenate([plus, minus]), np.concatenate([weights, -weights])
    return csc_array((values, (rows, columns)), shape=(len(plus), width))
