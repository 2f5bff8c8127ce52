"""One pixel of a pass: cleared, seen through, and added to."""

import numpy as np

from photonmap.kernels import warp
from photonmap.kernels.albedo import albedo
from photonmap.kernels.film import camera_ray
from photonmap.kernels.jit import jit
from photonmap.kernels.light import add_emitted, emitted
from photonmap.kernels.opaque import hit
from photonmap.kernels.records import (
    CAUSTIC,
    DIRECT,
    FIRST_CAUSTIC,
    INDIRECT,
    LIT_BY_CAUSTIC,
)
from photonmap.kernels.surface import meet, side_of


@jit
def start_seen(seen, pixel):
    """Set all of a pixel's sums of `seen` to 0, unless it is None."""
    if seen is None:
        return
    for row in range(seen.shape[0]):
        for band in range(seen.shape[2]):
            seen[row, pixel, band] = 0.0


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
    """Cast a camera ray, add what it sees emitted; return (triangle, hit, ray).

    hit is as from `meet`, ray = (u, v, direction): where on the triangle it came, and how.
    """
    direction = camera_ray(camera, pixel % film.width + x, pixel // film.width + y)
    triangle, u, v, _ = hit(geometry, camera.origin, direction)
    side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
    emitter = emitted(geometry, lights, triangle, side)
    if emitter >= 0:
        add_emitted(pixels.emission, pixel, lights, emitter, (u, v), direction, share)
    if triangle < 0:
        return triangle, (camera.origin, direction, direction, 0), (u, v, direction)
    pixels.coverage[pixel] += share
    return triangle, meet(geometry, triangle, u, v, direction), (u, v, direction)


@jit
def reflect_caustics(seen, materials, textures, color, share, pixel, irradiance):
    """Add a first hit's caustics, row CAUSTIC of irradiance, to `seen`, if there is one."""
    if seen is None:
        return
    for band in range(irradiance.shape[1]):
        light = share * irradiance[CAUSTIC, band]
        rho = albedo(materials, textures, color, band)
        seen[LIT_BY_CAUSTIC, pixel, band] += light
        seen[FIRST_CAUSTIC, pixel, band] += rho * light * np.float32(warp.INV_PI)


@jit
def reflect(materials, textures, color, share, pixel, irradiance, pixels):
    """Add a sample's irradiance, (2, N), and what its paint makes of it to a pixel."""
    for band in range(irradiance.shape[1]):
        rho = albedo(materials, textures, color, band) * share
        direct, indirect = irradiance[DIRECT, band], irradiance[INDIRECT, band]
        pixels.reflectance[pixel, band] += rho
        pixels.direct[pixel, band] += rho * direct * np.float32(warp.INV_PI)
        pixels.indirect[pixel, band] += rho * indirect * np.float32(warp.INV_PI)
        pixels.irradiance_direct[pixel, band] += share * direct
        pixels.irradiance_indirect[pixel, band] += share * indirect
