"""Numbers, as attributes of XML elements hold them."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.mitsuba_parts.xml import Element
from photonmap.runtime.wording import shown
from photonmap.scene.vectors import Vector

_SEPARATORS = re.compile(r"[\s,]+")


def numbers_of(element: Element, text: str) -> list[float]:
    """Return numbers separated by spaces or commas."""
    return [number_of(element, word) for word in _SEPARATORS.split(text.strip()) if word]


def number_of(element: Element, text: str) -> float:
    """Return a finite number.

    Raises
    ------
    InputError : the text is none
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        raise element.error(f"{shown(text)} is not a number; correct it")
    return value


def vector_of(element: Element, default: float) -> Vector:
    """Return x, y and z of an element, or its value: one number for all of them, or three."""
    if "value" not in element.attributes:
        x, y, z = (number_of(element, element.attributes.get(axis, str(default))) for axis in "xyz")
        return x, y, z
    return triple_of(element, "value")


def triple_of(element: Element, name: str) -> Vector:
    """Return the three numbers of an attribute; one counts three times."""
    values = numbers_of(element, element.attribute(name))
    if len(values) not in (1, 3):
        text = shown(element.attributes[name])
        raise element.error(f"{name} {text} is not one number or three; correct it")
    x, y, z = values * (3 // len(values))
    return x, y, z


def plain(vector: NDArray[np.float64]) -> Vector:
    """Return three numbers of an array."""
    x, y, z = vector.tolist()
    return x, y, z
