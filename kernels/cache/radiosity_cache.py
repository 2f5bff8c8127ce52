"""The radiosity cache: diffusely reflected light, kept in cells of the surface.

Each side of each triangle is tiled by cells: a large triangle is divided into n² similar ones,
and those again that reach under what stands on it; small neighbours of like orientation share
one. Photons add the flux that they reflect to their cell. So the cache holds radiosity, conserves
energy exactly, has no edge bias, and answers in O(1). Cells shrink from pass to pass.
"""

import math

import numpy as np

from photonmap.kernels.core.jit import jit, kernel

NEAR = 1.0  # Distance, in widths of a cell, below which the cell is not looked up


@jit
def _part_at(n, u, v):
    """Return which of the n² parts of a triangle holds (u, v), and the barycentrics in it."""
    # Strip i holds 2 (n - i) - 1 parts, upright ones at even places and inverted ones between.
    x, y = u * n, v * n
    i = min(int(x), n - 1)
    j = min(int(y), n - 1 - i)
    x, y = x - i, y - j
    if j < n - 1 - i and x + y > 1.0:
        return i * (2 * n - i) + 2 * j + 1, 1.0 - x, 1.0 - y
    return i * (2 * n - i) + 2 * j, x, y


@jit
def place_in(n, part, u, v):
    """Return the barycentrics of a triangle that are (u, v) in one of its n² parts."""
    i = n - math.ceil(math.sqrt(n * n - part))
    offset = part - i * (2 * n - i)
    if offset % 2 == 1:
        u, v = 1.0 - u, 1.0 - v
    return (i + u) / n, (offset // 2 + v) / n


@jit
def cell_at(cells, triangle, side, u, v):
    """Return the cell of barycentrics (u, v) on one side of a triangle."""
    n = cells.divisions[triangle]
    cell = np.int64(cells.first[triangle, side])
    if n == 1:
        return cell
    part, u, v = _part_at(n, u, v)
    cell += part
    if cells.parts[cell] < 0:
        return cell
    return cells.parts[cell] + _part_at(cells.finer, u, v)[0]


@jit
def width_of(inverse_area):
    """Return the distance below which a cell of an area is not looked up."""
    return NEAR / math.sqrt(inverse_area)


@jit
def can_look_up(cells, surface):
    """Return whether a cell is small against its distance from where it is looked up.

    A nearer cell would show: it is flat, and may reach under what stands on the surface. A cache
    without cells never answers.
    """
    if cells.divisions.shape[0] == 0:
        return False
    hit = surface.hit
    inverse_area = cells.inverse_area[hit.triangle, surface.side]
    return hit.distance * hit.distance * inverse_area > NEAR * NEAR


@kernel
def sum_bundles(bundles, first, last, radiosity):
    """Sum the bundles' cells first..last in order: (bundles, cells, N) into (cells, N)."""
    for cell in range(first, last):
        for band in range(radiosity.shape[1]):
            total = bundles[0, cell, band]
            for bundle in range(1, bundles.shape[0]):
                total += bundles[bundle, cell, band]
            radiosity[cell, band] = total
