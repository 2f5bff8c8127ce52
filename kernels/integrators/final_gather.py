"""Final gathering: what a cosine-distributed ray from a camera sample sees."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.cache.radiosity_cache import can_look_up, cell_at
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import DIRECT, EMPTY, FOUND, GATHER, INDIRECT, Hit
from photonmap.kernels.core.rng import block_key, sobol_point, stream
from photonmap.kernels.core.streams import split
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.integrators.cached_base import has_base, look_up_base
from photonmap.kernels.integrators.gather_chain import gather_specular_chain
from photonmap.kernels.integrators.path_walk import follow_path, seen_emitter
from photonmap.kernels.lights.emission import add_emission, emission_of


class LightKeys(NamedTuple):
    """Keys of the random numbers of a surface's light."""

    light: int
    """of light samples"""
    gather: int
    """of the directions of gather rays"""
    path: int
    """of paths that go on where the cache cannot answer"""
    chain: int
    """of specular chains that gather rays follow"""
    glossy: int
    """of paths that leave the surface by its own glossy BSDF"""


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
def _add_cell(scene, cache, surface, weight, irradiance):
    """Add a cell's light to row INDIRECT; return FOUND, EMPTY, or 0 if the surface is black."""
    cell = cell_at(cache.cells, surface.hit.triangle, surface.side, surface.hit.u, surface.hit.v)
    weight, light = np.float32(weight), np.float32(0.0)
    for band in range(irradiance.shape[1]):
        irradiance[INDIRECT, band] += weight * cache.radiosity[cell, band]
        light += cache.radiosity[cell, band]
    if light > 0.0:
        return FOUND
    material = scene.geometry.material[surface.hit.triangle]
    for band in range(irradiance.shape[1]):
        if scene.materials.reflectance[material, band] > 0.0:
            return EMPTY
    return 0


@jit
def _answers(cache, followed, end):
    """Return whether the cache answers for the end of a gather ray.

    Not where it is corrected: a path's light sample and next ray cost little there, and what they
    look up counts for less. Nor in clutter, where light differs within a cell, and gather rays see
    what is lit more often than its share of the surface.
    """
    cells, hit = cache.cells, end.hit
    if followed is not None or not can_look_up(cells, end):
        return False
    return not cells.cluttered[cell_at(cells, hit.triangle, end.side, hit.u, hit.v)]


@jit
def _look_up(scene, maps, end, share, state, scratch):
    """Add what the cache holds of a gather ray's end, if it answers.

    Returns (lookup flags, whether a path goes on from there, the surface it goes on from, state).
    """
    cache, is_lambertian = maps.cache, end.model == models.LAMBERTIAN
    if not (is_lambertian or has_base(scene.geometry, scene.scattering, end.hit.triangle)):
        return 0, True, end, state
    if not _answers(cache, cache.followed, end):
        return 0, True, end, state
    if is_lambertian:
        return _add_cell(scene, cache, end, share, scratch.irradiance), False, end, state
    return look_up_base(scene, scene.scattering, cache, end, state, scratch)


@jit
def gather(scene, maps, surface, direction, place, budget, keys, scratch):
    """Add what one of `budget.scattered` cosine-distributed rays sees to `scratch.irradiance`.

    Where the ray ends too near for the cache to answer, or on a surface that is not Lambertian, a
    path goes on from there; seldom from a glossy one, for whose base the cache answers. `place`
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
    found, share = 0, np.float32(1.0 / budget.scattered)
    probability = specular_probability(geometry, scene.specular, hit.triangle)
    if probability > 0.0:
        state = stream(keys.chain, place, 0)
        lit = gather_specular_chain(
            scene, scene.specular, maps, hit, direction, share, state, scratch
        )
        found = FOUND if lit else 0
        if probability == 1.0:
            return found, nothing
    end = surface_interaction(geometry, hit, direction)
    end = models.with_model(geometry, scene.scattering, end)
    scratch.throughput[:] = share
    lit, goes_on, end, state = _look_up(
        scene, maps, end, share, stream(keys.path, place, 0), scratch
    )
    if end.model != models.LAMBERTIAN:
        hit = nothing
    if goes_on:
        lit |= follow_path(scene, maps, end, state, scratch)
    return found | lit, hit
