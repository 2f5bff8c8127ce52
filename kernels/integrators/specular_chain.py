"""Specular chains: the one step by which paths, gather rays and camera rays follow them.

Functions take the specular record as an argument of its own, None in a scene without mirrors and
glass: then none of this is compiled.
"""

import math

import numpy as np

from photonmap.kernels.bsdf.absorption import absorb
from photonmap.kernels.bsdf.specular import (
    LONGEST_CHAIN,
    choose_lobe,
    draw_scattering,
    scatter_specular,
)
from photonmap.kernels.core.bands import largest
from photonmap.kernels.core.jit import outlined
from photonmap.kernels.core.passes import SPECULAR, Hit
from photonmap.kernels.core.roulette import russian_roulette
from photonmap.kernels.geometry.opacity import intersect
from photonmap.kernels.integrators.rough_chain import (
    Sink,
    add_chain_emission,
    add_rough_lights,
    draw_light_point,
)

CERTAIN_STEPS = 4
"""Specular scatterings of a chain before Russian roulette begins."""


@outlined
def specular_step(scene, specular, met, numbers, step, before, state, throughput):
    """Scatter at a specular surface, and go on to the next hit.

    `met` is (hit, direction) there, `numbers` are those of `scatter_specular`. From
    `CERTAIN_STEPS` on, Russian roulette is played against the throughput `before` the chain.
    Returns (whether the path goes on, hit, direction, state).
    """
    hit, direction = met
    origin, direction = scatter_specular(
        scene.geometry, specular, hit, direction, numbers, False, throughput
    )
    if step >= CERTAIN_STEPS:
        alive, state = russian_roulette(before, largest(throughput), state, throughput)
        if not alive:
            return False, hit, direction, state
    hit = intersect(scene.geometry, origin, direction)
    absorb(scene.geometry, specular, hit, direction, True, throughput)
    return True, hit, direction, state


@outlined
def follow_specular_chain(scene, specular, hit, direction, row, state, scratch):
    """Follow a path from a hit along specular surfaces, until it takes another lobe.

    Emission on the way, and light samples of rough surfaces, are added to row `row` of
    `scratch.irradiance`, unless it is -1. Returns (hit, direction, state); the hit's triangle is -1
    where the path ends.
    """
    if specular is None:
        return hit, direction, state
    throughput = scratch.throughput
    before = largest(throughput)
    sink = Sink(scratch.irradiance, row, math.pi, throughput)
    absorb(scene.geometry, specular, hit, direction, False, throughput)
    for step in range(LONGEST_CHAIN):
        probability = specular.probability[scene.geometry.material[hit.triangle]]
        is_specular, state = choose_lobe(probability, state, throughput)
        if not is_specular:
            return hit, direction, state
        met = hit, direction
        if row >= 0:
            point, state = draw_light_point(specular.alpha, state)
            state = add_rough_lights(
                scene, specular, specular.alpha, met, point, sink, state, scratch
            )
        numbers, state = draw_scattering(specular.alpha, state)
        alive, hit, direction, state = specular_step(
            scene, specular, met, numbers, step, before, state, throughput
        )
        if not alive:
            break
        scratch.rays[SPECULAR] += 1
        if row >= 0:
            add_chain_emission(scene, specular, met, (hit, direction), sink)
        if hit.triangle < 0:
            break
    return Hit(np.int64(-1), hit.u, hit.v, hit.distance), direction, state
