"""Paths from surface to surface, ended by the irradiance store where it can answer."""

from photonmap.kernels import vec, warp
from photonmap.kernels.bands import add_product, attenuate, divide
from photonmap.kernels.jit import outlined
from photonmap.kernels.light import emitted, sample_direct, weigh_hit, weigh_miss
from photonmap.kernels.ray import intersect
from photonmap.kernels.records import INDIRECT
from photonmap.kernels.rng import draw
from photonmap.kernels.store import answers, cell_at
from photonmap.kernels.surface import meet, side_of

CERTAIN_BOUNCES = 3
"""Before Russian roulette begins."""


@outlined
def walk(scene, store, hit, part, bounces, state, throughput, irradiance):
    """Add what one path brings to a hit, times throughput, (N,), to `irradiance`, (2, N).

    What the first ray and light sample bring goes to row `part`, the rest is INDIRECT. With an
    empty store this is plain path tracing. `throughput` is used up; returns the random state.
    """
    geometry, materials, lights = scene
    cells, radiosity = store
    point, ng, ns, _ = hit
    for bounce in range(bounces):
        u, state = draw(state)
        v, state = draw(state)
        emitter, weight = sample_direct(geometry, lights, point, ng, ns, u, v, 1, 1)
        if weight > 0.0:
            row = lights.spectrum[emitter]
            add_product(irradiance, part, lights.spectra, row, throughput, weight)
        u, state = draw(state)
        v, state = draw(state)
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        if vec.dot(ng, direction) <= 0.0:
            break
        triangle, u, v, distance = intersect(geometry.scene, point, direction)
        side = side_of(geometry, triangle, direction) if triangle >= 0 else 0
        row = emitted(geometry, lights, triangle, side)
        if triangle < 0:
            if row >= 0:
                weight = weigh_miss(lights, 1, 1)
                add_product(irradiance, part, lights.spectra, row, throughput, weight)
            break
        origin, cosine = point, vec.dot(ns, direction)
        point, ng, ns, side = meet(geometry, triangle, u, v, direction)
        if row >= 0:
            emitter = geometry.emitter[triangle]
            weight = weigh_hit(geometry, lights, emitter, origin, point, direction, cosine, 1, 1)
            add_product(irradiance, part, lights.spectra, row, throughput, weight)
        part = INDIRECT
        if answers(cells, triangle, side, distance):
            cell = cell_at(cells, triangle, side, u, v)
            add_product(irradiance, part, radiosity, cell, throughput, 1.0)
            break
        material = geometry.material[triangle]
        _, survival = attenuate(throughput, materials.reflectance, material, 1.0)
        if survival == 0.0:
            break
        if bounce >= CERTAIN_BOUNCES and survival < 1.0:
            chance, state = draw(state)
            if chance >= survival:
                break
            divide(throughput, survival)
    return state
