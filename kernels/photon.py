"""Photons: emitted, traced and added to the store where they are reflected."""

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.bands import attenuate, divide
from photonmap.kernels.jit import jit
from photonmap.kernels.light import emit
from photonmap.kernels.ray import intersect
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.store import cell_at
from photonmap.kernels.surface import meet

PLACE, AIM, SURVIVE, BOUNCE = 0, 1, 2, 3


@jit
def _trace(geometry, materials, cells, index, key, origin, direction, flux, bounces, radiosity):
    """Follow one photon until it dies; return (stores, 1 if it was cut at `bounces`)."""
    state = stream(key, SURVIVE, index)
    for bounce in range(bounces):
        triangle, u, v, _ = intersect(geometry.scene, origin, direction)
        if triangle < 0:
            return bounce, 0
        origin, ng, ns, side = meet(geometry, triangle, u, v, direction)
        # Veach 1996, "Non-symmetric scattering in light transport algorithms using particle
        # tracing": flux through the geometric surface becomes irradiance about ns; leaving
        # about ng takes up the other two cosines of his adjoint factor.
        factor = max(0.0, -vec.dot(ns, direction)) / max(1e-9, -vec.dot(ng, direction))
        material = geometry.material[triangle]
        before, after = attenuate(flux, materials.reflectance, material, factor)
        density = cells.inverse_area[triangle, side]
        cell = cell_at(cells, triangle, side, u, v)
        for band in range(len(flux)):
            radiosity[cell, band] += flux[band] * density
        if after < before:
            chance, state = draw(state)
            if chance * before >= after:
                return bounce + 1, 0
            divide(flux, after / before)
        point = sobol_2d(index, stream(key, BOUNCE, bounce))
        direction = vec.from_frame(warp.cosine_hemisphere(point[0], point[1]), ng)
    return bounces, 1


@jit
def trace_photons(
    geometry, materials, lights, cells, key, first, last, total, bounces, flux, radiosity
):
    """Trace photons first..last of `total`, in order, and fill `radiosity`, (cells, N) float32.

    `flux` is scratch, (N,) float32. Returns (stores, photons cut at `bounces`).
    """
    radiosity[:] = 0.0
    stores = cut = 0
    place_key, aim_key = stream(key, PLACE, 0), stream(key, AIM, 0)
    for index in range(first, last):
        place, aim = sobol_2d(index, place_key), sobol_2d(index, aim_key)
        emitter, weight, origin, direction = emit(geometry, lights, place, aim)
        spectrum = lights.spectra[lights.spectrum[emitter]]
        for band in range(len(flux)):
            flux[band] = spectrum[band] * np.float32(weight / total)
        counts = _trace(
            geometry, materials, cells, index, key, origin, direction, flux, bounces, radiosity
        )
        stores += counts[0]
        cut += counts[1]
    return stores, cut
