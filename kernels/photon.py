"""Photons: emitted, traced and added to the store where they are reflected."""

import numpy as np

from photonmap.kernels import vec, warp
from photonmap.kernels.albedo import absorb, paint
from photonmap.kernels.bands import divide
from photonmap.kernels.beyond import largest, smoothness
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.light import emit, start_flux
from photonmap.kernels.opaque import hit
from photonmap.kernels.optics import leave
from photonmap.kernels.rng import draw, sobol_2d, stream
from photonmap.kernels.store import cell_at
from photonmap.kernels.surface import meet

PLACE, AIM, SURVIVE, BOUNCE = 0, 1, 2, 3


@jit
def _pass_smooth(geometry, optics, triangle, u, v, direction, flux, state):
    """Send a photon on from a smooth surface, if it takes the surface for one.

    Returns (whether it did, origin, direction, state); flux of 0 is that of a lost photon.
    """
    if optics is None:
        return False, direction, direction, state
    smooth = smoothness(geometry, optics, triangle)
    if smooth == 0.0:
        return False, direction, direction, state
    if smooth < 1.0:
        chance, state = draw(state)
        if chance >= smooth:
            divide(flux, 1.0 - smooth)
            return False, direction, direction, state
        divide(flux, smooth)
    before = largest(flux)
    chance, state = draw(state)
    origin, direction = leave(geometry, optics, triangle, u, v, direction, chance, True, flux)
    after = largest(flux)
    if after < before:
        chance, state = draw(state)
        divide(flux, after / before if chance * before < after else np.inf)
    return True, origin, direction, state


@jit
def _trace(
    geometry, materials, optics, textures, cells, index, key, origin, direction, flux, bounces,
    radiosity,
):  # fmt: skip
    """Follow one photon until it dies; return (stores, 1 if it was cut at `bounces`)."""
    state = stream(key, SURVIVE, index)
    stores = 0
    for bounce in range(bounces):
        triangle, u, v, _ = hit(geometry, origin, direction)
        if triangle < 0:
            return stores, 0
        passed, origin, direction, state = _pass_smooth(
            geometry, optics, triangle, u, v, direction, flux, state
        )
        if passed:
            if largest(flux) == 0.0:
                return stores, 0
            continue
        origin, ng, ns, side = meet(geometry, triangle, u, v, direction)
        # Veach 1996, "Non-symmetric scattering in light transport algorithms using particle
        # tracing": flux through the geometric surface becomes irradiance about ns; leaving
        # about ng takes up the other two cosines of his adjoint factor.
        factor = max(0.0, -vec.dot(ns, direction)) / max(1e-9, -vec.dot(ng, direction))
        color = paint(geometry, textures, triangle, u, v)
        before, after = absorb(flux, materials, textures, color, factor)
        density = cells.inverse_area[triangle, side]
        cell = cell_at(cells, triangle, side, u, v)
        stores += 1
        for band in range(len(flux)):
            radiosity[cell, band] += flux[band] * density
        if after < before:
            chance, state = draw(state)
            if chance * before >= after:
                return stores, 0
            divide(flux, after / before)
        point = sobol_2d(index, stream(key, BOUNCE, bounce))
        direction = vec.from_frame(warp.cosine_hemisphere(point[0], point[1]), ng)
    return stores, 1


@kernel
def trace_photons(
    geometry, materials, lights, optics, textures, cells, key, first, last, total, bounces, flux,
    radiosity,
):  # fmt: skip
    """Trace photons first..last of `total`, in order, and fill `radiosity`, (cells, N) float32.

    `flux` is scratch, (N,) float32. Returns (stores, photons cut at `bounces`).
    """
    radiosity[:] = 0.0
    stores = cut = 0
    place_key, aim_key = stream(key, PLACE, 0), stream(key, AIM, 0)
    for index in range(first, last):
        place, aim = sobol_2d(index, place_key), sobol_2d(index, aim_key)
        emitter, weight, spot, origin, direction = emit(geometry, lights, place, aim)
        start_flux(flux, lights, emitter, spot, direction, weight / total)
        if largest(flux) == 0.0:
            continue
        counts = _trace(
            geometry,
            materials,
            optics,
            textures,
            cells,
            index,
            key,
            origin,
            direction,
            flux,
            bounces,
            radiosity,
        )
        stores += counts[0]
        cut += counts[1]
    return stores, cut
