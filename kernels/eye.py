"""The camera pass: first hits, direct light, and gather rays into the irradiance store."""

import numpy as np

from photonmap.kernels.bands import add_row, clear
from photonmap.kernels.film import FLAT, morton, note_hit
from photonmap.kernels.gather import gather
from photonmap.kernels.jit import jit
from photonmap.kernels.light import sample_direct
from photonmap.kernels.pixel import reflect, see, start_pixel
from photonmap.kernels.records import DIRECT
from photonmap.kernels.rng import sobol_2d, stream

FILM, LIGHT = 0, 1


@jit
def _light_and_gather(scene, store, hit, index, samples, gathers, keys, throughput, irradiance):
    """Estimate the irradiance, (2, N), of one hit; return what gather rays found."""
    geometry, _, lights = scene
    point, ng, ns, _ = hit
    clear(irradiance)
    for sample in range(samples):
        u, v = sobol_2d(index * np.uint64(samples) + np.uint64(sample), keys[LIGHT])
        emitter, weight = sample_direct(geometry, lights, point, ng, ns, u, v, samples, gathers)
        if weight > 0.0:
            add_row(irradiance, DIRECT, lights.spectra, lights.spectrum[emitter], weight)
    found = 0
    for ray in range(gathers):
        place = index * np.uint64(gathers) + np.uint64(ray)
        found |= gather(
            scene, store, hit, place, keys[2:], samples, gathers, throughput, irradiance
        )
    return found


@jit
def _render_pixel(scene, store, camera, film, plan, keys, pixel, throughput, irradiance, pixels):
    """Add all samples of one pixel to `pixels`."""
    geometry, materials, lights = scene
    samples, lights_each = int(plan.samples[pixel]), int(plan.lights[pixel])
    gathers = int(plan.gathers[pixel])
    share = np.float32(1.0 / samples)
    base = morton(pixel % film.width, pixel // film.width) * np.uint64(samples)
    for sample in range(samples):
        index = base + np.uint64(sample)
        x, y = sobol_2d(index, keys[FILM]) if film.jitter else (0.5, 0.5)
        first = pixels.coverage[pixel] == 0.0
        triangle, hit = see(geometry, lights, camera, film, pixel, x, y, share, pixels)
        if triangle < 0:
            continue
        note_hit(pixels.plane, pixel, first, hit[0], hit[2])
        pixels.found[pixel] |= _light_and_gather(
            scene, store, hit, index, lights_each, gathers, keys, throughput, irradiance
        )
        reflect(materials, geometry.material[triangle], share, pixel, irradiance, pixels)
    if pixels.coverage[pixel] < 1.0:
        pixels.plane[pixel, FLAT] = 0.0


@jit
def camera_pass(scene, store, camera, film, plan, key, first, last, scratch, pixels):
    """Render pixels first..last of one pass.

    scene = (Geometry, Materials, Lights), store = (Cells, radiosity (cells, N) float32),
    scratch = (throughput (N,), irradiance (2, N)) float32.
    """
    keys = (stream(key, 0, 0), stream(key, 1, 0), stream(key, 2, 0), stream(key, 3, 0))
    throughput, irradiance = scratch
    for pixel in range(first, last):
        start_pixel(pixels, pixel)
        _render_pixel(scene, store, camera, film, plan, keys, pixel, throughput, irradiance, pixels)
