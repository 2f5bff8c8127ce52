"""Errors after the best factor, of the image or of each window: LMSE, si-MSE, si-LMSE and DSSIM.

LMSE, a squared error relative to that of black: R. Grosse, M. K. Johnson, E. H. Adelson and W. T.
Freeman, "Ground truth dataset and baseline evaluations for intrinsic image algorithms", ICCV 2009.

The others are the protocol of MPI Sintel: Q. Chen and V. Koltun, "A simple model for intrinsic
image decomposition with depth cues", ICCV 2013, and the code of its evaluation. Their values are
those of images in [0, 1], so the truth should be of that range; the estimate may be of any.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, Mask, least_squares_factor, paired

WINDOW = 20  # Side of a window, pixels; windows are half of it apart
LEAST_ENERGY = 1e-5  # Σ e² of a window up to which its factor is 0


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
    return _ratio(*_window_sums(truth, estimate, mask, window))


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
    energy = float(energies.sum())
    if energy <= 0.0:
        raise InputError("the truth is black in all windows, so there is nothing to compare")
    return float(errors.sum()) / energy


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
    step = window // 2
    cc, ce, ee = (
        np.lib.stride_tricks.sliding_window_view(product.sum(axis=-1), (window, window))[
            ::step, ::step
        ].sum(axis=(-1, -2))
        for product in products
    )
    factor = np.divide(ce, ee, where=ee > LEAST_ENERGY, out=np.zeros_like(ee))
    return np.maximum(cc - 2.0 * factor * ce + factor**2 * ee, 0.0), cc


WINDOW_FRACTION = 0.1  # Side of a window over the longer side of the image
_RADIUS, _SIGMA = 5, 1.5
"""Of the Gaussian window of SSIM, pixels."""
_LARGEST_FACTOR, _STEPS = 5.0, tuple(range(2, 11))
"""Of the search for the factor of greatest SSIM: its limit, and the powers of ½ it is moved by."""


def si_mse(truth: Any, estimate: Any, mask: Any = None) -> float:
    """Return mean (c − a e)² over valid pixels and bands, a = Σ c e / Σ e².

    Parameters
    ----------
    truth, estimate : (H, W) or (H, W, C)
    mask : (H, W) bool, of the pixels that count; None for all

    Raises
    ------
    InputError : as `arrays.paired` says
    """
    pair = paired(truth, estimate, mask)
    return _scaled_error(pair.truth, pair.estimate) / (pair.mask.sum() * pair.truth.shape[2])


def si_lmse(truth: Any, estimate: Any, mask: Any = None) -> float:
    """Return the mean of si-MSE over windows: the LMSE of the Sintel protocol.

    Windows are a tenth of the longer side wide and half of that apart. Unlike those of `lmse`, they
    are cut off at the right and at the bottom, count alike whatever their brightness, and are not
    divided by the truth. Windows without a valid pixel are left out.

    Parameters
    ----------
    truth, estimate, mask : as for `si_mse`

    Raises
    ------
    InputError : the image is so small that windows have no side, or as `arrays.paired` says
    """
    pair = paired(truth, estimate, mask)
    side = int(WINDOW_FRACTION * max(pair.truth.shape) + 0.5)  # as MATLAB rounds, the protocol's
    if side < 1:
        raise InputError(
            "the image is too small for windows of a tenth of it; use 5 pixels or more"
        )
    step = int(side / 2.0 + 0.5)
    height, width, count = pair.truth.shape
    errors = []
    for top in range(0, height - step, step):
        for left in range(0, width - step, step):
            window = slice(top, top + side), slice(left, left + side)
            pixels = int(pair.mask[window].sum())
            if pixels:
                error = _scaled_error(pair.truth[window], pair.estimate[window])
                errors.append(error / (pixels * count))
    return float(np.mean(errors))


def _scaled_error(truth: Floats, estimate: Floats) -> float:
    """Return Σ (c − a e)² for the best a."""
    difference = truth - least_squares_factor(truth, estimate) * estimate
    return float((difference * difference).sum())


def dssim(truth: Any, estimate: Any, mask: Any = None, peak: float = 1.0) -> float:
    """Return (1 − SSIM) / 2 for the factor that the protocol finds, SSIM being the mean over bands.

    The factor starts as that of least squares and is moved in steps of ±¼ to ±1/1024, within 0 and
    5, as long as SSIM grows. SSIM is that of Z. Wang, A. C. Bovik, H. R. Sheikh and E. P.
    Simoncelli, "Image quality assessment", IEEE TIP 13(4), 2004: Gaussian windows of 11×11 pixels,
    σ = 1.5, K = (0.01, 0.03). Only windows that are wholly valid count.

    Parameters
    ----------
    truth, estimate, mask : as for `si_mse`
    peak : the largest value that the truth's range allows

    Raises
    ------
    InputError : no window of 11×11 pixels is valid, or as `arrays.paired` says
    """
    from scipy.ndimage import minimum_filter

    pair = paired(truth, estimate, mask)
    side = 2 * _RADIUS + 1
    centres = minimum_filter(pair.mask, size=side, mode="constant", cval=False)
    if not centres.any():
        raise InputError(f"no window of {side}×{side} pixels is entirely valid; use larger images")
    similarity = _Similarity(pair.truth, pair.estimate, centres, peak)
    factor = least_squares_factor(pair.truth, pair.estimate)
    best = similarity.at(factor)
    for power in _STEPS:
        for step in (-(0.5**power), 0.5**power):
            while 0.0 < factor + step < _LARGEST_FACTOR:
                moved = similarity.at(factor + step)
                if moved <= best:
                    break
                factor, best = factor + step, moved
    return (1.0 - best) / 2.0


class _Similarity:
    """SSIM of a truth and multiples of an estimate, (H, W, C) each, at the centres of windows."""

    def __init__(self, truth: Floats, estimate: Floats, centres: Mask, peak: float) -> None:
        from scipy.ndimage import gaussian_filter

        def mean(image: Floats) -> Floats:
            window = {"axes": (0, 1), "radius": _RADIUS, "mode": "constant"}
            return gaussian_filter(image, _SIGMA, **window)[centres]

        self._truth, self._estimate = mean(truth), mean(estimate)
        self._truth_variance = mean(truth * truth) - self._truth**2
        self._variance = mean(estimate * estimate) - self._estimate**2
        self._covariance = mean(truth * estimate) - self._truth * self._estimate
        self._c1, self._c2 = (0.01 * peak) ** 2, (0.03 * peak) ** 2

    def at(self, factor: float) -> float:
        """Return the mean SSIM over windows and bands of the estimate times a factor."""
        estimate = factor * self._estimate
        means = (2.0 * self._truth * estimate + self._c1) / (
            self._truth**2 + estimate**2 + self._c1
        )
        spreads = (2.0 * factor * self._covariance + self._c2) / (
            self._truth_variance + factor**2 * self._variance + self._c2
        )
        return float((means * spreads).mean())
