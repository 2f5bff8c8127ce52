"""What a cell of the radiosity cache is like.

Which fraction of it is exposed, and not inside what stands on the surface; whether things stand
near, and whether it sees an emitter; and which part of it is surface, where surfaces have holes.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.cache.radiosity_cache import cell_at, place_in, width_of
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.rng import draw, sobol_2d, stream
from photonmap.kernels.core.streams import EXPOSURE_COUNT, EXPOSURE_POINT, EXPOSURE_RAY, split
from photonmap.kernels.geometry.interaction import offset, point_at, side_of
from photonmap.kernels.geometry.opacity import intersect, occluded, opacity_at

LOOKS = 8  # Rays of a point, at most; one looks afar
HIDDEN = 4  # Points of a cell after which none are tested if none is exposed
COUNTS = 5
TESTED, EXPOSED, NEAR, EMITTER, BESIDE = range(COUNTS)
"""What is counted: points that were tested, those of them that are exposed, those whose first ray
or its mirror image meets something within the cell's width, and those whose first ray meets an
emitter, at any distance and beside the cell"""
WIDTHS_BESIDE = 4.0  # Distance, in widths of a cell, within which an emitter is beside it


@by_reference
class Exposure(NamedTuple):
    """Counts of points, uint8, in columns `TESTED` to `BESIDE`."""

    cells: np.ndarray  # (cells, COUNTS) of cells of single triangles
    parts: np.ndarray  # (T, 2, COUNTS) of triangles that share a cell with others


@by_reference
class Question(NamedTuple):
    """What is asked of which cells."""

    lit_sides: np.ndarray  # (T, 2), whether light reaches the sides of triangles
    points: np.ndarray  # (cells,) uint8, how many points of a cell are tested
    afar: bool  # whether points count as far as they are seen from farther than a cell is wide


class Piece(NamedTuple):
    """A part of one side of a triangle: one of n², and of it one of finer²."""

    triangle: int
    side: int
    n: int
    part: int
    finer: int
    sub: int


@jit
def _is_lit(scene, lit_sides, hit, direction):
    """Return whether light reaches what a ray meets, if anything."""
    other = hit.triangle
    if other < 0 or specular_probability(scene, other) > 0.0:
        return True
    return lit_sides[other, side_of(scene.geometry, other, direction)]


@jit
def _stops_near(scene, hit, width):
    """Return whether a ray ends within a width: specular surfaces send it on, and show its start.

    What is seen via them is looked up, however near to a cell they stand.
    """
    return (
        hit.triangle >= 0
        and hit.distance < width
        and specular_probability(scene, hit.triangle) == 0.0
    )


@jit
def is_hidden(scene, origin, direction, width):
    """Return whether a ray from a point of a cell ends within the cell's width."""
    if scene.specular is None:
        return occluded(scene.geometry, origin, direction, width)
    return _stops_near(scene, intersect(scene.geometry, origin, direction), width)


@jit
def _look_around(scene, question, piece, place, width, state, counts):
    """Count a point on a side of a triangle: it is exposed if it sees what light reaches."""
    geometry = scene.geometry
    ng = vec.scale(vec.row(geometry.normals, piece.triangle), 1.0 - 2.0 * piece.side)
    point, size = point_at(geometry, piece.triangle, place[0], place[1])
    origin = offset(point, size, ng)
    counts[TESTED] += 1
    for look in range(LOOKS):
        s, state = draw(state)
        t, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(s, t), ng)
        hit = intersect(geometry, origin, direction)
        if look == 0:
            is_emitter = hit.triangle >= 0 and geometry.emitter[hit.triangle] >= 0
            counts[EMITTER] += is_emitter
            counts[BESIDE] += is_emitter and hit.distance < WIDTHS_BESIDE * width
            mirrored = vec.sub(vec.scale(ng, 2.0 * vec.dot(direction, ng)), direction)
            near = _stops_near(scene, hit, width)
            counts[NEAR] += near or is_hidden(scene, origin, mirrored, width)
        if _is_lit(scene, question.lit_sides, hit, direction):
            counts[EXPOSED] += 1
            return


@jit
def _look_afar(scene, question, piece, place, width, state, counts):
    """Count a point on a side of a triangle: exposed if one ray meets what is lit, but far."""
    geometry = scene.geometry
    ng = vec.scale(vec.row(geometry.normals, piece.triangle), 1.0 - 2.0 * piece.side)
    point, size = point_at(geometry, piece.triangle, place[0], place[1])
    s, state = draw(state)
    t, _ = draw(state)
    direction = vec.from_frame(warp.cosine_hemisphere(s, t), ng)
    hit = intersect(geometry, offset(point, size, ng), direction)
    counts[TESTED] += 1
    if not _stops_near(scene, hit, width):
        counts[EXPOSED] += _is_lit(scene, question.lit_sides, hit, direction)


@jit
def _count(scene, question, cells, piece, points, key, counts):
    """Count so many points of a piece, in `counts` of its own if it is a cell, or a part of one."""
    may_be_hidden = cells.divisions[piece.triangle] > 1
    key = stream(key, piece.part, piece.sub)
    point_key, ray_key = split(key, EXPOSURE_POINT), split(key, EXPOSURE_RAY)
    width = width_of(cells.inverse_area[piece.triangle, piece.side])
    for index in range(points):
        state = stream(ray_key, index, 0)
        if question.afar:  # Points that are not stratified: counts are binomial then.
            s, state = draw(state)
            t, state = draw(state)
        else:
            s, t = sobol_2d(index, point_key)
        u, v = warp.uniform_triangle(s, t)
        u, v = place_in(piece.finer, piece.sub, u, v)
        place = place_in(piece.n, piece.part, u, v)
        if question.afar:
            _look_afar(scene, question, piece, place, width, state, counts)
            continue
        _look_around(scene, question, piece, place, width, state, counts)
        if may_be_hidden and counts[TESTED] == HIDDEN and counts[EXPOSED] == 0:
            return


@jit
def _probe_shared(scene, question, cells, area, piece, key, exposure):
    """Count points of a triangle that shares a cell with others."""
    triangle, side = piece.triangle, piece.side
    xi, _ = draw(split(key, EXPOSURE_COUNT))
    points = question.points[cells.first[triangle, side]]
    points = int(points * area * cells.inverse_area[triangle, side] + xi)
    _count(scene, question, cells, piece, points, key, exposure.parts[triangle, side])


@jit
def _probe_divided(scene, question, cells, triangle, side, key, exposure):
    """Count points of the cells into which a triangle's side is divided."""
    n = cells.divisions[triangle]
    for part in range(n * n):
        whole = cells.first[triangle, side] + part
        divided = cells.parts[whole] >= 0
        finer = cells.finer if divided else 1
        for sub in range(finer * finer):
            cell = cells.parts[whole] + sub if divided else whole
            if question.points[cell] > 0:
                piece, points = Piece(triangle, side, n, part, finer, sub), question.points[cell]
                _count(scene, question, cells, piece, points, key, exposure.cells[cell])


@kernel
def probe_exposure(scene, question, areas, cells, key, span, exposure):
    """Count points of the cells of a span of triangles, of areas (T,), as many in each cell."""
    for triangle in range(span.first, span.last):
        for side in range(2):
            if not question.lit_sides[triangle, side]:
                continue
            own = stream(key, triangle, side)
            if cells.divisions[triangle] > 1:
                _probe_divided(scene, question, cells, triangle, side, own, exposure)
            elif question.points[cells.first[triangle, side]] > 0:
                piece = Piece(triangle, side, np.int32(1), 0, 1, 0)
                area = areas[triangle]
                _probe_shared(scene, question, cells, area, piece, own, exposure)


FINE = 8  # Looks at a textured opacity along the side of a cell


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
