"""Which part of a cell lies open, and which is inside of what stands on the surface."""

from photonmap.kernels import vec, warp
from photonmap.kernels.beyond import smoothness
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.opaque import hit
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.store import place_in
from photonmap.kernels.surface import offset, point_at, side_of

POINTS = 8
"""Looked from in a cell."""
LOOKS = 8
"""At most, from a point."""


@jit
def _is_open(geometry, optics, reached, triangle, side, u, v, state):
    """Tell whether a point on a side of a triangle sees anything that light reaches."""
    ng = vec.scale(vec.row(geometry.normals, triangle), 1.0 - 2.0 * side)
    point, size = point_at(geometry, triangle, u, v)
    origin = offset(point, size, ng)
    for _ in range(LOOKS):
        s, state = draw(state)
        t, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(s, t), ng)
        other, _, _, _ = hit(geometry, origin, direction)
        if other < 0 or smoothness(geometry, optics, other) > 0.0:
            return True
        if reached[other, side_of(geometry, other, direction)]:
            return True
    return False


@jit
def _count_open(geometry, optics, reached, triangle, side, cell, points, keys):
    """Return how many of some points in a cell lie open.

    cell = (n, part, finer, sub): part of n² of the triangle, and sub of the finer² of that.
    """
    n, part, finer, sub = cell
    count = 0
    for index in range(points):
        place = sobol_2d(index, keys[0])
        u, v = warp.uniform_triangle(place[0], place[1])
        u, v = place_in(finer, sub, u, v)
        u, v = place_in(n, part, u, v)
        state = stream(keys[1], 0, index)
        count += _is_open(geometry, optics, reached, triangle, side, u, v, state)
    return count


@kernel
def probe_cells(
    geometry, optics, reached, areas, cells, key, first, last, tested, found, few_tested, few_found
):
    """Look from points on triangles first..last, as many in each cell; count those in the open.

    `reached`, (T, 2), tells of the sides of triangles whether light comes there; `areas` are
    theirs. Cells of a single triangle count in `tested` and `found`, (cells,), the parts of others
    in `few_tested` and `few_found`, (T, 2), all of them uint8. In a layout with divided cells,
    only what came of these is looked at.
    """
    divided = cells.finer > 1
    for triangle in range(first, last):
        n = cells.divisions[triangle]
        for side in range(2):
            if not reached[triangle, side] or (divided and n == 1):
                continue
            keys = (stream(key, triangle, side), stream(key, triangle, 2 + side))
            if n == 1:
                chance, _ = draw(stream(key, triangle, 4 + side))
                points = int(POINTS * areas[triangle] * cells.inverse_area[triangle, side] + chance)
                few_tested[triangle, side] = points
                few_found[triangle, side] = _count_open(
                    geometry, optics, reached, triangle, side, (1, 0, 1, 0), points, keys
                )
                continue
            for part in range(n * n):
                whole = cells.first[triangle, side] + part
                if divided and cells.parts[whole] < 0:
                    continue
                for sub in range(cells.finer * cells.finer):
                    cell = cells.parts[whole] + sub if divided else whole
                    own = (stream(keys[0], sub, part), stream(keys[1], sub, part))
                    tested[cell] = POINTS
                    found[cell] = _count_open(
                        geometry, optics, reached, triangle, side, (n, part, cells.finer, sub),
                        POINTS, own,
                    )  # fmt: skip
