"""PNG files, with nothing but zlib."""

from __future__ import annotations

import struct
import zlib
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_UP = b"\2"  # The filter that stores differences to the line above
_KINDS = {1: 0, 3: 2, 4: 6}  # Colour types of grey, RGB and RGBA

_LINEAR = 100000  # Of the chunk gAMA: an exponent of 1


def write_png(preview: NDArray[np.uint8], path: str | PathLike[str]) -> None:
    """Write an (H, W, 3) uint8 image in sRGB."""
    Path(path).write_bytes(encode_png(preview))


def encode_png(image: NDArray[np.uint8] | NDArray[np.uint16], linear: bool = False) -> bytes:
    """Return an image as the bytes of a PNG file (ISO/IEC 15948).

    image : (H, W, 3) RGB, or (H, W, 4) with an alpha by which RGB is not multiplied; uint8 or
        uint16. (H, W) for grey
    linear : its values are proportional to light, and not sRGB
    """
    image = image[..., None] if image.ndim == 2 else image
    height, width, channels = image.shape
    bits = 8 * image.itemsize
    lines = np.ascontiguousarray(image, f">u{image.itemsize}").reshape(height, -1).view(np.uint8)
    packer, above, packed = zlib.compressobj(), np.zeros_like(lines[0]), []
    for line in lines:
        packed.append(packer.compress(_UP + (line - above).tobytes()))
        above = line
    chunks = {
        b"IHDR": struct.pack(">IIBBBBB", width, height, bits, _KINDS[channels], 0, 0, 0),
        **({b"gAMA": struct.pack(">I", _LINEAR)} if linear else {b"sRGB": b"\0"}),
        b"IDAT": b"".join([*packed, packer.flush()]),
        b"IEND": b"",
    }
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    )
