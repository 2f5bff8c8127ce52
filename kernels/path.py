"""The plain path tracer: slow, unbiased, over the same scene; the arbiter of all else."""

import numpy as np

from photonmap.kernels.bands import clear
from photonmap.kernels.jit import jit
from photonmap.kernels.pixel import reflect, see, start_pixel
from photonmap.kernels.records import DIRECT
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.walk import walk


@jit
def path_pass(scene, nothing, camera, film, samples, bounces, key, first, last, scratch, pixels):
    """Render pixels first..last with `samples` paths each; scene as in `eye.camera_pass`.

    `nothing` is an empty store, `scratch` as there.
    """
    geometry, materials, lights = scene
    throughput, irradiance = scratch
    share = np.float32(1.0 / samples)
    for pixel in range(first, last):
        start_pixel(pixels, pixel)
        state = stream(key, 0, pixel)
        for _ in range(samples):
            x, state = draw(state)
            y, state = draw(state)
            x, y = (x, y) if film.jitter else (0.5, 0.5)
            triangle, hit = see(geometry, lights, camera, film, pixel, x, y, share, pixels)
            if triangle >= 0:
                throughput[:] = 1.0
                clear(irradiance)
                state = walk(scene, nothing, hit, DIRECT, bounces, state, throughput, irradiance)
                material = geometry.material[triangle]
                reflect(materials, material, share, pixel, irradiance, pixels)
