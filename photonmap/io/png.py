"""PNG files, with nothing but zlib."""

from __future__ import annotations

import struct
import zlib
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_UP = b"\2"
"""The filter that stores differences to the line above."""


def write_png(preview: NDArray[np.uint8], path: str | PathLike[str]) -> None:
    """Write an (H, W, 3) uint8 image in sRGB."""
    Path(path).write_bytes(encode_png(preview))


def encode_png(preview: NDArray[np.uint8]) -> bytes:
    """Return an (H, W, 3) uint8 image in sRGB as the bytes of a PNG file (ISO/IEC 15948)."""
    height, width, _ = preview.shape
    packer, above, packed = zlib.compressobj(), np.zeros(3 * width, np.uint8), []
    for line in preview.reshape(height, -1):
        packed.append(packer.compress(_UP + (line - above).tobytes()))
        above = line
    chunks = {
        b"IHDR": struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0),
        b"sRGB": b"\0",
        b"IDAT": b"".join([*packed, packer.flush()]),
        b"IEND": b"",
    }
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    )
