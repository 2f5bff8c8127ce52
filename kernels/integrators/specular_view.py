"""What the camera sees via specular surfaces.

Where all of them are smooth, light keeps its kind: what a mirror shows is emission, direct light,
and so on. Rough ones make light from an emitter direct, as other surfaces do, and all else
indirect.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.fluorescence import fluoresces
from photonmap.kernels.bsdf.glass import absorb
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN, reflected_share, specular_step
from photonmap.kernels.core import passes, streams
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import SampleBudget
from photonmap.kernels.core.records import METAL
from photonmap.kernels.core.rng import sobol_2d, stream
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.film.pixels import fill_reradiated
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

USES = (
    streams.CHAIN_LIGHT,
    streams.CHAIN_GATHER,
    streams.CHAIN_PATH,
    streams.CHAIN_GATHER_CHAIN,
    streams.CHAIN_GLOSSY_PATH,
)
STEP = np.uint64(40)  # Bits of an index below those that number the surfaces along a chain
METAL_CHAINS, GLASS_CHAINS = 4, 2
"""Most chains of a camera sample at rough metal, where one says little, and at rough glass, where
they are longer, with light samples on both sides of all surfaces"""
ALL_LOBES = (0.0, 1.0)
SMOOTH, ONE_ROUGH, FURTHER = 0, 1, 2  # Rough surfaces passed: none, the first just now, or more


class Chain(NamedTuple):
    """One chain of a camera sample."""

    key: int
    index: int  # for low-discrepancy points
    pixel: int
    weight: float  # of the pixel
    budget: SampleBudget  # of each surface that it comes to
    lobes: tuple  # (lowest value, width) of the number that chooses how its first surface scatters


@jit
def _add_radiance(scene, surface, roughness, chain, scratches, via_specular):
    """Add what a surface sends along the chain, whose throughput is `scratches.own.chain`."""
    if via_specular is None:
        return
    color = look_up_material(scene, surface.hit)
    for row in range(passes.CAUSTIC + 1):
        kind = passes.VIA_DIRECT + row if roughness == SMOOTH else passes.VIA_INDIRECT
        for band in range(len(scratches.own.chain)):
            rho = albedo(scene, color, band)
            light = rho * np.float32(INV_PI) * scratches.own.irradiance[row, band]
            if (
                scene.scattering is not None
                and scene.scattering.model[color[0]] != models.LAMBERTIAN
            ):
                light = scratches.scattered.irradiance[row, band]
            via_specular[kind, chain.pixel, band] += (
                chain.weight * scratches.own.chain[band] * light
            )
        if scene.fluorescence is not None and fluoresces(scene, surface.hit.triangle):
            sent = scratches.own.response
            fill_reradiated(scene, surface, scratches, row, scratches.own.walk, sent)
            for band in range(len(sent)):
                via_specular[kind, chain.pixel, band] += (
                    chain.weight * scratches.own.chain[band] * sent[band]
                )


@jit
def _light_of(job, surface, step, chain, state, scratches):
    """Fill the scratches with a surface's light; without a caustic map, by a plain path."""
    if job.photon_maps.caustics is None:
        return trace_irradiance(
            job.scene, job.photon_maps, surface, passes.MAX_BOUNCES, state, scratches
        )
    index, keys = chain.index + (np.uint64(step + 1) << STEP), light_keys(chain.key, USES)
    estimate_irradiance(
        job.scene, job.photon_maps, surface, index, chain.budget, keys, None, scratches
    )
    add_disks(job.scene, job.photon_maps.caustics, surface, scratches)
    return state


@jit
def _point(chain, use, step):
    """Return the point of a step along the chain, stratified over those of a pixel."""
    return sobol_2d(chain.index, stream(chain.key, use, step))


@jit
def _scattering_numbers(alpha, chain, step):
    """Return the numbers of `scatter_specular` for a step along the chain."""
    xi, _ = _point(chain, streams.CHAIN_LOBE, step)
    if step == 0:
        xi = chain.lobes[0] + chain.lobes[1] * xi
    if len(alpha) == 0:
        return xi, 0.0, 0.0
    u, v = _point(chain, streams.CHAIN_FACET, step)
    return xi, u, v


@jit
def _add_lights_of(scene, arrived, to, state, scratches):
    """Add the light samples of a rough surface on the chain; return the random state."""
    # `to` is (the chain, its step, its roughness before, `Estimate.via_specular`).
    chain, step, roughness, via_specular = to
    row = passes.VIA_DIRECT if roughness == SMOOTH else passes.VIA_INDIRECT
    sink = Sink(via_specular[row], chain.pixel, np.float64(chain.weight), scratches.own.chain)
    point = _point(chain, streams.CHAIN_ROUGH_LIGHT, step)
    return add_rough_lights(scene, arrived, point, sink, state, scratches.own)


@jit
def _add_emission(scene, met, roughness, chain, estimate, scratches):
    """Add the emission that a chain meets; `met` are (hit, direction) of its last two rays."""
    target = estimate.pixels.emission
    if roughness != SMOOTH:
        target = estimate.via_specular[
            passes.VIA_DIRECT if roughness == ONE_ROUGH else passes.VIA_INDIRECT
        ]
    sink = Sink(target, chain.pixel, np.float64(chain.weight), scratches.own.chain)
    add_chain_emission(scene, met[0], met[1], sink)


@outlined
def _view_along(job, seen, chain, estimate, scratches):
    """Add all that is seen along one chain."""
    scene, specular = job.scene, job.scene.specular
    hit, direction = seen
    scratches.own.chain[:] = 1.0
    absorb(scene, hit, direction, True, scratches.own.chain)
    state, roughness = stream(streams.split(chain.key, streams.CHAIN_WALK), chain.index, 0), SMOOTH
    for step in range(LONGEST_CHAIN):
        if specular.kind[scene.geometry.material[hit.triangle]] == 0:
            return
        met, to = (hit, direction), (chain, step, roughness, estimate.via_specular)
        if is_rough(scene, hit.triangle):
            state = _add_lights_of(scene, met, to, state, scratches)
        numbers = _scattering_numbers(specular.alpha, chain, step)
        alive, hit, direction, state = specular_step(
            scene, met, numbers, step, np.float32(1.0), state, False, scratches.own.chain
        )
        if not alive:
            return
        scratches.own.rays[passes.SPECULAR] += 1
        if roughness != SMOOTH:
            roughness = FURTHER
        elif is_rough(scene, met[0].triangle):
            roughness = ONE_ROUGH
        _add_emission(scene, (met, (hit, direction)), roughness, chain, estimate, scratches)
        if hit.triangle < 0:
            return
        if specular.probability[scene.geometry.material[hit.triangle]] < 1.0:
            surface = surface_interaction(scene.geometry, hit, direction)
            state = _light_of(job, surface, step, chain, state, scratches)
            _add_radiance(scene, surface, roughness, chain, scratches, estimate.via_specular)
    estimate.pixels.lookups[chain.pixel] |= passes.TRUNCATED


@jit
def _shared(budget, fraction):
    """Return the budget of a chain that has a fraction of the light."""
    gathers = max(int(budget.scattered * fraction + 0.5), 1) if budget.scattered > 0 else 0
    return SampleBudget(max(int(budget.lights * fraction + 0.5), 1), gathers)


@jit
def _view_both(job, seen, reflected, chain, estimate, scratches):
    """Follow what smooth glass reflects, and what it transmits, apart."""
    # Else one sample in 25 would show the lamp that a pane reflects by 4%, at its full brightness.
    key, rest = streams.split(chain.key, streams.CHAIN_REFLECTED), 1.0 - reflected
    for own, fraction, lobes in (
        (key, reflected, (0.0, reflected)),
        (chain.key, rest, (reflected, rest)),
    ):
        budget = _shared(chain.budget, fraction)
        weight = np.float32(chain.weight * fraction)
        part = Chain(own, chain.index, chain.pixel, weight, budget, lobes)
        _view_along(job, seen, part, estimate, scratches)


@jit
def view_specular_chains(job, seen, chain, estimate, scratches):
    """Follow a camera ray on from a specular first hit, and add all that it sees.

    `seen` = (hit, direction) of the ray, `chain` has its weight in the pixel and its budget, which
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
    kind = job.scene.specular.kind[job.scene.geometry.material[seen[0].triangle]]
    most = METAL_CHAINS if kind == METAL else GLASS_CHAINS
    count = min(max(chain.budget.scattered, 1), most)
    key, budget = streams.split(chain.key, streams.CHAIN_ROUGH), _shared(chain.budget, 1.0 / count)
    weight, first = np.float32(chain.weight / count), chain.index * np.uint64(count)
    for number in range(count):
        part = Chain(key, first + np.uint64(number), chain.pixel, weight, budget, ALL_LOBES)
        _view_along(job, seen, part, estimate, scratches)
