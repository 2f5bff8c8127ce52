"""The camera pass: first hits, direct light, gather rays, and specular chains.

And that of the plain path tracer: slow, unbiased, the reference for everything else.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.caustics.light_tracing import are_caustics_connected
from photonmap.kernels.core import streams
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import SampleBudget
from photonmap.kernels.core.rng import draw, sobol_2d, stream
from photonmap.kernels.film.pixels import (
    FLAT,
    add_reflected,
    clear_pixel,
    clear_sums,
    morton,
    trace_camera_ray,
    update_plane,
)
from photonmap.kernels.geometry.interaction import first_interaction
from photonmap.kernels.integrators.final_gather import light_keys
from photonmap.kernels.integrators.fluorescent_path import missed_levels
from photonmap.kernels.integrators.irradiance import (
    add_disks,
    estimate_irradiance,
    trace_irradiance,
)
from photonmap.kernels.integrators.irradiance_differences import begin_shifts
from photonmap.kernels.integrators.path_walk import ONE
from photonmap.kernels.integrators.specular_view import ALL_LOBES, Chain, view_specular_chains

CENTRE = (0.5, 0.5)


class Turn(NamedTuple):
    """Which pass of its replicate a pass is: all of these share one sequence in each pixel."""

    number: int  # from 0
    passes: int  # of the replicate


@jit
def _render_sample(job, keys, pixel, index, weight, budget, estimate, scratches):
    """Render one camera sample of a pixel; `index` numbers it for low-discrepancy points."""
    scene, pixels = job.scene, estimate.pixels
    position = sobol_2d(index, keys[0]) if job.eye.film.jitter else CENTRE
    is_first = pixels.coverage[pixel] == 0.0
    hit, ray = trace_camera_ray(job, pixel, position, index, weight, pixels, scratches.own.rays)
    if hit.triangle < 0:
        return
    surface = first_interaction(scene.geometry, hit, ray)
    update_plane(pixels.plane, pixel, is_first, surface.point, surface.ns)
    if specular_probability(scene, hit.triangle) < 1.0:
        shifts = begin_shifts(
            job, estimate.differences, position, index, pixel, weight, scratches.own
        )
        pixels.lookups[pixel] |= estimate_irradiance(
            scene, job.photon_maps, surface, index, budget, keys[1], shifts, scratches
        )
        if not are_caustics_connected(job, surface, pixel):
            add_disks(scene, job.photon_maps.caustics, surface, scratches)
        add_reflected(scene, surface, weight, pixel, scratches, estimate)
    chain = Chain(job.key, index, pixel, weight, budget, ALL_LOBES)
    view_specular_chains(job, (hit, ray.direction), chain, estimate, scratches)
    pixels.lookups[pixel] |= missed_levels(scene, scratches.own)


@kernel
def camera_pass(job, turn, span, scratches, estimate):
    """Render the pixels of a span from a `CameraPass` into an `Estimate`, when it is their turn."""
    film, plan, pixels = job.eye.film, job.plan, estimate.pixels
    light = light_keys(
        job.key,
        (streams.LIGHT, streams.GATHER, streams.PATH, streams.GATHER_CHAIN, streams.GLOSSY_PATH),
    )
    keys = (streams.split(job.key, streams.FILM), light)
    for pixel in range(span.first, span.last):
        clear_pixel(pixels, pixel)
        clear_sums(estimate.via_specular, pixel)
        clear_sums(estimate.differences, pixel)
        samples = int(plan.samples[pixel])
        budget = SampleBudget(np.int64(plan.lights[pixel]), np.int64(plan.gathers[pixel]))
        weight = np.float32(1.0 / samples)
        place = morton(pixel % film.width, pixel // film.width) * np.uint64(turn.passes)
        first = (place + np.uint64(turn.number)) * np.uint64(samples)
        for sample in range(samples):
            index = first + np.uint64(sample)
            _render_sample(job, keys, pixel, index, weight, budget, estimate, scratches)
        if pixels.coverage[pixel] < 1.0:
            pixels.plane[pixel, FLAT] = 0.0


@jit
def _render_path(job, bounces, pixel, index, weight, state, estimate, scratches):
    """Render one camera sample of a pixel by one path; return the random state."""
    scene = job.scene
    x, state = draw(state)
    y, state = draw(state)
    position = (x, y) if job.eye.film.jitter else CENTRE
    hit, ray = trace_camera_ray(
        job, pixel, position, index, weight, estimate.pixels, scratches.own.rays
    )
    if hit.triangle < 0:
        return state
    if specular_probability(scene, hit.triangle) < 1.0:
        surface = first_interaction(scene.geometry, hit, ray)
        state = trace_irradiance(scene, job.photon_maps, surface, bounces, state, scratches)
        add_reflected(scene, surface, weight, pixel, scratches, estimate)
    chain = Chain(job.key, index, pixel, weight, ONE, ALL_LOBES)
    view_specular_chains(job, (hit, ray.direction), chain, estimate, scratches)
    estimate.pixels.lookups[pixel] |= missed_levels(scene, scratches.own)
    return state


@kernel
def path_pass(job, samples, bounces, span, scratches, estimate):
    """Render a span with `samples` paths each; `job.photon_maps` are empty."""
    weight, key = np.float32(1.0 / samples), streams.split(job.key, streams.FILM)
    for pixel in range(span.first, span.last):
        clear_pixel(estimate.pixels, pixel)
        clear_sums(estimate.via_specular, pixel)
        state = stream(key, pixel, 0)
        for sample in range(samples):
            index = np.uint64(pixel) * np.uint64(samples) + np.uint64(sample)
            state = _render_path(job, bounces, pixel, index, weight, state, estimate, scratches)
