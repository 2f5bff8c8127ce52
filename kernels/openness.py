"""Which part of a cell lies open, and which is inside of what stands on the surface."""

from photonmap.kernels import vec, warp
from photonmap.kernels.beyond import smoothness
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.opaque import hit
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.store import cell_at
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
        if reached[geometry.material[other], side_of(geometry, other, direction)]:
            return True
    return False


@kernel
def probe_cells(
    geometry, optics, reached, areas, cells, key, first, last, tested, found, few_tested, few_found
):
    """Look from points on triangles first..last, as many in each cell; count those in the open.

    `reached`, (M, 2), tells of the sides of materials whether light comes there; `areas` are of
    triangles. Cells of a single triangle count in `tested` and `found`, (cells,), the parts of
    others in `few_tested` and `few_found`, (T, 2), all of them uint8.
    """
    for triangle in range(first, last):
        single = cells.divisions[triangle] > 1
        for side in range(2):
            if not reached[geometry.material[triangle], side]:
                continue
            chance, _ = draw(stream(key, triangle, side))
            points = int(POINTS * areas[triangle] * cells.inverse_area[triangle, side] + chance)
            place_key, look_key = stream(key, triangle, 2 + side), stream(key, triangle, 4 + side)
            for index in range(points):
                place = sobol_2d(index, place_key)
                u, v = warp.uniform_triangle(place[0], place[1])
                state = stream(look_key, 0, index)
                lies_open = _is_open(geometry, optics, reached, triangle, side, u, v, state)
                if single:
                    cell = cell_at(cells, triangle, side, u, v)
                    tested[cell] += 1
                    found[cell] += lies_open
                else:
                    few_tested[triangle, side] += 1
                    few_found[triangle, side] += lies_open
