"""Replays of a camera pass's rays, and of the other work per ray, each on its own."""

from __future__ import annotations

import numpy as np

from photonmap.kernels.cache.radiosity_cache import cell_at
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.geometry.interaction import side_of
from photonmap.kernels.geometry.ray import any_hit, closest_hit
from photonmap.kernels.integrators.final_gather import fill_directions

NEAREST = 0


@jit
def ray_at(rays, i):
    """Return (origin, direction) of row i of (n, 8) float32."""
    origin = (rays[i, 0], rays[i, 1], rays[i, 2])
    return origin, (rays[i, 3], rays[i, 4], rays[i, 5])


@kernel
def cast_rays(scene, rays, first, last):
    """Cast rays first..last and do nothing else; return the number of hits."""
    hits = 0
    for i in range(first, last):
        origin, direction = ray_at(rays, i)
        if rays[i, 7] == NEAREST:
            hits += closest_hit(scene, origin, direction).triangle >= 0
        else:
            hits += any_hit(scene, origin, direction, rays[i, 6])
    return hits


@kernel
def cast_and_look_up(geometry, cache, eye, rays, first, last, total):
    """Cast rays first..last; add the cache look-ups of those not from the eye to total, (N,)."""
    hits = 0
    for i in range(first, last):
        origin, direction = ray_at(rays, i)
        if rays[i, 7] != NEAREST:
            hits += any_hit(geometry.scene, origin, direction, rays[i, 6])
            continue
        hit = closest_hit(geometry.scene, origin, direction)
        hits += hit.triangle >= 0
        if hit.triangle >= 0 and origin[0] != eye[0]:
            side = side_of(geometry, hit.triangle, direction)
            cell = cell_at(cache.cells, hit.triangle, side, hit.u, hit.v)
            for band in range(len(total)):
                total[band] += cache.radiosity[cell, band]
    return hits


@kernel
def draw_samples(rays, key, first, last, directions):
    """Draw a direction for each of rays first..last; directions, (3, n), is scratch."""
    total = 0.0
    for i in range(first, last, directions.shape[1]):
        fill_directions(ray_at(rays, i)[1], np.uint64(i), key, directions)
        total += directions[0, 0]
    return total
