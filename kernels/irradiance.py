"""The irradiance of one hit: light samples, gather rays and caustics."""

import numpy as np

from photonmap.kernels.bands import clear
from photonmap.kernels.caustics import add_caustics
from photonmap.kernels.gather import aim, gather
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import add_emitted, sample_direct
from photonmap.kernels.records import CAUSTIC, DIRECT
from photonmap.kernels.rng import sobol_block, stream

LIGHT, AIM = 0, 1


@jit
def light_keys(key, first):
    """Return the keys of a hit's light samples, and of its gather rays: see `gather`."""
    return (
        stream(key, first, 0),
        stream(key, first + 1, 0),
        stream(key, first + 2, 0),
        stream(key, first + 3, 0),
    )


@outlined
def light_and_gather(scene, store, caustics, hit, index, samples, gathers, keys, scratch):
    """Estimate the irradiance of one hit, in scratch; return what gather rays found.

    `index` numbers the hit for low-discrepancy points, `keys` are of `light_keys`.
    """
    geometry, _, lights, _, _ = scene
    point, ng, ns, _ = hit
    throughput, _, irradiance, points, directions = scratch
    clear(irradiance)
    first = index * np.uint64(samples)
    for sample in range(samples):
        lane = sample % points.shape[1]
        if lane == 0:
            sobol_block(first + np.uint64(sample), keys[LIGHT], points)
        emitter, weight, place, direction = sample_direct(
            geometry, lights, point, ng, ns, points[0, lane], points[1, lane], samples, gathers
        )
        if weight > 0.0:
            add_emitted(irradiance, DIRECT, lights, emitter, place, direction, weight)
    found = 0
    first = index * np.uint64(gathers)
    for ray in range(gathers):
        place, lane = first + np.uint64(ray), ray % directions.shape[1]
        if lane == 0:
            aim(ns, place, keys[AIM], directions)
        direction = directions[0, lane], directions[1, lane], directions[2, lane]
        found |= gather(
            scene, store, caustics, hit, direction, place, keys, samples, gathers, throughput,
            irradiance,
        )  # fmt: skip
    if caustics is not None:
        throughput[:] = 1.0
        add_caustics(caustics, point, ng, throughput, irradiance, CAUSTIC)
    return found
