"""Direct light: an emitter sampled towards a surface point, weighed against scattered rays."""

from typing import NamedTuple

from photonmap.kernels.bsdf import models
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import SHADOW
from photonmap.kernels.core.warp import power_heuristic
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import occluded
from photonmap.kernels.lights import dome, triangle
from photonmap.kernels.lights.kinds import DIRECTIONAL, sample_towards
from photonmap.kernels.lights.portal import shines_in
from photonmap.kernels.lights.samples import NOWHERE
from photonmap.kernels.lights.selection import select_emitter, selection_probability, weigh_emitters


class DirectSample(NamedTuple):
    """One of some light samples: its irradiance is weight · emission."""

    emitter: int  # -1 where none is in front of the surface
    weight: float  # 0 where the emitter is occluded
    pdf: float  # of all samples, per steradian; 0 where scattered rays cannot hit the emitter
    position: tuple  # barycentrics on an emitting triangle
    direction: tuple  # unit vector towards the emitter


@jit
def prepare_direct(scene, surface, cdf):
    """Fill the CDF, (SCRATCH,), by which `sample_direct` chooses emitters for a point."""
    weigh_emitters(scene.geometry, scene.lights, surface.point, surface.ns, cdf)


@jit
def _is_hidden(geometry, lights, emitter, point, sample):
    """Return whether something is in the way from a point to a `LightSample`."""
    if lights.portals is not None and lights.kind[emitter] == DIRECTIONAL:
        return not shines_in(geometry, lights.portals, point, sample.direction)
    return occluded(geometry, point, sample.segment, sample.length)


@jit
def sample_direct(scene, surface, cdf, u, v):
    """Sample one emitter for the irradiance at a surface point: `sample_emitter` of one sample.

    `cdf` is what `prepare_direct` filled.
    """
    choice = select_emitter(scene.lights, surface.point, surface.ns, cdf, u)
    return sample_emitter(scene, surface, choice, v, 1)


@jit
def sample_emitter(scene, surface, choice, v, count):
    """Sample an emitter for the irradiance at a surface point; one `DirectSample` of `count`.

    The choice is (emitter, probability, u). The samples' sum estimates irradiance, alone or
    together with scattered rays: then samples are weighed by `weigh_sample`, and rays by
    `weigh_hit`.
    """
    geometry, lights = scene.geometry, scene.lights
    emitter, probability, u = choice
    if emitter < 0:
        return DirectSample(-1, 0.0, 0.0, NOWHERE, surface.ns)
    sample = sample_towards(geometry, lights, emitter, surface, u, v)
    cosine = max(vec.dot(surface.ns, sample.direction), 0.0)
    if sample.weight == 0.0 or cosine == 0.0 or vec.dot(surface.ng, sample.direction) <= 0.0:
        return DirectSample(-1, 0.0, 0.0, NOWHERE, sample.direction)
    if _is_hidden(geometry, lights, emitter, surface.point, sample):
        return DirectSample(emitter, 0.0, 0.0, NOWHERE, sample.direction)
    weight = cosine * sample.weight / (count * probability)
    pdf = count * probability * sample.pdf
    return DirectSample(emitter, weight, pdf, sample.position, sample.direction)


@jit
def count_shadow_ray(sample, rays):
    """Count the shadow ray of a `DirectSample`: none where no emitter is in front."""
    if sample.emitter >= 0:
        rays[SHADOW] += 1


@jit
def weigh_sample(scene, surface, sample, rays):
    """Return the weight of a `DirectSample` against `rays` scattered rays that may hit emitters.

    They have the density of the surface's model, or of Lambert's law where `scattering` is None.
    """
    if sample.pdf == 0.0:
        return 1.0
    density = models.pdf(scene, surface, sample.direction)
    return power_heuristic(sample.pdf, rays * density)


@jit
def sampling_pdf(scene, surface, hit, seen, direction):
    """Return a light sample's density (per steradian) at what a ray hits: (emitter, position)."""
    emitter, position = seen
    geometry, lights = scene.geometry, scene.lights
    probability = selection_probability(geometry, lights, emitter, surface.point, surface.ns)
    if emitter == lights.dome:
        pdf = dome.pdf(lights.environment, surface.ns, direction, position)
    else:
        end = surface_interaction(geometry, hit, direction).point
        segment = vec.sub(end, surface.point)
        pdf = triangle.pdf(geometry, lights, emitter, segment, direction)
    return probability * pdf


@jit
def weigh_hit(scene, surface, hit, seen, direction, budget):
    """Return the MIS weight of a ray that hits an emitter; `seen` is (emitter, position)."""
    pdf = sampling_pdf(scene, surface, hit, seen, direction)
    own = budget.scattered * models.pdf(scene, surface, direction)
    return power_heuristic(own, budget.lights * pdf)
