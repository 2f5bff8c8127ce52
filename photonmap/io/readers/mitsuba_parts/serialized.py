"""Read meshes of Mitsuba's compressed binary format, `.serialized`."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.meshes import Part
from photonmap.spectra.tables import read_bytes

_MAGIC = 0x041C
_OFFSETS = {3: "<I", 4: "<Q"}
"""How versions store where each mesh begins."""
_NORMALS, _UV, _COLORS, _FLAT, _DOUBLE = 0x1, 0x2, 0x8, 0x10, 0x2000
"""Flags of a mesh"""
_LONGEST_NAME = 4096
_HEADER = 4
"""Bytes before the compressed data."""
_MOST = 1100
"""Bytes that zlib can pack into one: 1032, and a little more."""


def read_serialized(path: Path, index: int) -> Part:
    """Return one of the meshes of a file, without normals if it is to be flat.

    Raises
    ------
    InputError : the file is not of this format, is damaged, or has no mesh of this index
    """
    data = read_bytes(path)
    if len(data) < 2 * _HEADER:
        raise _damaged(path)
    magic, version = struct.unpack_from("<HH", data)
    if magic != _MAGIC or version not in _OFFSETS:
        raise InputError("is not a .serialized file of version 3 or 4; export it again", path)
    start = _begin(path, data, version, index) if index else 0
    packed = data[start + _HEADER :]
    stream = _Stream(path, zlib.decompressobj(), packed, _MOST * len(packed))
    (flags,) = struct.unpack("<I", stream.take(4))
    if version > min(_OFFSETS):
        stream.skip_name()
    vertices, triangles = struct.unpack("<QQ", stream.take(16))
    real = np.dtype("<f8" if flags & _DOUBLE else "<f4")

    def rows(columns: int) -> NDArray[np.float64]:
        values = np.frombuffer(stream.take(vertices * columns * real.itemsize), real)
        return values.reshape(-1, columns).astype(np.float64)

    places = rows(3)
    normals = rows(3) if flags & _NORMALS else None
    uv = rows(2) if flags & _UV else None
    if flags & _COLORS:
        rows(3)
    whole = np.dtype("<u8" if vertices > 0xFFFFFFFF else "<u4")
    corners = np.frombuffer(stream.take(3 * triangles * whole.itemsize), whole)
    faces = corners.reshape(-1, 3).astype(np.int64)
    return Part(places, faces, np.zeros_like(places) if flags & _FLAT else normals, uv)


@dataclass
class _Stream:
    """Compressed data, of which no more is unpacked than is asked for.

    Parameters
    ----------
    path : the file, for messages
    unpacker : of zlib
    packed : what is still compressed
    room : most bytes that it can unpack to
    """

    path: Path
    unpacker: zlib._Decompress
    packed: bytes
    room: int

    def take(self, size: int) -> bytes:
        """Return the next bytes.

        Raises
        ------
        InputError : there are not so many, or they are damaged
        """
        if size > self.room:
            raise _damaged(self.path)
        self.room -= size
        parts = []
        try:
            while size:
                part = self.unpacker.decompress(self.packed, size)
                self.packed = self.unpacker.unconsumed_tail
                if not part:
                    raise _damaged(self.path)
                parts.append(part)
                size -= len(part)
        except zlib.error:
            raise _damaged(self.path) from None
        return b"".join(parts)

    def skip_name(self) -> None:
        """Skip a text that ends with a zero byte."""
        for _ in range(_LONGEST_NAME):
            if self.take(1) == b"\0":
                return
        raise _damaged(self.path)


def _begin(path: Path, data: bytes, version: int, index: int) -> int:
    """Return where a mesh begins, from the table at the end of the file."""
    (count,) = struct.unpack_from("<I", data, len(data) - 4)
    if index >= count:
        message = f"has {count} meshes, counted from 0, and not number {index}"
        raise InputError(f"{message}; correct shape_index", path)
    kind = _OFFSETS[version]
    at = len(data) - 4 - struct.calcsize(kind) * (count - index)
    if at < 0:
        raise _damaged(path)
    start: int = struct.unpack_from(kind, data, at)[0]
    return start


def _damaged(path: Path) -> InputError:
    return InputError("is damaged: its meshes are not complete; export it again", path)
