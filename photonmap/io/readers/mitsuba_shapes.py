"""Read shapes: surfaces with a formula, and those of mesh files."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers import meshes, obj, ply
from photonmap.io.readers.mitsuba_bsdfs import is_one_sided, read_material
from photonmap.io.readers.mitsuba_colors import read_paint
from photonmap.io.readers.mitsuba_nodes import Node, once
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.spectra.curves import Floats
from photonmap.spectra.tables import read_bytes

_MAGIC = 0x041C
_OFFSETS = {3: "<I", 4: "<Q"}  # How versions store where each mesh begins
_NORMALS, _UV, _COLORS, _FLAT, _DOUBLE = 0x1, 0x2, 0x8, 0x10, 0x2000  # Flags of a mesh
_LONGEST_NAME = 4096
_HEADER = 4  # Bytes before the compressed data
_MOST = 1100  # Bytes that zlib can pack into one: 1032, and a little more
Matrix = Floats
_CLOSED = ("sphere", "cube")
_GROUP, _INSTANCE = "shapegroup", "instance"


def read_shapes(node: Node) -> Iterator[Mesh]:
    """Return the meshes of a shape, none of a group, which only its instances show."""
    if node.type == _INSTANCE:
        groups = [part for part in node.parts("shape") if part.type == _GROUP]
        if len(groups) != 1:
            raise node.error("an instance shows one shapegroup; give it a <ref> to that")
        matrix = node.transform()
        for shape in groups[0].parts("shape"):
            yield _mesh(shape, node.unique_name("mesh"), matrix)
        node.lose_unread()
    elif node.type != _GROUP:
        yield _mesh(node, node.unique_name("mesh"), np.eye(4))


@once
def _part(node: Node) -> meshes.Part:
    """Return the geometry of a shape in its own coordinates."""
    if node.type not in _TYPES:
        raise node.unknown(_TYPES)
    return _TYPES[node.type](node)


def _mesh(node: Node, name: str, outer: Matrix) -> Mesh:
    part = meshes.move(_part(node), outer @ node.transform())
    if node.type in _FILES:
        part = _with_normals(node, part)
    if node.flag("flip_normals", False):
        normals = None if part.normals is None else -part.normals
        part = replace(part, faces=part.faces[:, ::-1], normals=normals)
    mesh = meshes.build_mesh(node.element.path, part, _material(node), name)
    node.lose_unread()
    return mesh


def _material(node: Node) -> Material:
    """Return the material of a shape; without a bsdf it is grey, or black if it emits."""
    bsdfs, emitters = node.parts("bsdf"), node.parts("emitter")
    material = read_material(bsdfs[-1]) if bsdfs else Material("default")
    if bsdfs and node.type not in _CLOSED and is_one_sided(bsdfs[-1]):
        node.lose("black backs of one-sided surfaces")
    if not emitters:
        return material
    emitter = emitters[-1]
    if emitter.type != "area":
        raise emitter.error(f"a shape has an emitter of type {shown(emitter.type)}; give area")
    radiance = read_paint(emitter, "radiance", (1.0, 1.0, 1.0), "emission")
    emitter.lose_unread()
    name = (emitter if emitter.id else node).unique_name("material")
    if not bsdfs:
        return Material(name, 0.0, radiance)
    return replace(material, name=name, emission=radiance)


def _sphere(node: Node) -> meshes.Part:
    return meshes.sphere(np.array(node.vector("center", (0.0, 0.0, 0.0))), _radius(node))


def _cylinder(node: Node) -> meshes.Part:
    start = np.array(node.vector("p0", (0.0, 0.0, 0.0)))
    end = np.array(node.vector("p1", (0.0, 0.0, 1.0)))
    if (start == end).all():
        raise node.error("both ends of a cylinder are the same; move p0 or p1")
    return meshes.cylinder(start, end, _radius(node))


def _radius(node: Node) -> float:
    radius = node.number("radius", 1.0)
    if radius <= 0.0:
        raise node.error(f"radius {radius:g} is not above 0; correct it")
    return radius


def _obj(node: Node) -> meshes.Part:
    mesh = obj.read_shape(node.file())
    part = meshes.Part(mesh.vertices, mesh.faces, mesh.normals, mesh.uv)
    return part if node.flag("flip_tex_coords", True) else _turned(part)


def _ply(node: Node) -> meshes.Part:
    mesh = ply.read(node.file(), ReadOptions()).meshes[0]
    part = meshes.Part(mesh.vertices, mesh.faces, mesh.normals, mesh.uv)
    return part if node.flag("flip_tex_coords", False) else _turned(part)


def _serialized(node: Node) -> meshes.Part:
    return _turned(read_serialized(node.file(), node.whole("shape_index", 0)))


def _turned(part: meshes.Part) -> meshes.Part:
    """Return a part whose v counts upwards instead of downwards, or the other way round."""
    return part if part.uv is None else replace(part, uv=part.uv * [1.0, -1.0] + [0.0, 1.0])


def _with_normals(node: Node, part: meshes.Part) -> meshes.Part:
    if node.flag("face_normals", False):
        return replace(part, normals=None)
    if part.normals is not None:
        return part
    sizes, at = np.full(len(part.faces), 3), part.faces.ravel()
    normals = meshes.vertex_normals(part.vertices[at], sizes, at, len(part.vertices))
    return replace(part, normals=normals)


def read_serialized(path: Path, index: int) -> meshes.Part:
    """Return one of the meshes of a file, without normals if it is to be flat."""
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

    def rows(columns: int) -> Floats:
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
    return meshes.Part(places, faces, np.zeros_like(places) if flags & _FLAT else normals, uv)


@dataclass
class _Stream:
    """Compressed data, of which no more is unpacked than is asked for."""

    path: Path  # the file, for messages
    unpacker: zlib._Decompress  # of zlib
    packed: bytes  # what is still compressed
    room: int  # most bytes that it can unpack to

    def take(self, size: int) -> bytes:
        """Return the next bytes."""
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


_FILES: dict[str, Callable[[Node], meshes.Part]] = {
    "obj": _obj,
    "ply": _ply,
    "serialized": _serialized,
}
_TYPES: dict[str, Callable[[Node], meshes.Part]] = {
    "rectangle": lambda node: meshes.rectangle(),
    "cube": lambda node: meshes.cube(),
    "sphere": _sphere,
    "disk": lambda node: meshes.disk(),
    "cylinder": _cylinder,
    **_FILES,
}
