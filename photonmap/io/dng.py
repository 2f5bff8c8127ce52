"""Raw images as Adobe's Digital Negative: TIFF 6.0 with the tags of DNG 1.4."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

_BYTE, _ASCII, _SHORT, _LONG, _RATIONAL, _SIGNED = 1, 2, 3, 4, 5, 10
_FORMATS = {_BYTE: "u1", _SHORT: "<u2", _LONG: "<u4", _RATIONAL: "<u4", _SIGNED: "<i4"}
_CFA, _D65 = 32803, 21
_MOST = 1_000_000  # Largest denominator of a fraction
_LARGEST = 2**31 - 1


@dataclass(frozen=True)
class Negative:
    """What a DNG says of a mosaic."""

    raw: NDArray[np.uint16]  # (H, W) uint16
    pattern: NDArray[np.intp]  # (rows, columns) of 0, 1 and 2 for red, green and blue
    black: float  # levels
    white: int
    color_matrix: NDArray[np.float64]  # (3, 3) from XYZ to the camera's colours, under D65
    neutral: Sequence[float]  # (3,) a white in the camera's colours, at most 1
    model: str  # name of the camera
    seconds: float  # of the exposure
    f_number: float
    iso: float


def encode_dng(negative: Negative) -> bytes:
    """Return the bytes of a DNG file: one strip, little-endian, not compressed."""
    height, width = negative.raw.shape
    rows, columns = negative.pattern.shape
    pixels = np.ascontiguousarray(negative.raw, "<u2").tobytes()
    model = negative.model.encode("ascii", "replace") + b"\0"
    tags: dict[int, tuple[int, Sequence[float] | bytes]] = {
        254: (_LONG, [0]),  # the full image
        256: (_LONG, [width]),
        257: (_LONG, [height]),
        258: (_SHORT, [16]),
        259: (_SHORT, [1]),  # no compression
        262: (_SHORT, [_CFA]),
        271: (_ASCII, b"photonmap\0"),
        272: (_ASCII, model),
        273: (_LONG, [8]),  # where the strip is
        274: (_SHORT, [1]),  # upright
        277: (_SHORT, [1]),
        278: (_LONG, [height]),
        279: (_LONG, [len(pixels)]),
        284: (_SHORT, [1]),
        33421: (_SHORT, [rows, columns]),
        33422: (_BYTE, negative.pattern.ravel().tolist()),
        50706: (_BYTE, [1, 4, 0, 0]),  # version
        50707: (_BYTE, [1, 1, 0, 0]),  # of readers, at least
        50708: (_ASCII, model),
        50710: (_BYTE, [0, 1, 2]),
        50711: (_SHORT, [1]),  # a rectangular layout
        50714: (_RATIONAL, [negative.black]),
        50717: (_LONG, [negative.white]),
        50721: (_SIGNED, negative.color_matrix.ravel().tolist()),
        50728: (_RATIONAL, list(negative.neutral)),
        50778: (_SHORT, [_D65]),
        33434: (_RATIONAL, [negative.seconds]),
        33437: (_RATIONAL, [negative.f_number]),
        34855: (_SHORT, [min(round(negative.iso), 65535)]),
    }
    end = 8 + len(pixels)
    return struct.pack("<2sHI", b"II", 42, end) + pixels + _directory(tags, end)


def _directory(tags: dict[int, tuple[int, Sequence[float] | bytes]], start: int) -> bytes:
    """Return a directory of tags that stands at `start`, followed by the values too long for it."""
    after = start + 2 + 12 * len(tags) + 4
    entries, values = [struct.pack("<H", len(tags))], b""
    for tag, (kind, content) in sorted(tags.items()):
        data = content if isinstance(content, bytes) else _pack(kind, content)
        count = len(content)
        if len(data) > 4:
            place = struct.pack("<I", after + len(values))
            values += data + b"\0" * (len(data) % 2)
        else:
            place = data.ljust(4, b"\0")
        entries.append(struct.pack("<HHI", tag, kind, count) + place)
    return b"".join([*entries, struct.pack("<I", 0), values])


def _pack(kind: int, numbers: Sequence[float]) -> bytes:
    """Return numbers of a kind; fractions as numerator and denominator."""
    is_fraction = kind in (_RATIONAL, _SIGNED)
    flat = [part for each in numbers for part in _fraction(each)] if is_fraction else numbers
    return np.array(flat, _FORMATS[kind]).tobytes()


def _fraction(number: float) -> tuple[int, int]:
    """Return a fraction of 32-bit integers near a number; of tiny ones, one over a whole number."""
    if 0.0 < abs(number) < 1.0 / _MOST:
        return (1 if number > 0 else -1), min(round(1.0 / abs(number)), _LARGEST)
    most = max(1, min(_MOST, int(_LARGEST / max(abs(number), 1.0))))
    near = Fraction(max(-_LARGEST, min(number, _LARGEST))).limit_denominator(most)
    return near.numerator, near.denominator
