"""Mosaics of colour filters: their patterns, which channel each pixel has, and demosaicing."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, shown
from photonmap.spectra.curves import Floats

AUTO, NONE = "auto", "none"
METHODS = AUTO, BILINEAR, MALVAR = "auto", "bilinear", "malvar"  # Of demosaicing
BAYER = "RGGB"
_MOST_SIDE = 16  # Rows and columns of a pattern, at most
_LETTERS = re.compile(r"[A-Z]+|[1-9]+")
_REMEDY = "write RGGB, RG/GB, 1,2,3/4,5,6 or none"

_WIDE = 1e-6  # Weight of pixels beyond a period, which decide only where there are no others
_LEAST_SPREAD = 1e-12

Pattern = NDArray[np.intp]  # (rows, columns): the number of the channel of each filter, from 0


def check_mosaic(text: str) -> str:
    """Return the text of a mosaic if it can be one."""
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

    channels : names of a camera's channels; a letter stands for one that begins with it
    """
    letters = initials(channels)
    if text == NONE or (text == AUTO and len(channels) == 1):
        return None
    if text == AUTO:
        if letters is not None and set(letters) == set("RGB"):
            text = BAYER
        else:
            side = math.isqrt(len(channels) - 1) + 1  # of the smallest square of all channels
            return (np.arange(side * side, dtype=np.intp) % len(channels)).reshape(side, side)
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


def tile(pattern: Pattern, height: int, width: int) -> Pattern:
    """Return the number of the channel of each pixel: (H, W)."""
    rows, columns = pattern.shape
    return pattern[np.arange(height)[:, None] % rows, np.arange(width) % columns]


def sample(image: Floats, pattern: Pattern | None) -> Floats:
    """Return what pixels see through their filters: (H, W); without a mosaic the image itself.

    image : (H, W, C)
    """
    if pattern is None:
        return image
    chosen = tile(pattern, *image.shape[:2])[..., None]
    return np.take_along_axis(image, chosen, axis=2)[..., 0]


def choose_method(method: str, pattern: Pattern) -> str:
    """Return the method that "auto" stands for; raise `InputError` if one cannot be applied."""
    if method == AUTO:
        return MALVAR if is_bayer(pattern) else BILINEAR
    if method == MALVAR and not is_bayer(pattern):
        raise InputError(
            "demosaic malvar needs a 2×2 mosaic of three channels, one of them on a diagonal; "
            "choose bilinear"
        )
    return method


def is_bayer(pattern: Pattern) -> bool:
    """Return whether a 2×2 pattern has one channel on a diagonal and two others beside it."""
    if pattern.shape != (2, 2):
        return False
    (a, b), (c, d) = pattern.tolist()
    return len({a, b, c, d}) == 3 and (a == d or b == c)


def demosaic(mosaic: Floats, pattern: Pattern, channels: int, method: str = AUTO) -> Floats:
    """Return all channels of all pixels: (H, W, C).

    Values that were measured are kept. Both methods reproduce constants and linear ramps;
    `_malvar` but for the two outer rows and columns.

    mosaic : (H, W)
    channels : C
    method : "bilinear", "malvar" or "auto"
    """
    if choose_method(method, pattern) == MALVAR and min(mosaic.shape) > 2:
        return _malvar(mosaic, pattern)
    return _bilinear(mosaic, pattern, channels)


def _bilinear(mosaic: Floats, pattern: Pattern, channels: int) -> Floats:
    """Fit a plane around each pixel, by weights that fall linearly to 0 within a period.

    Where a channel stands once in the pattern, and in Bayer's, that is bilinear interpolation. At
    the edges of the image it goes on linearly.
    """
    chosen = tile(pattern, *mosaic.shape)
    image = np.empty((*mosaic.shape, channels))
    for channel in range(channels):
        known = chosen == channel
        image[..., channel] = np.where(known, mosaic, _fit_planes(mosaic, known, pattern.shape))
    return image


def _fit_planes(mosaic: Floats, known: NDArray[np.bool_], period: tuple[int, ...]) -> Floats:
    """Return at each pixel the weighted least-squares plane through known values around it."""
    from scipy.ndimage import correlate1d

    rows, columns = (
        [
            [(1.0 - np.abs(at) / reach) * at**power for power in range(3)]
            for reach in (side, 2 * side)
            for at in [np.arange(-reach, reach + 1)]
        ]
        for side in period
    )  # of weight · distanceⁱ for i = 0, 1, 2, over a period and over two

    def moment(image: Floats, i: int, j: int) -> Floats:
        """Return the sum over neighbours of weight · dyⁱ · dxʲ · image."""
        near, wide = (
            correlate1d(correlate1d(image, down[i], 0, mode="constant"), across[j], 1, None,
                        "constant")
            for down, across in zip(rows, columns, strict=True)
        )  # fmt: skip
        return near + _WIDE * wide

    weight, value = known.astype(np.float64), np.where(known, mosaic, 0.0)
    s, sy, sx = moment(weight, 0, 0), moment(weight, 1, 0), moment(weight, 0, 1)
    v, vy, vx = moment(value, 0, 0), moment(value, 1, 0), moment(value, 0, 1)
    some = np.where(s > 0.0, s, 1.0)
    cyy = moment(weight, 2, 0) / some - (sy / some) ** 2
    cxx = moment(weight, 0, 2) / some - (sx / some) ** 2
    cxy = moment(weight, 1, 1) / some - sx * sy / some**2
    cy, cx = vy / some - sy * v / some**2, vx / some - sx * v / some**2
    det = cyy * cxx - cxy**2
    solid = det > _LEAST_SPREAD * cyy * cxx
    safe = np.where(solid, det, 1.0)
    down, across = (cy * cxx - cx * cxy) / safe, (cx * cyy - cy * cxy) / safe
    return v / some - np.where(solid, down * sy / some + across * sx / some, 0.0)


_CROSS = np.array([[0, 0, -1, 0, 0],
                   [0, 0, 2, 0, 0],
                   [-1, 2, 4, 2, -1],
                   [0, 0, 2, 0, 0],
                   [0, 0, -1, 0, 0]])  # fmt: skip
_ALONG_ROW = np.array([[0, 0, 0.5, 0, 0],
                       [0, -1, 0, -1, 0],
                       [-1, 4, 5, 4, -1],
                       [0, -1, 0, -1, 0],
                       [0, 0, 0.5, 0, 0]])  # fmt: skip
_DIAGONAL = np.array([[0, 0, -1.5, 0, 0],
                      [0, 2, 0, 2, 0],
                      [-1.5, 0, 6, 0, -1.5],
                      [0, 2, 0, 2, 0],
                      [0, 0, -1.5, 0, 0]])  # fmt: skip
"""8 × the filters of H. S. Malvar, L. He and R. Cutler, "High-quality linear interpolation for
demosaicing of Bayer-patterned color images", ICASSP 2004, figure 2: the frequent channel at the
others; another one at the frequent, with its neighbours in the row; another one at the third."""


def _malvar(mosaic: Floats, pattern: Pattern) -> Floats:
    """Interpolate a Bayer mosaic by the linear filters of Malvar, He and Cutler."""
    from scipy.ndimage import correlate

    across, down, cross, diagonal = (
        correlate(mosaic, kernel / 8, mode="mirror")
        for kernel in (_ALONG_ROW, _ALONG_ROW.T, _CROSS, _DIAGONAL)
    )
    counts = np.bincount(pattern.ravel(), minlength=3)
    frequent = int(np.argmax(counts))
    image = np.empty((*mosaic.shape, 3))
    for row in range(2):
        for column in range(2):
            at, here = (slice(row, None, 2), slice(column, None, 2)), int(pattern[row, column])
            beside = int(pattern[row, 1 - column])
            for channel in range(3):
                if channel == here:
                    source = mosaic
                elif channel == frequent:
                    source = cross
                elif here == frequent:
                    source = across if channel == beside else down
                else:
                    source = diagonal
                image[(*at, channel)] = source[at]
    return image
