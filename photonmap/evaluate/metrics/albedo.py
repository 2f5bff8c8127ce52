"""Errors of reflectance on surfaces of one colour each, after "Measured Albedo in the Wild".

J. Wu, S. Chowdhury, H. Shanmugaraja, D. Jacobs and S. Sengupta, "Measured Albedo in the Wild:
Filling the Gap in Intrinsics Evaluation", ICCP 2023, and the code of its evaluation.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, paired
from photonmap.study.color_error import delta_e_2000

_LEAST_ENERGY = 1e-6
"""Below which the divisor of a factor counts as this."""


class _Regions(NamedTuple):
    """Mean colours over the regions of an image."""

    truth: Floats
    """(R, C)"""
    estimate: Floats
    """(R, C)"""
    weights: Floats
    """(R,) pixels"""
    labels: NDArray[np.int64]
    """(P,) region of each of the pixels that belong to one"""
    pixels: tuple[Floats, Floats]
    """(P, C) truth and estimate of these pixels"""


def albedo_intensity(truth: Any, estimate: Any, regions: Any, mask: Any = None) -> float:
    """Return Σ w (g − θ m)² / Σ w, m and g being mean grey values of estimate and truth in regions.

    w is the number of a region's pixels and θ = Σ w m g / Σ w m² one factor for the image. MAW
    reports a hundred times this.

    Parameters
    ----------
    truth, estimate : reflectances, (H, W) or (H, W, C)
    regions : (H, W) int, surfaces of one colour each, as `material_id`; 0 belongs to none
    mask : (H, W) bool, of the pixels that count; None for all

    Raises
    ------
    InputError : no valid pixel belongs to a region, or as `arrays.paired` says
    """
    found = _by_region(truth, estimate, regions, mask)
    made, true, weights = found.estimate.mean(axis=1), found.truth.mean(axis=1), found.weights
    factor = (weights * made * true).sum() / max((weights * made**2).sum(), _LEAST_ENERGY)
    return float(np.average((true - factor * made) ** 2, weights=weights))


def albedo_chromaticity(truth: Any, estimate: Any, regions: Any, mask: Any = None) -> float:
    """Return the mean ΔE2000 of regions' mean colours after a factor for each, over their pixels.

    The factor makes mean grey values of a region equal, so that only its colour counts. Colours out
    of gamut stay as they are; MAW clips them.

    Parameters
    ----------
    truth, estimate : reflectances, (H, W, 3) linear sRGB
    regions, mask : as for `albedo_intensity`

    Raises
    ------
    InputError : as `albedo_intensity` does
    """
    found = _by_region(truth, estimate, regions, mask)
    made, true = (colors.mean(axis=1, keepdims=True) for colors in (found.estimate, found.truth))
    factors = made * true / np.maximum(made**2, _LEAST_ENERGY)
    deltas = delta_e_2000(factors * found.estimate, found.truth, white=1.0)
    return float(np.average(deltas, weights=found.weights))


def albedo_texture(truth: Any, estimate: Any, regions: Any, mask: Any = None) -> float:
    """Return the root mean square of the difference in relative texture within regions.

    The texture of a region is its grey values over their mean. MAW compares texture by LPIPS, a
    trained network; where the truth is known in every pixel, it can be compared directly.

    Parameters
    ----------
    truth, estimate : reflectances, (H, W) or (H, W, C)
    regions, mask : as for `albedo_intensity`

    Raises
    ------
    InputError : as `albedo_intensity` does
    """
    found = _by_region(truth, estimate, regions, mask)
    true, made = (
        _over_mean(pixels.mean(axis=1), means.mean(axis=1)[found.labels])
        for pixels, means in zip(found.pixels, (found.truth, found.estimate), strict=True)
    )
    return float(np.sqrt(np.mean((true - made) ** 2)))


def _over_mean(values: Floats, means: Floats) -> Floats:
    """Return values over means; 1, no texture, where the mean is 0."""
    return np.divide(values, means, where=means != 0.0, out=np.ones_like(values))


def _by_region(truth: Any, estimate: Any, regions: Any, mask: Any) -> _Regions:
    """Average a truth and an estimate over regions."""
    pair = paired(truth, estimate, mask)
    inside = pair.mask & (np.asarray(regions) != 0)
    if not inside.any():
        raise InputError("no valid pixel belongs to a region, so there is nothing to compare")
    _, labels, counts = np.unique(
        np.asarray(regions)[inside], return_inverse=True, return_counts=True
    )
    pixels = pair.truth[inside], pair.estimate[inside]
    truths, estimates = (
        np.stack([np.bincount(labels, column) for column in image.T], axis=1) / counts[:, None]
        for image in pixels
    )
    return _Regions(truths, estimates, counts.astype(np.float64), labels, pixels)
