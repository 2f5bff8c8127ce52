"""Read PLY files: elements of named numbers and lists, in text or binary, as a mesh."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.readers import decoding, meshes
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene
from photonmap.spectra.curves import Floats

SUFFIXES = (".ply",)

Kind = np.dtype[Any]
_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
Layout = tuple[dict[str, decoding.Ints], dict[str, decoding.Ints]]
"""Where the value of each row begins, and how long its list is, by the names of columns."""
_COLORS = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
)
_ALPHA = "alpha"
_INDICES = ("vertex_indices", "vertex_index")
_UV = (("texture_u", "texture_v"), ("u", "v"), ("s", "t"))
_WEDGES = ("texcoord", "texnumber")


def read(path: Path, options: ReadOptions) -> Scene:
    """Read the one mesh of a PLY file; its material is grey and called "default".

    Polygons are cut into triangles. Normals, texture coordinates, and colours of vertices or else
    of faces are those of the file.
    """
    return decoding.decode_file(path, _decode)


def _decode(path: Path, data: bytes, losses: decoding.Losses) -> Scene:
    if not data.startswith(b"ply"):
        raise InputError("is not a PLY file; name one that begins with 'ply'", path)
    elements, comments, rest = read_elements(path, data)
    _note_ply(elements, comments, losses)
    if rest:
        decoding.note_loss(losses, f"{rest} values behind the last element")
    none = Element(0)
    vertex, face = (elements.get(name, none) for name in ("vertex", "face"))
    if not (vertex.rows and face.rows):
        return Scene()
    part = _ply_part(path, vertex, face, losses)
    mesh = meshes.build_mesh(path, part, Material("default"), path.stem)
    if spare := len(part.vertices) - len(mesh.vertices):
        decoding.note_loss(losses, f"{spare} vertices in no face")
    return Scene([mesh], name=path.stem)


def _ply_part(path: Path, vertex: Element, face: Element, losses: decoding.Losses) -> meshes.Part:
    """Triangulate the faces; vertices are split where each corner has texture coordinates."""
    vertices, normals = _columns(vertex, tuple("xyz")), _columns(vertex, ("nx", "ny", "nz"))
    if vertices is None:
        raise ValueError("vertices lack x, y or z")
    uv = next((rows for pair in _UV if (rows := _columns(vertex, pair)) is not None), None)
    name = next((name for name in _INDICES if name in face.lists), None)
    if name is None:
        raise ValueError(f"faces lack {_INDICES[0]}")
    corners, sizes = face.lists[name][0].astype(np.int64), face.lists[name][1]
    if sizes.max() > meshes.LARGEST_FACE:
        row = int(np.argmax(sizes))
        message = f"face {row} has {sizes[row]} corners; export it with triangles only"
        raise InputError(message, path)
    with naming(f"mesh {shown(path.stem)}", path):
        meshes.check_indices(corners, len(vertices))
        meshes.check_rows("vertex", vertices)
    colors = _colors(vertex, "vertices", losses)
    of_faces = _colors(face, "faces", losses)
    if colors is not None and of_faces is not None:
        decoding.note_loss(losses, "colours of faces beside those of vertices")
    elif of_faces is not None:
        colors = of_faces[:, None]
    if "texcoord" in face.lists:
        flat, lengths = face.lists["texcoord"]
        if not np.array_equal(lengths, 2 * sizes):
            raise ValueError("texcoord does not hold two numbers per corner")
        vertices, uv = vertices[corners], flat.astype(np.float64).reshape(-1, 2)
        normals = None if normals is None else normals[corners]
        if colors is not None and colors.ndim == 2:
            colors = colors[corners]
        corners = np.arange(len(corners))
    return meshes.cut_polygons(vertices, corners, sizes, losses, normals, uv, colors)


def _colors(element: Element, owners: str, losses: decoding.Losses) -> Floats | None:
    """Return the colours of an element's rows, (n, 3), linear; None where it has none."""
    columns = element.columns
    found = next((names for names in _COLORS if set(names) <= set(columns)), None)
    if found is None:
        return None
    names = [*found, _ALPHA] if _ALPHA in columns else found
    rows = np.column_stack([columns[name] for name in names])
    return decoding.decode_colors(rows, partial(decoding.note_loss, losses), owners)


def _columns(element: Element, names: tuple[str, ...]) -> Floats | None:
    """Return properties of an element as columns; None where one is missing."""
    if not set(names) <= set(element.columns):
        return None
    return np.column_stack([element.columns[name].astype(np.float64) for name in names])


def _note_ply(elements: dict[str, Element], comments: list[str], losses: decoding.Losses) -> None:
    for comment in comments:
        if found := re.match(r"(?i)\s*comment\s+texturefile\s+(.*?)\s*$", comment):
            decoding.note_loss(losses, "texture", found[1])
    known = {
        "vertex": {"x", "y", "z", "nx", "ny", "nz", _ALPHA}.union(*_UV, *_COLORS),
        "face": {*_INDICES, *_WEDGES, _ALPHA}.union(*_COLORS),
    }
    for name, element in elements.items():
        if name in known:
            for other in element.kinds:
                if other not in known[name]:
                    decoding.note_loss(losses, f"{name} property", other)
        elif element.rows:
            decoding.note_loss(losses, "element", name)


@dataclass
class Element:
    """Rows of a kind, such as vertices."""

    rows: int  # how many there are
    kinds: dict[str, tuple[Kind, ...]] = field(default_factory=dict)  # of lists: length, item
    columns: dict[str, NDArray[Any]] = field(default_factory=dict)  # (rows,) numbers by name
    # all numbers of lists one after another, and the length of each, (rows,), by name
    lists: dict[str, tuple[NDArray[Any], decoding.Ints]] = field(default_factory=dict)


@dataclass
class _Stream:
    """What follows the header."""

    items: NDArray[Any]  # bytes, uint8; or the numbers of a text, float64
    at: int = 0  # how many have been read

    def width(self, kind: Kind) -> int:
        """Return how many items a number takes."""
        return kind.itemsize if self.items.dtype == np.uint8 else 1

    def take(self, places: decoding.Ints, kind: Kind) -> NDArray[Any]:
        """Return the numbers that begin at these items."""
        if self.items.dtype != np.uint8:
            with np.errstate(invalid="ignore"):
                return self.items[places].astype(kind)
        parts = self.items[places[:, None] + np.arange(kind.itemsize)]
        return parts.view(kind).ravel().astype(kind.newbyteorder("="))


def read_elements(path: Path, data: bytes) -> tuple[dict[str, Element], list[str], int]:
    """Return the elements of a PLY file by name, the lines of its header with comments, and a rest.

    The rest is the number of bytes, or numbers of a text, that belong to no element.
    """
    end = data.find(b"end_header")
    if end < 0:
        raise ValueError("its header has no end")
    begin = data.find(b"\n", end) + 1 or len(data)
    lines = [line for line in data[:end].decode("utf-8", "replace").splitlines() if line.strip()]
    words = [line.split() for line in lines]
    order = _ORDERS[next(line[1] for line in words if line[0] == "format")]
    elements = _read_header(words, order)
    items: NDArray[Any] = np.frombuffer(data, np.uint8, offset=begin)
    if order == "=":
        numbers = decoding.parse_floats(np.frombuffer(b"\n" + data[begin:] + b"\n", np.uint8))
        if numbers is None:
            decoding.check_decimals(path, data[begin:], len(data[:begin].splitlines()))
            raise ValueError("a number is malformed")
        items = numbers
    stream = _Stream(items)
    for element in elements.values():
        _read_rows(stream, element)
    comments = [line for line, parts in zip(lines, words, strict=True) if parts[0] == "comment"]
    return elements, comments, len(items) - stream.at


def _read_header(lines: list[list[str]], order: str) -> dict[str, Element]:
    elements: dict[str, Element] = {}
    element = Element(0)
    for keyword, *words in lines:
        if keyword == "element":
            if words[0] in elements or not words[1].isdecimal():
                raise ValueError(f"{shown(' '.join(words))} is no element, or is there twice")
            elements[words[0]] = element = Element(int(words[1]))
        elif keyword == "property":
            if words[-1] in element.kinds:
                raise ValueError(f"property {shown(words[-1])} is there twice")
            names = words[1:-1] if words[0] == "list" else words[:1]
            kinds = tuple(np.dtype(order + _TYPES[name]) for name in names)
            element.kinds[words[-1]] = kinds
    return elements


def _read_rows(stream: _Stream, element: Element) -> None:
    if not element.kinds:  # rows of nothing take no room, however many are announced
        return
    starts, sizes = _find_even(stream, element) or _find_uneven(stream, element)
    for name, (*length, kind) in element.kinds.items():
        places = starts[name]
        if not length:
            element.columns[name] = stream.take(places, kind)
            continue
        counts = sizes[name]
        first = np.repeat(places + stream.width(length[0]), counts)
        index = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
        element.lists[name] = stream.take(first + stream.width(kind) * index, kind), counts


def _find_even(stream: _Stream, element: Element) -> Layout | None:
    """Return the layout where the lists of a column are equally long; None where they are not."""
    at, offsets, counts = stream.at, {}, {}
    for name, (*length, kind) in element.kinds.items():
        offsets[name] = at - stream.at
        if length and element.rows:
            count = _count(stream, at, length[0])
            if count is None:
                return None
            counts[name] = count
            at += stream.width(length[0])
        at += stream.width(kind) * counts.get(name, 1)
    stride = at - stream.at
    end = stream.at + stride * element.rows
    if end > len(stream.items):
        if counts:
            return None
        raise _short(element, (len(stream.items) - stream.at) // stride)
    begins = stream.at + stride * np.arange(element.rows)
    starts = {name: begins + offset for name, offset in offsets.items()}
    sizes = {
        name: stream.take(starts[name], kinds[0]).astype(np.int64)
        for name, kinds in element.kinds.items()
        if len(kinds) > 1
    }
    if any((sizes[name] != counts[name]).any() for name in counts):
        return None
    stream.at = end
    return starts, sizes


def _find_uneven(stream: _Stream, element: Element) -> Layout:
    """Return the layout of lists of several lengths, which are followed one by one."""
    steps = [
        (stream.width(kind), length[0] if length else None)
        for *length, kind in element.kinds.values()
    ]
    places: list[int] = []
    counts: list[int] = []
    at = stream.at
    for row in range(element.rows):
        for width, length in steps:
            places.append(at)
            if length is None:
                at += width
                continue
            count = _count(stream, at, length)
            if count is None:
                raise _short(element, row)
            counts.append(count)
            at += stream.width(length) + width * count
        if at > len(stream.items):
            raise _short(element, row)
    stream.at = at
    starts = np.array(places, np.int64).reshape(element.rows, -1).T
    lists = [name for name, kinds in element.kinds.items() if len(kinds) > 1]
    lengths = np.array(counts, np.int64).reshape(element.rows, -1).T
    return (dict(zip(element.kinds, starts, strict=True)), dict(zip(lists, lengths, strict=True)))


def _short(element: Element, rows: int) -> ValueError:
    return ValueError(f"{element.rows} rows are announced, but there are {rows}")


def _count(stream: _Stream, at: int, kind: Kind) -> int | None:
    if at + stream.width(kind) > len(stream.items):
        return None
    is_item = stream.width(kind) == 1
    count = float(stream.items[at] if is_item else stream.take(np.array([at]), kind)[0])
    if not 0 <= count <= len(stream.items):
        raise ValueError(f"a list has {count:g} items")
    return int(count)
