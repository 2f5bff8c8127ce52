"""The JSON of a glTF file, and the arrays that it describes."""

from __future__ import annotations

import base64
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.named_files import named_file
from photonmap.runtime.wording import shown
from photonmap.spectra.tables import read_bytes

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of component types."""
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Document:
    """A glTF file.

    Parameters
    ----------
    path : the file
    tree : its JSON
    binary : the BIN chunk of a GLB file
    """

    path: Path
    tree: dict[str, Any]
    binary: memoryview | None
    _buffers: dict[int, memoryview] = field(default_factory=dict)

    def error(self, message: str) -> InputError:
        """Return an error about this file."""
        return InputError(message, self.path)

    def item(self, kind: str, index: int) -> dict[str, Any]:
        """Return an item of a top-level array."""
        items = self.tree.get(kind, [])
        if type(index) is not int or not 0 <= index < len(items):
            raise self.error(f"names {kind} {shown(index)}, but has {len(items)}; export it again")
        item: dict[str, Any] = items[index]
        return item

    def view(self, index: int) -> memoryview:
        """Return the bytes of a buffer view."""
        view = self.item("bufferViews", index)
        begin, data = view.get("byteOffset", 0), self._buffer(view["buffer"])
        end = begin + view["byteLength"]
        if not 0 <= begin <= end <= len(data):
            raise self.error("is truncated: its buffers are too short; export it again")
        return data[begin:end]

    def rows(self, index: int) -> NDArray[Any]:
        """Return what an accessor describes, (N, C); float64 where integers are normalised."""
        item = self.item("accessors", index)
        if "bufferView" not in item and "sparse" not in item:
            message = "has compressed vertices, or none, which is not supported"
            raise self.error(f"{message}; export it without compression")
        kind, columns = np.dtype(_TYPES[item["componentType"]]), _COLUMNS[item["type"]]
        values = self._strided(item, kind, columns)
        if "sparse" in item:
            values = self._replaced(values, item["sparse"])
        if item.get("normalized") and kind.kind != "f":
            return np.maximum(values / np.float64(np.iinfo(kind).max), -1.0)
        return values

    def _strided(self, item: dict[str, Any], kind: np.dtype[Any], columns: int) -> NDArray[Any]:
        """Return the rows in an accessor's buffer view; zeros without one."""
        if "bufferView" not in item:
            size = sum(len(self._buffer(i)) for i in range(len(self.tree.get("buffers", []))))
            if not 0 <= item["count"] <= size:  # the rows of a mesh take a byte somewhere
                raise self.error(f"announces {item['count']} rows without data; export it again")
            return np.zeros((item["count"], columns), kind)
        stride = self.item("bufferViews", item["bufferView"]).get("byteStride", 0)
        return np.ndarray(
            (item["count"], columns),
            kind,
            self.view(item["bufferView"]),
            item.get("byteOffset", 0),
            (stride or columns * kind.itemsize, kind.itemsize),
        )

    def _replaced(self, values: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """Return a copy of rows, with those that differ from them by a sparse accessor."""
        indices, rows = sparse["indices"], sparse["values"]
        kind, count = np.dtype(_TYPES[indices["componentType"]]), sparse["count"]
        at = self._packed(indices, kind, (count,))
        changed = values.copy()
        changed[at] = self._packed(rows, values.dtype, (count, values.shape[1]))
        return changed

    def _packed(
        self, item: dict[str, Any], kind: np.dtype[Any], shape: tuple[int, ...]
    ) -> NDArray[Any]:
        """Return an array that lies without gaps in a buffer view."""
        return np.ndarray(shape, kind, self.view(item["bufferView"]), item.get("byteOffset", 0))

    def _buffer(self, index: int) -> memoryview:
        """Return the bytes of a buffer, which are read once."""
        if index not in self._buffers:
            self._buffers[index] = memoryview(self._load(index, self.item("buffers", index)))
        return self._buffers[index]

    def _load(self, index: int, buffer: dict[str, Any]) -> bytes | memoryview:
        uri = buffer.get("uri")
        if uri is None:
            if index or self.binary is None:
                raise self.error(f"has no data for buffer {index}; export it again")
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2], validate=True)
        return read_bytes(named_file(self.path.parent, unquote(uri)))


def split_glb(path: Path, data: bytes) -> tuple[memoryview, memoryview | None]:
    """Return the JSON chunk of a GLB file, and its BIN chunk if there is one.

    Raises
    ------
    InputError : it is not a GLB file, of another version, or truncated
    """
    if data[:4] != b"glTF":
        raise InputError("is not a GLB file; name one that begins with 'glTF'", path)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(f"is glTF {version}; export it as glTF 2.0", path)
    chunks: dict[bytes, memoryview] = {}
    at = 12
    while at + 8 <= min(length, len(data)):
        size, kind = struct.unpack_from("<I4s", data, at)
        chunks.setdefault(kind, memoryview(data)[at + 8 : at + 8 + size])
        at += 8 + size
    if at > len(data) or length > len(data) or b"JSON" not in chunks:
        raise InputError(f"is truncated: {len(data)} of {length} bytes; export it again", path)
    return chunks[b"JSON"], chunks.get(b"BIN\0")
