"""How wide supports are in each pass: cells, footprints and disks narrow as passes add up."""

import numpy as np
from numpy.typing import ArrayLike

FOOTPRINTS_HOLD = 64
"""Passes after which sharing footprints begin to narrow; before, noise outweighs their bias."""


def footprint_width(indices: ArrayLike) -> float:
    """Return the mean width of the footprints of passes, in units of the first pass's.

    They are the supports that narrow the slowest (Knaus and Zwicker 2011).
    """
    return float(np.mean((1.0 + np.asarray(indices) / FOOTPRINTS_HOLD) ** (-1.0 / 6.0)))
