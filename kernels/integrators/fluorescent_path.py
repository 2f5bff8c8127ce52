"""Paths that come to fluorescent surfaces: what they go on to look for, and what becomes of it.

A path carries a throughput T of N bands, not the N² by which fluorescence would connect them. Where
it comes to a fluorescent surface it looks, with probability p, for what excites that one: it
remembers T and goes on with the importance of each band there, the transpose

    T' = c |F|ᵀ T / p.

With light E' collected so, T' times that of the bands, its bands are in the end

    T c / p · F (E' / T'),

times whatever Russian roulette did to T' on the way. Else it goes on by the surface's own BSDF,
with T / (1 − p). Further fluorescent surfaces on the way nest.
"""

import numpy as np

from photonmap.kernels.bsdf import glossy, models
from photonmap.kernels.bsdf.fluorescence import (
    FLUORESCING,
    add_reradiated,
    fill_transposed,
    fluoresces,
    fluorophore_at,
)
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.core.bands import copy, divide
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import INDIRECT, TRUNCATED
from photonmap.kernels.core.rng import draw

LEAST, MOST = 0.25, 0.75  # Probabilities of looking for what excites a surface
THROUGHPUT, LIGHT, IMPORTANCE = 0, 1, 2
"""Rows of a level: T, what the path had collected before, and T'"""
OPEN, MISSED = 0, 1
"""Of `Levels.state`: how many levels are open, and whether there was no room for one more"""


@jit
def choose_fluorescence(scene, surface, state, scratch):
    """Choose whether a path looks for what excites a surface, and change its throughput.

    Returns (whether it does, the surface, of which paths then look for that, the random state).
    """
    if scene.fluorescence is None:
        return False, surface, state
    if not fluoresces(scene, surface.hit.triangle) or surface.model == glossy.LOBE:
        return False, surface, state
    chosen, state = _open_level(scene, surface, state, scratch)
    if chosen and surface.model != models.LAMBERTIAN:
        surface = models.with_number(surface, FLUORESCING)
    return chosen, surface, state


@outlined
def _open_level(scene, surface, state, scratch):
    """Choose, and open a level if it is to be; return (whether it is, the random state)."""
    levels, throughput, hit = scratch.levels, scratch.throughput, surface.hit
    number = levels.state[OPEN]
    if number == len(levels.row):
        levels.state[MISSED] = 1
        return False, state
    row, concentration = fluorophore_at(scene.geometry, scene.fluorescence, hit)
    level = levels.values[number]
    excited = fill_transposed(scene.fluorescence, row, concentration, throughput, level[IMPORTANCE])
    if excited <= 0.0:
        return False, state
    color, reflected = look_up_material(scene, hit), np.float32(0.0)
    for band in range(len(throughput)):
        reflected += albedo(scene, color, band) * throughput[band]
    probability = min(max(excited / (excited + reflected), LEAST), MOST)
    xi, state = draw(state)
    if xi >= probability:
        divide(throughput, 1.0 - probability)
        return False, state
    levels.state[OPEN] = number + 1
    levels.row[number], levels.factor[number] = row, concentration / probability
    divide(level[IMPORTANCE], probability)
    copy(throughput, level[THROUGHPUT])
    copy(level[IMPORTANCE], throughput)
    copy(scratch.irradiance[INDIRECT], level[LIGHT])
    scratch.irradiance[INDIRECT, :] = 0.0
    return True, state


@jit
def close_levels(scene, scratch):
    """Turn what a path collected behind fluorescent surfaces into what it brings, in row INDIRECT.

    `scratch.throughput` is used up where there are any.
    """
    if scene.fluorescence is None:
        return
    if scratch.levels.state[OPEN] > 0:
        _close_all(scene.fluorescence, scratch)


@outlined
def _close_all(fluorescence, scratch):
    levels, light, sent = scratch.levels, scratch.irradiance[INDIRECT], scratch.throughput
    while levels.state[OPEN] > 0:
        levels.state[OPEN] -= 1
        number = levels.state[OPEN]
        level = levels.values[number]
        for band in range(len(light)):
            importance = level[IMPORTANCE, band]
            light[band] = light[band] / importance if importance > 0.0 else np.float32(0.0)
        sent[:] = 0.0
        add_reradiated(fluorescence, levels.row[number], levels.factor[number], light, sent)
        for band in range(len(light)):
            light[band] = level[LIGHT, band] + level[THROUGHPUT, band] * sent[band]


@jit
def missed_levels(scene, scratch):
    """Return TRUNCATED if a path lacked a level since this was last asked, else 0."""
    if scene.fluorescence is None:
        return 0
    if scratch.levels.state[MISSED] == 0:
        return 0
    scratch.levels.state[MISSED] = 0
    return TRUNCATED
