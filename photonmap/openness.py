"""Which part of the store's cells lies open: the rest is inside of what stands on the surface.

No photon comes there, and no gather ray: light that is taken to be spread over all of such a cell
is too dim where it can be seen. A point lies open if it sees anything that light reaches.
"""

import numpy as np
from numpy.typing import NDArray

from photonmap.cells import one_cell
from photonmap.kernels.openness import probe_cells
from photonmap.kernels.photon import trace_photons
from photonmap.kernels.records import Cells, SceneArrays
from photonmap.storage import RAM, Storage
from photonmap.workers import Workers

PILOT, BOUNCES = 4096, 32
"""Photons that find what light reaches, and their bounces."""
FLIGHTS, SURELY = 16, 12
"""Groups of them, and how many come to an object of which they say enough."""
LEAST = 1 / 4
"""Part of a cell that lies open, at least: no cell is taken to be more than so much brighter."""
SHARES = 16
"""In which triangles are looked at, for any number of threads."""


def find_reached(
    scene: SceneArrays, objects: NDArray[np.integer], bands: int, key: np.uint64
) -> NDArray[np.bool_]:
    """Tell of both sides of each triangle, (T, 2), whether light comes there.

    Triangles of one material are taken alike, and of one object, `objects` (T,), where photons
    come to it often.
    """
    material = scene[0].material
    of_material = _find_lit(scene, material, bands, key)
    of_object = _find_lit(scene, objects, bands, key)
    of_object[of_object.max(axis=1) < SURELY] = 1
    return (of_material[material] > 0) & (of_object[objects] > 0)


def _find_lit(
    scene: SceneArrays, groups: NDArray[np.integer], bands: int, key: np.uint64
) -> NDArray[np.int64]:
    """Count the flights of photons that come to the sides of groups of triangles, (G, 2).

    They lose nothing, and come from all emitters alike: whether a surface is dark, or a lamp dim,
    does not matter.
    """
    geometry, materials, lights, optics, textures = scene
    emitters = len(lights.cumulative)
    lights = lights._replace(cumulative=np.arange(1, emitters + 1) / emitters)
    white = materials._replace(reflectance=np.ones_like(materials.reflectance))
    if textures is not None:
        textures = textures._replace(reflectance=np.full_like(textures.reflectance, -1))
    count = int(groups.max()) + 1
    sides = 2 * groups.astype(np.int32)[:, None] + np.arange(2, dtype=np.int32)
    cells = one_cell(len(groups))._replace(first=sides)
    flux, light = np.empty(bands, np.float32), np.empty((2 * count, bands), np.float32)
    lit = np.zeros((count, 2), np.int64)
    for flight in range(FLIGHTS):
        first, last = flight * PILOT // FLIGHTS, (flight + 1) * PILOT // FLIGHTS
        trace_photons(
            geometry, white, lights, optics, textures, cells, key, first, last, PILOT, BOUNCES,
            flux, light,
        )  # fmt: skip
        lit += light.any(axis=1).reshape(count, 2)
    return lit


def measure_open(
    scene: SceneArrays,
    reached: NDArray[np.bool_],
    areas: NDArray[np.float64],
    cells: Cells,
    count: int,
    key: np.uint64,
    workers: Workers,
    storage: Storage = RAM,
) -> NDArray[np.float32]:
    """Return which part of each of `count` cells lies open, (count, 1); 1 where none seems to.

    In a layout with divided cells, only of what came of these: 1 elsewhere.

    Parameters
    ----------
    reached : (T, 2) of `find_reached`
    areas : (T,) of triangles
    """
    geometry, _, _, optics, _ = scene
    triangles = len(areas)
    single = storage.zeros((2, count), np.uint8)
    few = storage.zeros((2, triangles, 2), np.uint8)

    def probe(share: int) -> None:
        first, last = share * triangles // SHARES, (share + 1) * triangles // SHARES
        probe_cells(geometry, optics, reached, areas, cells, key, first, last, *single, *few)

    workers.map(probe, SHARES)
    small = cells.divisions == 1
    for counts, some in zip(single, few, strict=True):
        np.add.at(counts, cells.first[small].ravel(), some[small].ravel())
    tested, found = single
    part = storage.zeros((count, 1))
    part[:] = 1.0
    np.divide(found, tested, out=part[:, 0], where=found > 0)
    return np.maximum(part, LEAST, out=part)
