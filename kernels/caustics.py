"""Caustics: photons that smooth surfaces alone sent to diffuse ones, counted over small disks."""

import math

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.bands import divide
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import emit
from photonmap.kernels.optics import leave
from photonmap.kernels.ray import intersect
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.surface import meet

PLACE, AIM, CHOOSE = 0, 1, 2
MOST_SMOOTH = 64
"""Reflections and refractions in a row, after which a path is cut."""
ALIGNED = 0.7
"""Cosine between normals within which photons count for each other's surface."""
FLATNESS = 0.3
"""Height above the surface, in radii, within which photons count."""


@jit
def _follow(geometry, optics, origin, direction, state, flux, position, normal):
    """Follow a photon by smooth surfaces to a diffuse one; return 1 if it came there by them.

    Where it arrives, `position` and `normal` are filled, and flux through the geometric surface
    becomes irradiance about the shading normal. Where surfaces do both, chance decides.
    """
    for bounce in range(MOST_SMOOTH):
        triangle, u, v, _ = intersect(geometry.scene, origin, direction)
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
                for axis in range(3):
                    position[axis], normal[axis] = point[axis], ng[axis]
                return 1
            divide(flux, smooth)
        chance, state = draw(state)
        origin, direction = leave(geometry, optics, triangle, u, v, direction, chance, True, flux)
    return 0


@jit
def trace_caustics(geometry, lights, optics, key, first, last, total, positions, normals, flux):
    """Trace photons first..last of `total` to where they make caustics; return their number.

    They fill the first rows of positions and normals, (last - first, 3), and of flux,
    (last - first, N).
    """
    count = 0
    place_key, aim_key = stream(key, PLACE, 0), stream(key, AIM, 0)
    for index in range(first, last):
        place, aim = sobol_2d(index, place_key), sobol_2d(index, aim_key)
        emitter, weight, origin, direction = emit(geometry, lights, place, aim)
        spectrum = lights.spectra[lights.spectrum[emitter]]
        row = flux[count]
        for band in range(len(row)):
            row[band] = spectrum[band] * np.float32(weight / total)
        state = stream(key, CHOOSE, index)
        count += _follow(
            geometry, optics, origin, direction, state, row,
            positions[count], normals[count],
        )  # fmt: skip
    return count


@jit
def bucket_of(x, y, z, buckets):
    """Return the bucket of a box of space (whole numbers)."""
    mixed = np.uint64(x) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= np.uint64(y) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= np.uint64(z) * np.uint64(0x165667B19E3779F9)
    return np.int64((mixed ^ (mixed >> np.uint64(29))) % np.uint64(buckets))


@jit
def fill_buckets(positions, width, first, last, buckets, out):
    """Fill `out`, (n,) int32, with the buckets of photons first..last."""
    for photon in range(first, last):
        x, y, z = vec.row(positions, photon)
        out[photon] = bucket_of(
            math.floor(x / width), math.floor(y / width), math.floor(z / width), buckets
        )


@outlined
def add_caustics(caustics, point, ng, weight, target, row):
    """Add the irradiance by caustics at a point, times weight, to row `row` of target.

    Photons within the radius count with weights that fall as a parabola (Silverman 1986, 4.2).
    """
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
    scale = weight * 2.0 * warp.INV_PI / (radius * radius)
    for corner in range(8):
        x = low[0] + (corner & 1)
        y = low[1] + ((corner >> 1) & 1)
        z = low[2] + (corner >> 2)
        bucket = bucket_of(x, y, z, buckets)
        for photon in range(caustics.starts[bucket], caustics.starts[bucket + 1]):
            place = vec.row(caustics.positions, photon)
            if (
                math.floor(place[0] / width) != x
                or math.floor(place[1] / width) != y
                or math.floor(place[2] / width) != z
            ):
                continue
            step = vec.sub(place, point)
            near = 1.0 - vec.dot(step, step) / (radius * radius)
            if near <= 0.0 or vec.dot(vec.row(caustics.normals, photon), ng) < ALIGNED:
                continue
            if abs(vec.dot(step, ng)) > FLATNESS * radius:
                continue
            for band in range(target.shape[1]):
                target[row, band] += np.float32(scale * near) * caustics.flux[photon, band]
