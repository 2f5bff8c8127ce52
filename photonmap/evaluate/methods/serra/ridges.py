"""Ridges in the histogram of an image's colours: those of one surface, lighter and darker.

E. Vazquez, R. Baldrich, J. van de Weijer and M. Vanrell, "Describing reflectances for color
segmentation robust to shadows, highlights, and textures", PAMI 33(5), 2011 (ridge-based
distribution analysis). With H the histogram, smoothed at the scale of differentiation, and w the
first eigenvector of ∇H ∇Hᵀ, smoothed at the scale of integration, turned uphill, creaseness is

    κ = −div(w)

which is large on a ridge, however high it is (multilocal creaseness by the structure tensor, of
López, Lloret, Serrat and Villanueva 2000). Ridges flood the colours around them.

Chosen here: axes are square roots, which keep lines through black straight and give dark colours
more cells; H is a logarithm of counts; cells whose κ exceeds a threshold are ridges, and those that
touch are one, except near black, where all ridges meet; a colour belongs to the nearest ridge,
without a flood.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.metrics.arrays import Floats

_CELLS = 64
"""Along each axis."""
_BRIGHTEST = 99.5
"""Percentile of the largest band at which the axes end."""
_MARGIN = 3
"""Empty cells beyond each end."""
_DIFFERENTIATION, _INTEGRATION = 0.7, 1.0
"""Scales, in cells."""
_CREASED = 1.7
"""Least κ of a ridge; it is at most 3."""
_DENSE = 0.5
"""Least smoothed count of a ridge."""
_NEAR_BLACK = 0.3
"""Share of an axis within which no cell is a ridge."""
_TOUCHING = np.ones((3, 3, 3), bool)


def ridge_numbers(colors: Floats) -> NDArray[np.int64]:
    """Return the number of the ridge that each colour belongs to; 0 for all if there is none.

    Parameters
    ----------
    colors : (P, 3) linear RGB, above 0
    """
    from scipy.ndimage import distance_transform_edt, gaussian_filter, label

    brightest = float(np.percentile(colors.max(axis=1), _BRIGHTEST))
    places = np.sqrt(np.clip(colors / brightest, 0.0, 1.0)) * (_CELLS - 1)
    cells = tuple(np.rint(places).astype(np.int64).T + _MARGIN)
    counts = np.zeros((_CELLS + 2 * _MARGIN,) * 3)
    np.add.at(counts, cells, 1.0)
    density = gaussian_filter(counts, _DIFFERENTIATION)
    creaseness = _creaseness(np.log1p(density))
    from_black = np.linalg.norm(np.indices(counts.shape) - _MARGIN, axis=0) / _CELLS
    ridges = (creaseness > _CREASED) & (density > _DENSE) & (from_black > _NEAR_BLACK)
    numbers, count = label(ridges, _TOUCHING)
    if count == 0:
        return np.zeros(len(colors), np.int64)
    nearest = distance_transform_edt(~ridges, return_distances=False, return_indices=True)
    return np.asarray(numbers[tuple(nearest)][cells], np.int64)


def _creaseness(heights: Floats) -> Floats:
    """Return κ of a histogram (X, Y, Z), between −3 and 3."""
    from scipy.ndimage import gaussian_filter

    slopes = np.stack(list(np.gradient(heights)), axis=-1)
    tensor = slopes[..., :, None] * slopes[..., None, :]
    tensor = gaussian_filter(tensor, _INTEGRATION, axes=(0, 1, 2))
    sloping = slopes.any(axis=-1)
    steepest = np.linalg.eigh(tensor[sloping])[1][..., -1]
    field = np.zeros_like(slopes)
    uphill = np.sign((steepest * slopes[sloping]).sum(axis=-1, keepdims=True))
    field[sloping] = steepest * uphill
    return -np.sum([np.gradient(field[..., axis], axis=axis) for axis in range(3)], axis=0)
