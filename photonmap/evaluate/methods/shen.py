"""Shen's optimisation: neighbours of similar colour and brightness have similar reflectance.

J. Shen, X. Yang, Y. Jia and X. Li, "Intrinsic images using optimization", CVPR 2011, without user
strokes. With I_i = s_i R_i for colours I and R of pixel i and a scalar s,

    E(R, s) = Σ_i |R_i − Σ_j w_ij R_j|² + Σ_i |I_i / s_i − R_i|²
    w_ij ∝ exp(−T_ij² / σ_iT² − (Y_i − Y_j)² / σ_iY²), Σ_j w_ij = 1

for j in the window around i, T the angle between the colours of two pixels, Y their grey values
and σ² the variances of both in the window. E is quadratic in R and 1 / s and is lowered one pixel
after another: R_i is moved towards the mean of the two values that the terms of pixel i want,
over-relaxed, and s_i follows from its own term. Windows of 3×3 pixels, 100 rounds and a factor of
1.9 are those of the released code, as OpenCV's documentation states them too.

R = 0 has no energy at all, so that the result depends on where the rounds start, R = I, and on
their number. The paper says neither in which order pixels are visited, here in four interleaved
grids, nor what happens where a variance is 0; here it is at least 1e-6.
"""

from __future__ import annotations

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey

_SHIFTS = tuple((y, x) for y in (0, 1, 2) for x in (0, 1, 2) if (y, x) != (1, 1))
"""The neighbours of a pixel, as corners of the image within itself, one pixel wider all around."""
_LEAST_VARIANCE = 1e-6


def estimate(view: View, rounds: float, relaxation: float) -> Estimate:
    """Return the decomposition after rounds over all pixels, over-relaxed by a factor below 2."""
    image = np.where(view.mask[..., None], np.maximum(view.image, FLOOR), 0.0)
    weights = _weights(image, view.mask)
    energy = np.maximum((image**2).sum(axis=-1, keepdims=True), FLOOR**2)
    wide = np.pad(image, ((1, 1), (1, 1), (0, 0)))
    inner = wide[1:-1, 1:-1]
    for _ in range(round(rounds)):
        for grid in ((np.s_[y::2], np.s_[x::2]) for y in (0, 1) for x in (0, 1)):
            near = _neighbours_mean(wide, weights, grid)
            seen, now = image[grid], inner[grid]
            over_shading = (seen * now).sum(axis=-1, keepdims=True) / energy[grid]
            wanted = 0.5 * (near + over_shading * seen)
            moved = now + relaxation * (wanted - now)
            inner[grid] = np.where(view.mask[grid][..., None], np.maximum(moved, 0.0), 0.0)
    over_shading = (image * inner).sum(axis=-1) / energy[..., 0]
    return with_grey_shading(view, 1.0 / np.maximum(over_shading, 1e-9))


def _neighbours_mean(wide: Floats, weights: Floats, grid: tuple[slice, slice]) -> Floats:
    """Return Σ w_ij R_j for the pixels of a grid."""
    height, width = weights.shape[1:]
    return np.asarray(
        sum(
            weight[grid][..., None] * wide[y : y + height, x : x + width][grid]
            for weight, (y, x) in zip(weights, _SHIFTS, strict=True)
        )
    )


def _weights(image: Floats, mask: Mask) -> Floats:
    """Return w_ij for the eight neighbours j of each pixel: (8, H, W)."""
    length = np.maximum(np.linalg.norm(image, axis=-1, keepdims=True), FLOOR)
    direction, grey = image / length, to_grey(image)
    known = _shifted(mask.astype(np.float64))
    inside = known > 0.0
    cosine = np.stack([(near * direction).sum(axis=-1) for near in _shifted(direction)])
    angle = np.where(inside, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    step = np.where(inside, _shifted(grey) - grey, 0.0)
    exponent = angle**2 / _variance(angle, known) + step**2 / _variance(step, known)
    exponent -= np.where(inside, exponent, np.inf).min(axis=0, initial=1e9)
    weights = np.where(inside, np.exp(-np.maximum(exponent, 0.0)), 0.0)
    total = weights.sum(axis=0)
    return weights / np.where(total > 0.0, total, 1.0)  # without neighbours, a pixel stays the same


def _variance(values: Floats, known: Floats) -> Floats:
    """Return the variance over a window of differences (8, H, W) to its centre, which is 0."""
    count = known.sum(axis=0) + 1.0
    return np.maximum((values**2).sum(axis=0) / count - (values.sum(axis=0) / count) ** 2,
                      _LEAST_VARIANCE)  # fmt: skip


def _shifted(values: Floats) -> Floats:
    """Return the eight neighbours' values of (H, W, …), 0 beyond the border: (8, H, W, …)."""
    wide = np.pad(values, ((1, 1), (1, 1), *((0, 0),) * (values.ndim - 2)))
    height, width = values.shape[:2]
    return np.stack([wide[y : y + height, x : x + width] for y, x in _SHIFTS])


METHODS = (Method("shen", estimate, {"rounds": 100.0, "relaxation": 1.9}),)
