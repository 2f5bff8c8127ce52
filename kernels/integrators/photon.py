"""Photon tracing: photons leave emitters and fill the radiosity cache where they are reflected."""

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.fluorescence import reflect_flux
from photonmap.kernels.bsdf.glass import absorb
from photonmap.kernels.bsdf.specular import (
    choose_lobe,
    draw_scattering,
    scatter_specular,
    specular_probability,
)
from photonmap.kernels.cache.exposed_fraction import is_hidden
from photonmap.kernels.cache.radiosity_cache import cell_at, width_of
from photonmap.kernels.core import streams, vec, warp
from photonmap.kernels.core.bands import largest
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.rng import russian_roulette, sobol_2d, stream
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.integrators.cache_answer import fill_base_flux, has_base
from photonmap.kernels.lights.emission import emit_photon


@jit
def _scatter_if_specular(scene, hit, direction, before, flux, state):
    """Send a photon on from a surface if it takes the specular lobe."""
    # `before` is its largest flux over bands, against which Russian roulette is played: the choice
    # of a lobe is no loss, though it divides by a probability. Returns (whether it did, origin,
    # direction, state); a photon of no flux is lost.
    probability = specular_probability(scene, hit.triangle)
    if scene.specular is None or probability == 0.0:
        return False, direction, direction, state
    is_specular, state = choose_lobe(probability, state, flux)
    if not is_specular:
        return False, direction, direction, state
    numbers, state = draw_scattering(scene.specular.alpha, state)
    origin, direction = scatter_specular(scene, hit, direction, numbers, True, flux)
    alive, state = russian_roulette(before, largest(flux), state, flux)
    if not alive:
        flux[:] = 0.0
    return True, origin, direction, state


@jit
def adjoint_factor(surface, direction):
    """Return what turns flux through the geometric surface into irradiance about ns.

    Leaving about ng takes up the other two cosines of the adjoint factor of Veach 1996,
    "Non-symmetric scattering in light transport algorithms using particle tracing".
    """
    return max(0.0, -vec.dot(surface.ns, direction)) / max(1e-9, -vec.dot(surface.ng, direction))


@jit
def _store(scene, cache, surface, point, flux):
    """Add reflected flux to the cell of a surface point; to a crowded one if it goes far.

    Returns how many short rays told that.
    """
    hit, side, cells = surface.hit, surface.side, cache.cells
    density = cells.inverse_area[hit.triangle, side]
    cell = cell_at(cells, hit.triangle, side, hit.u, hit.v)
    is_crowded = cells.crowded.shape[0] > 0 and cells.crowded[cell]
    if is_crowded:
        direction = vec.from_frame(warp.cosine_hemisphere(point[0], point[1]), surface.ng)
        if is_hidden(scene, surface.point, direction, width_of(density)):
            return 1
    for band in range(len(flux)):
        cache.radiosity[cell, band] += flux[band] * density
    return int(is_crowded)


@jit
def _reflect(scene, cache, surface, point, flux, scratch):
    """Reflect a photon that does not take the specular lobe, and add what is kept to its cell."""
    # `point`, of the unit square, chooses the direction. Returns the photon's largest flux over
    # bands, the direction in which it leaves, and short rays that were cast.
    factor = adjoint_factor(surface, surface.arrival)
    surface = models.with_model(scene, surface)
    if scene.scattering is None or surface.model == models.LAMBERTIAN:
        after = reflect_flux(scene, surface.hit, factor, flux, scratch[0])
        short = _store(scene, cache, surface, point, flux)
        direction = vec.from_frame(warp.cosine_hemisphere(point[0], point[1]), surface.ng)
        return after, direction, short
    is_glossy, short = has_base(scene, surface.hit.triangle), 0
    if is_glossy:
        fill_base_flux(scene, surface, factor, flux, scratch[0], scratch[1])
        short = _store(scene, cache, surface, point, scratch[0])
    direction = models.scatter_flux(scene, surface, point, factor, flux, scratch[0], scratch[1])
    if not is_glossy:
        short = _store(scene, cache, surface, point, flux)
    return largest(flux), direction, short


@jit
def _trace(scene, cache, index, key, ray, bounces, flux, scratch):
    """Follow one photon until it is absorbed or leaves the scene."""
    # Returns (cache entries, rays cast, 1 if truncated at `bounces`, short rays cast).
    state, stores, short = stream(streams.split(key, streams.SURVIVAL), index, 0), 0, 0
    bounce_key = streams.split(key, streams.BOUNCE)
    origin, direction = ray
    is_specular = False
    for bounce in range(bounces):
        hit = intersect(scene.geometry, origin, direction)
        if hit.triangle < 0:
            return stores, bounce + 1, 0, short
        absorb(scene, hit, direction, is_specular, flux)
        before = largest(flux)
        is_specular, origin, direction, state = _scatter_if_specular(
            scene, hit, direction, before, flux, state
        )
        if is_specular:
            if largest(flux) == 0.0:
                return stores, bounce + 1, 0, short
            continue
        surface = surface_interaction(scene.geometry, hit, direction)
        point = sobol_2d(index, stream(bounce_key, bounce, 0))
        after, direction, cast = _reflect(scene, cache, surface, point, flux, scratch)
        stores, short = stores + 1, short + cast
        alive, state = russian_roulette(before, after, state, flux)
        if not alive:
            return stores, bounce + 1, 0, short
        origin = surface.point
    return stores, bounces, 1, short


@kernel
def trace_photons(scene, cache, key, span, total, bounces, scratch):
    """Trace photons of a span of `total`, in order, and fill `cache.radiosity`.

    `scratch` is (3, N) float32. Returns (cache entries, rays cast, photons truncated at
    `bounces`, short rays cast from crowded cells).
    """
    cache.radiosity[:] = 0.0
    stores = rays = truncated = short = 0
    flux, rest = scratch[0], scratch[1:]
    position_key, direction_key = (
        streams.split(key, streams.EMIT_POSITION),
        streams.split(key, streams.EMIT_DIRECTION),
    )
    for index in range(span.first, span.last):
        position, towards = sobol_2d(index, position_key), sobol_2d(index, direction_key)
        ray = emit_photon(scene.geometry, scene.lights, position, towards, 1.0 / total, flux)
        if largest(flux) == 0.0:
            continue
        counts = _trace(scene, cache, index, key, ray, bounces, flux, rest)
        stores += counts[0]
        rays += counts[1]
        truncated += counts[2]
        short += counts[3]
    return stores, rays, truncated, short
