"""Triangulate polygons, concave ones too."""

from __future__ import annotations

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

LARGEST_FACE = 1 << 15
"""Most corners of a polygon: ear clipping takes time with the square of their number."""

_CHUNK = 1 << 18
"""Corners triangulated at a time, to bound the memory of temporary arrays."""
_ROUNDING = 8 * np.finfo(np.float64).eps


def triangulate(
    points: NDArray[np.float64], polygons: NDArray[np.int32], sizes: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut polygons into triangles of the same winding.

    A polygon that is star-shaped from its first or second corner (each convex one is) becomes
    a fan, any other is cut by ear clipping in the plane of its Newell normal. Triangles
    thinner than the rounding of their coordinates are left out.

    Parameters
    ----------
    points : (V, 3) float64
    polygons : (C,) int, the corners of all polygons as indices into `points`
    sizes : (F,) int, corners of each polygon, three or more

    Returns
    -------
    triangles : (T, 3) int64, indices into `polygons`
    owners : (T,) int64, the polygon of each triangle, ascending
    """
    if (sizes == 3).all():
        owners = np.flatnonzero(_find_solid(points, polygons.reshape(-1, 3)))
        return 3 * owners[:, None] + np.arange(3), owners
    begins = np.cumsum(sizes) - sizes
    order = np.argsort(sizes, kind="stable")
    parts = []
    for group in np.split(order, np.flatnonzero(np.diff(sizes[order])) + 1):
        step = _CHUNK // int(sizes[group[0]])
        for chunk in (group[i : i + step] for i in range(0, len(group), step)):
            corners = begins[chunk, None] + np.arange(sizes[chunk[0]])
            local, solid = _cut(points[polygons[corners]])
            triangles = (local + begins[chunk, None, None])[solid]
            owners = np.broadcast_to(chunk[:, None], solid.shape)[solid]
            parts.append((triangles, owners))
    triangles, owners = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.argsort(owners, kind="stable")
    return triangles[order], owners[order]


def _find_solid(points: NDArray[np.float64], triangles: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return which triangles, (F, 3), have an area."""
    step, local = _CHUNK // 3, np.arange(3)[None, None]
    solid = [
        np.linalg.norm(crosses, axis=2)[:, 0] > limits[:, 0]
        for chunk in (triangles[i : i + step] for i in range(0, len(triangles), step))
        for crosses, limits in [_crosses(points[chunk], np.tile(local, (len(chunk), 1, 1)))]
    ]
    return np.concatenate(solid)


def _cut(corners: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Cut R polygons of n corners each.

    Parameters
    ----------
    corners : (R, n, 3)

    Returns
    -------
    local : (R, n - 2, 3) int64, triangles as indices of corners
    solid : (R, n - 2), whether a triangle has an area
    """
    rows, size = corners.shape[:2]
    fans = np.stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)], 1)
    local = np.tile(fans, (rows, 1, 1))
    crosses, limits = _crosses(corners, local)
    if size == 3:
        return local, np.linalg.norm(crosses, axis=2) > limits
    newell = crosses.sum(1, keepdims=True)
    newell /= np.maximum(np.linalg.norm(newell, axis=2, keepdims=True), np.finfo(float).tiny)
    heights = (crosses * newell).sum(2)
    solid = heights > limits
    doubtful = np.flatnonzero(~solid.all(1))
    if not len(doubtful):
        return local, solid
    second = (local[doubtful] + 1) % size
    crosses, others = _crosses(corners[doubtful], second)
    whole = ((crosses * newell[doubtful]).sum(2) > others).all(1)
    local[doubtful[whole]] = second[whole]
    for row in doubtful[~whole & (heights[doubtful] < -limits[doubtful]).any(1)]:
        local[row] = _clip_ears(corners[row], newell[row, 0])
    crosses, others = _crosses(corners[doubtful], local[doubtful])
    solid[doubtful] = np.linalg.norm(crosses, axis=2) > others
    return local, solid


def _crosses(
    corners: NDArray[np.float64], local: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return twice the vector area of each triangle, and how much of it may be rounding error."""
    a, b, c = (np.take_along_axis(corners, local[..., i, None], 1) for i in range(3))
    ab, ac = b - a, c - a
    longest = np.sqrt(np.maximum((ab**2).sum(2), (ac**2).sum(2)))
    reach = np.abs(corners).max((1, 2))
    return np.cross(ab, ac), _ROUNDING * reach[:, None] * longest


def _clip_ears(corners: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut one polygon, (n, 3), in the coordinate plane its normal faces most."""
    axis = int(np.argmax(np.abs(normal)))
    flat = np.ascontiguousarray((corners - corners[0])[:, [(axis + 1) % 3, (axis + 2) % 3]])
    rings = np.array([len(flat)], np.uint32)
    ears = mapbox_earcut.triangulate_float64(flat, rings).reshape(-1, 3).astype(np.int64)
    crosses, _ = _crosses(corners[None], ears[None])
    turned = crosses[0] @ normal < 0
    ears[turned] = ears[turned, ::-1]
    triangles = np.zeros((len(corners) - 2, 3), np.int64)
    triangles[: len(ears)] = ears
    return triangles
