"""Cumulative distribution functions, as `kernels.core.warp.discrete` takes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def make_cdf(weights: Floats) -> Floats:
    """Return the CDF of weights along the last axis: from above 0 to exactly 1.

    Where all weights are 0, so is the CDF.
    """
    sums = np.cumsum(weights, axis=-1, dtype=np.float64)
    totals = sums[..., -1:]
    return np.minimum(sums / np.where(totals > 0.0, totals, 1.0), 1.0)


def probabilities_of(cdf: Floats) -> Floats:
    """Return the probabilities that a CDF is made of."""
    return np.diff(cdf, prepend=0.0)
