"""The plain path tracer: slow, unbiased, over the same scene; the arbiter of all else."""

import numpy as np

from photonmap.kernels.albedo import paint
from photonmap.kernels.bands import clear
from photonmap.kernels.beyond import smoothness
from photonmap.kernels.irradiance import light_keys
from photonmap.kernels.jit import kernel
from photonmap.kernels.mirrors import see_beyond
from photonmap.kernels.pixel import reflect, reflect_caustics, see, start_pixel, start_seen
from photonmap.kernels.records import DIRECT
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.walk import walk

BEYOND = 1


@kernel
def path_pass(
    scene, nothing, camera, film, samples, bounces, key, first, last, scratch, pixels, seen
):
    """Render pixels first..last with `samples` paths each; scene as in `eye.camera_pass`.

    `nothing` is an empty store, `scratch` and `seen` as there.
    """
    geometry, materials, lights, optics, textures = scene
    throughput, _, irradiance, _, _ = scratch
    share = np.float32(1.0 / samples)
    beyond = light_keys(key, BEYOND)
    for pixel in range(first, last):
        start_pixel(pixels, pixel)
        start_seen(seen, pixel)
        state = stream(key, 0, pixel)
        for sample in range(samples):
            x, state = draw(state)
            y, state = draw(state)
            x, y = (x, y) if film.jitter else (0.5, 0.5)
            triangle, hit, ray = see(geometry, lights, camera, film, pixel, x, y, share, pixels)
            if triangle < 0:
                continue
            if smoothness(geometry, optics, triangle) < 1.0:
                throughput[:] = 1.0
                clear(irradiance)
                state = walk(
                    scene, nothing, None, hit, DIRECT, bounces, state, throughput, irradiance
                )
                color = paint(geometry, textures, triangle, ray[0], ray[1])
                reflect(materials, textures, color, share, pixel, irradiance, pixels)
                reflect_caustics(seen, materials, textures, color, share, pixel, irradiance)
            see_beyond(
                scene, optics, nothing, None, triangle, ray,
                np.uint64(pixel) * np.uint64(samples) + np.uint64(sample), 1, 1, beyond,
                share, pixel, scratch, pixels, seen,
            )  # fmt: skip
