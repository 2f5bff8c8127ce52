"""Read PLY files."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, naming
from photonmap.io.readers.decoding import Losses, decode_colors, decode_file, note_loss
from photonmap.io.readers.meshes import Part, build_mesh, check_indices, check_rows, cut_polygons
from photonmap.io.readers.ply_parts.elements import Element, read_elements
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
    if not data.startswith(b"ply"):
        raise InputError("is not a PLY file; name one that begins with 'ply'", path)
    elements, comments, rest = read_elements(data)
    _note_ply(elements, comments, losses)
    if rest:
        note_loss(losses, f"{rest} values behind the last element")
    none = Element(0)
    vertex, face = (elements.get(name, none) for name in ("vertex", "face"))
    if not (vertex.rows and face.rows):
        return Scene()
    part = _ply_part(path, vertex, face, losses)
    mesh = build_mesh(path, part, Material("default"), path.stem)
    if spare := len(part.vertices) - len(mesh.vertices):
        note_loss(losses, f"{spare} vertices in no face")
    return Scene([mesh], name=path.stem)


def _ply_part(path: Path, vertex: Element, face: Element, losses: Losses) -> Part:
    """Triangulate the faces; vertices are split where each corner has texture coordinates."""
    vertices, normals = _columns(vertex, tuple("xyz")), _columns(vertex, ("nx", "ny", "nz"))
    if vertices is None:
        raise ValueError("vertices lack x, y or z")
    uv = next((rows for pair in _UV if (rows := _columns(vertex, pair)) is not None), None)
    name = next((name for name in _INDICES if name in face.lists), None)
    if name is None:
        raise ValueError(f"faces lack {_INDICES[0]}")
    corners, sizes = face.lists[name][0].astype(np.int64), face.lists[name][1]
    if sizes.max() > LARGEST_FACE:
        row = int(np.argmax(sizes))
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
    if "texcoord" in face.lists:
        flat, lengths = face.lists["texcoord"]
        if not np.array_equal(lengths, 2 * sizes):
            raise ValueError("texcoord does not hold two numbers per corner")
        vertices, uv = vertices[corners], flat.astype(np.float64).reshape(-1, 2)
        normals = None if normals is None else normals[corners]
        if colors is not None and colors.ndim == 2:
            colors = colors[corners]
        corners = np.arange(len(corners))
    return cut_polygons(vertices, corners, sizes, losses, normals, uv, colors)


def _colors(element: Element, owners: str, losses: Losses) -> NDArray[np.float64] | None:
    """Return the colours of an element's rows, (n, 3), linear; None where it has none."""
    columns = element.columns
    found = next((names for names in _COLORS if set(names) <= set(columns)), None)
    if found is None:
        return None
    names = [*found, _ALPHA] if _ALPHA in columns else found
    rows = np.column_stack([columns[name] for name in names])
    return decode_colors(rows, partial(note_loss, losses), owners)


def _columns(element: Element, names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Return properties of an element as columns; None where one is missing."""
    if not set(names) <= set(element.columns):
        return None
    return np.column_stack([element.columns[name].astype(np.float64) for name in names])


def _note_ply(elements: dict[str, Element], comments: list[str], losses: Losses) -> None:
    for comment in comments:
        if found := re.match(r"(?i)\s*comment\s+texturefile\s+(.*?)\s*$", comment):
            note_loss(losses, "texture", found[1])
    known = {
        "vertex": {"x", "y", "z", "nx", "ny", "nz", _ALPHA}.union(*_UV, *_COLORS),
        "face": {*_INDICES, *_WEDGES, _ALPHA}.union(*_COLORS),
    }
    for name, element in elements.items():
        if name in known:
            for other in element.kinds:
                if other not in known[name]:
                    note_loss(losses, f"{name} property", other)
        elif element.rows:
            note_loss(losses, "element", name)
