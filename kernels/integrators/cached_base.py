"""The diffuse base of glossy surfaces in the radiosity cache.

What the base of a glossy BSDF sends is, with T the part of light that passes the lobe,

    T(i) T(o) ρ / (π (1 - ρ b)),

b being what the lobe returns to it (`bsdf.glossy`). It depends on where the light goes by T(o)
alone, so cells hold the rest, as they hold the radiosity of Lambertian surfaces; and paths go on by
the lobe alone, which is most often a small part of the light. Bases below coats, below sheen and
beside glass are left to paths.
"""

import numpy as np

from photonmap.kernels.bsdf import glossy, glossy_base, models
from photonmap.kernels.cache.radiosity_cache import cell_at
from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import EMPTY, FOUND, INDIRECT, SurfaceInteraction
from photonmap.kernels.core.rng import draw

SELDOM = 0.05
"""Least probability of going on by the lobe."""


@jit
def _is_whole(share):
    return share is None


@jit
def has_base(geometry, scattering, triangle):
    """Return whether the cache holds the diffuse base of a glossy surface."""
    if scattering is None:
        return False
    if not _is_whole(scattering.share):
        return False
    if models.model_at(geometry, scattering, triangle) != models.GLOSSY:
        return False
    return scattering.parameters[geometry.material[triangle], 2] > 0.0


@outlined
def fill_base_flux(scene, scattering, surface, factor, flux, values):
    """Fill values, (N,), with what a base makes of a photon's flux but for T(o): for its cell."""
    maps = scattering.maps
    lobe = glossy.lobe_at(scene.geometry, scattering, maps, surface.hit)
    models.fill_albedo(scene, surface, values)
    glossy_base.return_to_base(scattering, maps, lobe, values)
    glossy_base.pass_lobe(scattering, maps, lobe, models.departure(surface), surface.ns, values)
    for band in range(len(values)):
        values[band] *= np.float32(factor) * flux[band]


@outlined
def _add_base(scene, scattering, cache, surface, scratch):
    """Add the light of a base, times throughput, to row INDIRECT.

    Returns (whether there is any, the probability to go on by the lobe).
    """
    hit, maps, wo = surface.hit, scattering.maps, models.departure(surface)
    lobe = glossy.lobe_at(scene.geometry, scattering, maps, hit)
    passed, irradiance = scratch.response, scratch.irradiance
    passed[:] = np.float32(1.0)
    glossy_base.pass_lobe(scattering, maps, lobe, wo, surface.ns, passed)
    cell = cell_at(cache.cells, hit.triangle, surface.side, hit.u, hit.v)
    light = np.float32(0.0)
    for band in range(len(passed)):
        irradiance[INDIRECT, band] += (
            scratch.throughput[band] * passed[band] * cache.radiosity[cell, band]
        )
        light += cache.radiosity[cell, band]
    return light > 0.0, max(
        glossy_base.share_of_lobe(scattering, maps, lobe, wo, surface.ns), SELDOM
    )


@jit
def look_up_base(scene, scattering, cache, surface, state, scratch):
    """Add what the cache holds of a glossy surface's base; go on, sometimes, by its lobe alone.

    Returns (FOUND or EMPTY, whether the path goes on, the surface of which it goes on, state); the
    throughput is then divided by the probability.
    """
    if scattering is None:
        return 0, True, surface, state
    lit, probability = _add_base(scene, scattering, cache, surface, scratch)
    xi, state = draw(state)
    if xi >= probability:
        return FOUND if lit else EMPTY, False, surface, state
    divide(scratch.throughput, probability)
    point, ng, ns, side, hit, arrival, _ = surface
    surface = SurfaceInteraction(point, ng, ns, side, hit, arrival, np.int64(models.LOBE))
    return FOUND if lit else EMPTY, True, surface, state
