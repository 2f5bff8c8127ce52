"""Relative errors of images, sqrt(mean(d² / (v² + 0.01 m²))) over valid pixels and bands.

d is a deviation or a standard error, v the value that it is relative to and m the mean of v in a
band, which keeps dark pixels from dominating.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

MEAN_FRACTION = 0.01
"""Fraction of the squared mean that is added to the square of each value."""

Array = NDArray[Any]


def dark_floor(mean: Any) -> Any:
    """Return 0.01 m² of the mean of each band, (N,)."""
    return MEAN_FRACTION * mean**2


def squared_norm(values: Array, mean: Any = None) -> Array:
    """Return v² + 0.01 m² of values (P, N); m is their mean over P, or as given."""
    return values**2 + dark_floor(values.mean(axis=0) if mean is None else mean)


def divide_by_norm(squares: Array, norm: Array) -> Array:
    """Return squares over their norm; 0 where that is 0, in black bands."""
    return np.divide(squares, norm, out=np.zeros_like(norm), where=norm > 0.0)


def relative_squares(squares: Array, values: Array, mean: Any = None) -> Array:
    """Return d² / (v² + 0.01 m²) of squares d² and values v, (P, N); m as in `squared_norm`."""
    return divide_by_norm(squares, squared_norm(values, mean))


Mask = NDArray[np.bool_]


def valid_pixels(coverage: NDArray[Any], emission: NDArray[Any], unresolved: Mask) -> Mask:
    """Return whether surfaces cover a pixel wholly, none of them emits, and it is resolved.

    The one definition of valid pixels; `photonmap.kernels.film.moments.is_valid` is its kernel.
    Emission is (..., N), in any unit; a pixel is unresolved if no photon was found for indirect
    light, although some were stored.
    """
    return (coverage == 1.0) & ~emission.any(axis=-1) & ~unresolved
