"""LMSE: squared error in windows, each with a factor of its own, relative to that of black.

R. Grosse, M. K. Johnson, E. H. Adelson and W. T. Freeman, "Ground truth dataset and baseline
evaluations for intrinsic image algorithms", ICCV 2009.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, paired

WINDOW = 20
"""Side of a window, pixels; windows are half of it apart."""
LEAST_ENERGY = 1e-5
"""Σ e² of a window up to which its factor is 0."""


def lmse(truth: Any, estimate: Any, mask: Any = None, window: int = WINDOW) -> float:
    """Return Σ_w Σ (c − a_w e)² / Σ_w Σ c² over windows w and their valid pixels.

    c is the truth, e the estimate, and a_w = Σ c e / Σ e² one factor per window for all bands; 0
    where Σ e² is at most 1e-5. Windows are wholly inside the image, half their side apart. Grosse
    et al. average bands first and rate a decomposition by the mean over reflectance and shading.

    The code they released divides by less, see `lmse_mit`; this is the paper's formula, as in the
    copy that S. Bell, K. Bala and N. Snavely corrected for "Intrinsic images in the wild" (2014).

    Parameters
    ----------
    truth, estimate : (H, W) or (H, W, C)
    mask : (H, W) bool, of the pixels that count; None for all
    window : side of a window, pixels

    Raises
    ------
    InputError : no window fits into the image, the truth is black, or as `arrays.paired` says
    """
    errors, energies = _window_sums(truth, estimate, mask, window)
    return _ratio(errors, energies)


def lmse_mit(truth: Any, estimate: Any, mask: Any = None, window: int = WINDOW) -> float:
    """Return LMSE as the code computes it that Grosse et al. released with their data set.

    Its denominator sums c² over the last window of each row of windows only, so values may exceed
    1. Many published figures were computed with it.

    Parameters
    ----------
    truth, estimate, mask, window : as for `lmse`

    Raises
    ------
    InputError : as `lmse` does
    """
    errors, energies = _window_sums(truth, estimate, mask, window)
    return _ratio(errors, energies[:, -1])


def _ratio(errors: Floats, energies: Floats) -> float:
    whole = float(energies.sum())
    if whole <= 0.0:
        raise InputError("the truth is black in all windows, so there is nothing to compare")
    return float(errors.sum()) / whole


def _window_sums(truth: Any, estimate: Any, mask: Any, window: int) -> tuple[Floats, Floats]:
    """Return Σ (c − a e)² and Σ c² of each window, as rows of windows."""
    pair = paired(truth, estimate, mask)
    height, width = pair.mask.shape
    if not 2 <= window <= min(height, width):
        raise InputError(
            f"a window of {window}×{window} pixels does not fit into {width}×{height}; choose "
            "2 or more pixels, and no more than the image has"
        )
    products = (pair.truth**2, pair.truth * pair.estimate, pair.estimate**2)
    cc, ce, ee = (_sums(product.sum(axis=-1), window) for product in products)
    factor = np.divide(ce, ee, where=ee > LEAST_ENERGY, out=np.zeros_like(ee))
    return np.maximum(cc - 2.0 * factor * ce + factor**2 * ee, 0.0), cc


def _sums(values: Floats, window: int) -> Floats:
    """Return the sums of (H, W) over windows."""
    windows = np.lib.stride_tricks.sliding_window_view(values, (window, window))
    step = window // 2
    return windows[::step, ::step].sum(axis=(-1, -2))
