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
from photonmap.io.readers.registry import extended
from photonmap.runtime.named_files import named_file
from photonmap.runtime.wording import shown
from photonmap.spectra.tables import read_bytes

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of component types."""
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

_HEAD = 12  # Bytes of a GLB file before its chunks


@dataclass
class Document:
    """A glTF file."""

    path: Path  # the file
    tree: dict[str, Any]  # its JSON
    binary: memoryview | None  # the BIN chunk of a GLB file
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
            raise self.error(
                f"is truncated: buffer view {index} takes bytes {begin} to {end} of buffer "
                f"{view['buffer']}, which has {len(data)}; export it again"
            )
        return data[begin:end]

    def rows(self, index: int) -> NDArray[Any]:
        """Return what an accessor describes, (N, C); float64 where integers are normalised."""
        item = self.item("accessors", index)
        if "bufferView" not in item and "sparse" not in item:
            message = "has compressed vertices, or none, which is not supported"
            raise self.error(f"{message}; export it without compression")
        kind, columns = np.dtype(_TYPES[item["componentType"]]), _COLUMNS[item["type"]]
        values = self._strided(index, item, kind, columns)
        if "sparse" in item:
            values = self._replaced(index, values, item["sparse"])
        if item.get("normalized") and kind.kind != "f":
            return np.maximum(values / np.float64(np.iinfo(kind).max), -1.0)
        return values

    def _strided(
        self, index: int, item: dict[str, Any], kind: np.dtype[Any], columns: int
    ) -> NDArray[Any]:
        """Return the rows in the buffer view of an accessor of an index; zeros without one."""
        count = item["count"]
        if "bufferView" not in item:
            size = sum(len(self._buffer(i)) for i in range(len(self.tree.get("buffers", []))))
            if not 0 <= count <= size:  # the rows of a mesh take a byte somewhere
                raise self.error(
                    f"accessor {index} announces {count} rows without data; export it again"
                )
            return np.zeros((count, columns), kind)
        stride = self.item("bufferViews", item["bufferView"]).get("byteStride", 0)
        return self._array(index, item, kind, (count, columns), stride)

    def _replaced(self, index: int, values: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """Return a copy of rows, with those that differ from them by a sparse accessor."""
        indices, rows = sparse["indices"], sparse["values"]
        kind, count = np.dtype(_TYPES[indices["componentType"]]), sparse["count"]
        at = self._array(index, indices, kind, (count, 1))[:, 0]
        if (at >= len(values)).any():
            raise self.error(
                f"accessor {index} has {len(values)} rows, and changes row {at.max()}; "
                "export it again"
            )
        changed = values.copy()
        changed[at] = self._array(index, rows, values.dtype, (count, values.shape[1]))
        return changed

    def _array(
        self,
        index: int,
        item: dict[str, Any],
        kind: np.dtype[Any],
        shape: tuple[int, int],
        stride: int = 0,
    ) -> NDArray[Any]:
        """Return rows in a buffer view, for an accessor of an index.

        Parameters
        ----------
        stride : bytes from row to row; 0 where they lie without gaps
        """
        view, begin, size = self.view(item["bufferView"]), item.get("byteOffset", 0), kind.itemsize
        (count, columns), step = shape, stride or shape[1] * size
        end = begin + max(count - 1, 0) * step + (columns * size if count else 0)
        if not (0 <= begin <= end <= len(view) and count >= 0 <= step):
            rows = f"{count} rows of {columns} × {size} bytes"
            owner = f"buffer view {item['bufferView']}, which has {len(view)}"
            raise self.error(
                f"accessor {index} takes bytes {begin} to {end} ({rows}) of {owner}; "
                "export it again"
            )
        return np.ndarray(shape, kind, view, begin, (step, size))

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
        try:
            return read_bytes(named_file(self.path.parent, unquote(uri)))
        except InputError as error:
            raise extended(error, f"; {self.path.name} names it") from None


def split_glb(path: Path, data: bytes) -> tuple[memoryview, memoryview | None]:
    """Return the JSON chunk of a GLB file, and its BIN chunk if there is one."""
    if data[:4] != b"glTF":
        raise InputError("is not a GLB file; name one that begins with 'glTF'", path)
    if len(data) < _HEAD:
        raise InputError(f"is truncated after {len(data)} bytes; export it again", path)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(f"is glTF {version}; export it as glTF 2.0", path)
    chunks: dict[bytes, memoryview] = {}
    at = _HEAD
    while at + 8 <= min(length, len(data)):
        size, kind = struct.unpack_from("<I4s", data, at)
        chunks.setdefault(kind, memoryview(data)[at + 8 : at + 8 + size])
        at += 8 + size
    if at > len(data) or length > len(data) or b"JSON" not in chunks:
        raise InputError(f"is truncated: {len(data)} of {length} bytes; export it again", path)
    return chunks[b"JSON"], chunks.get(b"BIN\0")
