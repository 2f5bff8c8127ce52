"""The irradiance of one hit: light samples, gather rays and caustics."""

import numpy as np

from photonmap.kernels.bands import clear
from photonmap.kernels.caustics import add_caustics
from photonmap.kernels.gather import gather
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import add_emitted, sample_direct
from photonmap.kernels.records import CAUSTIC, DIRECT
from photonmap.kernels.rng import sobol_2d, stream

LIGHT, GATHER = 0, 1


@jit
def light_keys(key, first):
    """Return the keys of a hit's light samples and of the three parts of its gather rays."""
    return (
        stream(key, first, 0),
        (stream(key, first + 1, 0), stream(key, first + 2, 0), stream(key, first + 3, 0)),
    )


@outlined
def light_and_gather(
    scene, store, caustics, hit, index, samples, gathers, keys, throughput, irradiance
):
    """Estimate the irradiance, (2, N) or (3, N), of one hit; return what gather rays found.

    `index` numbers the hit for low-discrepancy points, `keys` are of `light_keys`, `throughput`
    is scratch.
    """
    geometry, _, lights, _, _ = scene
    point, ng, ns, _ = hit
    clear(irradiance)
    for sample in range(samples):
        u, v = sobol_2d(index * np.uint64(samples) + np.uint64(sample), keys[LIGHT])
        emitter, weight, place, direction = sample_direct(
            geometry, lights, point, ng, ns, u, v, samples, gathers
        )
        if weight > 0.0:
            add_emitted(irradiance, DIRECT, lights, emitter, place, direction, weight)
    found = 0
    for ray in range(gathers):
        place = index * np.uint64(gathers) + np.uint64(ray)
        found |= gather(
            scene, store, caustics, hit, place, keys[GATHER], samples, gathers, throughput,
            irradiance,
        )  # fmt: skip
    if caustics is not None:
        throughput[:] = 1.0
        add_caustics(caustics, point, ng, throughput, irradiance, CAUSTIC)
    return found
