"""Standard errors that hold where few passes saw what makes a pixel's light vary.

An edge or a shadow that grazes a pixel may show in none of 16 passes: their spread is 0 then, and
the truth lies infinitely many standard errors away. So each variance is a mean of the pixel's own
and of what its eight neighbours show, which counts for `PRIOR` passes: nothing in the long run.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PRIOR = 2.0
"""Passes that the neighbours count for: of 1, 2 and 4 what kept 95% intervals nearest to 95%."""
SECOND_ORDER = 2.0
"""Of a ratio's error, times the square of its denominator's relative error."""

Images = dict[str, NDArray[np.float32]]


def steady_errors(
    buffers: Images, errors: Images, counts: NDArray[np.uint32], shape: tuple[int, int]
) -> Images:
    """Return standard errors steadied by neighbours, (P, N) each.

    Parameters
    ----------
    buffers, errors : (P, N), of several passes
    counts : (P,) passes of each pixel
    shape : height and width of the image
    """
    own = (np.maximum(counts, 1).astype(np.float32) - 1.0)[:, None]
    steady = {
        name: np.sqrt((PRIOR * _around(error, shape) + own * error**2) / (PRIOR + own))
        for name, error in errors.items()
    }
    if "reflectance" in errors:
        relative = np.divide(
            steady["reflectance"],
            buffers["reflectance"],
            out=np.zeros_like(steady["reflectance"]),
            where=buffers["reflectance"] > 0.0,
        )
        for name in errors:
            if name.startswith("shading"):
                steady[name] *= 1.0 + SECOND_ORDER * relative**2
    return steady


def _around(error: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    """Return the mean variance of the eight neighbours; the image goes on beyond its edges."""
    variance = np.pad(error.reshape(*shape, -1) ** 2, ((1, 1), (1, 1), (0, 0)), mode="edge")
    rows = variance[:-2] + variance[1:-1] + variance[2:]
    nine = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
    return ((nine - variance[1:-1, 1:-1]) / 8.0).reshape(error.shape)
