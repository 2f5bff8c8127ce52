"""What the camera sees via specular surfaces."""

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.bsdf.specular import LONGEST_CHAIN
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import CAUSTIC, MAX_BOUNCES, TRUNCATED, VIA_DIRECT
from photonmap.kernels.core.rng import stream
from photonmap.kernels.core.streams import (
    CHAIN_GATHER,
    CHAIN_GATHER_CHAIN,
    CHAIN_GLOSSY_PATH,
    CHAIN_LIGHT,
    CHAIN_PATH,
    CHAIN_WALK,
    split,
)
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.integrators.final_gather import light_keys
from photonmap.kernels.integrators.irradiance import estimate_irradiance, trace_irradiance
from photonmap.kernels.integrators.specular_chain import add_visible_emission, specular_step

USES = (CHAIN_LIGHT, CHAIN_GATHER, CHAIN_PATH, CHAIN_GATHER_CHAIN, CHAIN_GLOSSY_PATH)
STEP = np.uint64(40)
"""Bits of an index below those that number the surfaces along a chain."""


@jit
def _radiance(scene, scattering, color, row, band, scratch):
    """Return the radiance that a surface sends along the chain, of a row of its irradiance."""
    if scattering is not None and scattering.model[color[0]] != models.LAMBERTIAN:
        return scratch.scattered[row, band]
    rho = albedo(scene.materials, scene.textures, color, band)
    return rho * np.float32(INV_PI) * scratch.irradiance[row, band]


@jit
def _add_radiance(scene, surface, share, pixel, scratch, via_specular):
    """Add what a surface sends along the chain, whose throughput is `scratch.chain`."""
    if via_specular is None:
        return
    color = look_up_material(scene.geometry, scene.textures, surface.hit)
    for row in range(CAUSTIC + 1):
        for band in range(len(scratch.chain)):
            light = _radiance(scene, scene.scattering, color, row, band, scratch)
            via_specular[VIA_DIRECT + row, pixel, band] += share * scratch.chain[band] * light


@jit
def _light_of(job, caustics, surface, index, budget, state, scratch):
    """Fill the scratch with a surface's light; without a caustic map, by a plain path."""
    if caustics is None:
        return trace_irradiance(job.scene, job.maps, surface, MAX_BOUNCES, state, scratch)
    keys = light_keys(job.key, USES)
    estimate_irradiance(job.scene, job.maps, surface, index, budget, keys, scratch)
    return state


@jit
def view_specular_chain(job, specular, seen, index, sample, budget, estimate, scratch):
    """Follow a camera ray on from a specular first hit, and add all that it sees.

    `seen` = (hit, direction) of the ray, `sample` = (pixel, share of it). Emission goes to
    `estimate.pixels.emission`, other light to `estimate.via_specular`.
    """
    if specular is None:
        return
    scene = job.scene
    (hit, direction), (pixel, share) = seen, sample
    scratch.chain[:] = 1.0
    state = stream(split(job.key, CHAIN_WALK), index, 0)
    for step in range(LONGEST_CHAIN):
        if specular.kind[scene.geometry.material[hit.triangle]] == 0:
            return
        alive, hit, direction, state = specular_step(
            scene, specular, hit, direction, step, np.float32(1.0), state, scratch.chain
        )
        if not alive:
            return
        add_visible_emission(
            scene, hit, direction, scratch.chain, share, estimate.pixels.emission, pixel
        )
        if hit.triangle < 0:
            return
        if specular.probability[scene.geometry.material[hit.triangle]] < 1.0:
            surface = surface_interaction(scene.geometry, hit, direction)
            place = index + (np.uint64(step + 1) << STEP)
            state = _light_of(job, job.maps.caustics, surface, place, budget, state, scratch)
            _add_radiance(scene, surface, share, pixel, scratch, estimate.via_specular)
    estimate.pixels.lookups[pixel] |= TRUNCATED
