"""Tangents of vertices: those that meshes have, and those that follow from texture coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core import records
from photonmap.scene.mesh import Mesh

Floats = NDArray[np.float64]


def given_tangents(meshes: Sequence[Mesh]) -> Floats:
    """Return the tangents that meshes have, (V, 4), of length 1 and with a sign; 0 for none."""
    rows = []
    for mesh in meshes:
        tangents, normals = mesh.unit_tangents, mesh.unit_normals
        if tangents is None or normals is None:
            rows.append(np.zeros((len(mesh.vertices), 4)))
        else:
            rows.append(np.where(normals.any(axis=1, keepdims=True), tangents, 0.0))
    return np.concatenate(rows)


def vertex_tangents(
    geometry: records.Geometry, chosen: NDArray[np.bool_], given: Floats
) -> NDArray[np.float32]:
    """Return directions at vertices in which u rises, (V, 4), unit or 0 where the mesh is flat.

    The last column is the sign of those that are given, and 0 of others. Each of these is the mean
    over the chosen triangles around it, weighted by their angles there, in the plane of the
    vertex's normal (as MikkTSpace: M. Mikkelsen, "Simulation of wrinkled surfaces revisited",
    2008).

    Parameters
    ----------
    geometry : all triangles
    chosen : (T,) which triangles count
    given : of `given_tangents`
    """
    tangents = np.zeros(geometry.vertices.shape)
    if len(geometry.shading_normals) and len(geometry.uv):
        tangents = _by_coordinates(geometry, chosen)
    is_given = given[:, 3:] != 0.0
    joined = np.where(is_given, given, np.pad(tangents, ((0, 0), (0, 1))))
    return joined.astype(np.float32)


def _by_coordinates(geometry: records.Geometry, chosen: NDArray[np.bool_]) -> Floats:
    """Return the tangents of vertices, (V, 3), that follow from texture coordinates."""
    tangents = np.zeros(geometry.vertices.shape)
    faces = geometry.triangles[chosen]
    corners = geometry.vertices[faces].astype(np.float64)
    by_u = _rising(corners, geometry.uv[faces].astype(np.float64))
    normals = geometry.shading_normals.astype(np.float64)
    for corner in range(3):
        vertex = faces[:, corner]
        normal = normals[vertex]
        along = _unit(by_u - (by_u * normal).sum(axis=1, keepdims=True) * normal)
        edges = [_unit(corners[:, (corner + k) % 3] - corners[:, corner]) for k in (1, 2)]
        angle = np.arccos(np.clip((edges[0] * edges[1]).sum(axis=1), -1.0, 1.0))
        np.add.at(tangents, vertex, along * angle[:, None])
    tangents[(normals == 0.0).all(axis=1)] = 0.0
    return _unit(tangents)


def _rising(corners: Floats, uv: Floats) -> Floats:
    """Return the direction in which u rises, (T, 3), of any length; 0 where there is none."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    along, across = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = along[:, 0] * across[:, 1] - across[:, 0] * along[:, 1]
    return (first * across[:, 1:] - second * along[:, 1:]) * np.sign(area)[:, None]


def _unit(vectors: Floats) -> Floats:
    """Return vectors of length 1, and 0 for 0."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 1e-30)
