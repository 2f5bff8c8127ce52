"""The pose of a mesh: morph targets with the weights that a file states, and skins on bones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.readers.gltf_parts.document import Document
from photonmap.io.readers.meshes import Part

Place = Callable[[int], NDArray[np.float64]]
"""Returns the matrix of a node, from its coordinates to the scene's."""


@dataclass(frozen=True)
class Pose:
    """How the mesh of a node is changed before it is shown.

    Parameters
    ----------
    weights : of morph targets
    bones : (J, 4, 4), from the mesh's coordinates at rest to the scene's; None without a skin,
        where the node's matrix does that
    """

    weights: Sequence[float]
    bones: NDArray[np.float64] | None


def find_pose(document: Document, node: Mapping[str, Any], place: Place) -> Pose:
    """Return the pose of a node's mesh, with its bones where the nodes are.

    Raises
    ------
    InputError, KeyError, ValueError : what it names is missing or of the wrong shape
    """
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
    """Return a primitive in a pose, and whether it is in the scene's coordinates.

    Raises
    ------
    InputError, KeyError, ValueError : what it names is missing or of the wrong shape
    """
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
        normals = _unit(np.einsum("vij,vj->vi", rows, normals))
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
        normals = _unit(normals)
    return replace(part, vertices=vertices, normals=normals, tangents=tangents)


def _unit(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.divide(rows, length, out=np.zeros_like(rows), where=length > 0.0)
