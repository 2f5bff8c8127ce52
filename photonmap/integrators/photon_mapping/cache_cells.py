"""The cells of the radiosity cache: their layout, and which fraction of each is exposed.

The rest is inside what stands on the surface. No photon or gather ray arrives there: light that is
assumed to be spread over all of such a cell would be too dim where it can be seen. A point is
exposed if it sees anything that light reaches.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.integrators.base import PassSetup
from photonmap.kernels.cache.exposed_fraction import (
    BESIDE,
    COUNTS,
    EMITTER,
    EXPOSED,
    NEAR,
    TESTED,
    Exposure,
    Question,
    measure_cells,
    probe_exposure,
)
from photonmap.kernels.core.passes import CacheCells, RadiosityCache, Span
from photonmap.kernels.core.records import Geometry
from photonmap.kernels.core.streams import Domain
from photonmap.kernels.integrators.photon import trace_photons
from photonmap.runtime.storage import strips

FINER = 4
"""Cells along the side of one that is divided."""
NONE_CROWDED = np.zeros(0, np.bool_)
"""Of cells that are not looked up, or not measured yet."""
FINER_SHARED = 2
"""How many times as narrow the cells that triangles share are beside an emitter."""
DIRECTIONS = 4
"""Small triangles share a cell only where their normals fall in the same of 4³ boxes."""


class Exposed(NamedTuple):
    """What was measured of the cells of a layout."""

    fraction: NDArray[np.float32]
    """(cells, 1) of each that is exposed; 1 where none seems to be"""
    crowded: NDArray[np.bool_]
    """(cells,) whether things stand within its width"""
    cluttered: NDArray[np.bool_]
    """(cells,) whether many do, and no emitter is seen: that would be noisy"""
    beside_emitter: NDArray[np.bool_]
    """(cells,) whether an emitter stands within a few widths"""


def lay_cells(
    geometry: Geometry, areas: NDArray[np.float64], area: float
) -> tuple[CacheCells, int]:
    """Tile both sides of all triangles with cells of about the given area; return how many, too.

    Larger triangles are divided into n² similar ones; smaller ones share a cell with neighbours
    whose centres lie in the same box of that size and whose normals point alike. So there are
    O(surface / area) cells, however many triangles.
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
    undivided = np.full(2 * one_side, -1, np.int32)
    return CacheCells(
        both, divisions, inverse, undivided, NONE_CROWDED, NONE_CROWDED, 1
    ), 2 * one_side


def divide_cells(cells: CacheCells, chosen: NDArray[np.bool_]) -> tuple[CacheCells, int]:
    """Divide some of the cells that `lay_cells` laid into `FINER`² each, or fewer if many.

    Of the chosen ones, (count,), those of single triangles are. What comes of them lies behind all
    others, and is no more than they are. Return the layout, and the number of cells, those that
    were divided among them.
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


def split_shared(
    geometry: Geometry,
    areas: NDArray[np.float64],
    cells: CacheCells,
    chosen: NDArray[np.bool_],
    size: float,
) -> tuple[CacheCells, NDArray[np.int32]]:
    """Share out triangles of chosen cells, (count,), in boxes of a smaller size.

    Beside an emitter, triangles that share a cell are not alike: those that face it are bright, and
    seen from elsewhere than the others. The new cells lie behind all others. Return the layout, and
    of which cell each of them was, (new,).
    """
    shared = cells.divisions == 1
    triangles = np.flatnonzero(shared & chosen[cells.first].any(axis=1))
    if len(triangles) == 0:
        return cells, np.empty(0, np.int32)
    group, count = _group_neighbours(geometry, triangles, size), len(cells.parts)
    number = int(group.max()) + 1
    both, inverse = cells.first.copy(), cells.inverse_area.copy()
    of = np.empty((2, number), np.int32)
    of[:, group] = cells.first[triangles].T
    both[triangles] = (count + np.stack([group, group + number], axis=1)).astype(np.int32)
    inverse[triangles] = (1.0 / np.bincount(group, areas[triangles], number))[group, None]
    parts = np.concatenate([cells.parts, np.full(2 * number, -1, np.int32)])
    return cells._replace(first=both, inverse_area=inverse, parts=parts), of.ravel()


def one_cell(triangles: int) -> CacheCells:
    """Lay one cell of area 1 over all triangles, for photons that are only counted."""
    first, inverse = np.zeros((triangles, 2), np.int32), np.ones((triangles, 2), np.float32)
    none = np.zeros(0, np.int32)
    return CacheCells(
        first, np.ones(triangles, np.int32), inverse, none, NONE_CROWDED, NONE_CROWDED, 1
    )


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
    total, opaque = np.zeros(count), np.zeros(count)
    measure_cells(geometry, geometry.alpha, cells, areas, total, opaque)
    fill = np.divide(opaque, total, out=np.ones(count), where=total > 0.0)
    return np.maximum(fill, LEAST_FILL).astype(np.float32)[:, None]


def _group_neighbours(
    geometry: Geometry, small: NDArray[np.int64], size: float
) -> NDArray[np.int64]:
    """Give small triangles their cells: one for each box of space and of directions."""
    keys = np.zeros(len(small), np.int64)
    for part in strips(len(small)):
        some, key = small[part], keys[part]
        first, second, third = (geometry.vertices[corner] for corner in geometry.triangles[some].T)
        centres = (first.astype(np.float64) + second + third) / 3.0  # np.mean takes 3 times as long
        boxes = np.clip(np.floor(centres / size), -(1 << 16), (1 << 16) - 1) + (1 << 16)
        turns = np.floor((geometry.normals[some] + 1.0) * (DIRECTIONS / 2.001))
        for column, span in ((boxes, 1 << 17), (turns, DIRECTIONS)):
            for axis in range(3):
                key *= span
                key += column[:, axis].astype(np.int64)
    return _number(keys)[1]


def _number(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the distinct keys, which are not negative, and the number of each key among them.

    Neighbours are often alike: it sorts runs, in a fifth of the time of np.unique.
    """
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    distinct, number = np.unique(keys[starts], return_inverse=True)
    return distinct, np.repeat(number, np.diff(starts, append=len(keys)))


PILOT, BOUNCES = 4096, 16
"""Photons that find what light reaches, and their bounces."""
BATCHES = 16
"""In which they are traced."""
ENOUGH_BATCHES = 12
"""Of these, how many must reach an object for a decision of its own."""
LEAST = 1 / 4
"""Exposed fraction of a cell, at least: it bounds by how much a cell is made brighter."""
CLUTTERED = 2 / 5
"""Share of pairs of rays from a cell of which one ends within its width, above which it is
cluttered."""
POINTS = 8
"""Points of a cell from which rays look around."""
FEW_FAR, SEEN_FAR, MOST_FAR = 4, 8, 60
"""Points of a crowded cell from which one ray each looks afar: so many say how many it takes until
about 8 do; at most 60."""
PARTS = 16
"""Parts in which triangles are processed, for any number of threads."""


def find_lit_sides(setup: PassSetup) -> NDArray[np.bool_]:
    """Return of both sides of each triangle, (T, 2), whether light reaches it.

    Triangles of one material share the answer; so do those of one object that photons often reach.
    """
    material, objects = setup.compiled.geometry.material, setup.compiled.object_ids
    kinds = int(material.max()) + 1
    pairs, pair = _number(objects.astype(np.int64) * kinds + material)
    lit = _find_lit_batches(setup, pair, len(pairs))
    of_material = _count_batches(lit, pairs % kinds)
    of_object = _count_batches(lit, pairs // kinds)
    of_object[of_object.max(axis=1) < ENOUGH_BATCHES] = 1
    return (of_material[material] > 0) & (of_object[objects] > 0)


def _count_batches(lit: NDArray[np.bool_], group: NDArray[np.int64]) -> NDArray[np.int64]:
    """Count the batches that come to the sides of a group of pairs, (groups, 2)."""
    found = np.zeros((int(group.max()) + 1, BATCHES, 2), np.bool_)
    np.logical_or.at(found, group, lit)
    return found.sum(axis=1)


def _find_lit_batches(setup: PassSetup, pair: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    """Return of which batches some photons come to the sides of triangles, (count, BATCHES, 2).

    Those of one material and object, whose number is in `pair`, (T,), are one. Photons lose
    nothing, and come from all emitters alike: whether a surface is dark, or a light dim, does not
    matter.
    """
    scene = setup.compiled.arrays
    lights, materials, textures = scene.lights, scene.materials, scene.textures
    emitters = len(lights.cdf)
    if textures:
        textures = textures._replace(reflectance=np.full_like(textures.reflectance, -1))
    scene = scene._replace(
        lights=lights._replace(cdf=np.arange(1, emitters + 1) / emitters),
        materials=materials._replace(reflectance=np.ones_like(materials.reflectance)),
        textures=textures,
    )
    sides = 2 * pair.astype(np.int32)[:, None] + np.arange(2, dtype=np.int32)
    cells = one_cell(len(pair))._replace(first=sides)
    cache = RadiosityCache(cells, np.empty((2 * count, setup.bands), np.float32))
    key, scratch = setup.key(0, Domain.LIT_SIDES), np.empty((3, setup.bands), np.float32)
    lit = np.empty((count, BATCHES, 2), np.bool_)
    for batch in range(BATCHES):
        span = Span(batch * PILOT // BATCHES, (batch + 1) * PILOT // BATCHES)
        trace_photons(scene, cache, key, span, PILOT, BOUNCES, scratch)
        lit[:, batch] = cache.radiosity.any(axis=1).reshape(count, 2)
    return lit


def measure_exposed(
    setup: PassSetup,
    lit_sides: NDArray[np.bool_],
    areas: NDArray[np.float64],
    cells: CacheCells,
) -> Exposed:
    """Return what is exposed of each of cells that are not divided.

    Sides are those of `find_lit_sides`, (T, 2), and areas, (T,), those of triangles.
    """
    count = len(cells.parts)
    question = Question(lit_sides, np.full(count, POINTS, np.uint8), False)
    counts = _count_points(setup, question, areas, cells, setup.key(0, Domain.EXPOSURE))
    fraction = setup.storage.zeros((count, 1))
    fraction[:] = 1.0
    found = counts[:, EXPOSED] > 0
    np.divide(counts[:, EXPOSED], counts[:, TESTED], out=fraction[:, 0], where=found)
    near = counts[:, NEAR]
    cluttered = (near > CLUTTERED * counts[:, TESTED]) & (counts[:, EMITTER] == 0)
    np.maximum(fraction, LEAST, out=fraction)
    return Exposed(fraction, near > 0, cluttered, counts[:, BESIDE] > 0)


def measure_seen_afar(
    setup: PassSetup,
    index: int,
    lit_sides: NDArray[np.bool_],
    areas: NDArray[np.float64],
    cells: CacheCells,
    wanted: NDArray[np.bool_],
) -> tuple[NDArray[np.float32], int]:
    """Return the inverse share of cells that is seen from afar, and how many rays told that.

    (cells, 1): that of rays from a cell which meet what light reaches, and not within its width, as
    some of pass `index` estimate it; 1 of cells that are not `wanted`. The other arguments are
    those of `measure_exposed`.
    """
    known = areas, cells, setup.key(index, Domain.SEEN_AFAR)
    few = _count_points(setup, Question(lit_sides, wanted * np.uint8(FEW_FAR), True), *known)
    share = (few[:, EXPOSED] + 0.5) / (few[:, TESTED] + 1.0)
    points = np.where(wanted, np.minimum(SEEN_FAR / share, MOST_FAR), 0.0).astype(np.uint8)
    known = areas, cells, setup.key(index, Domain.SEEN_AFAR_AGAIN)
    counts = _count_points(setup, Question(lit_sides, points, True), *known)
    # With k of n rays, its mean lacks (1 - share)^(n + 1); that of n / k is too large.
    tested, exposed = (counts[:, [column]] + np.float32(1.0) for column in (TESTED, EXPOSED))
    return tested / exposed, int(few[:, TESTED].sum() + counts[:, TESTED].sum())


def _count_points(
    setup: PassSetup,
    question: Question,
    areas: NDArray[np.float64],
    cells: CacheCells,
    key: np.uint64,
) -> NDArray[np.uint8]:
    """Return what is counted of the points of cells, (cells, COUNTS)."""
    scene, storage, triangles = setup.compiled.arrays, setup.storage, len(areas)
    exposure = Exposure(
        storage.zeros((len(question.points), COUNTS), np.uint8),
        storage.zeros((triangles, 2, COUNTS), np.uint8),
    )

    def probe(part: int) -> None:
        span = Span(part * triangles // PARTS, (part + 1) * triangles // PARTS)
        probe_exposure(scene, question, areas, cells, key, span, exposure)

    setup.workers.map(probe, PARTS)
    shared = np.nonzero(exposure.parts[..., TESTED])
    np.add.at(exposure.cells, cells.first[shared], exposure.parts[shared])
    return exposure.cells
