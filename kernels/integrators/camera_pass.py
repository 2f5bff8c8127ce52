"""The camera pass: first hits, direct light, gather rays, and specular chains."""

import numpy as np

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.caustics.light_tracing import are_caustics_connected
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.passes import SampleBudget
from photonmap.kernels.core.rng import sobol_2d
from photonmap.kernels.core.streams import (
    FILM,
    GATHER,
    GATHER_CHAIN,
    GLOSSY_PATH,
    LIGHT,
    PATH,
    split,
)
from photonmap.kernels.film.pixel import (
    add_reflected,
    clear_pixel,
    clear_sums,
    trace_camera_ray,
)
from photonmap.kernels.film.pixels import FLAT, morton, update_plane
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.integrators.final_gather import light_keys
from photonmap.kernels.integrators.irradiance import add_disks, estimate_irradiance
from photonmap.kernels.integrators.irradiance_differences import begin_shifts
from photonmap.kernels.integrators.specular_view import ALL_LOBES, Chain, view_specular_chains

CENTRE = (0.5, 0.5)


@jit
def _render_sample(job, keys, pixel, index, share, budget, estimate, scratches):
    """Render one camera sample of a pixel; `index` numbers it for low-discrepancy points."""
    scene, pixels = job.scene, estimate.pixels
    position = sobol_2d(index, keys[0]) if job.eye.film.jitter else CENTRE
    is_first = pixels.coverage[pixel] == 0.0
    hit, direction = trace_camera_ray(
        job, pixel, position, index, share, pixels, scratches.own.rays
    )
    if hit.triangle < 0:
        return
    surface = surface_interaction(scene.geometry, hit, direction)
    update_plane(pixels.plane, pixel, is_first, surface.point, surface.ns)
    if specular_probability(scene, hit.triangle) < 1.0:
        shifts = begin_shifts(
            job, estimate.differences, position, index, pixel, share, scratches.own
        )
        pixels.lookups[pixel] |= estimate_irradiance(
            scene, job.maps, surface, index, budget, keys[1], shifts, scratches
        )
        if not are_caustics_connected(job, surface, pixel):
            add_disks(scene, job.maps.caustics, surface, scratches)
        add_reflected(scene, surface, share, pixel, scratches, estimate)
    chain = Chain(job.key, index, pixel, share, budget, ALL_LOBES)
    view_specular_chains(job, (hit, direction), chain, estimate, scratches)


@kernel
def camera_pass(job, span, scratches, estimate):
    """Render the pixels of a span from a `CameraPass` into an `Estimate`."""
    film, plan, pixels = job.eye.film, job.plan, estimate.pixels
    light = light_keys(job.key, (LIGHT, GATHER, PATH, GATHER_CHAIN, GLOSSY_PATH))
    keys = (split(job.key, FILM), light)
    for pixel in range(span.first, span.last):
        clear_pixel(pixels, pixel)
        clear_sums(estimate.via_specular, pixel)
        clear_sums(estimate.differences, pixel)
        samples = int(plan.samples[pixel])
        budget = SampleBudget(np.int64(plan.lights[pixel]), np.int64(plan.gathers[pixel]))
        share = np.float32(1.0 / samples)
        base = morton(pixel % film.width, pixel // film.width) * np.uint64(samples)
        for sample in range(samples):
            index = base + np.uint64(sample)
            _render_sample(job, keys, pixel, index, share, budget, estimate, scratches)
        if pixels.coverage[pixel] < 1.0:
            pixels.plane[pixel, FLAT] = 0.0
