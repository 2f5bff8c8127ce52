"""Paths from surface to surface, ended by the radiosity cache where it can answer."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import lambert, models
from photonmap.kernels.bsdf.material import look_up_material, multiply_albedo
from photonmap.kernels.caustics.photon_map import add_caustics
from photonmap.kernels.core import passes, vec
from photonmap.kernels.core.bands import copy, largest, total
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import Hit, SampleBudget
from photonmap.kernels.core.rng import draw, russian_roulette
from photonmap.kernels.core.warp import power_heuristic
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.integrators.cache_answer import answer, may_answer
from photonmap.kernels.integrators.fluorescent_path import choose_fluorescence, close_levels
from photonmap.kernels.integrators.specular_chain import follow_specular_chain
from photonmap.kernels.lights.direct import (
    count_shadow_ray,
    prepare_direct,
    sample_direct,
    weigh_hit,
    weigh_sample,
)
from photonmap.kernels.lights.emission import add_attenuated, emission_of, visible_emitter

CERTAIN_BOUNCES = 3  # Bounces before Russian roulette begins
ONE = SampleBudget(1, 1)
SMALLEST = np.float32(1e-20)  # Smallest value of a BSDF used as a divisor


class PathStart(NamedTuple):
    """Where what a path brings is added, and how long it may become."""

    row: int  # of the irradiance, for the first ray and light sample; the rest is INDIRECT
    bounces: int
    budget: SampleBudget  # of the first surface: its light samples, and paths like this one
    skips_light_sample: bool  # whether the light samples of its first surface are taken elsewhere
    gathers: int  # cosine-distributed rays from there that bring its indirect light too; 0 for none
    point: tuple  # of the unit square, for the first direction; used where `skips_light_sample`


@jit
def plain_start(row, bounces):
    """Return the start of a path that takes a light sample of its own."""
    return PathStart(row, bounces, ONE, False, 0, (0.0, 0.0))


@jit
def seen_emitter(scene, surface, hit, direction, budget):
    """Return (emitter or -1, position on it, MIS weight) of what a scattered ray hits."""
    emitter, position = visible_emitter(scene.geometry, scene.lights, hit, direction)
    if emitter < 0:
        return emitter, position, 0.0
    weight = weigh_hit(scene, surface, hit, (emitter, position), direction, budget)
    return emitter, position, weight


@jit
def _attenuate(scene, surface, wi, factor, scratch):
    """Fill `scratch.response` with throughput · factor · BSDF: of Lambert's, throughput has it."""
    response, throughput = scratch.response, scratch.throughput
    if scene.scattering is None or surface.model == models.LAMBERTIAN:
        copy(throughput, response)
        return
    models.evaluate_sought(scene, surface, wi, response, scratch.walk)
    for band in range(len(response)):
        response[band] *= throughput[band] * np.float32(factor)


@jit
def _add_light_sample(scene, surface, row, state, scratch):
    """Add a light sample's irradiance to a row; return the random state."""
    u, state = draw(state)
    v, state = draw(state)
    prepare_direct(scene, surface, scratch.emitters)
    sample = sample_direct(scene, surface, scratch.emitters, u, v)
    count_shadow_ray(sample, scratch.rays)
    if sample.weight > 0.0:
        emission = emission_of(scene.lights, sample.emitter, sample.position)
        weight = sample.weight * weigh_sample(scene, surface, sample, 1)
        _attenuate(scene, surface, sample.direction, math.pi, scratch)
        add_attenuated(scratch.irradiance, row, scene.lights, emission, scratch.response, weight)
    return state


@jit
def weigh_gather(scene, surface, direction, paths, gathers):
    """Return the weight of paths of a surface's own BSDF against cosine-distributed rays."""
    own = paths * models.pdf(scene, surface, direction)
    return power_heuristic(own, gathers * lambert.cosine_pdf(surface, direction))


@jit
def _weigh_path(scene, surface, direction, start, scratch):
    """Weight the path against gather rays, if any, which also estimate the diffuse base."""
    if scene.scattering is None or start.gathers == 0:
        return
    throughput, response = scratch.throughput, scratch.response
    weight = np.float32(
        weigh_gather(scene, surface, direction, start.budget.scattered, start.gathers)
    )
    models.evaluate(scene, surface, direction, response)
    for band in range(len(throughput)):
        throughput[band] *= weight / max(response[band], SMALLEST)
    models.evaluate_lobe(scene, surface, direction, response)
    for band in range(len(throughput)):
        throughput[band] *= response[band]


@jit
def _extend(scene, caustics, surface, start, bounce, state, scratch):
    """Follow a path to its next hit that is not specular; return (hit, direction, state)."""
    # Emission on the way is added. The hit's triangle is -1 where the path ends.
    row = start.row if bounce == 0 else passes.INDIRECT
    budget = start.budget if bounce == 0 else ONE
    u, state = draw(state)
    v, state = draw(state)
    if bounce == 0 and start.skips_light_sample:
        u, v = start.point
    direction = models.sample(scene, surface, u, v)
    lost = Hit(np.int64(-1), 0.0, 0.0, 0.0)
    if vec.dot(surface.ng, direction) <= 0.0:
        return lost, direction, state
    if not _scale_by_bsdf(scene, surface, direction, scratch):
        return lost, direction, state
    hit = intersect(scene.geometry, surface.point, direction)
    scratch.rays[passes.WALK] += 1
    emitter, position, weight = seen_emitter(scene, surface, hit, direction, budget)
    if emitter >= 0:
        emission = emission_of(scene.lights, emitter, position)
        add_attenuated(
            scratch.irradiance, row, scene.lights, emission, scratch.throughput, math.pi * weight
        )
    if hit.triangle < 0:
        return lost, direction, state
    if bounce == 0:
        _weigh_path(scene, surface, direction, start, scratch)
    chain_row = -1  # photons bring what emitters send via specular surfaces
    if caustics is None:
        chain_row = passes.CAUSTIC if bounce == 0 else passes.INDIRECT
    return follow_specular_chain(scene, hit, direction, chain_row, state, scratch)


@jit
def _scale_by_bsdf(scene, surface, direction, scratch):
    """Multiply throughput by BSDF · cosine / pdf, unless the surface is Lambertian."""
    # Returns whether light can come from there.
    if scene.scattering is None or surface.model == models.LAMBERTIAN:
        return True
    density = models.pdf(scene, surface, direction)
    if density <= 0.0:
        return False
    cosine = vec.dot(surface.ns, direction)
    _attenuate(scene, surface, direction, cosine / density, scratch)
    copy(scratch.response, scratch.throughput)
    return True


@jit
def _arrive(scene, caustics, surface, state, scratch):
    """Multiply throughput by a Lambertian surface's albedo, and add caustics of the photon map.

    Or by what excites the surface, if it fluoresces and the path looks for that. Returns (the
    surface, of which it may do so, the random state).
    """
    fluoresces, surface, state = choose_fluorescence(scene, surface, state, scratch)
    scatters, target = surface.model != models.LAMBERTIAN, scratch.irradiance
    if scene.scattering is None or not scatters:
        after = np.float32(1.0)
        if not fluoresces:
            color = look_up_material(scene, surface.hit)
            _, after = multiply_albedo(scene, color, 1.0, scratch.throughput)
        if after == 0.0:
            return surface, state
    factor = math.pi if scatters else 1.0
    add_caustics(scene, caustics, surface, scatters, factor, target, passes.INDIRECT, scratch)
    return surface, state


@outlined
def trace_path(scene, photon_maps, surface, start, state, scratch):
    """Add what one path brings to a surface, times throughput, to `scratch.irradiance`.

    Where `surface` is Lambertian that is irradiance; else π times the radiance that its BSDF sends
    to where the ray came from. Light that specular surfaces bring at once goes to row CAUSTIC. With
    an empty cache and no caustic map (None) this is plain path tracing; with them, they answer for
    caustics after the first surface, whose own they leave to the caller. `scratch.throughput` is
    used up; returns the random state.
    """
    throughput, cache, caustics, looks_up = (
        scratch.throughput,
        photon_maps.cache,
        photon_maps.caustics,
        True,
    )
    # Where nearly all gather rays go on as paths, each brings a small part of the light only.
    reference = np.float32(1.0) if cache.followed is None else largest(throughput)
    for bounce in range(start.bounces):
        if bounce > 0 or not start.skips_light_sample:
            row = start.row if bounce == 0 else passes.INDIRECT
            state = _add_light_sample(scene, surface, row, state, scratch)
        hit, direction, state = _extend(scene, caustics, surface, start, bounce, state, scratch)
        if hit.triangle < 0:
            break
        surface = surface_interaction(scene.geometry, hit, direction)
        surface = models.with_model(scene, surface)
        if looks_up and may_answer(cache, surface):
            _, goes_on, surface, state = answer(scene, cache, surface, state, scratch)
            if not goes_on:
                break
            looks_up = cache.followed is None
        surface, state = _arrive(scene, caustics, surface, state, scratch)
        survival = largest(throughput)
        if survival == 0.0:
            break
        if bounce >= CERTAIN_BOUNCES:
            alive, state = russian_roulette(reference, survival, state, throughput)
            if not alive:
                break
    close_levels(scene, scratch)
    return state


@jit
def follow_path(scene, photon_maps, surface, state, scratch):
    """Add what a gather ray sees of a surface for which the cache cannot answer, by one path.

    It is added, times throughput, to row INDIRECT. Returns FOUND, EMPTY, or 0 if the surface is
    black.
    """
    before = total(scratch.irradiance, passes.INDIRECT)
    surface, state = _arrive(scene, photon_maps.caustics, surface, state, scratch)
    if largest(scratch.throughput) == 0.0:
        close_levels(scene, scratch)
        return 0
    trace_path(
        scene,
        photon_maps,
        surface,
        plain_start(passes.INDIRECT, passes.MAX_BOUNCES),
        state,
        scratch,
    )
    return passes.FOUND if total(scratch.irradiance, passes.INDIRECT) > before else passes.EMPTY
