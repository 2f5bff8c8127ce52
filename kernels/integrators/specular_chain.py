"""Specular chains: the one step by which paths, gather rays and camera rays follow them.

Functions take the specular record as an argument of its own, None in a scene without mirrors and
glass: then none of this is compiled.
"""

import math

import numpy as np

from photonmap.kernels.bsdf.specular import LONGEST_CHAIN, choose_lobe, scatter_specular
from photonmap.kernels.core.bands import largest
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import Hit
from photonmap.kernels.core.rng import draw
from photonmap.kernels.core.roulette import russian_roulette
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.lights.emission import add_attenuated, emission_of, visible_emitter

CERTAIN_STEPS = 4
"""Specular scatterings of a chain before Russian roulette begins."""


@jit
def specular_step(scene, specular, hit, direction, step, before, state, throughput):
    """Scatter at a specular surface, and go on to the next hit.

    From `CERTAIN_STEPS` on, Russian roulette is played against the throughput `before` the chain.
    Returns (whether the path goes on, hit, direction, state).
    """
    xi, state = draw(state)
    origin, direction = scatter_specular(
        scene.geometry, specular, hit, direction, xi, False, throughput
    )
    if step >= CERTAIN_STEPS:
        alive, state = russian_roulette(before, largest(throughput), state, throughput)
        if not alive:
            return False, hit, direction, state
    return True, intersect(scene.geometry, origin, direction), direction, state


@jit
def add_visible_emission(scene, hit, direction, throughput, factor, target, row):
    """Add the emission at a ray's end, times factor · throughput, to a row of target."""
    geometry, lights = scene.geometry, scene.lights
    emitter, position = visible_emitter(geometry, lights, hit, direction)
    if emitter >= 0:
        emission = emission_of(lights, emitter, position)
        add_attenuated(target, row, lights, emission, throughput, factor)


@jit
def follow_specular_chain(scene, specular, hit, direction, row, state, scratch):
    """Follow a path from a hit along specular surfaces, until it takes another lobe.

    Emission on the way is added to row `row` of `scratch.irradiance`, unless it is -1. Returns
    (hit, direction, state); the hit's triangle is -1 where the path ends.
    """
    if specular is None:
        return hit, direction, state
    throughput = scratch.throughput
    before = largest(throughput)
    for step in range(LONGEST_CHAIN):
        probability = specular.probability[scene.geometry.material[hit.triangle]]
        is_specular, state = choose_lobe(probability, state, throughput)
        if not is_specular:
            return hit, direction, state
        alive, hit, direction, state = specular_step(
            scene, specular, hit, direction, step, before, state, throughput
        )
        if not alive:
            break
        if row >= 0:
            add_visible_emission(
                scene, hit, direction, throughput, math.pi, scratch.irradiance, row
            )
        if hit.triangle < 0:
            break
    return Hit(np.int64(-1), hit.u, hit.v, hit.distance), direction, state
