"""The irradiance store: light that leaves a surface diffusely, kept in cells of the surface.

Each side of each triangle is tiled by cells: a large triangle is divided into n² similar ones,
small neighbours of like orientation share one. Photons add the flux they reflect to their cell,
so the store holds radiosity, it conserves energy exactly, knows no edge bias, and answers in
O(1). Cells shrink from pass to pass.
"""

from photonmap.kernels.jit import jit, kernel

NEAR = 1.0
"""Distance, in widths of a cell, within which it is not looked up."""


@jit
def cell_at(cells, triangle, side, u, v):
    """Return the cell of barycentrics (u, v) on one side of a triangle."""
    n = cells.divisions[triangle]
    first = cells.first[triangle, side]
    if n == 1:
        return first
    # Strip i holds 2 (n - i) - 1 cells, upright ones at even places and inverted ones between.
    x, y = u * n, v * n
    i = min(int(x), n - 1)
    j = min(int(y), n - 1 - i)
    inverted = j < n - 1 - i and (x - i) + (y - j) > 1.0
    return first + i * (2 * n - i) + 2 * j + inverted


@jit
def answers(cells, triangle, side, distance):
    """Tell whether a cell is small against its distance from where it is looked up.

    A nearer cell would show: it is flat and may reach under what stands on the surface. An empty
    store never answers.
    """
    if cells.divisions.shape[0] == 0:
        return False
    return distance * distance * cells.inverse_area[triangle, side] > NEAR * NEAR


@kernel
def join(bundles, first, last, radiosity):
    """Add the bundles' cells first..last in order: (bundles, cells, N) into (cells, N)."""
    for cell in range(first, last):
        for band in range(radiosity.shape[1]):
            total = bundles[0, cell, band]
            for bundle in range(1, bundles.shape[0]):
                total += bundles[bundle, cell, band]
            radiosity[cell, band] = total
