"""The plain path tracer: slow, unbiased, over the same scene; the reference for everything else."""

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.rng import draw, stream
from photonmap.kernels.core.streams import FILM, split
from photonmap.kernels.film.pixel import (
    add_reflected,
    clear_pixel,
    clear_sums,
    trace_camera_ray,
)
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.integrators.camera_pass import CENTRE
from photonmap.kernels.integrators.irradiance import trace_irradiance
from photonmap.kernels.integrators.path_walk import ONE
from photonmap.kernels.integrators.specular_view import ALL_LOBES, Chain, view_specular_chains


@jit
def _render_path(job, bounces, pixel, index, share, state, estimate, scratches):
    """Render one camera sample of a pixel by one path; return the random state."""
    scene = job.scene
    x, state = draw(state)
    y, state = draw(state)
    position = (x, y) if job.eye.film.jitter else CENTRE
    hit, direction = trace_camera_ray(
        job, pixel, position, index, share, estimate.pixels, scratches.own.rays
    )
    if hit.triangle < 0:
        return state
    if specular_probability(scene, hit.triangle) < 1.0:
        surface = surface_interaction(scene.geometry, hit, direction)
        state = trace_irradiance(scene, job.maps, surface, bounces, state, scratches)
        add_reflected(scene, surface, share, pixel, scratches, estimate)
    chain = Chain(job.key, index, pixel, share, ONE, ALL_LOBES)
    view_specular_chains(job, (hit, direction), chain, estimate, scratches)
    return state


@kernel
def path_pass(job, samples, bounces, span, scratches, estimate):
    """Render the pixels of a span with `samples` paths each; records as in `camera_pass`.

    `job.maps` has an empty cache and no caustic map.
    """
    share, key = np.float32(1.0 / samples), split(job.key, FILM)
    for pixel in range(span.first, span.last):
        clear_pixel(estimate.pixels, pixel)
        clear_sums(estimate.via_specular, pixel)
        state = stream(key, pixel, 0)
        for sample in range(samples):
            index = np.uint64(pixel) * np.uint64(samples) + np.uint64(sample)
            state = _render_path(job, bounces, pixel, index, share, state, estimate, scratches)
