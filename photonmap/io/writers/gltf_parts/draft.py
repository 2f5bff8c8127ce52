"""A glTF file under construction: its JSON and its binary buffer."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from photonmap.errors import InputError, warn
from photonmap.runtime.wording import listed

_TYPES = {"<f4": 5126, "<u2": 5123, "<u4": 5125}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_LARGEST = (1 << 32) - 1
_VERTICES, _INDICES = 34962, 34963  # What buffer views are for


@dataclass
class Draft:
    """What has been written so far."""

    tree: dict[str, Any] = field(default_factory=dict)  # the JSON
    blocks: list[bytes] = field(default_factory=list)  # of the buffer, each a multiple of 4 bytes
    # what other numbers than those of the scene are written for, and whose it is
    rounded: dict[str, list[str]] = field(default_factory=dict)
    _size: int = 0

    def add(self, kind: str, item: dict[str, Any]) -> int:
        """Append an item to a top-level array; return its index."""
        items = self.tree.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def use(self, extension: str, content: dict[str, Any]) -> dict[str, Any]:
        """Return the JSON of an extension, which is listed as used."""
        used = self.tree.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)
        return {extension: content}

    def add_view(self, data: bytes, **more: int) -> int:
        """Append bytes to the buffer; return the index of their view, which may say more."""
        view = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data), **more}
        self.blocks.append(data + b"\0" * (-len(data) % 4))
        self._size += len(self.blocks[-1])
        return self.add("bufferViews", view)

    def add_rows(self, rows: NDArray[Any], kind: str, limits: bool = False) -> int:
        """Append an array of one or two dimensions; return the index of its accessor.

        Parameters
        ----------
        kind : "<f4", "<u2" or "<u4"
        limits : whether the least and largest values are named too
        """
        table, is_float = rows.reshape(len(rows), -1).astype(kind), kind == "<f4"
        item = {
            "bufferView": self.add_view(
                table.tobytes(), target=_VERTICES if is_float else _INDICES
            ),
            "componentType": _TYPES[kind],
            "type": _SHAPES[table.shape[1]],
            "count": len(table),
        }
        if limits:
            item |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self.add("accessors", item)

    def note(self, what: str, owner: str) -> None:
        """Note what is written differently, and whose it is."""
        self.rounded.setdefault(what, []).append(owner)

    def warn(self) -> None:
        """Warn of what is written differently."""
        for what, owners in self.rounded.items():
            warn(f"{what}, in {len(owners)} material{'s' * (len(owners) > 1)}: {listed(owners)}")

    def finish(self, uri: str | None) -> tuple[dict[str, Any], bytes]:
        """Return the JSON and the buffer, which lies in the file of a name or in the same one."""
        data = b"".join(self.blocks)
        named = {} if uri is None else {"uri": uri}
        buffer = {**named, "byteLength": len(data)}
        asset = {"version": "2.0", "generator": "photonmap"}
        return {"asset": asset, **self.tree, "buffers": [buffer]}, data


def pack_glb(tree: dict[str, Any], data: bytes) -> bytes:
    """Return a GLB file."""
    text = json.dumps(tree, ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    size = 28 + len(text) + len(data)
    if size > _LARGEST:
        raise InputError(f"a GLB file of {size} bytes is too large; write .gltf")
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(data), b"BIN\0"),
            data,
        ]
    )
