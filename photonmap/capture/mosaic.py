"""Mosaics of colour filters: their patterns, and which channel each pixel has."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, shown

AUTO, NONE = "auto", "none"
BAYER = "RGGB"
_MOST_SIDE = 16
"""Rows and columns of a pattern, at most."""
_LETTERS = re.compile(r"[A-Z]+|[1-9]+")
_REMEDY = "write RGGB, RG/GB, 1,2,3/4,5,6 or none"

Pattern = NDArray[np.intp]
"""(rows, columns): the number of the channel of each filter, from 0."""


def check_mosaic(text: str) -> str:
    """Return the text of a mosaic if it can be one.

    Raises
    ------
    InputError : it cannot
    """
    if text not in (AUTO, NONE):
        _cells(text)
    return text


def _cells(text: str) -> list[list[str]]:
    """Return the rows of a pattern, as the names or numbers of its channels."""
    if not isinstance(text, str):
        raise InputError(f"mosaic {shown(text)} is not a pattern; {_REMEDY}")
    body = text.replace(" ", "").upper()
    rows = [_split(row) for row in body.split("/")]
    if len(rows) == 1 and rows[0] and "," not in body:
        side = math.isqrt(len(rows[0]))
        if side * side != len(rows[0]):
            raise InputError(f"mosaic {shown(text)} is not a square; {_REMEDY}")
        rows = [rows[0][i : i + side] for i in range(0, side * side, side)]
    if not all(rows) or len({len(row) for row in rows}) != 1:
        raise InputError(f"mosaic {shown(text)} has rows of different lengths; {_REMEDY}")
    if max(len(rows), len(rows[0])) > _MOST_SIDE:
        raise InputError(f"mosaic {shown(text)} has more than {_MOST_SIDE} rows or columns")
    return rows


def _split(row: str) -> list[str]:
    """Return the cells of a row: between commas, or single letters or digits."""
    if "," in row:
        return row.split(",") if all(row.split(",")) else []
    return list(row) if _LETTERS.fullmatch(row) else []


def read_mosaic(text: str, channels: Sequence[str]) -> Pattern | None:
    """Return the pattern of a mosaic; None where every pixel has all channels.

    Parameters
    ----------
    text : of `check_mosaic`
    channels : names of a camera's channels; a letter stands for one that begins with it

    Raises
    ------
    InputError : it names a channel that there is not, or leaves one out
    """
    letters = initials(channels)
    if text == NONE or (text == AUTO and len(channels) == 1):
        return None
    if text == AUTO:
        if letters is not None and set(letters) == set("RGB"):
            text = BAYER
        else:
            return _square(len(channels))
    known = {str(number + 1): number for number in range(len(channels))}
    known |= {letter: number for number, letter in enumerate(letters or ())}
    cells = _cells(text)
    for name in chain.from_iterable(cells):
        if name not in known:
            raise InputError(
                f"mosaic {shown(text)} names {name}, but the camera has {listed(known, 9)}"
            )
    pattern = np.array([[known[name] for name in row] for row in cells], np.intp)
    missing = set(range(len(channels))) - set(pattern.ravel().tolist())
    if missing:
        names = listed([channels[number] for number in sorted(missing)], 9)
        raise InputError(f"mosaic {shown(text)} leaves out {names} of the camera's channels")
    return pattern


def initials(channels: Sequence[str]) -> list[str] | None:
    """Return the first letters of channels; None if two are equal or one is not a letter."""
    letters = [name[:1].upper() for name in channels]
    good = len(set(letters)) == len(letters) and all(letter.isalpha() for letter in letters)
    return letters if good else None


def _square(count: int) -> Pattern:
    """Return the smallest square of all channels in order; the first ones fill it up."""
    side = math.isqrt(count - 1) + 1
    return (np.arange(side * side, dtype=np.intp) % count).reshape(side, side)


def tile(pattern: Pattern, height: int, width: int) -> Pattern:
    """Return the number of the channel of each pixel: (H, W)."""
    rows, columns = pattern.shape
    return pattern[np.arange(height)[:, None] % rows, np.arange(width) % columns]


def sample(image: NDArray[np.float64], pattern: Pattern | None) -> NDArray[np.float64]:
    """Return what pixels see through their filters: (H, W); without a mosaic the image itself.

    Parameters
    ----------
    image : (H, W, C)
    """
    if pattern is None:
        return image
    chosen = tile(pattern, *image.shape[:2])[..., None]
    return np.take_along_axis(image, chosen, axis=2)[..., 0]
