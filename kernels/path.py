"""The plain path tracer: slow, unbiased, over the same scene; the arbiter of all else."""

import numpy as np
from photonmap.kernels import vec, warp
from photonmap.kernels.eye import DIRECT, INDIRECT, emitted, reflect, see, start_pixel
from photonmap.kernels.jit import jit
from photonmap.kernels.light import sample_direct, weigh_hit, weigh_miss
from photonmap.kernels.ray import intersect
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.surface import meet, side_of

CERTAIN_BOUNCES = 3


@jit
def _add(irradiance, part, throughput, spectra, row, weight):
    """Add throughput · spectrum · weight to one part of the irradiance, (2, N)."""
    for band in range(len(throughput)):
        irradiance[part, band] += throughput[band] * spectra[row, band] * np.float32(weight)


@jit
def _absorb(materials, material, throughput, bounce, state):
    """Reflect in place and play Russian roulette; return (alive, state)."""
    most = np.float32(0.0)
    for band in range(len(throughput)):
        throughput[band] *= materials.reflectance[material, band]
        most = max(most, throughput[band])
    if bounce < CERTAIN_BOUNCES or most >= 1.0:
        return most > 0.0, state
    chance, state = draw(state)
    for band in range(len(throughput)):
        throughput[band] /= most
    return chance < most, state


@jit
def _follow(scene, hit, bounces, state, throughput, irradiance):
    """Estimate the irradiance, (2, N), at a hit by one path; return the random state."""
    geometry, materials, lights = scene
    point, ng, ns, _ = hit
    throughput[:] = 1.0
    irradiance[:] = 0.0
    part = DIRECT
    for bounce in range(bounces):
        u, state = draw(state)
        v, state = draw(state)
        emitter, weight = sample_direct(geometry, lights, point, ng, ns, u, v, 1, 1)
        if weight > 0.0:
            row = lights.spectrum[emitter]
            _add(irradiance, part, throughput, lights.spectra, row, weight)
        u, state = draw(state)
        v, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        if vec.dot(ng, direction) <= 0.0:
            break
        triangle, u, v = intersect(geometry.scene, point, direction)
        side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
        row = emitted(geometry, lights, triangle, side)
        if triangle < 0:
            if row >= 0:
                weight = weigh_miss(lights, 1, 1)
                _add(irradiance, part, throughput, lights.spectra, row, weight)
            break
        origin, cosine = point, vec.dot(ns, direction)
        point, ng, ns, side = meet(geometry, triangle, u, v, direction)
        if row >= 0:
            emitter = geometry.emitter[triangle]
            weight = weigh_hit(geometry, lights, emitter, origin, point, direction, cosine, 1, 1)
            _add(irradiance, part, throughput, lights.spectra, row, weight)
        part = INDIRECT
        alive, state = _absorb(materials, geometry.material[triangle], throughput, bounce, state)
        if not alive:
            break
    return state


@jit
def path_pass(scene, camera, film, samples, bounces, key, first, last, pixels):
    """Render pixels first..last with `samples` paths each; scene as in `eye.camera_pass`."""
    geometry, materials, lights = scene
    bands = pixels.direct.shape[1]
    irradiance, throughput = np.empty((2, bands), np.float32), np.empty(bands, np.float32)
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
                state = _follow(scene, hit, bounces, state, throughput, irradiance)
                material = geometry.material[triangle]
                reflect(materials, material, share, pixel, irradiance, pixels)
