"""How values are read from the command line, for argparse."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError
from collections.abc import Callable
from typing import TypeVar

from photonmap.errors import InputError

T = TypeVar("T")


def reader(read: Callable[[str], T]) -> Callable[[str], T]:
    """Return a function that reads text as `read` does, with errors in full sentences."""

    def convert(text: str) -> T:
        try:
            return read(text)
        except InputError as error:
            raise ArgumentTypeError(str(error)) from None
        except ValueError:
            kind = "whole number" if read is int else "number"
            raise ArgumentTypeError(f"{text!r} is not a {kind}") from None

    return convert


def vector(text: str) -> tuple[float, ...]:
    """Read "1,2,3"."""
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a vector; write it as x,y,z") from None
    return x, y, z


def direction(text: str) -> tuple[float, ...]:
    """Read "1,2,3", or an axis: "z" or "-z"."""
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    axis = axes.get(text.lower().removeprefix("-"))
    if axis is None:
        return vector(text)
    return tuple(-value for value in axis) if text.startswith("-") else axis


def limits(text: str) -> tuple[float, float]:
    """Read "400:700"."""
    try:
        low, high = map(float, text.split(":"))
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a range; write it as 400:700") from None
    return low, high


def number(low: float, high: float, unit: str = "") -> Callable[[str], float]:
    """Return what reads a number from `low` to `high`; `unit` is named in errors."""

    def convert(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise ArgumentTypeError(f"{text!r} is not a number from {low:g} to {high:g}{unit}")
        return value

    return convert


def whole_number(low: int, high: int, unit: str = "") -> Callable[[str], int]:
    """Return what reads a whole number from `low` to `high`; `unit` is named in errors."""

    def convert(text: str) -> int:
        if not text.strip().isdecimal() or not low <= int(text) <= high:
            raise ArgumentTypeError(f"{text!r} is not a whole number from {low} to {high}{unit}")
        return int(text)

    return convert
