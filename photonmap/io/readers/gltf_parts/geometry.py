"""The triangles of glTF files, and where their nodes put them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.decoding import Note
from photonmap.io.readers.gltf_parts.document import Document
from photonmap.io.readers.gltf_parts.textures import UNMOVED, Placement
from photonmap.io.readers.meshes import Part

MODES = TRIANGLES, STRIP, FAN = 4, 5, 6
"""Of primitives that are made of triangles."""


def read_primitive(
    document: Document,
    primitive: Mapping[str, Any],
    placement: Placement = UNMOVED,
    lose: Note = lambda what: None,
) -> Part:
    """Return the triangles of a primitive; v increases upwards, as in OBJ.

    Parameters
    ----------
    placement : of textures on it
    lose : takes what is left out

    Raises
    ------
    InputError, KeyError, ValueError : what it names is missing or of the wrong shape
    """
    attributes = primitive["attributes"]
    columns_of = {"POSITION": 3, "NORMAL": 3, f"TEXCOORD_{placement.coordinates}": 2}
    count = document.item("accessors", attributes["POSITION"])["count"]
    vertices, normals, uv = (
        np.array(_rows(document, attributes[name], (count, columns), name), np.float64)
        if name in attributes
        else None
        for name, columns in columns_of.items()
    )
    assert vertices is not None
    if uv is not None:
        uv[:, 1] = 1.0 - uv[:, 1]
        uv = placement.turn(uv)
    colors = None
    if "COLOR_0" in attributes:
        colors = _read_colors(document, attributes["COLOR_0"], count)
    if "indices" in primitive:
        corners = document.rows(primitive["indices"])[:, 0].astype(np.int64)
    else:
        corners = np.arange(count)
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES and (more := len(corners) % 3):
        corners = corners[:-more]
        lose("corners of incomplete triangles")
    faces = _triangles(corners, mode)
    tangents = None
    if "TANGENT" in attributes and normals is not None:
        tangents = document.rows(attributes["TANGENT"]).astype(np.float64)
        if tangents.shape != (count, 4):
            lose("tangents of another shape than (x, y, z, w)")
            tangents = None
    return Part(vertices, faces, normals, uv, colors, tangents)


def _read_colors(document: Document, accessor: int, count: int) -> NDArray[np.float64]:
    """Return linear RGBA of vertices, (V, 4), in [0, 1]."""
    colors = document.rows(accessor)
    if colors.shape not in ((count, 3), (count, 4)):
        raise ValueError("COLOR_0 has the wrong shape")
    rgba = np.ones((count, 4))
    rgba[:, : colors.shape[1]] = np.clip(colors, 0.0, 1.0)
    return rgba


def _rows(document: Document, accessor: int, shape: tuple[int, int], name: str) -> NDArray[Any]:
    rows = document.rows(accessor)
    if rows.shape != shape:
        raise ValueError(f"{name} has the wrong shape")
    return rows


def _triangles(corners: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    """Return (F, 3) corners of the triangles of a list, a strip or a fan."""
    if mode == TRIANGLES:
        return corners.reshape(-1, 3)
    first = np.arange(max(len(corners) - 2, 0))
    if mode == STRIP:
        odd = first % 2
        return corners[np.stack([first, first + 1 + odd, first + 2 - odd], axis=1)]
    return corners[np.stack([first + 1, first + 2, np.zeros_like(first)], axis=1)]


def place_nodes(document: Document, roots: list[int]) -> dict[int, NDArray[np.float64]]:
    """Return the matrix of each node below the roots, 4×4, from its coordinates to the scene's.

    Parameters
    ----------
    roots : nodes of a forest
    """
    placed = {}
    below = [(root, np.eye(4)) for root in roots]
    while below:
        index, above = below.pop()
        node = document.item("nodes", index)
        placed[index] = above @ _matrix(node)
        below += [(child, placed[index]) for child in node.get("children", ())]
    return placed


def _matrix(node: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return the matrix of a node, or the product of its translation, rotation and scale."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(node.get("rotation", (0.0, 0.0, 0.0, 1.0))) * np.array(
        node.get("scale", (1.0, 1.0, 1.0)), np.float64
    )
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix


def _rotation(quaternion: Any) -> NDArray[np.float64]:
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
