"""Final gathering: what a cosine-distributed ray from a camera sample sees."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.glass import absorb
from photonmap.kernels.bsdf.specular import (
    LONGEST_CHAIN,
    choose_lobe,
    draw_scattering,
    specular_probability,
    specular_step,
)
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import DIRECT, FOUND, GATHER, SPECULAR, Hit
from photonmap.kernels.core.rng import block_key, sobol_point, stream
from photonmap.kernels.core.streams import split
from photonmap.kernels.geometry.interaction import side_of, surface_interaction
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.integrators.cache_answer import answer, answer_by_cell, may_answer_gather_ray
from photonmap.kernels.integrators.path_walk import follow_path, seen_emitter
from photonmap.kernels.lights.emission import add_emission, emission_of


class LightKeys(NamedTuple):
    """Keys of the random numbers of a surface's light."""

    light: int  # of light samples
    gather: int  # of the directions of gather rays
    path: int  # of paths that go on where the cache cannot answer
    chain: int  # of specular chains that gather rays follow
    glossy: int  # of paths that leave the surface by its own glossy BSDF


@jit
def light_keys(key, uses):
    """Return the keys for five uses of random numbers."""
    return LightKeys(
        split(key, uses[0]),
        split(key, uses[1]),
        split(key, uses[2]),
        split(key, uses[3]),
        split(key, uses[4]),
    )


@jit
def fill_directions(ns, first, key, directions):
    """Fill directions, (3, n), with cosine-distributed ones about ns; as `sobol_block`."""
    key = block_key(first, key)
    for lane in range(directions.shape[1]):
        u, v = sobol_point(first + np.uint64(lane), key)
        x, y, z = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        directions[0, lane], directions[1, lane], directions[2, lane] = x, y, z


@jit
def _add_surface(scene, photon_maps, hit, direction, state, scratch):
    """Add the light of a surface on a chain; return (whether the chain goes on, flags, state)."""
    if models.model_at(scene, hit.triangle) == models.LAMBERTIAN:
        side = side_of(scene.geometry, hit.triangle, direction)
        flags, _, state = answer_by_cell(scene, photon_maps.cache, hit, side, state, scratch)
        return True, flags, state
    surface = models.with_model(scene, surface_interaction(scene.geometry, hit, direction))
    probability = specular_probability(scene, hit.triangle)
    is_specular, state = choose_lobe(probability, state, scratch.throughput)
    if is_specular:
        return True, 0, state
    flags, goes_on, surface, state = answer(scene, photon_maps.cache, surface, state, scratch)
    if goes_on:
        flags |= follow_path(scene, photon_maps, surface, state, scratch)
    return False, flags, state


@outlined
def _gather_specular_chain(scene, photon_maps, hit, direction, weight, state, scratch):
    """Add the light that a gather ray sees via specular surfaces, times weight; return flags."""
    # The cache answers for Lambertian surfaces and the bases of glossy ones; from others, a path
    # goes on. Emitters seen so make caustics, which photons bring.
    throughput, flags = scratch.throughput, 0
    throughput[:] = weight
    absorb(scene, hit, direction, False, throughput)
    for step in range(LONGEST_CHAIN):
        if scene.specular.kind[scene.geometry.material[hit.triangle]] == 0:
            break
        numbers, state = draw_scattering(scene.specular.alpha, state)
        alive, hit, direction, state = specular_step(
            scene, (hit, direction), numbers, step, weight, state, False, throughput
        )
        if not alive:
            break
        scratch.rays[SPECULAR] += 1
        if hit.triangle < 0 or len(photon_maps.cache.cells.divisions) == 0:
            break
        goes_on, found, state = _add_surface(scene, photon_maps, hit, direction, state, scratch)
        flags |= found
        if not goes_on:
            break
    return flags


@jit
def gather(scene, photon_maps, surface, direction, index, budget, keys, scratch):
    """Add what one of `budget.scattered` cosine-distributed rays sees to `scratch.irradiance`.

    Where the ray ends too near for the cache to answer, or on a surface that is not Lambertian, a
    path goes on from there; seldom from a glossy one, for whose base the cache answers. `index`
    numbers the ray. Returns lookup flags, and the ray's hit if its end is Lambertian, without a
    specular part; else the hit's triangle is -1.
    """
    nothing = Hit(np.int64(-1), 0.0, 0.0, 0.0)
    geometry = scene.geometry
    if vec.dot(surface.ng, direction) <= 0.0:
        return 0, nothing
    hit = intersect(geometry, surface.point, direction)
    scratch.rays[GATHER] += 1
    emitter, position, weight = seen_emitter(scene, surface, hit, direction, budget)
    if emitter >= 0:
        emission = emission_of(scene.lights, emitter, position)
        weight *= math.pi / budget.scattered
        add_emission(scratch.irradiance, DIRECT, scene.lights, emission, weight)
    if hit.triangle < 0:
        return 0, nothing
    found, per_ray = 0, np.float32(1.0 / budget.scattered)
    probability = specular_probability(scene, hit.triangle)
    if scene.specular is not None and probability > 0.0:
        state = stream(keys.chain, index, 0)
        found = (
            _gather_specular_chain(scene, photon_maps, hit, direction, per_ray, state, scratch)
            & FOUND
        )
        if probability == 1.0:
            return found, nothing
    end = models.with_model(scene, surface_interaction(geometry, hit, direction))
    scratch.throughput[:] = per_ray
    state, goes_on = stream(keys.path, index, 0), True
    if may_answer_gather_ray(photon_maps.cache, end):
        flags, goes_on, end, state = answer(scene, photon_maps.cache, end, state, scratch)
        found |= flags
    if end.model != models.LAMBERTIAN:
        hit = nothing
    if goes_on:
        found |= follow_path(scene, photon_maps, end, state, scratch)
    return found, hit
