"""Which part of the store's cells lies open: the rest is inside of what stands on the surface.

No photon comes there, and no gather ray: light that is taken to be spread over all of such a cell
is too dim where it can be seen. A point lies open if it sees anything that light reaches.
"""

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.openness import probe_cells
from photonmap.kernels.photon import trace_photons
from photonmap.kernels.records import Cells, SceneArrays
from photonmap.storage import RAM, Storage
from photonmap.workers import Workers

PILOT, BOUNCES = 4096, 64
"""Photons that find what light reaches, and their bounces."""
LEAST = 1 / 4
"""Part of a cell that lies open, at least: no cell is taken to be more than so much brighter."""
SHARES = 16
"""In which triangles are looked at, for any number of threads."""


def find_reached(scene: SceneArrays, bands: int, key: np.uint64) -> NDArray[np.bool_]:
    """Tell of both sides of each material, (M, 2), whether light comes there.

    By photons that lose nothing, as many from each emitter: whether a surface is dark, or a lamp
    dim, does not matter.
    """
    geometry, materials, lights, optics, textures = scene
    emitters = len(lights.cumulative)
    lights = lights._replace(cumulative=np.arange(1, emitters + 1) / emitters)
    white = materials._replace(reflectance=np.ones_like(materials.reflectance))
    if textures is not None:
        textures = textures._replace(reflectance=np.full_like(textures.reflectance, -1))
    count = len(materials.reflectance)
    sides = 2 * geometry.material[:, None] + np.arange(2, dtype=np.int32)
    ones = np.ones(len(sides), np.int32), np.ones((len(sides), 2), np.float32)
    whole = np.zeros(0, np.int32)
    light = np.empty((2 * count, bands), np.float32)
    trace_photons(
        geometry,
        white,
        lights,
        optics,
        textures,
        Cells(sides.astype(np.int32), *ones, whole, 1),
        key,
        0,
        PILOT,
        PILOT,
        BOUNCES,
        np.empty(bands, np.float32),
        light,
    )
    return light.any(axis=1).reshape(count, 2)


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

    Parameters
    ----------
    reached : (M, 2) of `find_reached`
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
