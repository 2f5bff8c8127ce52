"""Spheres that hold all specular surfaces, few and tight, for photons to be aimed at.

Arrays begin with the three coordinates: NumPy then reduces and accumulates over long rows.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.records import SceneArrays

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Boxes = tuple[Floats, Floats]

MOST = 48
"""Spheres at most."""
DEPTH = 8
"""Times that a group of triangles is parted in two, at most."""
COST = 0.01
"""What a further sphere must save, in areas of all."""
BINS = 64
"""Places along each axis where a group of triangles may be parted."""
MANY = 20_000
"""Triangles above which boxes of those that lie together stand for them."""
VOXELS = 64
"""Along each side of the grid by which they do."""
MARGIN = 1.0 + 1e-4
"""Factor on radii: rays start and end off surfaces by the rounding of their coordinates."""


def bound_specular_surfaces(arrays: SceneArrays) -> Floats:
    """Return the centres and radii of spheres around all specular triangles, (K, 4).

    Where there are none, of one around the scene.
    """
    geometry, specular = arrays.geometry, arrays.specular
    assert specular
    of_material = specular.probability > 0.0
    triangles = geometry.triangles[of_material[geometry.material]]
    if len(triangles) == 0:
        return np.array([(0.0, 0.0, 0.0, arrays.lights.radius)])
    corners = geometry.vertices.T.astype(np.float64)[:, triangles.T]
    spheres, halves = _build_tree(_simplify(corners))
    return spheres[_choose(spheres[:, 3] ** 2, halves)] * (1.0, 1.0, 1.0, MARGIN)


def _simplify(corners: Floats) -> Floats:
    """Return triangles, (3, 3, n), or where they are many, boxes around them, (3, 8, m)."""
    if corners.shape[2] <= MANY:
        return corners
    middles = corners.mean(axis=1)
    grid = middles - middles.min(axis=1, keepdims=True)
    grid /= max(float(grid.max()), 1e-30)
    voxels = [VOXELS**2, VOXELS, 1] @ (grid * (VOXELS - 1)).astype(np.int64)
    order = np.argsort(voxels, kind="stable")
    starts = np.flatnonzero(np.diff(voxels[order], prepend=-1))
    low = np.minimum.reduceat(corners.min(axis=1)[:, order], starts, axis=1)
    high = np.maximum.reduceat(corners.max(axis=1)[:, order], starts, axis=1)
    sides = np.array(list(itertools.product((False, True), repeat=3))).T
    return np.where(sides[..., None], high[:, None], low[:, None])


def _build_tree(corners: Floats) -> tuple[Floats, Integers]:
    """Part triangles in two, and these groups again, `DEPTH` times: all groups of a level at once.

    Returns the sphere around each group, (groups, 4), and the number of the first of the two groups
    that it was parted into, which the other follows; 0 where it was not parted.
    """
    group = np.zeros(corners.shape[2], np.int64)
    spheres, halves, count = [], [], 1
    for level in range(DEPTH + 1):
        starts = np.flatnonzero(np.diff(group, prepend=-1))
        boxes = corners.min(axis=1), corners.max(axis=1)
        spheres.append(_bound(corners, boxes, group, starts))
        before, is_parted = _part(corners.mean(axis=1), boxes, group, starts)
        is_parted &= level < DEPTH
        half = 2 * np.cumsum(is_parted) - 2
        halves.append(np.where(is_parted, count + half, 0))
        if not is_parted.any():
            break
        count += 2 * int(is_parted.sum())
        order = np.argsort(half[group] + ~before, kind="stable")
        order = order[is_parted[group[order]]]
        group, corners = (half[group] + ~before)[order], corners[..., order]
    return np.concatenate(spheres), np.concatenate(halves)


def _bound(corners: Floats, boxes: Boxes, group: Integers, starts: Integers) -> Floats:
    """Return the centres of boxes around groups, and how far corners are from them, (groups, 4)."""
    low = np.minimum.reduceat(boxes[0], starts, axis=1)
    centre = 0.5 * (low + np.maximum.reduceat(boxes[1], starts, axis=1))
    squares = ((corners - centre[:, None, group]) ** 2).sum(axis=0).max(axis=0)
    return np.column_stack((*centre, np.sqrt(np.maximum.reduceat(squares, starts))))


def _part(middles: Floats, boxes: Boxes, group: Integers, starts: Integers) -> tuple[Flags, Flags]:
    """Return which triangles lie before the best plane for each group, and which it can part."""
    low = np.minimum.reduceat(middles, starts, axis=1)
    span = np.maximum.reduceat(middles, starts, axis=1) - low
    scale = np.where(span > 0.0, span, 1.0)
    bins = ((middles - low[:, group]) / scale[:, group] * (BINS - 1)).astype(np.int64)
    planes = [_find_planes(boxes, group * BINS + row, len(starts)) for row in bins]
    lasts, costs = (np.array(rows) for rows in zip(*planes, strict=True))
    axis = np.where(span > 0.0, costs, np.inf).argmin(axis=0)
    last = lasts[axis, np.arange(len(starts))]
    return bins[axis[group], np.arange(len(group))] <= last[group], span.max(axis=0) > 0.0


def _find_planes(boxes: Boxes, cell: Integers, groups: int) -> tuple[Integers, Floats]:
    """Return the last bin before the best plane across an axis for each group, and its cost.

    By the surface area heuristic: squared radius, from the box of a part, times triangles in it.
    """
    order = np.argsort(cell, kind="stable")
    starts = np.flatnonzero(np.diff(cell[order], prepend=-1))
    used = cell[order[starts]]
    low, high = np.full((2, 3, groups * BINS), [[[np.inf]], [[-np.inf]]])
    low[:, used] = np.minimum.reduceat(boxes[0][:, order], starts, axis=1)
    high[:, used] = np.maximum.reduceat(boxes[1][:, order], starts, axis=1)
    counts = np.bincount(cell, minlength=groups * BINS)
    of_bins: list[NDArray[Any]] = [rows.reshape(-1, groups, BINS) for rows in (low, high, counts)]
    after = _costs(*(rows[..., ::-1] for rows in of_bins))[:, -2::-1]
    costs = _costs(*of_bins)[:, :-1] + after
    return costs.argmin(axis=1), costs.min(axis=1)


def _costs(low: Floats, high: Floats, counts: Integers) -> Floats:
    """Return the costs of the first bin, the first two, and so on, (groups, bins)."""
    sides = np.maximum.accumulate(high, axis=2) - np.minimum.accumulate(low, axis=2)
    with np.errstate(invalid="ignore"):  # 0 triangles × infinity: all lie in another bin
        return (sides**2).sum(axis=0) * np.cumsum(counts[0], axis=1)


def _choose(areas: Floats, halves: Integers) -> list[int]:
    """Choose the groups whose spheres hold all triangles with the least area, `MOST` at most.

    Finds the least area for one sphere, two, and so on, of each group, from those of its halves.
    """
    least, first_counts = {}, {}
    for group in range(len(areas) - 1, -1, -1):
        least[group], half = areas[group : group + 1], halves[group]
        if half:
            one, other = least[half], least[half + 1]
            sums = np.full((len(one), len(one) + len(other)), np.inf)
            sums[:, : len(other)] = one[:, None] + other
            # Row i moved by i columns: in each column, the same count of spheres.
            sums = sums.ravel()[: -len(one)].reshape(len(one), -1)[:, : MOST - 1]
            least[group] = np.append(least[group], sums.min(axis=0))
            first_counts[group] = sums.argmin(axis=0) + 1

    def choose(group: int, count: int) -> list[int]:
        if count == 1:
            return [group]
        half, first = halves[group], first_counts[group][count - 2]
        return choose(half, first) + choose(half + 1, count - first)

    counts = np.arange(1, len(least[0]) + 1)
    return choose(0, counts[np.argmin(least[0] * (1.0 + COST * counts))])
