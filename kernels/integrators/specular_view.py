"""What the camera sees via specular surfaces.

Where all of them are smooth, light keeps its kind: what a mirror shows is emission, direct light,
and so on. Rough ones make light from an emitter direct, as other surfaces do, and all else
indirect.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.glass import absorb
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN, reflected_share, specular_step
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import (
    CAUSTIC,
    MAX_BOUNCES,
    SPECULAR,
    TRUNCATED,
    VIA_DIRECT,
    VIA_INDIRECT,
    SampleBudget,
)
from photonmap.kernels.core.records import METAL
from photonmap.kernels.core.rng import sobol_2d, stream
from photonmap.kernels.core.streams import (
    CHAIN_FACET,
    CHAIN_GATHER,
    CHAIN_GATHER_CHAIN,
    CHAIN_GLOSSY_PATH,
    CHAIN_LIGHT,
    CHAIN_LOBE,
    CHAIN_PATH,
    CHAIN_REFLECTED,
    CHAIN_ROUGH,
    CHAIN_ROUGH_LIGHT,
    CHAIN_WALK,
    split,
)
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.integrators.final_gather import light_keys
from photonmap.kernels.integrators.irradiance import (
    add_disks,
    estimate_irradiance,
    trace_irradiance,
)
from photonmap.kernels.integrators.specular_chain import (
    Sink,
    add_chain_emission,
    add_rough_lights,
    is_rough,
)

USES = (CHAIN_LIGHT, CHAIN_GATHER, CHAIN_PATH, CHAIN_GATHER_CHAIN, CHAIN_GLOSSY_PATH)
STEP = np.uint64(40)  # Bits of an index below those that number the surfaces along a chain
METAL_CHAINS, GLASS_CHAINS = 4, 2
"""Most chains of a camera sample at rough metal, where one says little, and at rough glass, where
they are longer, with light samples on both sides of all surfaces"""
ALL_LOBES = (0.0, 1.0)
SMOOTH, ONE_ROUGH, FURTHER = 0, 1, 2
"""What a chain has passed: no rough surface, the first one just now, or more since then"""


class Chain(NamedTuple):
    """One chain of a camera sample."""

    key: int
    index: int  # for low-discrepancy points
    pixel: int
    share: float  # of the pixel
    budget: SampleBudget  # of each surface that it comes to
    lobes: tuple  # (lowest value, width) of the number that chooses how its first surface scatters


@jit
def _radiance(scene, color, row, band, scratches):
    """Return the radiance that a surface sends along the chain, of a row of its irradiance."""
    if scene.scattering is not None and scene.scattering.model[color[0]] != models.LAMBERTIAN:
        return scratches.scattered.irradiance[row, band]
    rho = albedo(scene, color, band)
    return rho * np.float32(INV_PI) * scratches.own.irradiance[row, band]


@jit
def _add_radiance(scene, surface, passed, chain, scratches, via_specular):
    """Add what a surface sends along the chain, whose throughput is `scratches.own.chain`."""
    if via_specular is None:
        return
    color = look_up_material(scene, surface.hit)
    for row in range(CAUSTIC + 1):
        kind = VIA_DIRECT + row if passed == SMOOTH else VIA_INDIRECT
        for band in range(len(scratches.own.chain)):
            light = _radiance(scene, color, row, band, scratches)
            via_specular[kind, chain.pixel, band] += chain.share * scratches.own.chain[band] * light


@jit
def _light_of(job, surface, step, chain, state, scratches):
    """Fill the scratches with a surface's light; without a caustic map, by a plain path."""
    if job.maps.caustics is None:
        return trace_irradiance(job.scene, job.maps, surface, MAX_BOUNCES, state, scratches)
    index, keys = chain.index + (np.uint64(step + 1) << STEP), light_keys(chain.key, USES)
    estimate_irradiance(job.scene, job.maps, surface, index, chain.budget, keys, None, scratches)
    add_disks(job.scene, job.maps.caustics, surface, scratches)
    return state


@jit
def _pass(scene, hit, passed):
    """Return what a chain has passed after one more surface."""
    if passed != SMOOTH:
        return FURTHER
    return ONE_ROUGH if is_rough(scene, hit.triangle) else SMOOTH


@jit
def _point(chain, use, step):
    """Return the point of a step along the chain, stratified over those of a pixel."""
    return sobol_2d(chain.index, stream(chain.key, use, step))


@jit
def _scattering_numbers(alpha, chain, step):
    """Return the numbers of `scatter_specular` for a step along the chain."""
    xi, _ = _point(chain, CHAIN_LOBE, step)
    if step == 0:
        xi = chain.lobes[0] + chain.lobes[1] * xi
    if len(alpha) == 0:
        return xi, 0.0, 0.0
    u, v = _point(chain, CHAIN_FACET, step)
    return xi, u, v


@jit
def _add_lights_of(scene, arrived, to, state, scratches):
    """Add the light samples of a rough surface on the chain; return the random state.

    `to` is (the chain, its step, what it has passed before, `Estimate.via_specular`).
    """
    chain, step, passed, via_specular = to
    row = VIA_DIRECT if passed == SMOOTH else VIA_INDIRECT
    sink = Sink(via_specular[row], chain.pixel, np.float64(chain.share), scratches.own.chain)
    point = _point(chain, CHAIN_ROUGH_LIGHT, step)
    return add_rough_lights(scene, arrived, point, sink, state, scratches.own)


@jit
def _add_emission(scene, met, passed, chain, estimate, scratches):
    """Add the emission that a chain meets; `met` are (hit, direction) of its last two rays."""
    target = estimate.pixels.emission
    if passed != SMOOTH:
        target = estimate.via_specular[VIA_DIRECT if passed == ONE_ROUGH else VIA_INDIRECT]
    sink = Sink(target, chain.pixel, np.float64(chain.share), scratches.own.chain)
    add_chain_emission(scene, met[0], met[1], sink)


@outlined
def _view_along(job, seen, chain, estimate, scratches):
    """Add all that is seen along one chain."""
    scene, specular = job.scene, job.scene.specular
    hit, direction = seen
    scratches.own.chain[:] = 1.0
    absorb(scene, hit, direction, True, scratches.own.chain)
    state, passed = stream(split(chain.key, CHAIN_WALK), chain.index, 0), SMOOTH
    for step in range(LONGEST_CHAIN):
        if specular.kind[scene.geometry.material[hit.triangle]] == 0:
            return
        met, to = (hit, direction), (chain, step, passed, estimate.via_specular)
        if is_rough(scene, hit.triangle):
            state = _add_lights_of(scene, met, to, state, scratches)
        numbers = _scattering_numbers(specular.alpha, chain, step)
        alive, hit, direction, state = specular_step(
            scene, met, numbers, step, np.float32(1.0), state, False, scratches.own.chain
        )
        if not alive:
            return
        scratches.own.rays[SPECULAR] += 1
        passed = _pass(scene, met[0], passed)
        rays = met, (hit, direction)
        _add_emission(scene, rays, passed, chain, estimate, scratches)
        if hit.triangle < 0:
            return
        if specular.probability[scene.geometry.material[hit.triangle]] < 1.0:
            surface = surface_interaction(scene.geometry, hit, direction)
            state = _light_of(job, surface, step, chain, state, scratches)
            _add_radiance(scene, surface, passed, chain, scratches, estimate.via_specular)
    estimate.pixels.lookups[chain.pixel] |= TRUNCATED


@jit
def _shared(budget, share):
    """Return the budget of a chain that has a share of the light."""
    gathers = max(int(budget.scattered * share + 0.5), 1) if budget.scattered > 0 else 0
    return SampleBudget(max(int(budget.lights * share + 0.5), 1), gathers)


@jit
def _view_both(job, seen, reflected, chain, estimate, scratches):
    """Follow what smooth glass reflects, and what it transmits, apart.

    Else one sample in 25 would show the lamp that a pane reflects by 4%, at its full brightness.
    """
    key, rest = split(chain.key, CHAIN_REFLECTED), 1.0 - reflected
    for own, share, lobes in (
        (key, reflected, (0.0, reflected)),
        (chain.key, rest, (reflected, rest)),
    ):
        budget = _shared(chain.budget, share)
        weight = np.float32(chain.share * share)
        part = Chain(own, chain.index, chain.pixel, weight, budget, lobes)
        _view_along(job, seen, part, estimate, scratches)


@jit
def _count_chains(scene, triangle, budget):
    """Return how many chains a camera sample of a rough surface sends."""
    is_metal = scene.specular.kind[scene.geometry.material[triangle]] == METAL
    most = METAL_CHAINS if is_metal else GLASS_CHAINS
    return min(max(budget.scattered, 1), most)


@jit
def view_specular_chains(job, seen, chain, estimate, scratches):
    """Follow a camera ray on from a specular first hit, and add all that it sees.

    `seen` = (hit, direction) of the ray, `chain` has its share of the pixel and its budget, which
    glass and rough surfaces split between several. Emission goes to `estimate.pixels.emission`
    while all is smooth, other light to `estimate.via_specular`.
    """
    if job.scene.specular is None:
        return
    if not is_rough(job.scene, seen[0].triangle):
        reflected = reflected_share(job.scene, seen[0], seen[1])
        if 0.0 < reflected < 1.0:
            _view_both(job, seen, reflected, chain, estimate, scratches)
        else:
            _view_along(job, seen, chain, estimate, scratches)
        return
    count = _count_chains(job.scene, seen[0].triangle, chain.budget)
    key, budget = split(chain.key, CHAIN_ROUGH), _shared(chain.budget, 1.0 / count)
    share, first = np.float32(chain.share / count), chain.index * np.uint64(count)
    for number in range(count):
        part = Chain(key, first + np.uint64(number), chain.pixel, share, budget, ALL_LOBES)
        _view_along(job, seen, part, estimate, scratches)
