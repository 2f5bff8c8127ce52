"""Relative errors of images: what a render states, and what it is truly off by.

All are sqrt(mean(d² / (v² + 0.01 m²))) over bands and over the pixels that surfaces cover wholly
and none of which emits: d is a deviation, v the value it is relative to, m its mean in a band.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.result import Result

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

BUFFERS = ("radiance", "direct", "indirect", "shading")
"""Whose errors are studied."""

_OF_MEAN = 0.01  # part of the squared mean by which dark pixels are kept from counting too much


def counted_pixels(result: Result) -> Mask:
    """Return which pixels count: (H, W), those covered wholly by surfaces that do not emit."""
    return (result.coverage == 1.0) & ~result.emission.any(axis=-1)


def mean_relative(squares: NDArray[Any], values: NDArray[Any]) -> float:
    """Return mean(squares / (v² + 0.01 m²)) of (P, N) squares and values; black bands count 0."""
    norm = relative_to(values)
    ratio = np.divide(squares, norm, where=norm > 0.0, out=np.zeros(norm.shape))
    return float(ratio.mean())


def relative_to(values: NDArray[Any]) -> Floats:
    """Return v² + 0.01 m² of (P, N) values, m the mean over P."""
    values = np.asarray(values, np.float64)
    return values**2 + _OF_MEAN * values.mean(axis=0) ** 2


def relative_distance(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return sqrt(mean(|d|² / (|v|² + 0.01 |m|²))) of colours (P, 3): lengths, not single bands."""
    squares = ((np.asarray(values, np.float64) - truth) ** 2).sum(axis=-1, keepdims=True)
    norm = relative_to(truth).sum(axis=-1, keepdims=True)
    ratio = np.divide(squares, norm, where=norm > 0.0, out=np.zeros(norm.shape))
    return math.sqrt(float(ratio.mean()))


def stated_error(result: Result, buffer: str, mask: Mask) -> float:
    """Return the error that a render states of one of its buffers; nan after a single pass."""
    if buffer not in result.errors:
        return math.nan
    spread = result.errors[buffer][mask].astype(np.float64)
    return math.sqrt(mean_relative(spread**2, result.buffers[buffer][mask]))


def mean_difference(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return the relative difference of two images' means over all pixels and bands."""
    whole = float(np.mean(truth, dtype=np.float64))
    return float(np.mean(values, dtype=np.float64)) / whole - 1.0 if whole > 0.0 else 0.0


def mean_error(result: Result, mask: Mask) -> float:
    """Return the relative standard error of mean radiance, if pixels are independent.

    So they are where no light is shared between them: in path tracing. nan after a single pass.
    """
    if "radiance" not in result.errors:
        return math.nan
    spread = result.errors["radiance"][mask].mean(axis=-1, dtype=np.float64)
    mean = float(result.radiance[mask].mean(dtype=np.float64))
    return float(np.sqrt((spread**2).sum())) / len(spread) / mean if mean > 0.0 else 0.0
