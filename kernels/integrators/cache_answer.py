"""What the radiosity cache answers for a surface, and whether a path goes on from there.

Of a Lambertian surface, cells hold all of its light, and a path ends there. In the unbiased mode a
cell is only a control variate (two-level Monte Carlo): where the cache answers C, and a path that
goes on would estimate P, the light is estimated by

    C                   with probability 1 − p,
    C + (P − C) / p     with probability p.

Its mean is that of P, whatever the cache holds: Russian roulette that ends at a good guess, not at
0 (Heinrich 2001, "Multilevel Monte Carlo methods"). The path that goes on looks nothing up again:
one level more would multiply the variance by albedo² / p, which may be above 1.

Of a glossy surface, cells hold the light of the diffuse base. What that sends is, with T the part
of light that passes the lobe,

    T(i) T(o) ρ / (π (1 - ρ b)),

b being what the lobe returns to it (`bsdf.glossy`). It depends on where the light goes by T(o)
alone, so cells hold the rest; and paths go on by the lobe alone, which is most often a small part
of the light. Bases below coats, below sheen and beside glass are left to paths.
"""

import numpy as np

from photonmap.kernels.bsdf import glossy, models
from photonmap.kernels.bsdf.fluorescence import (
    add_reradiated,
    divide_by_taken,
    fill_whole_albedo,
    fluoresces,
    fluorophore_at,
)
from photonmap.kernels.cache.radiosity_cache import can_look_up, cell_at
from photonmap.kernels.core.bands import add_product, divide, total
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import EMPTY, FOUND, INDIRECT
from photonmap.kernels.core.rng import draw
from photonmap.kernels.geometry.interaction import departure

SELDOM = 0.05  # Least probability of going on by the lobe


@jit
def has_base(scene, triangle):
    """Return whether the cache holds the diffuse base of a glossy surface."""
    scattering = scene.scattering
    if scattering is None or scattering.glass is not None:
        return False
    if models.model_at(scene, triangle) != models.GLOSSY:
        return False
    return scattering.parameters[scene.geometry.material[triangle], 2] > 0.0


@jit
def _multiply_to_base(scene, surface, lobe, values):
    """Turn the base's albedos in values, (N,), into what it sends, but for T(o)."""
    glossy.return_to_base(scene.scattering, lobe, values)
    glossy.multiply_transmitted(scene.scattering, lobe, departure(surface), surface.ns, values)


@outlined
def fill_base_flux(scene, surface, factor, flux, values, excited):
    """Fill values, (N,), with what a base makes of a photon's flux but for T(o): for its cell.

    `excited`, (N,), is scratch.
    """
    lobe = glossy.lobe_at(scene.geometry, scene.scattering, surface.hit)
    models.fill_albedo(scene, surface, values)
    _multiply_to_base(scene, surface, lobe, values)
    is_fluorescent = fluoresces(scene, surface.hit.triangle)
    if scene.fluorescence is not None and is_fluorescent:
        fill_whole_albedo(scene, surface.hit, excited)
        _multiply_to_base(scene, surface, lobe, excited)
        divide_by_taken(scene, surface.hit, values, excited)
        for band in range(len(excited)):
            excited[band] *= flux[band]
    for band in range(len(values)):
        values[band] *= np.float32(factor) * flux[band]
    if scene.fluorescence is not None and is_fluorescent:
        row, concentration = fluorophore_at(scene.geometry, scene.fluorescence, surface.hit)
        add_reradiated(scene.fluorescence, row, factor * concentration, excited, values)


@jit
def may_answer(cache, surface):
    """Return whether the cache may answer for the end of a path's ray."""
    if cache.followed is not None and surface.model != models.LAMBERTIAN:
        return False
    return can_look_up(cache.cells, surface)


@jit
def may_answer_gather_ray(cache, surface):
    """Return whether the cache may answer for the end of a gather ray.

    Not where it is corrected: a path's light sample and next ray cost little there, and what they
    look up counts for less. Nor in clutter, where a cell may reach to the other side of a wall.
    """
    if cache.followed is not None or not can_look_up(cache.cells, surface):
        return False
    hit = surface.hit
    return not cache.cells.cluttered[cell_at(cache.cells, hit.triangle, surface.side, hit.u, hit.v)]


@jit
def answer_by_cell(scene, cache, hit, side, state, scratch):
    """Add a Lambertian side's cell, as `answer`; return (flags, whether a path goes on, state)."""
    cell = cell_at(cache.cells, hit.triangle, side, hit.u, hit.v)
    add_product(scratch.irradiance, INDIRECT, cache.radiosity, cell, scratch.throughput, 1.0)
    goes_on, state = _corrects(cache, cell, state, scratch)
    return _flags(scene, cache, hit.triangle, cell), goes_on, state


@jit
def answer(scene, cache, surface, state, scratch):
    """Add what the cache holds of a surface, times throughput, to row INDIRECT.

    Returns (lookup flags, which are 0 where nothing is held or the surface is black; whether a path
    goes on; the surface of which it goes on, by the lobe alone where the base was answered for; the
    random state). Where a path goes on, its throughput was divided by the probability of that.
    """
    if surface.model == models.LAMBERTIAN:
        flags, goes_on, state = answer_by_cell(
            scene, cache, surface.hit, surface.side, state, scratch
        )
        return flags, goes_on, surface, state
    if scene.scattering is None or not has_base(scene, surface.hit.triangle):
        return 0, True, surface, state
    lit, probability = _add_base(scene, cache, surface, scratch)
    flags = FOUND if lit else EMPTY
    xi, state = draw(state)
    if xi >= probability:
        return flags, False, surface, state
    divide(scratch.throughput, probability)
    return flags, True, models.with_number(surface, glossy.LOBE), state


@jit
def _flags(scene, cache, triangle, cell):
    """Return FOUND, EMPTY, or 0 if the surface is black."""
    if total(cache.radiosity, cell) > 0.0:
        return FOUND
    material = scene.geometry.material[triangle]
    is_black = total(scene.materials.reflectance, material) == 0.0
    return 0 if is_black and not fluoresces(scene, triangle) else EMPTY


@jit
def _corrects(cache, cell, state, scratch):
    """Return whether a path goes on from a cell whose C was added, and the random state."""
    # With p = `followed`, throughput T becomes T / p where it does, and C · T / p is taken from row
    # INDIRECT. It never does if `followed` is None.
    followed = cache.followed
    if followed is None:
        return False, state
    xi, state = draw(state)
    if xi >= followed:
        return False, state
    divide(scratch.throughput, followed)
    add_product(scratch.irradiance, INDIRECT, cache.radiosity, cell, scratch.throughput, -1.0)
    return True, state


@outlined
def _add_base(scene, cache, surface, scratch):
    """Add the light of a base, times throughput, to row INDIRECT."""
    # Returns (whether there is any, the probability to go on by the lobe).
    scattering, wo, ns = scene.scattering, departure(surface), surface.ns
    lobe = glossy.lobe_at(scene.geometry, scattering, surface.hit)
    transmitted = scratch.response
    transmitted[:] = np.float32(1.0)
    glossy.multiply_transmitted(scattering, lobe, wo, ns, transmitted)
    hit = surface.hit
    cell = cell_at(cache.cells, hit.triangle, surface.side, hit.u, hit.v)
    for band in range(len(transmitted)):
        transmitted[band] *= scratch.throughput[band]
    add_product(scratch.irradiance, INDIRECT, cache.radiosity, cell, transmitted, 1.0)
    lit = total(cache.radiosity, cell) > 0.0
    return lit, max(glossy.lobe_probability(scattering, lobe, wo, ns), SELDOM)
