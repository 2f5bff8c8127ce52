"""One pixel of a pass: cleared, seen through, and added to."""

import numpy as np

from photonmap.kernels import warp
from photonmap.kernels.bands import add_row
from photonmap.kernels.film import camera_ray
from photonmap.kernels.jit import jit
from photonmap.kernels.light import emitted
from photonmap.kernels.ray import intersect
from photonmap.kernels.records import DIRECT, INDIRECT
from photonmap.kernels.surface import meet, side_of


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
    triangle, u, v, _ = intersect(geometry.scene, camera.origin, direction)
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
    for band in range(irradiance.shape[1]):
        albedo = materials.reflectance[material, band] * share
        direct, indirect = irradiance[DIRECT, band], irradiance[INDIRECT, band]
        pixels.reflectance[pixel, band] += albedo
        pixels.direct[pixel, band] += albedo * direct * np.float32(warp.INV_PI)
        pixels.indirect[pixel, band] += albedo * indirect * np.float32(warp.INV_PI)
        pixels.irradiance_direct[pixel, band] += share * direct
        pixels.irradiance_indirect[pixel, band] += share * indirect
