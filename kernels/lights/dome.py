"""The dome: light from all around, infinitely far away, even or of an environment map."""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.environment import (
    ALL_AROUND,
    cell_of_normal,
    environment_pdf,
    sample_environment,
)
from photonmap.kernels.lights.samples import NOWHERE, LightSample, PhotonStart, no_sample
from photonmap.kernels.lights.samples import NoParameters as Parameters  # noqa: F401


@jit
def importance(geometry, lights, emitter, at, ns):
    """Return the irradiance from a dome of power 1, half of which is seen."""
    return 0.25 * warp.INV_PI / (lights.radius * lights.radius)


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Sample a direction to the dome, by cosine times light; a `LightSample`."""
    environment = lights.environment
    if environment is None:
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), surface.ns)
        position, pdf = NOWHERE, warp.cosine_hemisphere_pdf(vec.dot(surface.ns, direction))
    else:
        cell = cell_of_normal(surface.ns)
        direction, position, pdf = sample_environment(environment, cell, u, v)
    if pdf <= 0.0:
        return no_sample(direction)
    return LightSample(direction, math.inf, direction, 1.0 / pdf, pdf, position)


@jit
def pdf(environment, ns, direction, position):
    """Return the density of `sample_towards` (per steradian); `position` is the map's texel."""
    if environment is None:
        return warp.cosine_hemisphere_pdf(vec.dot(ns, direction))
    return environment_pdf(environment, cell_of_normal(ns), position)


@jit
def start_at(lights, direction, x, y):
    """Return a point outside the scene, at (x, y) of the frame of a direction into it."""
    return vec.from_frame((x, y, -2.0 * lights.radius), direction)


@jit
def start_on_disk(lights, direction, point, density, texel):
    """Start a photon on a disk outside the scene, across its direction."""
    x, y = warp.uniform_disk(point[0], point[1])
    origin = start_at(lights, direction, lights.radius * x, lights.radius * y)
    weight = lights.radius * lights.radius / (density * warp.uniform_disk_pdf())
    return PhotonStart(weight, texel, origin, direction)


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by two points of the unit square; a `PhotonStart`."""
    u, v = direction
    if lights.environment is None:
        towards = warp.uniform_sphere(u, v)
        return start_on_disk(lights, towards, position, warp.uniform_sphere_pdf(), NOWHERE)
    outwards, texel, density = sample_environment(lights.environment, ALL_AROUND, u, v)
    return start_on_disk(lights, vec.scale(outwards, -1.0), position, density, texel)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return nothing: a `PhotonStart` of the dome has one direction."""
    return 0.0, 0.0
