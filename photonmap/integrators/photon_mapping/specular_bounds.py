"""Spheres that hold all specular surfaces, few and tight, for photons to be aimed at."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.records import SceneArrays

Floats = NDArray[np.float64]

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
    corners = geometry.vertices[geometry.triangles[of_material[geometry.material]]]
    if len(corners) == 0:
        return np.array([(0.0, 0.0, 0.0, arrays.lights.radius)])
    coverings = _coverings(_simplify(corners.astype(np.float64)), DEPTH)
    _, best = min(coverings, key=lambda covering: covering[0] * (1.0 + COST * len(covering[1])))
    return np.array(best) * (1.0, 1.0, 1.0, MARGIN)


def _simplify(corners: Floats) -> Floats:
    """Return triangles, (n, 3, 3), or where they are many, boxes around them, (m, 8, 3)."""
    if len(corners) <= MANY:
        return corners
    middles = corners.mean(axis=1)
    grid = (middles - middles.min(axis=0)) / max(float(np.ptp(middles, axis=0).max()), 1e-30)
    voxels = (grid * (VOXELS - 1)).astype(np.int64) @ [VOXELS**2, VOXELS, 1]
    order = np.argsort(voxels, kind="stable")
    _, first = np.unique(voxels[order], return_index=True)
    low = np.minimum.reduceat(corners.min(axis=1)[order], first)
    high = np.maximum.reduceat(corners.max(axis=1)[order], first)
    sides = np.array(list(itertools.product((False, True), repeat=3)))
    return np.where(sides, high[:, None], low[:, None])


def _coverings(corners: Floats, depth: int) -> list[tuple[float, list[Floats]]]:
    """Return the spheres of least area around triangles, and the sum of their squared radii.

    For one sphere, two, and so on, as far as parting the triangles `depth` times gives them.
    """
    sphere = _sphere(corners)
    parts = _part(corners) if depth else []
    halves = [_coverings(part, depth - 1) for part in parts]
    best = {1: (float(sphere[3] ** 2), [sphere])}
    for (area, spheres), (other_area, others) in itertools.product(*halves) if halves else ():
        count, total = len(spheres) + len(others), area + other_area
        if count <= MOST and (count not in best or total < best[count][0]):
            best[count] = (total, spheres + others)
    return list(best.values())


def _sphere(corners: Floats) -> Floats:
    """Return the centre of a box around triangles, and how far their corners are from it."""
    points = corners.reshape(-1, 3)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.append(centre, np.sqrt(((points - centre) ** 2).sum(axis=1).max()))


def _part(corners: Floats) -> list[Floats]:
    """Part triangles in two by the best plane across an axis; nothing where all lie together."""
    middles = corners.mean(axis=1)
    planes = []
    for axis in range(3):
        position = middles[:, axis]
        span = np.ptp(position)
        if span > 0.0:
            bins = ((position - position.min()) / span * (BINS - 1)).astype(np.uint8)
            plane, cost = _best_plane(corners, bins)
            planes.append((cost, bins < plane))
    if not planes:
        return []
    _, before = min(planes, key=lambda plane: plane[0])
    return [corners[before], corners[~before]]


def _best_plane(corners: Floats, bins: NDArray[np.uint8]) -> tuple[int, float]:
    """Return the bin before which triangles are best parted, and what they cost then.

    By the surface area heuristic: squared radius, from the box of a part, times triangles in it.
    """
    order = np.argsort(bins, kind="stable")
    used, first, counts = np.unique(bins[order], return_index=True, return_counts=True)
    low = np.minimum.reduceat(corners.min(axis=1)[order], first)
    high = np.maximum.reduceat(corners.max(axis=1)[order], first)
    after = _costs(low[::-1], high[::-1], counts[::-1])[::-1]
    costs = _costs(low, high, counts)[:-1] + after[1:]
    best = int(np.argmin(costs))
    return int(used[best + 1]), float(costs[best])


def _costs(low: Floats, high: Floats, counts: NDArray[np.int64]) -> Floats:
    """Return the costs of the first bin, the first two, and so on."""
    sides = np.maximum.accumulate(high) - np.minimum.accumulate(low)
    return (sides**2).sum(axis=1) * np.cumsum(counts)
