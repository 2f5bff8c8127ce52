"""Relative errors of images: stated by a render, and true against a reference.

All are sqrt(mean(d² / (v² + 0.01 m²))) over bands and valid pixels: d is a deviation, v the value
it is relative to, m its mean in a band.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.film.relative_error import divide_by_norm, squared_norm
from photonmap.film.valid_pixels import Mask, valid_pixels
from photonmap.results.result import Result

Floats = NDArray[np.float64]

BUFFERS = ("radiance", "direct", "indirect", "shading")
"""Buffers whose errors are studied."""


def counted_pixels(result: Result) -> Mask:
    """Return which pixels are valid, (H, W)."""
    return valid_pixels(result.coverage, result.emission, result.unresolved)


def mean_relative(squares: NDArray[Any], values: NDArray[Any]) -> float:
    """Return mean(squares / (v² + 0.01 m²)) of (P, N) squares and values; black bands count 0."""
    return float(divide_by_norm(np.asarray(squares, np.float64), relative_to(values)).mean())


def relative_to(values: NDArray[Any]) -> Floats:
    """Return v² + 0.01 m² of (P, N) values, m the mean over P."""
    return squared_norm(np.asarray(values, np.float64))


def relative_distance(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return sqrt(mean(|d|² / (|v|² + 0.01 |m|²))) of colours (P, 3), taken as vectors."""
    squares = ((np.asarray(values, np.float64) - truth) ** 2).sum(axis=-1, keepdims=True)
    norm = relative_to(truth).sum(axis=-1, keepdims=True)
    return math.sqrt(float(divide_by_norm(squares, norm).mean()))


def stated_error(result: Result, buffer: str, mask: Mask) -> float:
    """Return the relative error that a render states for a buffer; nan after a single pass."""
    if buffer not in result.errors:
        return math.nan
    spread = result.errors[buffer][mask].astype(np.float64)
    return math.sqrt(mean_relative(spread**2, result.buffers[buffer][mask]))


def mean_difference(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return the relative difference of the means of two images over all pixels and bands."""
    whole = float(np.mean(truth, dtype=np.float64))
    return float(np.mean(values, dtype=np.float64)) / whole - 1.0 if whole > 0.0 else 0.0


def mean_error(result: Result, mask: Mask) -> float:
    """Return the relative standard error of mean radiance of independent pixels.

    Pixels are independent in path tracing, which shares no light between them. nan after a single
    pass.
    """
    if "radiance" not in result.errors:
        return math.nan
    spread = result.errors["radiance"][mask].mean(axis=-1, dtype=np.float64)
    mean = float(result.radiance[mask].mean(dtype=np.float64))
    return float(np.sqrt((spread**2).sum())) / len(spread) / mean if mean > 0.0 else 0.0
