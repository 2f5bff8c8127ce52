"""The light of one surface: its irradiance, and what BSDFs other than Lambert's make of it."""

import numpy as np

from photonmap.kernels.bsdf import models
from photonmap.kernels.bsdf.fluorescence import FLUORESCING, fluoresces
from photonmap.kernels.caustics.photon_map import add_caustics
from photonmap.kernels.core.bands import clear
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import CAUSTIC, DIRECT, INDIRECT, MAX_BOUNCES, SampleBudget
from photonmap.kernels.core.rng import sobol_2d, sobol_block, stream
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.integrators.final_gather import fill_directions, gather
from photonmap.kernels.integrators.irradiance_differences import add_differences
from photonmap.kernels.integrators.path_walk import PathStart, plain_start, trace_path, weigh_gather
from photonmap.kernels.lights.direct import (
    count_shadow_ray,
    prepare_direct,
    sample_emitter,
    weigh_sample,
)
from photonmap.kernels.lights.emission import add_attenuated, add_emission, emission_of
from photonmap.kernels.lights.selection import select_emitter

GATHERS_PER_PATH = 2  # Gather rays of a glossy surface for each path by its own BSDF
LEAST_PATHS, LEAST_BARE_PATHS = 8, 16  # Of these paths: with a diffuse base, and without


@jit
def _clear_light(scratches):
    clear(scratches.own.irradiance)
    clear(scratches.scattered.irradiance)
    clear(scratches.excited.irradiance)


@jit
def _is_narrow(scene, surface):
    return models.model_at(scene, surface.hit.triangle) in models.NARROW


@jit
def _is_lambertian(scene, surface):
    return models.model_at(scene, surface.hit.triangle) == models.LAMBERTIAN


@jit
def _paths(scene, surface, budget):
    """Return how many paths leave a surface by its own narrow BSDF."""
    base = scene.scattering.parameters[scene.geometry.material[surface.hit.triangle], 2]
    least = LEAST_PATHS if base > 0.0 else LEAST_BARE_PATHS
    return max(budget.scattered // GATHERS_PER_PATH, least)


@jit
def _scatter_light(scene, surface, sample, emission, weight, budget, scratches):
    """Add a light sample to what the surface scatters; its irradiance has the weight given."""
    if scene.scattering is None or _is_lambertian(scene, surface):
        return
    response, target = scratches.own.response, scratches.scattered.irradiance
    models.evaluate(scene, surface, sample.direction, response)
    if scene.fluorescence is not None and fluoresces(scene, surface.hit.triangle):
        exciting, excited = scratches.own.walk, scratches.excited.irradiance
        models.fill_excitation(scene, surface, sample.direction, response, exciting)
        add_attenuated(excited, DIRECT, scene.lights, emission, exciting, weight)
    if _is_narrow(scene, surface):
        own = models.with_model(scene, surface)
        paths = _paths(scene, surface, budget)
        weight = sample.weight * weigh_sample(scene, own, sample, paths)
    add_attenuated(target, DIRECT, scene.lights, emission, response, weight)


@jit
def _add_lights(scene, surface, index, budget, key, scratches):
    """Add all light samples; or one of each emitter, by the same point, where they take turns."""
    lights, points, cdf = scene.lights, scratches.own.points, scratches.own.emitters
    count = len(lights.cdf) if lights.in_turn else budget.lights
    first = index if lights.in_turn else index * np.uint64(budget.lights)
    if not lights.in_turn:
        prepare_direct(scene, surface, cdf)
    for number in range(count):
        lane = number % points.shape[1]
        if lane == 0:
            sobol_block(first + np.uint64(number), key, points)
        if lights.in_turn:
            choice, v, share = (number, 1.0, points[0, 0]), points[1, 0], 1
        else:
            choice = select_emitter(lights, surface.point, surface.ns, cdf, points[0, lane])
            v, share = points[1, lane], budget.lights
        sample = sample_emitter(scene, surface, choice, v, share)
        count_shadow_ray(sample, scratches.own.rays)
        if sample.weight > 0.0:
            weight = sample.weight * weigh_sample(scene, surface, sample, budget.scattered)
            emission = emission_of(scene.lights, sample.emitter, sample.position)
            add_emission(scratches.own.irradiance, DIRECT, scene.lights, emission, weight)
            _scatter_light(scene, surface, sample, emission, weight, budget, scratches)


@jit
def _leave_to_paths(scene, surface, direction, budget, scratches):
    """Subtract from the response what paths estimate; return the first row it applies to."""
    # Paths estimate what a narrow BSDF makes of emission, and their part of its lobe, by MIS. The
    # diffuse base stays with the gather rays, so that its noise cancels against that of irradiance.
    if not _is_narrow(scene, surface):
        return DIRECT
    own = models.with_model(scene, surface)
    paths = _paths(scene, surface, budget)
    weight = np.float32(weigh_gather(scene, own, direction, paths, budget.scattered))
    models.evaluate_lobe(scene, surface, direction, scratches.own.throughput)
    for band in range(len(scratches.own.response)):
        scratches.own.response[band] -= weight * scratches.own.throughput[band]
    return INDIRECT


@jit
def _excite(scene, surface, direction, incident, scratches):
    """Add what a gather ray brings, (rows, N), to what excites a surface that is not Lambertian."""
    if scene.fluorescence is None:
        return
    if not fluoresces(scene, surface.hit.triangle):
        return
    exciting, excited = scratches.own.walk, scratches.excited.irradiance
    models.fill_excitation(scene, surface, direction, scratches.own.response, exciting)
    for row in range(incident.shape[0]):
        for band in range(incident.shape[1]):
            excited[row, band] += exciting[band] * incident[row, band]


@jit
def _gather(scene, shifts, photon_maps, surface, ray, budget, keys, scratches):
    """Add a gather ray, (direction, index), to irradiance, differences and what is scattered."""
    direction, index = ray
    if shifts is None and (scene.scattering is None or _is_lambertian(scene, surface)):
        return gather(scene, photon_maps, surface, direction, index, budget, keys, scratches.own)[0]
    own, incident = scratches.own, scratches.incident.irradiance
    clear(incident)
    found, end = gather(
        scene, photon_maps, surface, direction, index, budget, keys, scratches.incident
    )
    add_differences(scene, shifts, surface, end, direction, incident, own)
    first = incident.shape[0]
    if scene.scattering is not None and not _is_lambertian(scene, surface):
        models.evaluate(scene, surface, direction, own.response)
        _excite(scene, surface, direction, incident, scratches)
        first = _leave_to_paths(scene, surface, direction, budget, scratches)
    for row in range(incident.shape[0]):
        for band in range(incident.shape[1]):
            light = incident[row, band]
            own.irradiance[row, band] += light
            if row >= first:
                scratches.scattered.irradiance[row, band] += own.response[band] * light
    return found


@jit
def add_disks(scene, caustics, surface, scratches):
    """Add what disks of the photon map say of caustics, if there is a map, to a surface's light."""
    if caustics is None:
        return
    own, scattered = scratches.own, scratches.scattered.irradiance
    own.throughput[:] = 1.0
    add_caustics(scene, caustics, surface, False, 1.0, own.irradiance, CAUSTIC, own)
    if scene.scattering is not None and not _is_lambertian(scene, surface):
        add_caustics(scene, caustics, surface, True, 1.0, scattered, CAUSTIC, own)
        if scene.fluorescence is not None and fluoresces(scene, surface.hit.triangle):
            sought, excited = models.with_number(surface, FLUORESCING), scratches.excited.irradiance
            add_caustics(scene, caustics, sought, True, 1.0, excited, CAUSTIC, own)


@jit
def _add_glossy(scene, photon_maps, surface, index, budget, key, scratches):
    """Add what a narrow BSDF scatters, by paths that leave the surface in directions of its own."""
    if scene.scattering is None or not _is_narrow(scene, surface):
        return
    paths = _paths(scene, surface, budget)
    bounces = MAX_BOUNCES if budget.scattered > 0 else 1
    both = SampleBudget(budget.lights, paths)
    own = models.with_model(scene, surface)
    state = stream(key, index, 0)
    first = index * np.uint64(paths)
    for number in range(paths):
        point = sobol_2d(first + np.uint64(number), key)
        start = PathStart(DIRECT, bounces, both, True, budget.scattered, point)
        scratches.own.throughput[:] = np.float32(INV_PI / paths)
        state = trace_path(scene, photon_maps, own, start, state, scratches.scattered)


@outlined
def estimate_irradiance(scene, photon_maps, surface, index, budget, keys, shifts, scratches):
    """Estimate the light of a surface, without its caustics, by light samples and gather rays.

    Fills the irradiance of `scratches.own`, and where the surface is not Lambertian that of
    `.scattered`, the radiance that it sends to where the ray came from, and of `.excited`, what
    makes it fluoresce. `index` numbers the surface for low-discrepancy points. What gather rays say
    of neighbouring pixels goes to `shifts`, or None. Returns lookup flags.
    """
    _clear_light(scratches)
    _add_lights(scene, surface, index, budget, keys.light, scratches)
    found = 0
    first = index * np.uint64(budget.scattered)
    directions = scratches.own.directions
    for number in range(budget.scattered):
        ray, lane = first + np.uint64(number), number % directions.shape[1]
        if lane == 0:
            fill_directions(surface.ns, ray, keys.gather, directions)
        direction = directions[0, lane], directions[1, lane], directions[2, lane]
        found |= _gather(
            scene, shifts, photon_maps, surface, (direction, ray), budget, keys, scratches
        )
    _add_glossy(scene, photon_maps, surface, index, budget, keys.glossy, scratches)
    return found


@jit
def trace_irradiance(scene, photon_maps, surface, bounces, state, scratches):
    """Estimate the light of a surface as `estimate_irradiance` does, by one plain path.

    By another for what it sends to the eye, if it is not Lambertian, and by a third for what
    excites it, if it fluoresces then. Returns the random state.
    """
    _clear_light(scratches)
    start = plain_start(DIRECT, bounces)
    scratches.own.throughput[:] = 1.0
    state = trace_path(scene, photon_maps, surface, start, state, scratches.own)
    if scene.scattering is None or _is_lambertian(scene, surface):
        return state
    scratches.own.throughput[:] = np.float32(INV_PI)
    own = models.with_model(scene, surface)
    state = trace_path(scene, photon_maps, own, start, state, scratches.scattered)
    if scene.fluorescence is None or not fluoresces(scene, surface.hit.triangle):
        return state
    scratches.own.throughput[:] = np.float32(INV_PI)
    sought = models.with_number(surface, FLUORESCING)
    return trace_path(scene, photon_maps, sought, start, state, scratches.excited)
