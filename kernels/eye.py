"""The camera pass: first hits, direct light, and gather rays into the irradiance store."""

import numpy as np
from photonmap.kernels import vec, warp
from photonmap.kernels.film import FLAT, camera_ray, morton, note_hit
from photonmap.kernels.jit import jit
from photonmap.kernels.light import sample_direct, weigh_hit, weigh_miss
from photonmap.kernels.ray import intersect
from photonmap.kernels.rng import sobol_2d, stream
from photonmap.kernels.store import cell_at
from photonmap.kernels.surface import meet, side_of

FILM, LIGHT, GATHER = 0, 1, 2
DIRECT, INDIRECT = 0, 1
EMPTY, FOUND = 1, 2


@jit
def add_row(target, i, source, j, factor):
    """Add factor · row j of source to row i of target, band by band."""
    factor = np.float32(factor)
    for band in range(target.shape[1]):
        target[i, band] += factor * source[j, band]


@jit
def emitted(geometry, lights, triangle, side):
    """Return the row of spectra that a ray's end shows, -1 if it shows none."""
    emitter = lights.dome if triangle < 0 else geometry.emitter[triangle] if side == 0 else -1
    return lights.spectrum[emitter] if emitter >= 0 else -1


@jit
def _look_up(materials, material, radiosity, cell, weight, irradiance):
    """Add a cell's light to `irradiance`, (2, N); return FOUND, EMPTY, or 0 if it is black."""
    add_row(irradiance, INDIRECT, radiosity, cell, weight)
    for band in range(radiosity.shape[1]):
        if radiosity[cell, band] > 0.0:
            return FOUND
    for band in range(radiosity.shape[1]):
        if materials.reflectance[material, band] > 0.0:
            return EMPTY
    return 0


@jit
def _gather(scene, store, point, ng, ns, aim, samples, gathers, irradiance):
    """Add what one of `gathers` cosine-distributed rays sees to `irradiance`, (2, N).

    `samples` light samples are taken from the same point. Returns what it found, as `_look_up`.
    """
    geometry, materials, lights = scene
    cells, radiosity = store
    direction = vec.from_frame(warp.cosine_hemisphere(aim[0], aim[1]), ns)
    if vec.dot(ng, direction) <= 0.0:
        return 0
    triangle, u, v = intersect(geometry.scene, point, direction)
    side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
    spectrum = emitted(geometry, lights, triangle, side)
    if triangle < 0:
        if spectrum >= 0:
            add_row(
                irradiance, DIRECT, lights.spectra, spectrum, weigh_miss(lights, samples, gathers)
            )
        return 0
    if spectrum >= 0:
        hit = meet(geometry, triangle, u, v, direction)[0]
        emitter = geometry.emitter[triangle]
        cosine = vec.dot(ns, direction)
        weight = weigh_hit(
            geometry, lights, emitter, point, hit, direction, cosine, samples, gathers
        )
        add_row(irradiance, DIRECT, lights.spectra, spectrum, weight)
    cell = cell_at(cells, triangle, side, u, v)
    material = geometry.material[triangle]
    return _look_up(materials, material, radiosity, cell, 1.0 / gathers, irradiance)


@jit
def start_pixel(pixels, pixel):
    """Set all of a pixel's sums to 0."""
    pixels.coverage[pixel] = 0.0
    pixels.found[pixel] = 0
    for band in range(pixels.direct.shape[1]):
        pixels.emission[pixel, band] = 0.0
        pixels.direct[pixel, band] = 0.0
        pixels.indirect[pixel, band] = 0.0
        pixels.reflectance[pixel, band] = 0.0
        pixels.irradiance_direct[pixel, band] = 0.0
        pixels.irradiance_indirect[pixel, band] = 0.0


@jit
def see(geometry, lights, camera, film, pixel, x, y, share, pixels):
    """Cast a camera ray, add what it sees emitted; return (triangle, hit as from `meet`)."""
    direction = camera_ray(camera, pixel % film.width + x, pixel // film.width + y)
    triangle, u, v = intersect(geometry.scene, camera.origin, direction)
    side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
    spectrum = emitted(geometry, lights, triangle, side)
    if spectrum >= 0:
        add_row(pixels.emission, pixel, lights.spectra, spectrum, share)
    if triangle < 0:
        return triangle, (camera.origin, direction, direction, 0)
    pixels.coverage[pixel] += share
    return triangle, meet(geometry, triangle, u, v, direction)


@jit
def reflect(materials, material, share, pixel, irradiance, pixels):
    """Add a sample's irradiance, (2, N), and what its material makes of it to a pixel."""
    add_row(pixels.reflectance, pixel, materials.reflectance, material, share)
    add_row(pixels.irradiance_direct, pixel, irradiance, DIRECT, share)
    add_row(pixels.irradiance_indirect, pixel, irradiance, INDIRECT, share)
    for band in range(irradiance.shape[1]):
        albedo = materials.reflectance[material, band] * np.float32(share * warp.INV_PI)
        pixels.direct[pixel, band] += albedo * irradiance[DIRECT, band]
        pixels.indirect[pixel, band] += albedo * irradiance[INDIRECT, band]


@jit
def _light_and_gather(scene, store, hit, index, samples, gathers, keys, irradiance):
    """Estimate the irradiance, (2, N), of one hit; return what gather rays found."""
    geometry, _, lights = scene
    point, ng, ns, _ = hit
    irradiance[:] = 0.0
    for sample in range(samples):
        u, v = sobol_2d(index * np.uint64(samples) + np.uint64(sample), keys[LIGHT])
        emitter, weight = sample_direct(geometry, lights, point, ng, ns, u, v, samples, gathers)
        if weight > 0.0:
            add_row(irradiance, DIRECT, lights.spectra, lights.spectrum[emitter], weight)
    found = 0
    for ray in range(gathers):
        aim = sobol_2d(index * np.uint64(gathers) + np.uint64(ray), keys[GATHER])
        found |= _gather(scene, store, point, ng, ns, aim, samples, gathers, irradiance)
    return found


@jit
def _render_pixel(scene, store, camera, film, plan, keys, pixel, irradiance, pixels):
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
            scene, store, hit, index, lights_each, gathers, keys, irradiance
        )
        reflect(materials, geometry.material[triangle], share, pixel, irradiance, pixels)
    if pixels.coverage[pixel] < 1.0:
        pixels.plane[pixel, FLAT] = 0.0


@jit
def camera_pass(scene, store, camera, film, plan, key, first, last, pixels):
    """Render pixels first..last of one pass.

    scene = (Geometry, Materials, Lights), store = (Cells, radiosity (cells, N) float32).
    """
    keys = (stream(key, FILM, 0), stream(key, LIGHT, 0), stream(key, GATHER, 0))
    irradiance = np.empty((2, pixels.direct.shape[1]), np.float32)
    for pixel in range(first, last):
        start_pixel(pixels, pixel)
        _render_pixel(scene, store, camera, film, plan, keys, pixel, irradiance, pixels)
