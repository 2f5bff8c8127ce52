"""The camera pass: first hits, direct light, and gather rays into the irradiance store."""

import numpy as np

from photonmap.kernels.albedo import paint
from photonmap.kernels.beyond import smoothness
from photonmap.kernels.film import FLAT, morton, note_hit
from photonmap.kernels.irradiance import light_and_gather, light_keys
from photonmap.kernels.jit import kernel
from photonmap.kernels.mirrors import see_beyond
from photonmap.kernels.pixel import reflect, reflect_caustics, see, start_pixel, start_seen
from photonmap.kernels.rng import sobol_2d, stream

FILM, FIRST_HIT, BEYOND = 0, 1, 5


@kernel
def camera_pass(
    scene, store, caustics, camera, film, plan, key, first, last, scratch, pixels, seen
):
    """Render pixels first..last of one pass.

    scene = (Geometry, Materials, Lights, Optics, Textures), store = (Cells, radiosity (cells, N)
    float32). Optics, caustics and seen are None in a scene without smooth surfaces, Textures
    without any.
    """
    geometry, materials, lights, optics, textures = scene
    film_key = stream(key, FILM, 0)
    light, beyond = light_keys(key, FIRST_HIT), light_keys(key, BEYOND)
    for pixel in range(first, last):
        start_pixel(pixels, pixel)
        start_seen(seen, pixel)
        samples, lights_each = int(plan.samples[pixel]), int(plan.lights[pixel])
        gathers = int(plan.gathers[pixel])
        share = np.float32(1.0 / samples)
        base = morton(pixel % film.width, pixel // film.width) * np.uint64(samples)
        for sample in range(samples):
            index = base + np.uint64(sample)
            x, y = sobol_2d(index, film_key) if film.jitter else (0.5, 0.5)
            is_first = pixels.coverage[pixel] == 0.0
            triangle, hit, ray = see(geometry, lights, camera, film, pixel, x, y, share, pixels)
            if triangle < 0:
                continue
            note_hit(pixels.plane, pixel, is_first, hit[0], hit[2])
            if smoothness(geometry, optics, triangle) < 1.0:
                pixels.found[pixel] |= light_and_gather(
                    scene, store, caustics, hit, index, lights_each, gathers, light, scratch
                )
                color = paint(geometry, textures, triangle, ray[0], ray[1])
                reflect(materials, textures, color, share, pixel, scratch.irradiance, pixels)
                reflect_caustics(seen, materials, textures, color, share, pixel, scratch.irradiance)
            see_beyond(
                scene, optics, store, caustics, triangle, ray, index, lights_each, gathers,
                beyond, share, pixel, scratch, pixels, seen,
            )  # fmt: skip
        if pixels.coverage[pixel] < 1.0:
            pixels.plane[pixel, FLAT] = 0.0
