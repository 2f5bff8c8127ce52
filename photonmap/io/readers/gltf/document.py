"""The JSON of a glTF file; the arrays, nodes, triangles and poses that it describes."""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Ints, Note
from photonmap.io.readers.gltf.materials import Json, Placement
from photonmap.io.readers.meshes import Part, unit_rows
from photonmap.io.readers.registry import extended
from photonmap.runtime.bounds import OF_TRIANGLE, Budget
from photonmap.runtime.files import named_file
from photonmap.runtime.wording import listed, shown
from photonmap.spectra.curves import Floats
from photonmap.spectra.tables import read_bytes

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy's names of component types."""
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

_SPARSE = 4
"""Vertices for each corner of a primitive from which on only those in use are read."""
_HEAD = 12  # Bytes of a GLB file before its chunks


@dataclass
class Document:
    """A glTF file."""

    path: Path  # the file
    tree: dict[str, Any]  # its JSON
    binary: memoryview | None  # the BIN chunk of a GLB file
    _buffers: dict[int, memoryview] = field(default_factory=dict)
    _files: dict[Path, bytes] = field(default_factory=dict)

    @cached_property
    def budget(self) -> Budget:
        """What nodes and primitives take that share meshes and accessors."""
        return Budget(self.path)

    @cached_property
    def _size(self) -> int:
        """Bytes of all buffers."""
        return sum(len(self._buffer(i)) for i in range(len(self.tree.get("buffers", []))))

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

    def rows(self, index: int, at: Ints | None = None) -> NDArray[Any]:
        """Return what an accessor describes, (N, C), or some of its rows.

        float64 where integers are normalised
        """
        item = self.item("accessors", index)
        if "bufferView" not in item and "sparse" not in item:
            message = "has compressed vertices, or none, which is not supported"
            raise self.error(f"{message}; export it without compression")
        kind, columns = np.dtype(_TYPES[item["componentType"]]), _COLUMNS[item["type"]]
        values = self._strided(index, item, kind, columns)
        if "sparse" in item:
            self.budget.spend(values.nbytes, "what changes rows of others")
            values = self._replaced(index, values, item["sparse"])
        values = values if at is None else values[at]
        if item.get("normalized") and kind.kind != "f":
            return np.maximum(values / np.float64(np.iinfo(kind).max), -1.0)
        return values

    def _strided(
        self, index: int, item: dict[str, Any], kind: np.dtype[Any], columns: int
    ) -> NDArray[Any]:
        """Return the rows in the buffer view of an accessor of an index; zeros without one."""
        count = item["count"]
        if "bufferView" not in item:
            if not 0 <= count <= self._size:  # the rows of a mesh take a byte somewhere
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
            path = named_file(self.path.parent, unquote(uri))
            if path not in self._files:
                self._files[path] = read_bytes(path)
            return self._files[path]
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


MODES = TRIANGLES, STRIP, FAN = 4, 5, 6  # Of primitives that are made of triangles
Place = Callable[[int], Floats]
"""Returns the matrix of a node, from its coordinates to the scene's."""


def read_primitive(document: Document, primitive: Json, placement: Placement, lose: Note) -> Part:
    """Return the triangles of a primitive; v increases upwards, as in OBJ."""
    attributes = primitive["attributes"]
    count = document.item("accessors", attributes["POSITION"])["count"]

    def rows(name: str, *columns: int) -> Floats | None:
        if name not in attributes:
            return None
        if document.item("accessors", attributes[name])["count"] != count:
            raise ValueError(f"{name} has the wrong shape")
        found = document.rows(attributes[name], used)
        if found.shape[1] not in columns:
            raise ValueError(f"{name} has the wrong shape")
        return np.array(found, np.float64)

    if "indices" in primitive:
        corners = document.rows(primitive["indices"])[:, 0].astype(np.int64)
    else:
        corners = np.arange(len(document.rows(attributes["POSITION"])))  # which are there
    document.budget.spend(OF_TRIANGLE // 3 * len(corners))
    used, corners = _find_used(corners, count)

    vertices, normals = rows("POSITION", 3), rows("NORMAL", 3)
    assert vertices is not None
    uv, colors = rows(f"TEXCOORD_{placement.coordinates}", 2), rows("COLOR_0", 3, 4)
    if uv is not None:
        uv[:, 1] = 1.0 - uv[:, 1]
        uv = placement.turn(uv)
    if colors is not None:  # linear
        opaque = np.ones((len(colors), 4 - colors.shape[1]))
        colors = np.column_stack([np.clip(colors, 0.0, 1.0), opaque])
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES and (more := len(corners) % 3):
        corners = corners[:-more]
        lose("corners of incomplete triangles")
    faces = _triangles(corners, mode)
    tangents = None
    if "TANGENT" in attributes and normals is not None:
        tangents = document.rows(attributes["TANGENT"]).astype(np.float64)
        tangents = tangents if used is None or len(tangents) != count else tangents[used]
        if tangents.shape != (len(vertices), 4):
            lose("tangents of another shape than (x, y, z, w)")
            tangents = None
    return Part(vertices, faces, normals, uv, colors, tangents, used)


def _find_used(corners: Ints, count: int) -> tuple[Ints | None, Ints]:
    """Return the rows, of `count`, that corners use, and the corners among these.

    None is all of them: many primitives may share accessors of which each uses a part.
    """
    if len(corners) * _SPARSE >= count or not len(corners) or corners.min() < 0:
        return None, corners
    if corners.max() >= count:
        return None, corners
    used, among = np.unique(corners, return_inverse=True)
    return used, among


def _triangles(corners: Ints, mode: int) -> Ints:
    if mode == TRIANGLES:
        return corners.reshape(-1, 3)
    first = np.arange(max(len(corners) - 2, 0))
    if mode == STRIP:
        odd = first % 2
        return corners[np.stack([first, first + 1 + odd, first + 2 - odd], axis=1)]
    return corners[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]


def place_nodes(document: Document, roots: list[int]) -> dict[int, Floats]:
    """Return the matrix of each node below the roots, 4×4, from its coordinates to the scene's."""
    placed = {}
    below = [(root, np.eye(4)) for root in roots]
    while below:
        index, above = below.pop()
        node = document.item("nodes", index)
        placed[index] = above @ _matrix(node)
        below += [(child, placed[index]) for child in node.get("children", ())]
    return placed


def _matrix(node: Json) -> Floats:
    """Return the matrix of a node, or the product of its translation, rotation and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(node.get("rotation", (0.0, 0.0, 0.0, 1.0))) * np.array(
        node.get("scale", (1.0, 1.0, 1.0)), np.float64
    )
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


COPIES = "EXT_mesh_gpu_instancing"


def find_copies(document: Document, node: Json) -> list[Floats] | None:
    """Return matrices, 4×4, from copies of a node's mesh to its own coordinates; None without."""
    content = node.get("extensions", {}).get(COPIES)
    if content is None:
        return None
    attributes = content.get("attributes", {})
    for index in attributes.values():  # so that a copy takes bytes in the file
        if "bufferView" not in document.item("accessors", index):
            raise document.error(f"{COPIES} has accessor {index} without data; export it again")
    rows = {name.lower(): document.rows(index) for name, index in attributes.items()}
    counts = {len(values) for values in rows.values()}
    if len(counts) != 1:
        found = f"attributes of {' and '.join(map(str, sorted(counts)))} rows" if counts else "none"
        problem = f"node {shown(node.get('name', ''))}: {COPIES} needs attributes of one count"
        raise document.error(f"{problem}, and has {found}; export it again")
    (count,) = counts
    return [_matrix({name: values[row] for name, values in rows.items()}) for row in range(count)]


def _rotation(quaternion: Any) -> Floats:
    """Return the rotation, 3×3, of a quaternion (x, y, z, w) of any length; 0 does not turn."""
    x, y, z, w = np.array(quaternion, np.float64)
    length = x * x + y * y + z * z + w * w
    s = 2.0 / length if length > 0.0 else 0.0
    return np.array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True)
class Pose:
    """How the mesh of a node is changed before it is shown."""

    weights: Sequence[float]  # of morph targets
    # (J, 4, 4), from the mesh's coordinates at rest to the scene's; None without a skin, where the
    # node's matrix does that
    bones: Floats | None


def find_pose(document: Document, node: Json, place: Place) -> Pose:
    """Return the pose of a node's mesh, with its bones where the nodes are."""
    mesh = document.item("meshes", node["mesh"])
    weights = node.get("weights") or mesh.get("weights") or ()
    if "skin" not in node:
        return Pose(weights, None)
    skin = document.item("skins", node["skin"])
    bones = np.array([place(joint) for joint in skin["joints"]], np.float64).reshape(-1, 4, 4)
    if "inverseBindMatrices" in skin:
        columns = document.rows(skin["inverseBindMatrices"])[: len(bones)]
        bones = bones @ columns.reshape(-1, 4, 4).transpose(0, 2, 1)
    return Pose(weights, bones)


def strike_pose(
    document: Document, part: Part, primitive: Json, pose: Pose, lose: Note
) -> tuple[Part, bool]:
    """Return a primitive in a pose, and whether it is in the scene's coordinates."""
    part = _morphed(document, part, primitive, pose.weights, lose)
    attributes = primitive["attributes"]
    if pose.bones is None or "JOINTS_0" not in attributes:
        return part, False
    blended = np.zeros((len(part.vertices), 4, 4))
    total = np.zeros(len(part.vertices))
    for index in range(len(attributes)):
        if f"JOINTS_{index}" not in attributes:
            break
        joints = document.rows(attributes[f"JOINTS_{index}"], part.rows).astype(np.int64)
        shares = document.rows(attributes[f"WEIGHTS_{index}"], part.rows).astype(np.float64)
        for joint, share in zip(joints.T, shares.T, strict=True):
            blended += share[:, None, None] * pose.bones[joint]
            total += share
    blended /= np.where(total > 0.0, total, 1.0)[:, None, None]
    linear, moved = blended[:, :3, :3], blended[:, :3, 3]
    vertices = np.einsum("vij,vj->vi", linear, part.vertices) + moved
    normals = part.normals
    if normals is not None:
        rows = np.stack([np.cross(linear[:, i - 2], linear[:, i - 1]) for i in range(3)], axis=1)
        normals = unit_rows(np.einsum("vij,vj->vi", rows, normals))
    tangents = part.tangents
    if tangents is not None:
        along = np.einsum("vij,vj->vi", linear, tangents[:, :3])
        tangents = np.column_stack([along, tangents[:, 3]])
    faces = part.faces
    if len(linear) and np.linalg.det(linear).mean() < 0.0:  # bones that mirror: sides stay outside
        faces, normals = faces[:, ::-1], None if normals is None else -normals
        tangents = None if tangents is None else tangents * [1.0, 1.0, 1.0, -1.0]
    posed = replace(part, vertices=vertices, faces=faces, normals=normals, tangents=tangents)
    return posed, True


def _morphed(
    document: Document, part: Part, primitive: Json, weights: Sequence[float], lose: Note
) -> Part:
    """Add what morph targets add, times their weights."""
    moved: dict[str, Any] = {
        "POSITION": part.vertices, "NORMAL": part.normals, "TANGENT": part.tangents
    }  # fmt: skip
    for target, weight in zip(primitive.get("targets", ()), weights, strict=False):
        if weight != 0.0 and (others := [name for name in target if name not in moved]):
            lose(f"morphing of {listed(sorted(others))}")
        for name, rows in moved.items():
            if weight != 0.0 and name in target and rows is not None:
                along = rows[:, :3] + weight * document.rows(target[name], part.rows)
                moved[name] = np.column_stack([along, rows[:, 3:]])
    vertices, normals, tangents = moved.values()
    if normals is not part.normals:
        normals = unit_rows(normals)
    return replace(part, vertices=vertices, normals=normals, tangents=tangents)
