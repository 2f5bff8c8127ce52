"""Smooth normals of surfaces that come without any."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
Indices = NDArray[np.int64]


def vertex_normals(points: Matrix, sizes: Indices, vertices: Indices, count: int) -> Matrix:
    """Return means of the normals of polygons about each vertex, weighted by their angles there.

    G. Thürmer and C. Wüthrich, "Computing vertex normals from polygonal facets", 1998.

    Parameters
    ----------
    points : (C, 3), the corners of all polygons
    sizes : (F,), corners of each polygon, three or more
    vertices : (C,), the vertex of each corner, below `count`
    count : of vertices

    Returns
    -------
    (count, 3), of length 1; 0 where there is none
    """
    ends = np.cumsum(sizes)
    begins = ends - sizes
    following, previous = np.arange(1, len(points) + 1), np.arange(-1, len(points) - 1)
    following[ends - 1], previous[begins] = begins, ends - 1
    ahead, back = points[following] - points, points[previous] - points
    angles = np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), (ahead * back).sum(axis=1))
    from_first = points - np.repeat(points[begins], sizes, axis=0)
    normals = _unit(np.add.reduceat(np.cross(from_first, ahead), begins))
    weighted = angles[:, None] * np.repeat(normals, sizes, axis=0)
    return _unit(np.stack([np.bincount(vertices, each, count) for each in weighted.T], axis=1))


def _unit(rows: Matrix) -> Matrix:
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.divide(rows, length, out=np.zeros_like(rows), where=length > 0.0)
