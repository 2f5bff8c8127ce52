"""Read PLY files."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.readers.colors import decode_colors
from photonmap.io.readers.decoding import Losses, decode_file, note_loss
from photonmap.io.readers.meshes import Part, build_mesh, check_indices, check_rows, cut_polygons
from photonmap.io.readers.polygons import LARGEST_FACE
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.wording import shown
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene

SUFFIXES = (".ply",)

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

    Raises
    ------
    InputError : as `decode_file`; or a face or a number is not valid
    """
    return decode_file(path, _decode)


def _decode(path: Path, data: bytes, losses: Losses) -> Scene:
    from trimesh.exchange.ply import load_ply

    if not data.startswith(b"ply"):
        raise InputError("is not a PLY file; name one that begins with 'ply'", path)
    try:
        loaded = load_ply(BytesIO(data), fix_texture=False, skip_materials=True)
    except ValueError as error:
        if "unexpected length" not in str(error):
            raise
        message = "is damaged, or has polygons of several sizes in binary; export it again"
        raise InputError(f"{message}, triangulated or as ASCII", path) from None
    elements = loaded["metadata"]["_ply_raw"]
    if not all(elements.get(name, {}).get("length") for name in ("vertex", "face")):
        return Scene()
    _note_ply(data, elements, losses)
    part = _ply_part(path, elements["vertex"], elements["face"], losses)
    if not len(part.faces):
        return Scene()
    mesh = build_mesh(path, part, Material("default"), path.stem)
    if spare := len(part.vertices) - len(mesh.vertices):
        note_loss(losses, f"{spare} vertices in no face")
    return Scene([mesh], name=path.stem)


def _ply_part(path: Path, vertex: dict[str, Any], face: dict[str, Any], losses: Losses) -> Part:
    """Triangulate the faces; vertices are split where each corner has texture coordinates."""
    vertices, normals = _columns(vertex, tuple("xyz")), _columns(vertex, ("nx", "ny", "nz"))
    if vertices is None:
        raise ValueError("vertices lack x, y or z")
    uv = next((rows for pair in _UV if (rows := _columns(vertex, pair)) is not None), None)
    name = next((name for name in _INDICES if name in face["properties"]), None)
    if name is None:
        raise ValueError(f"faces lack {_INDICES[0]}")
    corners, sizes = _lists(face, name)
    if not (sizes.min() >= 3 and sizes.max() <= LARGEST_FACE):
        row = int(np.argmax((sizes < 3) | (sizes > LARGEST_FACE)))
        message = f"face {row} has {sizes[row]} corners; export it with triangles only"
        raise InputError(message, path)
    with naming(f"mesh {shown(path.stem)}", path):
        check_indices(corners, len(vertices))
        check_rows("vertex", vertices)
    colors = _colors(vertex, "vertices", losses)
    of_faces = _colors(face, "faces", losses)
    if colors is not None and of_faces is not None:
        note_loss(losses, "colours of faces beside those of vertices")
    elif of_faces is not None:
        colors = of_faces[:, None]
    if "texcoord" in face["properties"]:
        flat, lengths = _lists(face, "texcoord", np.float64)
        if not np.array_equal(lengths, 2 * sizes):
            raise ValueError("texcoord does not hold two numbers per corner")
        vertices, uv = vertices[corners], flat.reshape(-1, 2)
        normals = None if normals is None else normals[corners]
        if colors is not None and colors.ndim == 2:
            colors = colors[corners]
        corners = np.arange(len(corners))
    return cut_polygons(vertices, corners, sizes, losses, normals, uv, colors)


def _colors(element: dict[str, Any], owners: str, losses: Losses) -> NDArray[np.float64] | None:
    """Return the colours of an element's rows, (n, 3), linear; None where it has none."""
    properties = element["properties"]
    found = next((names for names in _COLORS if set(names) <= set(properties)), None)
    if found is None:
        return None
    names = [*found, _ALPHA] if _ALPHA in properties else found
    columns = [np.asarray(element["data"][name]).ravel() for name in names]
    _check_length(element, len(columns[0]))
    return decode_colors(np.column_stack(columns), partial(note_loss, losses), owners)


def _columns(element: dict[str, Any], names: Iterable[str]) -> NDArray[np.float64] | None:
    """Return properties of an element as columns; None where one is missing."""
    names = tuple(names)
    if not set(names) <= set(element["properties"]):
        return None
    columns = [np.asarray(element["data"][name], np.float64) for name in names]
    table = np.column_stack(columns)
    _check_length(element, len(table))
    return table


def _lists(
    element: dict[str, Any], name: str, kind: type = np.int64
) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Return a list property of an element: all its numbers, and how many each row has."""
    column = element["data"][name]
    if isinstance(element["data"], np.ndarray):
        if (column["f0"] != column["f0"][0]).any():
            raise ValueError("lists of several sizes in binary")
        column = column["f1"]
    _check_length(element, len(column))
    if column.dtype == object:
        sizes = np.array([len(row) for row in column], np.int64)
        return np.concatenate(list(column)).astype(kind), sizes
    column = column.reshape(len(column), -1)
    return column.ravel().astype(kind), np.full(len(column), column.shape[1], np.int64)


def _check_length(element: dict[str, Any], length: int) -> None:
    if length != element["length"]:
        raise ValueError(f"{element['length']} rows are announced, but there are {length}")


def _note_ply(data: bytes, elements: dict[str, Any], losses: Losses) -> None:
    header = data[: data.find(b"end_header")]
    for texture in re.findall(rb"(?im)^\s*comment\s+texturefile\s+(.*?)\s*$", header):
        note_loss(losses, "texture", texture.decode("utf-8", "replace"))
    known = {
        "vertex": {"x", "y", "z", "nx", "ny", "nz", _ALPHA}.union(*_UV, *_COLORS),
        "face": {*_INDICES, *_WEDGES, _ALPHA}.union(*_COLORS),
    }
    for name, element in elements.items():
        if name in known:
            for other in element["properties"]:
                if other not in known[name]:
                    note_loss(losses, f"{name} property", other)
        elif element["length"]:
            note_loss(losses, "element", name)
