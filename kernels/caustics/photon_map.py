"""Caustics: photons that specular surfaces alone sent to diffuse ones, counted over small disks."""

import math

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.glass import absorb
from photonmap.kernels.bsdf.specular import (
    LONGEST_CHAIN,
    choose_lobe,
    draw_scattering,
    specular_probability,
    specular_step,
)
from photonmap.kernels.caustics.aim import aim_photon
from photonmap.kernels.caustics.disk import Place, disk_weight, edge_correction
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.bands import total as band_total
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.rng import sobol_2d, stream
from photonmap.kernels.core.streams import DISK, EMIT_DIRECTION, EMIT_POSITION, LOBE, split
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import divide_by_opacity, intersect

FIRST = 0  # Number of every step: no Russian roulette, so photons keep their flux


@jit
def _follow(scene, ray, state, flux):
    """Follow a photon along specular surfaces to where it takes another lobe."""
    # Returns (whether it came there via specular surfaces, its hit, its direction, rays cast).
    hit, direction = intersect(scene.geometry, *ray), ray[1]
    if hit.triangle < 0 or specular_probability(scene, hit.triangle) == 0.0:
        return False, hit, direction, 1
    absorb(scene, hit, direction, True, flux)
    for step in range(LONGEST_CHAIN):
        if step > 0:
            probability = specular_probability(scene, hit.triangle)
            is_specular, state = choose_lobe(probability, state, flux)
            if not is_specular:
                return True, hit, direction, step + 1
        numbers, state = draw_scattering(scene.specular.alpha, state)
        _, hit, direction, state = specular_step(
            scene, (hit, direction), numbers, FIRST, np.float32(1.0), state, True, flux
        )
        if hit.triangle < 0:
            return False, hit, direction, step + 2
    return False, hit, direction, LONGEST_CHAIN + 1


@jit
def _arrive(geometry, hit, direction, photons, row):
    """Turn flux into irradiance about the shading normal, and fill a row of photons.

    Returns their `Place`.
    """
    surface = surface_interaction(geometry, hit, direction)
    factor = max(0.0, -vec.dot(surface.ns, direction))
    factor /= max(1e-9, -vec.dot(surface.ng, direction))
    divide(photons.flux[row], 1.0 / max(factor, 1e-9))
    divide_by_opacity(geometry, hit, photons.flux[row])
    for axis in range(3):
        photons.positions[row, axis] = surface.point[axis]
        photons.positions[row, 3 + axis] = surface.ng[axis]
        photons.arrivals[row, axis] = direction[axis]
    photons.triangles[row] = hit.triangle
    photons.barycentrics[row, 0], photons.barycentrics[row, 1] = hit.u, hit.v
    return Place(surface.point, surface.ng, hit.triangle)


@jit
def _guided(rows, columns, point):
    """Warp a point of the unit square to a density by boxes; return (point, density)."""
    boxes = len(rows)
    row, x = warp.discrete(rows, point[0])
    column, y = warp.discrete(columns[row], point[1])
    probability = warp.discrete_pdf(rows, row) * warp.discrete_pdf(columns[row], column)
    return ((row + x) / boxes, (column + y) / boxes), probability * boxes * boxes


@kernel
def trace_caustics(scene, guide, key, span, total, radius, sums, photons):
    """Trace photons of a span of `total` to where they make caustics; fill a row of `photons` each.

    `radius` is that of their disks, or 0 where they do not count; `sums`, (K,) float64, is used up.
    Returns the number of rays cast.
    """
    rays = 0
    position_key, direction_key = split(key, EMIT_POSITION), split(key, EMIT_DIRECTION)
    lobe_key, disk_key = split(key, LOBE), split(key, DISK)
    for index in range(span.first, span.last):
        row = index - span.first
        point, density = _guided(
            guide.position_rows, guide.position_columns, sobol_2d(index, position_key)
        )
        aim, aimed = _guided(guide.aim_rows, guide.aim_columns, sobol_2d(index, direction_key))
        flux, weight = photons.flux[row], 1.0 / (total * density * aimed)
        start, direction, sphere = aim_photon(
            scene.geometry, scene.lights, guide, sums, point, aim, weight, flux
        )
        for axis in range(2):
            photons.origins[row, axis] = point[axis]
            photons.origins[row, 2 + axis] = aim[axis]
        photons.origins[row, 4] = sphere
        photons.emitted[row] = band_total(photons.flux, row)
        photons.arrived[row] = False
        if photons.emitted[row] == 0.0:
            continue
        state = stream(lobe_key, index, 0)
        photons.arrived[row], hit, direction, cast = _follow(scene, (start, direction), state, flux)
        rays += cast
        if photons.arrived[row]:
            place = _arrive(scene.geometry, hit, direction, photons, row)
            if radius > 0.0:
                state = stream(disk_key, index, 0)
                photons.edge_correction[row], cast = edge_correction(scene, place, radius, state)
                rays += cast
    return rays


@jit
def bucket_of(x, y, z, buckets):
    """Return the bucket of a box of space (whole numbers)."""
    mixed = np.uint64(np.int64(x)) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= np.uint64(np.int64(y)) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= np.uint64(np.int64(z)) * np.uint64(0x165667B19E3779F9)
    return np.int64((mixed ^ (mixed >> np.uint64(29))) % np.uint64(buckets))


@kernel
def fill_buckets(positions, width, first, last, buckets, out):
    """Fill `out`, (n,) int32, with the buckets of photons first..last."""
    for photon in range(first, last):
        x, y, z = vec.row(positions, photon)
        out[photon] = bucket_of(
            math.floor(x / width), math.floor(y / width), math.floor(z / width), buckets
        )


@kernel
def sort_by_key(keys, starts, order):
    """Sort rows by their keys, (n,) int32, in a stable way; rows of key -1 are left out.

    Fills `order`, (n,) int32, with rows, and `starts`, (K + 2,) int32, zero before, so that those
    of key k begin at starts[k] and end before starts[k + 1].
    """
    for row in range(len(keys)):
        if keys[row] >= 0:
            starts[keys[row] + 2] += 1
    for key in range(2, len(starts)):
        starts[key] += starts[key - 1]
    for row in range(len(keys)):
        key = keys[row]
        if key >= 0:
            order[starts[key + 1]] = row
            starts[key + 1] += 1


@jit
def _weight(scene, caustics, photon, at, box):
    """Return the weight of a photon for a `Place`, 0 if it does not count."""
    # Photons of other boxes may share a bucket, and those of other surfaces a box.
    position = vec.row(caustics.positions, photon)
    width = 2.0 * caustics.radius
    if (
        math.floor(position[0] / width) != box[0]
        or math.floor(position[1] / width) != box[1]
        or math.floor(position[2] / width) != box[2]
    ):
        return 0.0
    triangle = caustics.triangles[photon] if len(caustics.triangles) > 0 else 0
    row = caustics.positions[photon]
    other = Place(position, (row[3], row[4], row[5]), triangle)
    return disk_weight(scene, other, at, caustics.radius)


@jit
def _box(caustics, point, corner):
    """Return one of the eight boxes of space that photons around a point lie in."""
    width = 2.0 * caustics.radius
    return (
        math.floor(point[0] / width - 0.5) + (corner & 1),
        math.floor(point[1] / width - 0.5) + ((corner >> 1) & 1),
        math.floor(point[2] / width - 0.5) + (corner >> 2),
    )


@jit
def _density(caustics):
    """Return the irradiance of a photon of flux and weight 1."""
    return 2.0 * warp.INV_PI / (caustics.radius * caustics.radius)


@jit
def add_caustics(scene, caustics, surface, scatters, factor, target, row, scratch):
    """Add the irradiance by caustics at a point, times factor · throughput, to row `row` of target.

    Or, where the surface `scatters`, the radiance that its BSDF makes of them; `scratch.response`
    is used up. Without a caustic map (None) nothing is added.
    """
    if caustics is None:
        return
    buckets = len(caustics.starts) - 1
    if buckets < 1:
        return
    scale, at = factor * _density(caustics), Place(surface.point, surface.ng, surface.hit.triangle)
    if scene.scattering is None or not scatters:
        scratch.response[:] = np.float32(1.0)
    for corner in range(8):
        box = _box(caustics, surface.point, corner)
        bucket = bucket_of(box[0], box[1], box[2], buckets)
        for photon in range(caustics.starts[bucket], caustics.starts[bucket + 1]):
            near = _weight(scene, caustics, photon, at, box)
            if near == 0.0:
                continue
            near *= caustics.edge_correction[photon]
            if scene.scattering is not None and scatters:
                wi = vec.scale(vec.row(caustics.arrivals, photon), -1.0)
                models.evaluate_sought(scene, surface, wi, scratch.response, scratch.walk)
            for band in range(target.shape[1]):
                light = np.float32(scale * near) * caustics.flux[photon, band]
                target[row, band] += scratch.throughput[band] * scratch.response[band] * light
