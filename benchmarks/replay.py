"""Rays of a camera pass cast again, and what else a pass does for each ray, on its own."""

from __future__ import annotations

import numpy as np

from photonmap.kernels.gather import aim
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.ray import intersect, occluded
from photonmap.kernels.store import cell_at
from photonmap.kernels.surface import side_of

NEAREST = 0


@jit
def ray_at(rays, i):
    """Return (origin, direction) of row i of (n, 8) float32."""
    origin = (rays[i, 0], rays[i, 1], rays[i, 2])
    return origin, (rays[i, 3], rays[i, 4], rays[i, 5])


@kernel
def cast_rays(scene, rays, first, last):
    """Cast rays first..last and do nothing else; return how many hit."""
    hits = 0
    for i in range(first, last):
        origin, direction = ray_at(rays, i)
        if rays[i, 7] == NEAREST:
            hits += intersect(scene, origin, direction)[0] >= 0
        else:
            hits += occluded(scene, origin, direction, rays[i, 6])
    return hits


@kernel
def cast_and_look_up(geometry, cells, radiosity, eye, rays, first, last, total):
    """Cast rays first..last; add what those not from the eye find in the store to total, (N,)."""
    hits = 0
    for i in range(first, last):
        origin, direction = ray_at(rays, i)
        if rays[i, 7] != NEAREST:
            hits += occluded(geometry.scene, origin, direction, rays[i, 6])
            continue
        found = intersect(geometry.scene, origin, direction)
        triangle = found[0]
        hits += triangle >= 0
        if triangle >= 0 and origin[0] != eye[0]:
            side = side_of(geometry, triangle, direction)
            cell = cell_at(cells, triangle, side, found[1], found[2])
            for band in range(radiosity.shape[1]):
                total[band] += radiosity[cell, band]
    return hits


@kernel
def draw_samples(rays, key, first, last, directions):
    """Draw a direction for each of rays first..last; directions, (3, n), is scratch."""
    total = 0.0
    for i in range(first, last, directions.shape[1]):
        aim(ray_at(rays, i)[1], np.uint64(i), key, directions)
        total += directions[0, 0]
    return total
