"""Numbers and vectors of any type that a user gives, as plain floats."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

Vector = tuple[float, float, float]


def finite(value: object) -> float | None:
    """Give a finite number as a float, anything else as None."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def vector(value: object) -> Vector | None:
    """Give three finite numbers as floats, anything else as None."""
    if not isinstance(value, tuple | list | np.ndarray) or len(value) != 3:
        return None
    x, y, z = map(finite, value)
    return None if x is None or y is None or z is None else (x, y, z)


def unit(vector: np.ndarray) -> np.ndarray | None:
    """Scale a vector to length 1; None where it is zero."""
    largest = np.abs(vector).max()
    return vector / largest / np.linalg.norm(vector / largest) if largest > 0 else None
