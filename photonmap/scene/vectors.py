"""Numbers and vectors that a user gives in any type, as plain floats."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

Vector = tuple[float, float, float]


def finite(value: object) -> float | None:
    """Return a finite number as a float, None for anything else."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def vector(value: object) -> Vector | None:
    """Return three finite numbers as floats, None for anything else."""
    if not isinstance(value, tuple | list | np.ndarray) or len(value) != 3:
        return None
    x, y, z = map(finite, value)
    return None if x is None or y is None or z is None else (x, y, z)


def unit(vector: np.ndarray) -> np.ndarray | None:
    """Return a vector scaled to length 1; None if it is zero."""
    largest = np.abs(vector).max()
    return vector / largest / np.linalg.norm(vector / largest) if largest > 0 else None
