"""What the camera sees in mirrors and through glass."""

import numpy as np

from photonmap.kernels.albedo import albedo, paint
from photonmap.kernels.beyond import MOST_SMOOTH, survives
from photonmap.kernels.irradiance import light_and_gather
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import add_emitted_product, emitted
from photonmap.kernels.opaque import hit as first_hit
from photonmap.kernels.optics import leave
from photonmap.kernels.records import (
    CAUSTIC,
    DIRECT,
    INDIRECT,
    SEEN_CAUSTIC,
    SEEN_DIRECT,
    SEEN_INDIRECT,
)
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.surface import meet, side_of
from photonmap.kernels.walk import walk
from photonmap.kernels.warp import INV_PI

CUT = 4
"""Flag of a pixel beside those of `gather`: a chain of smooth surfaces was cut."""
MOST_BOUNCES = 1000


@jit
def _reflect_beyond(materials, textures, color, share, through, pixel, irradiance, seen):
    """Add what a surface seen in smooth ones makes of its irradiance, (3, N)."""
    for band in range(irradiance.shape[1]):
        rho = albedo(materials, textures, color, band) * through[band]
        rho *= share * np.float32(INV_PI)
        seen[SEEN_DIRECT, pixel, band] += rho * irradiance[DIRECT, band]
        seen[SEEN_INDIRECT, pixel, band] += rho * irradiance[INDIRECT, band]
        seen[SEEN_CAUSTIC, pixel, band] += rho * irradiance[CAUSTIC, band]


@outlined
def see_beyond(
    scene, optics, store, caustics, triangle, ray, index, samples, gathers, keys, share, pixel,
    scratch, pixels, seen,
):  # fmt: skip
    """Follow a camera ray on from a smooth first hit, and add all that it sees.

    Lamps go to `pixels.emission`, the light of diffuse surfaces to `seen`. As `light_and_gather`
    otherwise; without a caustic map (None) the surfaces' light is that of plain paths.
    """
    if optics is None:
        return
    geometry, materials, lights, _, textures = scene
    throughput, through, irradiance, _, _ = scratch
    through[:] = 1.0
    u, v, direction = ray
    state = stream(keys[0], 0, index)
    for step in range(MOST_SMOOTH):
        if optics.kind[geometry.material[triangle]] == 0:
            return
        chance, state = draw(state)
        origin, direction = leave(
            geometry, optics, triangle, u, v, direction, chance, False, through
        )
        alive, state = survives(step, np.float32(1.0), state, through)
        if not alive:
            return
        triangle, u, v, _ = first_hit(geometry, origin, direction)
        side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
        emitter = emitted(geometry, lights, triangle, side)
        if emitter >= 0:
            add_emitted_product(
                pixels.emission, pixel, lights, emitter, (u, v), direction, through, share
            )
        if triangle < 0:
            return
        material = geometry.material[triangle]
        if optics.chance[material] < 1.0:
            hit = meet(geometry, triangle, u, v, direction)
            place = index + (np.uint64(step + 1) << np.uint64(40))
            if caustics is None:
                throughput[:] = 1.0
                irradiance[:] = 0.0
                state = walk(
                    scene, store, None, hit, DIRECT, MOST_BOUNCES, state, throughput, irradiance
                )
            else:
                light_and_gather(
                    scene, store, caustics, hit, place, samples, gathers, keys, scratch
                )
            color = paint(geometry, textures, triangle, u, v)
            _reflect_beyond(materials, textures, color, share, through, pixel, irradiance, seen)
    pixels.found[pixel] |= CUT
