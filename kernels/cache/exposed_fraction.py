"""Which fraction of a cell is exposed, and which is inside what stands on the surface."""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.cache.radiosity_cache import place_in
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.rng import draw, sobol_2d, stream
from photonmap.kernels.core.streams import EXPOSURE_COUNT, EXPOSURE_POINT, EXPOSURE_RAY, split
from photonmap.kernels.geometry.interaction import offset, point_at, side_of
from photonmap.kernels.geometry.opacity import intersect

POINTS = 8
"""Points of a cell from which rays look around."""
LOOKS = 8
"""Rays of a point, at most."""


@by_reference
class Exposure(NamedTuple):
    """Points that were tested, and those of them that are exposed, all uint8."""

    tested: np.ndarray
    """(cells,) of cells of single triangles"""
    exposed: np.ndarray
    tested_parts: np.ndarray
    """(T, 2) of triangles that share a cell with others"""
    exposed_parts: np.ndarray


class Piece(NamedTuple):
    """A part of one side of a triangle: one of n², and of it one of finer²."""

    triangle: int
    side: int
    n: int
    part: int
    finer: int
    sub: int


@jit
def _is_exposed(scene, lit_sides, piece, u, v, state):
    """Return whether a point on a side of a triangle sees anything that light reaches."""
    geometry = scene.geometry
    ng = vec.scale(vec.row(geometry.normals, piece.triangle), 1.0 - 2.0 * piece.side)
    point, size = point_at(geometry, piece.triangle, u, v)
    origin = offset(point, size, ng)
    for _ in range(LOOKS):
        s, state = draw(state)
        t, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(s, t), ng)
        other = intersect(geometry, origin, direction).triangle
        if other < 0 or specular_probability(geometry, scene.specular, other) > 0.0:
            return True
        if lit_sides[other, side_of(geometry, other, direction)]:
            return True
    return False


@jit
def _count_exposed(scene, lit_sides, piece, points, key):
    """Return how many of some points of a piece are exposed."""
    count = 0
    key = stream(key, piece.part, piece.sub)
    point_key, ray_key = split(key, EXPOSURE_POINT), split(key, EXPOSURE_RAY)
    for index in range(points):
        position = sobol_2d(index, point_key)
        u, v = warp.uniform_triangle(position[0], position[1])
        u, v = place_in(piece.finer, piece.sub, u, v)
        u, v = place_in(piece.n, piece.part, u, v)
        count += _is_exposed(scene, lit_sides, piece, u, v, stream(ray_key, index, 0))
    return count


@jit
def _probe_whole(scene, lit_sides, cells, area, piece, key, exposure):
    """Count the exposed points of a triangle that shares a cell with others."""
    triangle, side = piece.triangle, piece.side
    xi, _ = draw(split(key, EXPOSURE_COUNT))
    points = int(POINTS * area * cells.inverse_area[triangle, side] + xi)
    exposure.tested_parts[triangle, side] = points
    count = _count_exposed(scene, lit_sides, piece, points, key)
    exposure.exposed_parts[triangle, side] = count


@jit
def _probe_divided(scene, lit_sides, cells, triangle, side, key, exposure):
    """Count the exposed points of the cells into which a triangle's side is divided.

    In a layout with divided cells, only the parts of divided cells are measured.
    """
    divided, n = cells.finer > 1, cells.divisions[triangle]
    for part in range(n * n):
        whole = cells.first[triangle, side] + part
        if divided and cells.parts[whole] < 0:
            continue
        for sub in range(cells.finer * cells.finer):
            cell = cells.parts[whole] + sub if divided else whole
            piece = Piece(triangle, side, n, part, cells.finer, sub)
            exposure.tested[cell] = POINTS
            exposure.exposed[cell] = _count_exposed(scene, lit_sides, piece, POINTS, key)


@kernel
def probe_exposure(scene, lit_sides, areas, cells, key, span, exposure):
    """Count the exposed points of the cells of a span of triangles, as many in each cell.

    `lit_sides`, (T, 2), says of the sides of triangles whether light reaches them; `areas` are
    theirs.
    """
    for triangle in range(span.first, span.last):
        for side in range(2):
            if not lit_sides[triangle, side]:
                continue
            own = stream(key, triangle, side)
            if cells.divisions[triangle] > 1:
                _probe_divided(scene, lit_sides, cells, triangle, side, own, exposure)
            elif cells.finer == 1:
                piece = Piece(triangle, side, np.int32(1), 0, 1, 0)
                area = areas[triangle]
                _probe_whole(scene, lit_sides, cells, area, piece, own, exposure)
