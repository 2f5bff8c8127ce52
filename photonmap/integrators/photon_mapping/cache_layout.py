"""The cells of the radiosity cache: their layout and areas."""

import math

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.cache.exposed_fraction import measure_cells
from photonmap.kernels.core.passes import CacheCells
from photonmap.kernels.core.records import Geometry
from photonmap.runtime.storage import strips

FINER = 4
"""Cells along the side of one that is divided."""
NO_CLUTTER = np.zeros(0, np.bool_)
"""Of cells that are not looked up, or not measured yet."""
DIRECTIONS = 4
"""Small triangles share a cell only where their normals fall in the same of 4³ boxes."""


def lay_cells(
    geometry: Geometry, areas: NDArray[np.float64], area: float
) -> tuple[CacheCells, int]:
    """Tile both sides of all triangles with cells of about the given area.

    Larger triangles are divided into n² similar ones; smaller ones share a cell with neighbours
    whose centres lie in the same box of that size and whose normals point alike. So there are
    O(surface / area) cells, however many triangles.

    Returns
    -------
    cells : the layout
    count : the number of cells on both sides together
    """
    divisions = np.ceil(np.sqrt(areas / area)).astype(np.int32)
    np.maximum(divisions, 1, out=divisions)
    cell_area = areas / divisions.astype(np.float64) ** 2
    small = np.flatnonzero(divisions == 1)
    large = np.flatnonzero(divisions > 1)

    first = np.empty(len(areas), np.int64)
    group = _group_neighbours(geometry, small, np.sqrt(area))
    groups = int(group.max()) + 1 if len(small) else 0
    first[small] = group
    cell_area[small] = np.bincount(group, areas[small], groups)[group]
    ends = groups + np.cumsum(divisions[large].astype(np.int64) ** 2)
    first[large] = ends - divisions[large].astype(np.int64) ** 2
    one_side = int(ends[-1]) if len(large) else groups

    both = np.stack([first, first + one_side], axis=1).astype(np.int32)
    inverse = np.repeat((1.0 / cell_area).astype(np.float32)[:, None], 2, axis=1)
    whole = np.full(2 * one_side, -1, np.int32)
    return CacheCells(both, divisions, inverse, whole, NO_CLUTTER, 1), 2 * one_side


def divide_cells(cells: CacheCells, chosen: NDArray[np.bool_]) -> tuple[CacheCells, int]:
    """Divide some of the cells that `lay_cells` laid into `FINER`² each, or fewer if many.

    Of the chosen ones, (count,), those of single triangles are. What comes of them lies behind
    all others, and is no more than they are.

    Returns
    -------
    cells : the layout
    count : the number of cells, those that were divided among them
    """
    count = len(cells.parts)
    chosen = chosen.copy()
    chosen[cells.first[cells.divisions == 1]] = False
    number = int(np.count_nonzero(chosen))
    finer = min(FINER, math.isqrt(count // max(number, 1)))
    if number == 0 or finer == 1:
        return cells, count
    parts = np.full(count, -1, np.int32)
    parts[chosen] = count + finer**2 * np.arange(number)
    return cells._replace(parts=parts, finer=finer), count + finer**2 * number


def one_cell(triangles: int) -> CacheCells:
    """Lay one cell of area 1 over all triangles, for photons that are only counted."""
    first, inverse = np.zeros((triangles, 2), np.int32), np.ones((triangles, 2), np.float32)
    none = np.zeros(0, np.int32)
    return CacheCells(first, np.ones(triangles, np.int32), inverse, none, NO_CLUTTER, 1)


LEAST_FILL = 1 / 64
"""Part of a cell that is surface, at least, if light was found there."""


def measure_surface_fraction(
    geometry: Geometry, areas: NDArray[np.float64], cells: CacheCells, count: int
) -> NDArray[np.float32] | None:
    """Return which part of each cell is surface, (count, 1); None where all surfaces are opaque.

    What photons leave in a cell, over its area, is radiosity times that.
    """
    if not geometry.alpha:
        return None
    whole, there = np.zeros(count), np.zeros(count)
    measure_cells(geometry, geometry.alpha, cells, areas, whole, there)
    fill = np.divide(there, whole, out=np.ones(count), where=whole > 0.0)
    return np.maximum(fill, LEAST_FILL).astype(np.float32)[:, None]


def _group_neighbours(
    geometry: Geometry, small: NDArray[np.int64], size: float
) -> NDArray[np.int64]:
    """Give small triangles their cells: one for each box of space and of directions."""
    keys = np.zeros(len(small), np.int64)
    for part in strips(len(small)):
        some, key = small[part], keys[part]
        centres = geometry.vertices[geometry.triangles[some]].mean(axis=1, dtype=np.float64)
        boxes = np.clip(np.floor(centres / size), -(1 << 16), (1 << 16) - 1) + (1 << 16)
        turns = np.floor((geometry.normals[some] + 1.0) * (DIRECTIONS / 2.001))
        for column, span in ((boxes, 1 << 17), (turns, DIRECTIONS)):
            for axis in range(3):
                key *= span
                key += column[:, axis].astype(np.int64)
    return np.unique(keys, return_inverse=True)[1]
