"""Gather rays: what a cosine-distributed ray from a camera sample sees."""

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.albedo import albedo, paint
from photonmap.kernels.bands import total
from photonmap.kernels.beyond import gather_beyond, largest, smoothness
from photonmap.kernels.caustics import add_caustics
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import add_emitted, emitted, weigh_hit, weigh_miss
from photonmap.kernels.opaque import hit as first_hit
from photonmap.kernels.records import DIRECT, INDIRECT
from photonmap.kernels.rng import sobol_2d, stream
from photonmap.kernels.store import answers, cell_at
from photonmap.kernels.surface import meet, side_of
from photonmap.kernels.walk import walk

EMPTY, FOUND = 1, 2
WALK, BEYOND = 2, 3
"""Keys of `light_keys` for what goes on from a ray's end."""
MOST_BOUNCES = 1000


@jit
def _look_up(materials, material, radiosity, cell, weight, irradiance):
    """Add a cell's light to `irradiance`, (2, N); return FOUND, EMPTY, or 0 if it is black."""
    weight, light = np.float32(weight), np.float32(0.0)
    for band in range(radiosity.shape[1]):
        irradiance[INDIRECT, band] += weight * radiosity[cell, band]
        light += radiosity[cell, band]
    if light > 0.0:
        return FOUND
    for band in range(radiosity.shape[1]):
        if materials.reflectance[material, band] > 0.0:
            return EMPTY
    return 0


@jit
def aim(ns, first, key, directions):
    """Fill directions, (3, n), with cosine-distributed ones about ns; as `sobol_block`."""
    for lane in range(directions.shape[1]):
        u, v = sobol_2d(first + np.uint64(lane), key)
        x, y, z = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        directions[0, lane], directions[1, lane], directions[2, lane] = x, y, z


@outlined
def gather(
    scene, store, caustics, hit, direction, place, keys, samples, gathers, throughput, irradiance
):
    """Add what one of `gathers` cosine-distributed rays sees to `irradiance`, (2, N).

    `samples` light samples are taken at the same hit. Where the ray ends too near for the store
    to answer, a path goes on from there. `place` numbers the ray, `keys` are for the WALK on, and
    what lies BEYOND smooth surfaces. Returns what was found, as `_look_up`.
    """
    geometry, materials, lights, optics, textures = scene
    cells, radiosity = store
    point, ng, ns, _ = hit
    if vec.dot(ng, direction) <= 0.0:
        return 0
    triangle, u, v, distance = first_hit(geometry, point, direction)
    side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
    emitter = emitted(geometry, lights, triangle, side)
    if triangle < 0:
        if emitter >= 0:
            weight = weigh_miss(geometry, lights, point, ns, direction, samples, gathers)
            add_emitted(irradiance, DIRECT, lights, emitter, (u, v), direction, weight)
        return 0
    if emitter >= 0:
        end = meet(geometry, triangle, u, v, direction)[0]
        weight = weigh_hit(geometry, lights, emitter, point, ns, end, direction, samples, gathers)
        add_emitted(irradiance, DIRECT, lights, emitter, (u, v), direction, weight)
    material = geometry.material[triangle]
    found = 0
    smooth = smoothness(geometry, optics, triangle)
    if smooth > 0.0:
        state = stream(keys[BEYOND], 0, place)
        weight = np.float32(1.0 / gathers)
        lit = gather_beyond(
            geometry, optics, store, triangle, u, v, direction, weight, state, throughput,
            irradiance,
        )  # fmt: skip
        found = FOUND if lit else 0
        if smooth == 1.0:
            return found
    if answers(cells, triangle, side, distance):
        cell = cell_at(cells, triangle, side, u, v)
        return found | _look_up(materials, material, radiosity, cell, 1.0 / gathers, irradiance)
    color = paint(geometry, textures, triangle, u, v)
    for band in range(len(throughput)):
        throughput[band] = albedo(materials, textures, color, band) / np.float32(gathers)
    if largest(throughput) == 0.0:
        return found
    before = total(irradiance, INDIRECT)
    state = stream(keys[WALK], 0, place)
    end_hit = meet(geometry, triangle, u, v, direction)
    add_caustics(caustics, end_hit[0], end_hit[1], throughput, irradiance, INDIRECT)
    walk(scene, store, caustics, end_hit, INDIRECT, MOST_BOUNCES, state, throughput, irradiance)
    return FOUND if total(irradiance, INDIRECT) > before else EMPTY
