"""The light of one surface: its irradiance, and what BSDFs other than Lambert's make of it."""

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.caustics.photon_map import add_caustics, scatter_caustics
from photonmap.kernels.core.bands import clear
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import (
    CAUSTIC,
    DIRECT,
    INDIRECT,
    MAX_BOUNCES,
    SampleBudget,
    Scratch,
)
from photonmap.kernels.core.rng import sobol_2d, sobol_block, stream
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.integrators.final_gather import fill_directions, gather
from photonmap.kernels.integrators.irradiance_differences import add_differences
from photonmap.kernels.integrators.path_walk import PathStart, alone, trace_path, weigh_gather
from photonmap.kernels.lights.direct import (
    count_shadow_ray,
    prepare_direct,
    sample_direct,
    weigh_sample,
)
from photonmap.kernels.lights.emission import add_attenuated, add_emission, emission_of

GATHERS_PER_PATH = 2
"""Gather rays of a glossy surface for each path that leaves it in a direction of its own BSDF."""
LEAST_PATHS, LEAST_BARE_PATHS = 8, 16
"""The least number of these paths: with a diffuse base, and without one."""


@jit
def _onto(scratch, irradiance):
    """Return the same scratch with another place for irradiance."""
    return Scratch(
        scratch.throughput, scratch.chain, irradiance, scratch.points, scratch.directions,
        scratch.incident, scratch.scattered, scratch.response, scratch.walk, scratch.emitters,
        scratch.rays, scratch.shifted,
    )  # fmt: skip


@jit
def _model(scene, scattering, surface):
    return models.model_at(scene.geometry, scattering, surface.hit.triangle)


@jit
def _is_broad(scene, scattering, surface):
    """Return whether a BSDF is neither Lambertian nor narrow."""
    model = _model(scene, scattering, surface)
    return model != models.LAMBERTIAN and model not in models.NARROW


@jit
def _paths(scene, scattering, surface, budget):
    """Return how many paths leave a surface by its own narrow BSDF."""
    base = scattering.parameters[scene.geometry.material[surface.hit.triangle], 2]
    least = LEAST_PATHS if base > 0.0 else LEAST_BARE_PATHS
    return max(budget.scattered // GATHERS_PER_PATH, least)


@jit
def _scatter_light(scene, scattering, surface, sample, emission, weight, budget, scratch):
    """Add a light sample to what the surface scatters; its irradiance has the weight given."""
    if scattering is None or _model(scene, scattering, surface) == models.LAMBERTIAN:
        return
    if not _is_broad(scene, scattering, surface):
        own = models.with_model(scene.geometry, scattering, surface)
        paths = _paths(scene, scattering, surface, budget)
        weight = sample.weight * weigh_sample(scene, scattering, own, sample, paths)
    models.evaluate(scene, scattering, surface, sample.direction, scratch.response)
    add_attenuated(scratch.scattered, DIRECT, scene.lights, emission, scratch.response, weight)


@jit
def _add_lights(scene, surface, index, budget, key, scratch):
    """Add all light samples."""
    first = index * np.uint64(budget.lights)
    points, cdf = scratch.points, scratch.emitters
    prepare_direct(scene, surface, cdf)
    for number in range(budget.lights):
        lane = number % points.shape[1]
        if lane == 0:
            sobol_block(first + np.uint64(number), key, points)
        sample = sample_direct(scene, surface, cdf, points[0, lane], points[1, lane], budget.lights)
        count_shadow_ray(sample, scratch.rays)
        if sample.weight > 0.0:
            weight = sample.weight * weigh_sample(scene, None, surface, sample, budget.scattered)
            emission = emission_of(scene.lights, sample.emitter, sample.position)
            add_emission(scratch.irradiance, DIRECT, scene.lights, emission, weight)
            _scatter_light(
                scene, scene.scattering, surface, sample, emission, weight, budget, scratch
            )


@jit
def _leave_to_paths(scene, scattering, surface, direction, budget, scratch):
    """Subtract from `scratch.response` what paths estimate; return the first row it applies to.

    Paths estimate what a narrow BSDF makes of emission, and their share of its lobe. The diffuse
    base stays with the gather rays, so that its noise cancels against that of irradiance.
    """
    if _is_broad(scene, scattering, surface):
        return DIRECT
    own = models.with_model(scene.geometry, scattering, surface)
    paths = _paths(scene, scattering, surface, budget)
    share = weigh_gather(scene, scattering, own, direction, paths, budget.scattered)
    models.evaluate_lobe(scene, scattering, surface, direction, scratch.throughput)
    for band in range(len(scratch.response)):
        scratch.response[band] -= np.float32(share) * scratch.throughput[band]
    return INDIRECT


@jit
def _gather_diffuse(scene, shifts, maps, surface, ray, budget, keys, scratch):
    """Add a gather ray to the irradiance, and to differences, if there are any."""
    direction, place = ray
    if shifts is None:
        return gather(scene, maps, surface, direction, place, budget, keys, scratch)[0]
    clear(scratch.incident)
    onto = _onto(scratch, scratch.incident)
    found, end = gather(scene, maps, surface, direction, place, budget, keys, onto)
    for row in range(scratch.incident.shape[0]):
        for band in range(scratch.incident.shape[1]):
            scratch.irradiance[row, band] += scratch.incident[row, band]
    add_differences(scene, shifts, surface, end, direction, scratch.incident, scratch)
    return found


@jit
def _gather(scene, scattering, maps, surface, ray, budget, keys, scratch):
    """Add a gather ray, (direction, number, shifts), to the irradiance and what is scattered."""
    direction, place, shifts = ray
    if scattering is None or _model(scene, scattering, surface) == models.LAMBERTIAN:
        of_lambert = direction, place
        return _gather_diffuse(scene, shifts, maps, surface, of_lambert, budget, keys, scratch)
    clear(scratch.incident)
    onto = _onto(scratch, scratch.incident)
    found, end = gather(scene, maps, surface, direction, place, budget, keys, onto)
    add_differences(scene, shifts, surface, end, direction, scratch.incident, scratch)
    models.evaluate(scene, scattering, surface, direction, scratch.response)
    first = _leave_to_paths(scene, scattering, surface, direction, budget, scratch)
    for row in range(scratch.incident.shape[0]):
        for band in range(scratch.incident.shape[1]):
            light = scratch.incident[row, band]
            scratch.irradiance[row, band] += light
            if row >= first:
                scratch.scattered[row, band] += scratch.response[band] * light
    return found


@jit
def add_disks(scene, scattering, caustics, surface, scratch):
    """Add what disks of the photon map say of caustics, if there is a map, to a surface's light."""
    if caustics is None:
        return
    scratch.throughput[:] = 1.0
    add_caustics(caustics, surface, scratch.throughput, scratch.irradiance, CAUSTIC)
    if scattering is not None and _model(scene, scattering, surface) != models.LAMBERTIAN:
        scatter_caustics(scene, caustics, surface, 1.0, scratch.scattered, CAUSTIC, scratch)


@jit
def _add_glossy(scene, scattering, maps, surface, index, budget, key, scratch):
    """Add what a narrow BSDF scatters, by paths that leave the surface in directions of its own."""
    if scattering is None or _model(scene, scattering, surface) not in models.NARROW:
        return
    paths = _paths(scene, scattering, surface, budget)
    bounces = MAX_BOUNCES if budget.scattered > 0 else 1
    both = SampleBudget(budget.lights, paths)
    own = models.with_model(scene.geometry, scattering, surface)
    onto = _onto(scratch, scratch.scattered)
    state = stream(key, index, 0)
    first = index * np.uint64(paths)
    for number in range(paths):
        point = sobol_2d(first + np.uint64(number), key)
        start = PathStart(DIRECT, bounces, both, True, budget.scattered, point)
        scratch.throughput[:] = np.float32(INV_PI / paths)
        state = trace_path(scene, maps, own, start, state, onto)


@jit
def estimate_irradiance(scene, maps, surface, index, budget, keys, shifts, scratch):
    """Estimate the light of a surface, without its caustics, by light samples and gather rays.

    Fills `scratch.irradiance`, and where the surface is not Lambertian `scratch.scattered`, the
    radiance that it sends to where the ray came from. `index` numbers the surface for
    low-discrepancy points. What gather rays say of neighbouring pixels goes to `shifts`, or None.
    Returns lookup flags.
    """
    clear(scratch.irradiance)
    clear(scratch.scattered)
    _add_lights(scene, surface, index, budget, keys.light, scratch)
    found = 0
    first = index * np.uint64(budget.scattered)
    directions = scratch.directions
    for number in range(budget.scattered):
        place, lane = first + np.uint64(number), number % directions.shape[1]
        if lane == 0:
            fill_directions(surface.ns, place, keys.gather, directions)
        ray = directions[0, lane], directions[1, lane], directions[2, lane]
        found |= _gather(
            scene, scene.scattering, maps, surface, (ray, place, shifts), budget, keys, scratch
        )
    _add_glossy(scene, scene.scattering, maps, surface, index, budget, keys.glossy, scratch)
    return found


@jit
def _trace_scattered(scene, scattering, maps, surface, bounces, state, scratch):
    """Trace another path for what a surface that is not Lambertian sends to the eye."""
    if scattering is None or _model(scene, scattering, surface) == models.LAMBERTIAN:
        return state
    scratch.throughput[:] = np.float32(INV_PI)
    own = models.with_model(scene.geometry, scattering, surface)
    onto = _onto(scratch, scratch.scattered)
    return trace_path(scene, maps, own, alone(DIRECT, bounces), state, onto)


@jit
def trace_irradiance(scene, maps, surface, bounces, state, scratch):
    """Estimate the light of a surface as `estimate_irradiance` does, by one plain path.

    Returns the random state.
    """
    clear(scratch.irradiance)
    clear(scratch.scattered)
    scratch.throughput[:] = 1.0
    state = trace_path(scene, maps, surface, alone(DIRECT, bounces), state, scratch)
    return _trace_scattered(scene, scene.scattering, maps, surface, bounces, state, scratch)
