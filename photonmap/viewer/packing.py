"""Arrays made small enough for a page: rounded to their noise, differenced, deflated, base64.

Values are half floats of which only as many bits are kept as their standard error leaves meaning:
the last bit is worth between a quarter and a half of it, or 2⁻¹¹ of the value. (M. Klöwer et al.,
"Compressing atmospheric data into its real information content", Nature Computational Science 1,
2021.) Standard errors are one byte, in four steps an octave. Each line is stored as differences
from left to right, band after band, the low bytes of a band before the high ones.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LARGEST = 15
"""Exponent of 2 that the largest value of an array is scaled to; half floats end below 2¹⁶."""
_DEFLATE = (1, zlib.DEFLATED, 15, 9, zlib.Z_RLE)
"""Noise does not repeat: runs and Huffman codes alone are faster, and 13% smaller."""
INFINITE = 255
"""The byte of a standard error that is infinite; 0 is 0, and 254 the largest that is finite."""


def find_scale(image: NDArray[Any]) -> int:
    """Return the power of 2 by which an image is multiplied to become half floats."""
    largest = float(np.abs(image, where=np.isfinite(image), out=np.zeros(image.shape)).max())
    return _LARGEST - int(np.ceil(np.log2(largest))) if largest > 0.0 else 0


def pack_values(image: NDArray[Any], error: NDArray[Any] | None, scale: int) -> str:
    """Return an image as text, see the module.

    Parameters
    ----------
    image : (H, W) or (H, W, N) float32; what is not a number becomes 0
    error : its standard error, in its shape; None keeps all 11 bits
    scale : see `find_scale`
    """
    finite = np.nan_to_num(image.astype(np.float32, copy=False), posinf=0.0, neginf=0.0)
    halves = np.ldexp(finite, scale).astype(np.float16).view(np.uint16)
    if error is not None:
        halves = _round_to(halves, error, scale)
    return _pack(halves)


def _round_to(halves: NDArray[np.uint16], error: NDArray[Any], scale: int) -> NDArray[np.uint16]:
    """Round bits of half floats to nearest multiples of a power of 2, of half an error or less."""
    of_error = (error.astype(np.float32, copy=False).view(np.int32) >> 23).astype(np.int16)
    of_value = ((halves >> np.uint16(10)) & np.uint16(31)).astype(np.int16)
    spare = of_error + np.int16(scale - 127 - 1) - (of_value - np.int16(15 + 10))
    bits = np.where(np.isfinite(error), spare, 10).clip(0, 10).astype(np.uint16)
    half = (np.uint16(1) << bits) >> np.uint16(1)
    return ((halves + half) >> bits) << bits


def pack_errors(error: NDArray[Any]) -> tuple[str, int]:
    """Return standard errors as text, and the exponent of 2 that byte 1 begins at, times 4."""
    steps = error.astype(np.float32, copy=False).view(np.int32) >> 21
    finite = np.isfinite(error)
    first = int(steps.max(where=finite, initial=0)) - (INFINITE - 1)
    codes = np.where(error > 0.0, (steps - first).clip(1, INFINITE - 1), 0)
    return _pack(np.where(finite, codes, INFINITE).astype(np.uint8)), first - 4 * 127


def pack_numbers(image: NDArray[Any]) -> str:
    """Return numbers of objects or materials as text: (H, W), of which those ≥ 65536 become 0."""
    return _pack(np.where(image < 1 << 16, image, 0).astype(np.uint16))


def _pack(image: NDArray[Any]) -> str:
    """Return an image of one byte or two a value as text."""
    planes = image.reshape(*image.shape[:2], -1)
    packer = zlib.compressobj(*_DEFLATE)
    packed = list[bytes]()
    for band in range(planes.shape[2]):
        plane = np.ascontiguousarray(planes[:, :, band])
        change = np.diff(plane, axis=1, prepend=plane.dtype.type(0))
        packed += [
            packer.compress((change >> plane.dtype.type(shift)).astype(np.uint8))
            for shift in range(0, 8 * plane.itemsize, 8)
        ]
    return base64.b64encode(b"".join([*packed, packer.flush()])).decode()
