"""Paths from surface to surface, ended by the irradiance store where it can answer."""

from photonmap.kernels import vec, warp
from photonmap.kernels.albedo import absorb, paint
from photonmap.kernels.bands import add_product, divide
from photonmap.kernels.beyond import pass_smooth
from photonmap.kernels.caustics import add_caustics
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.light import (
    add_emitted_product,
    emitted,
    sample_direct,
    weigh_hit,
    weigh_miss,
)
from photonmap.kernels.opaque import hit as first_hit
from photonmap.kernels.records import CAUSTIC, INDIRECT
from photonmap.kernels.rng import draw
from photonmap.kernels.store import answers, cell_at
from photonmap.kernels.surface import meet, side_of

CERTAIN_BOUNCES = 3
"""Before Russian roulette begins."""


@jit
def _row_of_lamps(caustics, bounce):
    """Return the row for lamps seen in smooth surfaces; -1 where photons bring their light."""
    if caustics is None:
        return CAUSTIC if bounce == 0 else INDIRECT
    return -1


@outlined
def walk(scene, store, caustics, hit, part, bounces, state, throughput, irradiance):
    """Add what one path brings to a hit, times throughput, (N,), to `irradiance`, (2, N).

    What the first ray and light sample bring goes to row `part`, the rest is INDIRECT, but what
    smooth surfaces bring at once is CAUSTIC. With an empty store and no `caustics` (None) this is
    plain path tracing; with them, they answer for caustics after the first hit, whose own they
    leave to the caller. `throughput` is used up; returns the random state.
    """
    geometry, materials, lights, optics, textures = scene
    cells, radiosity = store
    point, ng, ns, _ = hit
    for bounce in range(bounces):
        u, state = draw(state)
        v, state = draw(state)
        emitter, weight, place, aim = sample_direct(geometry, lights, point, ng, ns, u, v, 1, 1)
        if weight > 0.0:
            add_emitted_product(irradiance, part, lights, emitter, place, aim, throughput, weight)
        u, state = draw(state)
        v, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        if vec.dot(ng, direction) <= 0.0:
            break
        triangle, u, v, distance = first_hit(geometry, point, direction)
        side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
        emitter = emitted(geometry, lights, triangle, side)
        if triangle < 0:
            if emitter >= 0:
                weight = weigh_miss(geometry, lights, point, ns, direction, 1, 1)
                add_emitted_product(
                    irradiance, part, lights, emitter, (u, v), direction, throughput, weight
                )
            break
        origin = point
        if emitter >= 0:
            point, _, _, _ = meet(geometry, triangle, u, v, direction)
            weight = weigh_hit(geometry, lights, emitter, origin, ns, point, direction, 1, 1)
            add_emitted_product(
                irradiance, part, lights, emitter, (u, v), direction, throughput, weight
            )
        bright = _row_of_lamps(caustics, bounce)
        triangle, u, v, direction, state = pass_smooth(
            geometry, lights, optics, bright, triangle, u, v, direction, state, throughput,
            irradiance,
        )  # fmt: skip
        if triangle < 0:
            break
        point, ng, ns, side = meet(geometry, triangle, u, v, direction)
        part = INDIRECT
        if answers(cells, triangle, side, distance):
            cell = cell_at(cells, triangle, side, u, v)
            add_product(irradiance, part, radiosity, cell, throughput, 1.0)
            break
        color = paint(geometry, textures, triangle, u, v)
        _, survival = absorb(throughput, materials, textures, color, 1.0)
        if survival == 0.0:
            break
        add_caustics(caustics, point, ng, throughput, irradiance, INDIRECT)
        if bounce >= CERTAIN_BOUNCES and survival < 1.0:
            chance, state = draw(state)
            if chance >= survival:
                break
            divide(throughput, survival)
    return state
