"""Relief as kernels take it: images of directions or slopes, and the tangents of vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.textures import TextureTable
from photonmap.kernels.core import records
from photonmap.scene.material import Material

Floats = NDArray[np.float64]


def compile_relief(
    geometry: records.Geometry, materials: list[Material], table: TextureTable, size: float
) -> records.Relief | None:
    """Return what turns shading normals; None where nothing does.

    Parameters
    ----------
    geometry : with materials and texture coordinates
    materials : (M,)
    table : of their textures
    size : scene units in a unit of the kernels' length
    """
    if (table.relief < 0).all():
        return None
    reliefs = [material.relief for material in materials]
    is_height = np.array([relief is not None and relief.is_height for relief in reliefs])
    factor = np.array([0.0 if relief is None else relief.factor for relief in reliefs])
    by_directions = (table.relief >= 0) & ~is_height
    return records.Relief(
        table.maps,
        table.relief,
        is_height.astype(np.uint8),
        np.where(is_height, factor / size, factor),
        vertex_tangents(geometry, by_directions[geometry.material]),
    )


def vertex_tangents(geometry: records.Geometry, chosen: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return directions at vertices in which u rises, (V, 3), unit or 0 where the mesh is flat.

    Each is the mean over the chosen triangles around it, weighted by their angles there, in the
    plane of the vertex's normal (as MikkTSpace: M. Mikkelsen, "Simulation of wrinkled surfaces
    revisited", 2008).

    Parameters
    ----------
    geometry : all triangles
    chosen : (T,) which triangles count
    """
    tangents = np.zeros(geometry.vertices.shape)
    if not len(geometry.shading_normals):
        return tangents.astype(np.float32)
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
    return _unit(tangents).astype(np.float32)


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
