"""Caustics: photons that smooth surfaces alone sent to diffuse ones, counted over small disks."""

import math

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.bands import divide
from photonmap.kernels.beyond import MOST_SMOOTH
from photonmap.kernels.jit import jit, kernel, outlined
from photonmap.kernels.light import emit, start_flux
from photonmap.kernels.opaque import hit, make_whole
from photonmap.kernels.optics import leave
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.surface import meet

PLACE, AIM, CHOOSE = 0, 1, 2
ALIGNED = 0.7
"""Cosine between normals within which photons count for each other's surface."""
FLATNESS = 0.3
"""Height above the surface, in radii, within which photons count."""


@jit
def _follow(geometry, optics, origin, direction, state, flux, place):
    """Follow a photon by smooth surfaces to a diffuse one; return 1 if it came there by them.

    Where it arrives, `place` (6,) is filled as in `Caustics`, and flux through the geometric
    surface becomes irradiance about the shading normal. Where surfaces do both, chance decides.
    """
    for bounce in range(MOST_SMOOTH):
        triangle, u, v, _ = hit(geometry, origin, direction)
        if triangle < 0:
            return 0
        material = geometry.material[triangle]
        smooth = optics.chance[material]
        if bounce == 0 and smooth == 0.0:
            return 0
        if bounce > 0 and smooth < 1.0:
            chance, state = draw(state)
            if chance >= smooth:
                point, ng, ns, _ = meet(geometry, triangle, u, v, direction)
                factor = max(0.0, -vec.dot(ns, direction)) / max(1e-9, -vec.dot(ng, direction))
                divide(flux, (1.0 - smooth) / max(factor, 1e-9))
                make_whole(geometry, geometry.alpha, triangle, u, v, flux)
                for axis in range(3):
                    place[axis], place[3 + axis] = point[axis], ng[axis]
                return 1
            divide(flux, smooth)
        chance, state = draw(state)
        origin, direction = leave(geometry, optics, triangle, u, v, direction, chance, True, flux)
    return 0


@jit
def _boxed(rows, columns, point):
    """Warp a point of the unit square to a density by boxes; return (point, density)."""
    boxes = len(rows) - 1
    row, x = _invert(rows, point[0])
    column, y = _invert(columns[row], point[1])
    chance = (rows[row + 1] - rows[row]) * (columns[row, column + 1] - columns[row, column])
    return ((row + x) / boxes, (column + y) / boxes), chance * boxes * boxes


@jit
def _invert(cumulative, u):
    """Return the interval of a rising table that holds u, and how far u is through it."""
    low, high = 0, len(cumulative) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if cumulative[middle] <= u:
            low = middle
        else:
            high = middle
    return low, (u - cumulative[low]) / (cumulative[high] - cumulative[low])


@kernel
def trace_caustics(geometry, lights, optics, guide, key, first, last, total, origins, places, flux):
    """Trace photons first..last of `total` to where they make caustics; return their number.

    They fill the first rows of origins, (last - first, 4), where in the unit squares of place and
    aim they left; of places, (last - first, 6), and flux, (last - first, N), as in `Caustics`.
    """
    count = 0
    place_key, aim_key = stream(key, PLACE, 0), stream(key, AIM, 0)
    for index in range(first, last):
        place, at = _boxed(guide.place_rows, guide.place_columns, sobol_2d(index, place_key))
        aim, towards = _boxed(guide.aim_rows, guide.aim_columns, sobol_2d(index, aim_key))
        emitter, weight, spot, origin, direction = emit(geometry, lights, place, aim)
        row = flux[count]
        start_flux(row, lights, emitter, spot, direction, weight / (total * at * towards))
        for axis in range(2):
            origins[count, axis], origins[count, 2 + axis] = place[axis], aim[axis]
        state = stream(key, CHOOSE, index)
        count += _follow(geometry, optics, origin, direction, state, row, places[count])
    return count


@jit
def bucket_of(x, y, z, buckets):
    """Return the bucket of a box of space (whole numbers)."""
    mixed = np.uint64(np.int64(x)) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= np.uint64(np.int64(y)) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= np.uint64(np.int64(z)) * np.uint64(0x165667B19E3779F9)
    return np.int64((mixed ^ (mixed >> np.uint64(29))) % np.uint64(buckets))


@kernel
def fill_buckets(places, width, first, last, buckets, out):
    """Fill `out`, (n,) int32, with the buckets of photons first..last."""
    for photon in range(first, last):
        x, y, z = vec.row(places, photon)
        out[photon] = bucket_of(
            math.floor(x / width), math.floor(y / width), math.floor(z / width), buckets
        )


@jit
def _dot_normal(places, photon, ng):
    return places[photon, 3] * ng[0] + places[photon, 4] * ng[1] + places[photon, 5] * ng[2]


@outlined
def add_caustics(caustics, point, ng, throughput, target, row):
    """Add the irradiance by caustics at a point, times throughput, (N,), to row `row` of target.

    Photons within the radius count with weights that fall as a parabola (Silverman 1986, 4.2).
    Without a caustic map (None) nothing is added.
    """
    if caustics is None:
        return
    buckets = len(caustics.starts) - 1
    if buckets < 1:
        return
    radius = caustics.radius
    width = 2.0 * radius
    low = (
        math.floor(point[0] / width - 0.5),
        math.floor(point[1] / width - 0.5),
        math.floor(point[2] / width - 0.5),
    )
    scale = 2.0 * warp.INV_PI / (radius * radius)
    for corner in range(8):
        x = low[0] + (corner & 1)
        y = low[1] + ((corner >> 1) & 1)
        z = low[2] + (corner >> 2)
        bucket = bucket_of(x, y, z, buckets)
        for photon in range(caustics.starts[bucket], caustics.starts[bucket + 1]):
            place = vec.row(caustics.places, photon)
            if (
                math.floor(place[0] / width) != x
                or math.floor(place[1] / width) != y
                or math.floor(place[2] / width) != z
            ):
                continue
            step = vec.sub(place, point)
            near = 1.0 - vec.dot(step, step) / (radius * radius)
            if near <= 0.0 or _dot_normal(caustics.places, photon, ng) < ALIGNED:
                continue
            if abs(vec.dot(step, ng)) > FLATNESS * radius:
                continue
            for band in range(target.shape[1]):
                light = np.float32(scale * near) * caustics.flux[photon, band]
                target[row, band] += throughput[band] * light
