"""Isotropic point lights, and what all lights at a point share."""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.samples import NOWHERE, LightSample, PhotonStart, no_sample
from photonmap.kernels.lights.samples import NoParameters as Parameters  # noqa: F401

TINY = 1e-30
NEAREST = 2.0**-24  # Distance to a light at which light stops growing


@jit
def importance_at(position, point, ns):
    """Return the irradiance at a point from a position of intensity 1, unless it is occluded."""
    step = vec.sub(position, point)
    squared = max(vec.dot(step, step), TINY)
    return max(vec.dot(ns, step), 0.0) / (squared * math.sqrt(squared))


@jit
def importance(geometry, lights, emitter, at, ns):
    """Estimate the irradiance at a point from a light of power 1, unless it is occluded."""
    reach = importance_at(vec.row(lights.position, emitter), at, ns)
    return reach * warp.uniform_sphere_pdf()


@jit
def sample_position(position, surface):
    """Return the `LightSample` of a position of intensity 1."""
    step = vec.sub(position, surface.site)
    squared = vec.dot(step, step)
    if squared == 0.0:
        return no_sample(surface.ns)
    direction = vec.scale(step, 1.0 / math.sqrt(squared))
    segment, weight = vec.sub(position, surface.point), 1.0 / max(squared, NEAREST * NEAREST)
    return LightSample(segment, 1.0, direction, weight, 0.0, NOWHERE)


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Return the only `LightSample` there is."""
    return sample_position(vec.row(lights.position, emitter), surface)


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by a point of the unit square; a `PhotonStart`."""
    weight = 1.0 / warp.uniform_sphere_pdf()
    origin = vec.row(lights.position, emitter)
    return PhotonStart(weight, NOWHERE, origin, warp.uniform_sphere(direction[0], direction[1]))


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return what is sent in any direction, per steradian, and the density of `emit`."""
    return 1.0, warp.uniform_sphere_pdf()
