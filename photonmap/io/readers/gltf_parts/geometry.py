"""The triangles of glTF files, where their nodes put them, and their poses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.decoding import Note
from photonmap.io.readers.gltf_parts.document import Document
from photonmap.io.readers.gltf_parts.textures import UNMOVED, Placement
from photonmap.io.readers.meshes import Part, unit_rows

MODES = TRIANGLES, STRIP, FAN = 4, 5, 6  # Of primitives that are made of triangles
Place = Callable[[int], NDArray[np.float64]]
"""Returns the matrix of a node, from its coordinates to the scene's."""


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


@dataclass(frozen=True)
class Pose:
    """How the mesh of a node is changed before it is shown."""

    weights: Sequence[float]  # of morph targets
    # (J, 4, 4), from the mesh's coordinates at rest to the scene's; None without a skin, where the
    # node's matrix does that
    bones: NDArray[np.float64] | None


def find_pose(document: Document, node: Mapping[str, Any], place: Place) -> Pose:
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
    document: Document, part: Part, primitive: Mapping[str, Any], pose: Pose
) -> tuple[Part, bool]:
    """Return a primitive in a pose, and whether it is in the scene's coordinates."""
    part = _morphed(document, part, primitive, pose.weights)
    attributes = primitive["attributes"]
    if pose.bones is None or "JOINTS_0" not in attributes:
        return part, False
    blended = np.zeros((len(part.vertices), 4, 4))
    total = np.zeros(len(part.vertices))
    for index in range(len(attributes)):
        if f"JOINTS_{index}" not in attributes:
            break
        joints = document.rows(attributes[f"JOINTS_{index}"]).astype(np.int64)
        shares = document.rows(attributes[f"WEIGHTS_{index}"]).astype(np.float64)
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
    return replace(part, vertices=vertices, normals=normals, tangents=tangents), True


def _morphed(
    document: Document, part: Part, primitive: Mapping[str, Any], weights: Sequence[float]
) -> Part:
    """Add what morph targets add, times their weights."""
    vertices, normals, tangents = part.vertices, part.normals, part.tangents
    for target, weight in zip(primitive.get("targets", ()), weights, strict=False):
        if weight == 0.0:
            continue
        if "POSITION" in target:
            vertices = vertices + weight * document.rows(target["POSITION"])
        if "NORMAL" in target and normals is not None:
            normals = normals + weight * document.rows(target["NORMAL"])
        if "TANGENT" in target and tangents is not None:
            along = tangents[:, :3] + weight * document.rows(target["TANGENT"])
            tangents = np.column_stack([along, tangents[:, 3]])
    if normals is not None and normals is not part.normals:
        normals = unit_rows(normals)
    return replace(part, vertices=vertices, normals=normals, tangents=tangents)
