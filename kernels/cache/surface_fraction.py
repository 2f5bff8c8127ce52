"""Which part of a cell is surface, where surfaces have holes."""

from photonmap.kernels.cache.radiosity_cache import cell_at, place_in
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.geometry.opacity import opacity_at

FINE = 8
"""Looks at a textured opacity along the side of a cell."""


@kernel
def measure_cells(geometry, alpha, cells, areas, whole, there):
    """Add to `whole` and `there`, both (cells,), the area of each cell, and that of its surface."""
    for triangle in range(len(areas)):
        textured = alpha.image[geometry.material[triangle]] >= 0
        n = cells.divisions[triangle]
        for part in range(n * n):
            finer = 1
            for side in range(2):
                if n > 1 and cells.parts[cells.first[triangle, side] + part] >= 0:
                    finer = cells.finer
            steps = finer * (FINE if textured else 2)
            weight = areas[triangle] / (n * n * (steps * (steps + 1) // 2))
            for i in range(steps):
                for j in range(steps - i):
                    u, v = place_in(n, part, (i + 0.4) / steps, (j + 0.4) / steps)
                    opacity = opacity_at(geometry, triangle, u, v)
                    for side in range(2):
                        cell = cell_at(cells, triangle, side, u, v)
                        whole[cell] += weight
                        there[cell] += weight * opacity
