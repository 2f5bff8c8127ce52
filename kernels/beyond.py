"""Light that comes by smooth surfaces: paths and gather rays that go on from a mirror or glass.

All take the optics as an argument of their own, None in a scene without smooth surfaces: then
nothing of them is compiled.
"""

import math

import numpy as np

from photonmap.kernels.bands import add_product, divide
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import add_emitted_product, emitted
from photonmap.kernels.opaque import hit
from photonmap.kernels.optics import leave
from photonmap.kernels.records import INDIRECT
from photonmap.kernels.rng import draw
from photonmap.kernels.store import cell_at
from photonmap.kernels.surface import side_of

MOST_SMOOTH = 256
"""Reflections and refractions in a row, after which a path is cut."""
CERTAIN_SMOOTH = 4
"""Of them, before Russian roulette begins."""


@jit
def smoothness(geometry, optics, triangle):
    """Return the chance that a path takes a surface for smooth; 1 if it is nothing else."""
    return 0.0 if optics is None else optics.chance[geometry.material[triangle]]


@jit
def largest(throughput):
    """Return the largest value over bands."""
    most = throughput[0]
    for band in range(1, len(throughput)):
        most = max(most, throughput[band])
    return most


@jit
def survives(step, before, state, throughput):
    """Play Russian roulette against the throughput `before` some reflections: (alive, state)."""
    if step < CERTAIN_SMOOTH:
        return True, state
    if before <= 0.0:
        return False, state
    survival = largest(throughput) / before
    if survival >= 1.0:
        return True, state
    chance, state = draw(state)
    if chance >= survival:
        return False, state
    divide(throughput, survival)
    return True, state


@outlined
def gather_beyond(
    geometry, optics, store, triangle, u, v, direction, weight, state, throughput, irradiance
):
    """Add to `irradiance` what a gather ray sees in a smooth surface: the store's light there.

    Lamps seen so make caustics, which photons bring. Returns whether light was found.
    """
    if optics is None:
        return False
    cells, radiosity = store
    throughput[:] = weight
    found = False
    for step in range(MOST_SMOOTH):
        if optics.kind[geometry.material[triangle]] == 0:
            return found
        chance, state = draw(state)
        origin, direction = leave(
            geometry, optics, triangle, u, v, direction, chance, False, throughput
        )
        alive, state = survives(step, weight, state, throughput)
        if not alive:
            return found
        triangle, u, v, _ = hit(geometry, origin, direction)
        if triangle < 0 or len(cells.divisions) == 0:
            return found
        cell = cell_at(cells, triangle, side_of(geometry, triangle, direction), u, v)
        add_product(irradiance, INDIRECT, radiosity, cell, throughput, 1.0)
        found |= radiosity[cell, 0] > 0.0
    return found


@outlined
def pass_smooth(
    geometry, lights, optics, row, triangle, u, v, direction, state, throughput, irradiance
):
    """Lead a path on from a hit by smooth surfaces, until one is taken for diffuse.

    Lamps on the way are added to row `row` of `irradiance`, unless it is -1. Returns (triangle,
    u, v, direction, state); triangle is -1 where the path ends.
    """
    if optics is None:
        return triangle, u, v, direction, state
    before = largest(throughput)
    for step in range(MOST_SMOOTH):
        smooth = optics.chance[geometry.material[triangle]]
        if smooth < 1.0:
            chance, state = draw(state)
            if chance >= smooth:
                divide(throughput, 1.0 - smooth)
                return triangle, u, v, direction, state
            divide(throughput, smooth)
        chance, state = draw(state)
        origin, direction = leave(
            geometry, optics, triangle, u, v, direction, chance, False, throughput
        )
        alive, state = survives(step, before, state, throughput)
        if not alive:
            break
        triangle, u, v, _ = hit(geometry, origin, direction)
        side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
        emitter = emitted(geometry, lights, triangle, side)
        if row >= 0 and emitter >= 0:
            add_emitted_product(
                irradiance, row, lights, emitter, (u, v), direction, throughput, math.pi
            )
        if triangle < 0:
            break
    return np.int64(-1), u, v, direction, state
