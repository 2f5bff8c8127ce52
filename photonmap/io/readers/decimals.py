"""Parse text that consists of numbers alone, a block at a time."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

_SPACE, _PLUS, _MINUS, _POINT, _ZERO = b" +-.0"
_PLAIN = np.isin(np.arange(256), list(b"0123456789+-. \v\n"))
_POWERS = 10.0 ** np.arange(23)
_EXACT = 1 << 53  # Integers up to here, and powers of ten up to 10²², are exact in float64


def begins(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return where runs of True begin; the first element is False."""
    return np.flatnonzero(inside[1:] & ~inside[:-1]) + 1


def parse_integers(text: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Parse integers.

    Parameters
    ----------
    text : (B,) uint8, numbers separated by white space, which also comes first and last

    Returns
    -------
    (W,) int64, a value for each word; too few or too many values where one is malformed
    """
    signs = np.flatnonzero((text == _PLUS) | (text == _MINUS))
    if (text[signs - 1] > _SPACE).any() or (text[signs + 1] < _ZERO).any():
        return np.empty(0, np.int64)
    values: NDArray[np.int64] = _parse(text, np.int64)
    return values


def parse_floats(text: NDArray[np.uint8]) -> NDArray[np.float64] | None:
    """Parse decimals, correctly rounded.

    Parameters
    ----------
    text : as in `parse_integers`

    Returns
    -------
    (W,) float64, a value for each word, or None where one is malformed
    """
    solid = text > _SPACE
    words = begins(solid)
    values = _parse_plain(text, words, begins(~solid))
    if values is None:
        values = _parse(text, np.float64)
    return values if len(values) == len(words) else None


def _parse_plain(
    text: NDArray[np.uint8], words: NDArray[np.int64], ends: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Parse decimals without exponents as integers over powers of ten, which is faster.

    Where both are exact, the quotient is the nearest float64 (Clinger, "How to read floating
    point numbers accurately", 1990). None where they are not.

    text : as in `parse_integers`
    words, ends : (W,) where each word begins and ends
    """
    sign = (text == _PLUS) | (text == _MINUS)
    if not _PLAIN[text].all() or np.count_nonzero(sign) != np.count_nonzero(sign[words]):
        return None
    point = text == _POINT
    points = np.flatnonzero(point)
    owners = np.searchsorted(ends, points, "right")
    decimals = np.zeros(len(words), np.int64)
    decimals[owners] = ends[owners] - points - 1
    digits = parse_integers(text[~point])
    if (
        len(digits) != len(words)
        or (np.diff(owners) == 0).any()
        or decimals.max(initial=0) >= len(_POWERS)
        or digits.max(initial=0) > _EXACT
        or digits.min(initial=0) < -_EXACT
    ):
        return None
    return digits / _POWERS[decimals]


def _parse(text: NDArray[np.uint8], kind: type) -> NDArray[Any]:
    """Parse numbers; return none if one is malformed, or if there are none."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text.tobytes().rstrip() or b"none", kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return np.empty(0, kind)
