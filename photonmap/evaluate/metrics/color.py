"""Colour differences of reflectance."""

from __future__ import annotations

from typing import Any

from photonmap.evaluate.metrics.arrays import least_squares_factor, paired
from photonmap.study.color_error import delta_e_2000


def delta_e(truth: Any, estimate: Any, mask: Any = None) -> float:
    """Return the mean ΔE2000 of an estimated reflectance after one factor, that of least squares.

    G. Sharma, W. Wu and E. N. Dalal, "The CIEDE2000 color-difference formula", Color Research and
    Application 30(1), 2005, as colour-science implements it; a reflectance of 1 is white.

    Parameters
    ----------
    truth, estimate : (H, W, 3) linear sRGB
    mask : (H, W) bool, of the pixels that count; None for all

    Raises
    ------
    InputError : as `arrays.paired` says
    """
    pair = paired(truth, estimate, mask)
    factor = least_squares_factor(pair.truth, pair.estimate)
    true, made = pair.truth[pair.mask], factor * pair.estimate[pair.mask]
    return float(delta_e_2000(made, true, white=1.0).mean())
