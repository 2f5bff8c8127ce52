"""Errors of reflectance alone: of materials, of colours, and of the order of pairs.

On surfaces of one colour each (`albedo_intensity`, `albedo_chromaticity`, `albedo_texture`): J. Wu,
S. Chowdhury, H. Shanmugaraja, D. Jacobs and S. Sengupta, "Measured Albedo in the Wild: Filling the
Gap in Intrinsics Evaluation", ICCP 2023 (MAW), and the code of its evaluation.

How often an estimate orders two reflectances wrongly (`whdr`): S. Bell, K. Bala and N. Snavely,
"Intrinsic images in the wild", ACM TOG 33(4), 2014, section 3.5. Their judgements are people's;
these are those of the true reflectance.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.evaluate.metrics.arrays import Floats, Mask, least_squares_factor, paired, to_grey
from photonmap.spectra.color_difference import delta_e_2000

_LEAST_ENERGY = 1e-6  # Below which the divisor of a factor counts as this


class _Regions(NamedTuple):
    """Mean colours over the regions of an image."""

    truth: Floats  # (R, C)
    estimate: Floats  # (R, C)
    weights: Floats  # (R,) pixels
    labels: NDArray[np.int64]  # (P,) region of each of the pixels that belong to one
    pixels: tuple[Floats, Floats]  # (P, C) truth and estimate of these pixels


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
    textures = []
    for pixels, means in zip(found.pixels, (found.truth, found.estimate), strict=True):
        grey, mean = pixels.mean(axis=1), means.mean(axis=1)[found.labels]
        textures.append(np.divide(grey, mean, where=mean != 0.0, out=np.ones_like(grey)))
    return float(np.sqrt(np.mean((textures[0] - textures[1]) ** 2)))


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


DELTA = 0.10  # Ratio minus 1 above which one of two reflectances is called darker
DISTANCE = 0.07  # Least distance of two points over the longer side of the image
_DARKEST = 1e-10  # Values below count as this


class OrdinalPairs(NamedTuple):
    """Pairs of pixels that are compared."""

    first: NDArray[np.int64]  # (P, 2), row and column
    second: NDArray[np.int64]  # (P, 2)


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
            f"{len(points)} valid points, {distance:g} of the image apart, do not form a triangle; "
            "use larger images or a smaller distance"
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
