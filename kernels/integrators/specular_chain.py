"""Light along specular chains: emission that they meet, and light samples of rough surfaces.

Emitters beyond rough metal and glass are found in two ways, weighed against each other: a light
sample on each side of the surface, and the walk of `bsdf.microsurface` that goes on to the next
hit.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import microsurface
from photonmap.kernels.bsdf.dispersion import choose_index, column_of, index_ratio, keep_index
from photonmap.kernels.bsdf.facets import to_local
from photonmap.kernels.bsdf.glass import absorb, multiply_tint, roughness_at, take_glass_fraction
from photonmap.kernels.bsdf.specular import (
    LONGEST_CHAIN,
    arrive_at,
    choose_lobe,
    draw_scattering,
    is_folded,
    metal_of,
    specular_step,
)
from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import largest
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import SPECULAR, Hit, SurfaceInteraction
from photonmap.kernels.core.records import METAL
from photonmap.kernels.core.rng import draw
from photonmap.kernels.core.warp import power_heuristic
from photonmap.kernels.geometry.interaction import offset, point_at
from photonmap.kernels.lights.direct import (
    count_shadow_ray,
    prepare_direct,
    sample_direct,
    sampling_pdf,
)
from photonmap.kernels.lights.emission import add_attenuated, emission_of, visible_emitter


class Sink(NamedTuple):
    """Where light is added, and times what."""

    target: np.ndarray  # (rows, N) float32
    row: int
    factor: float
    throughput: np.ndarray  # of the chain, (N,)


@jit
def is_rough(scene, triangle):
    """Return whether a specular surface is rough."""
    alpha = scene.specular.alpha
    return len(alpha) > 0 and alpha[scene.geometry.material[triangle]] > 0.0


@jit
def _surface_on(geometry, hit, arrival, crossed):
    """Return a rough surface as seen from the side on which light is looked for."""
    sign, side = (-1.0, 1 - arrival.side) if crossed else (1.0, arrival.side)
    ng, ns = vec.scale(arrival.ng, sign), vec.scale(arrival.n, sign)
    point, size = point_at(geometry, hit.triangle, hit.u, hit.v)
    apart = offset(point, size, ng)
    return SurfaceInteraction(apart, point, ng, ns, side, hit, arrival.direction, 0)


@jit
def _local(specular, rough, arrival, direction):
    """Return (wi, wo) of a walk that leaves along `direction`, in the frame of its facets."""
    wi = to_local(rough, vec.scale(arrival.direction, -1.0), arrival.n)
    return wi, to_local(rough, direction, arrival.n)


@jit
def _walk_pdf(scene, met, column, direction):
    """Return about the density (per steradian) with which a walk leaves along a direction."""
    specular = scene.specular
    hit, arrival = met
    rough = roughness_at(scene, hit)
    wi, wo = _local(specular, rough, arrival, direction)
    eta = index_ratio(specular, scene.geometry.material[hit.triangle], arrival, column)
    alpha = specular.anisotropy, rough.along, rough.alpha
    return microsurface.typical_pdf(alpha, eta, wi, wo)


@jit
def _evaluate_walk(scene, met, column, direction, state, scratch):
    """Fill `scratch.response` with the density of a direction, tinted and scaled by refraction."""
    specular = scene.specular
    hit, arrival = met
    material = scene.geometry.material[hit.triangle]
    response, eta = scratch.response, index_ratio(specular, material, arrival, column)
    rough = roughness_at(scene, hit)
    pair = _local(specular, rough, arrival, direction)
    alpha = specular.anisotropy, rough.along, rough.alpha
    metal = metal_of(specular, material)
    state = microsurface.evaluate(alpha, eta, metal, pair, state, scratch.walk, response)
    if pair[1][2] < 0.0:
        factor = microsurface.radiance_factor(eta)
        multiply_tint(scene, hit, factor, response)
    take_glass_fraction(scene.geometry, specular.glass, hit, response)
    return state


@jit
def _choose_index(media, arrival, throughput, state):
    """Choose an index for a light sample where glass disperses; return (choice, state)."""
    if media is None or media.dispersion is None:
        return (0, 1.0), state
    xi, state = draw(state)
    column, probability, _ = choose_index(media, arrival, throughput, xi)
    return (column, probability), state


@outlined
def _add_light_sample(scene, arrived, crossed, point, sink, state, scratch):
    """Add a light sample on one side of a rough surface; return the random state."""
    (hit, arrival), throughput = arrived, sink.throughput
    surface = _surface_on(scene.geometry, hit, arrival, crossed)
    prepare_direct(scene, surface, scratch.emitters)
    sample = sample_direct(scene, surface, scratch.emitters, point[0], point[1])
    count_shadow_ray(sample, scratch.rays)
    if sample.weight <= 0.0 or is_folded(sample.direction, arrival, crossed):
        return state
    weight = sample.weight / vec.dot(surface.ns, sample.direction)
    choice, state = _choose_index(scene.specular.media, arrival, throughput, state)
    if sample.pdf > 0.0:
        own = _walk_pdf(scene, arrived, choice[0], sample.direction)
        weight *= power_heuristic(sample.pdf, own)
    state = _evaluate_walk(scene, arrived, choice[0], sample.direction, state, scratch)
    keep_index(scene.specular.media, arrival, choice, scratch.response)
    for band in range(len(throughput)):
        scratch.response[band] *= throughput[band]
    emission = emission_of(scene.lights, sample.emitter, sample.position)
    weight *= sink.factor
    add_attenuated(sink.target, sink.row, scene.lights, emission, scratch.response, weight)
    return state


@jit
def draw_light_point(alpha, state):
    """Draw the `point` of `add_rough_lights`; nothing is drawn where all is smooth."""
    if len(alpha) == 0:
        return (0.0, 0.0), state
    u, state = draw(state)
    v, state = draw(state)
    return (u, v), state


@jit
def add_rough_lights(scene, arrived, point, sink, state, scratch):
    """Add what emitters send along the chain by a surface, if it is rough, at once.

    `arrived` is (hit, direction) of the ray that meets it, `point` one of the unit square, for the
    light samples of both sides. Returns the random state.
    """
    hit, direction = arrived
    if not is_rough(scene, hit.triangle):
        return state
    met = hit, arrive_at(scene.geometry, hit, direction)
    state = _add_light_sample(scene, met, False, point, sink, state, scratch)
    if scene.specular.kind[scene.geometry.material[hit.triangle]] == METAL:
        return state
    return _add_light_sample(scene, met, True, point, sink, state, scratch)


@outlined
def _weigh_walk(scene, column, before, after, seen):
    """Return the MIS weight of a walk, in the index of `column`, that ends on an emitter."""
    (hit, direction), (end, out) = before, after
    arrival = arrive_at(scene.geometry, hit, direction)
    crossed = vec.dot(out, arrival.ng) < 0.0
    if is_folded(out, arrival, crossed):
        return 1.0
    surface = _surface_on(scene.geometry, hit, arrival, crossed)
    own = _walk_pdf(scene, (hit, arrival), column, out)
    return power_heuristic(own, sampling_pdf(scene, surface, end, seen, out))


@jit
def add_chain_emission(scene, before, after, sink):
    """Add emission that a step meets; `before` and `after` are (hit, direction) of its rays."""
    geometry, lights = scene.geometry, scene.lights
    emitter, position = visible_emitter(geometry, lights, *after)
    if emitter >= 0:
        seen = emitter, position
        weight, emission = 1.0, emission_of(lights, emitter, position)
        if is_rough(scene, before[0].triangle):
            column = column_of(scene.specular.media, sink.throughput)
            weight = _weigh_walk(scene, column, before, after, seen)
        factor = sink.factor * weight
        add_attenuated(sink.target, sink.row, lights, emission, sink.throughput, factor)


@outlined
def follow_specular_chain(scene, hit, direction, row, state, scratch):
    """Follow a path from a hit along specular surfaces, until it takes another lobe.

    Emission on the way, and light samples of rough surfaces, are added to row `row` of
    `scratch.irradiance`, unless it is -1. Returns (hit, direction, state); the hit's triangle is -1
    where the path ends.
    """
    specular = scene.specular
    if specular is None:
        return hit, direction, state
    throughput = scratch.throughput
    before = largest(throughput)
    sink = Sink(scratch.irradiance, row, math.pi, throughput)
    absorb(scene, hit, direction, False, throughput)
    for step in range(LONGEST_CHAIN):
        probability = specular.probability[scene.geometry.material[hit.triangle]]
        is_specular, state = choose_lobe(probability, state, throughput)
        if not is_specular:
            return hit, direction, state
        met = hit, direction
        if row >= 0:
            point, state = draw_light_point(specular.alpha, state)
            state = add_rough_lights(scene, met, point, sink, state, scratch)
        numbers, state = draw_scattering(specular.alpha, state)
        alive, hit, direction, state = specular_step(
            scene, met, numbers, step, before, state, False, throughput
        )
        if not alive:
            break
        scratch.rays[SPECULAR] += 1
        if row >= 0:
            add_chain_emission(scene, met, (hit, direction), sink)
        if hit.triangle < 0:
            break
    return Hit(np.int64(-1), hit.u, hit.v, hit.distance), direction, state
