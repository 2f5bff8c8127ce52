"""Lights infinitely far away: suns, parallel or discs, and the dome, even or an environment map."""

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


@jit
def sun_importance(lights, portals, emitter, ns):
    """Estimate the unoccluded irradiance from a sun of power 1: too high near the horizon.

    The portals, None or those of the lights, are all that the power of suns goes through.
    """
    edge = lights.cosines[emitter, 0]
    reach = math.sqrt(1.0 - edge * edge)  # a part of the disc may be above the horizon
    facing = max(reach - vec.dot(ns, vec.row(lights.axis, emitter)), 0.0)
    if portals is not None:
        return facing / portals.extent[portals.row[emitter]]
    return facing * warp.INV_PI / (lights.radius * lights.radius)


@jit
def dome_importance(lights):
    """Return the irradiance from a dome of power 1, half of which is seen."""
    return 0.25 * warp.INV_PI / (lights.radius * lights.radius)


@jit
def direction_of_sun(lights, emitter, u, v):
    """Return a direction in which a sun shines, uniform over its disc if it has one."""
    axis, edge = vec.row(lights.axis, emitter), lights.cosines[emitter, 0]
    if edge == 1.0:
        return axis
    return vec.from_frame(warp.uniform_cone(u, v, edge), axis)


@jit
def sample_sun(lights, emitter, u, v):
    """Return a `LightSample` of a point of the disc, the only one there is of a parallel sun."""
    direction = vec.scale(direction_of_sun(lights, emitter, u, v), -1.0)
    return LightSample(direction, math.inf, direction, 1.0, 0.0, NOWHERE)


@jit
def sample_dome(environment, surface, u, v):
    """Sample a direction to the dome, by cosine times light; a `LightSample`."""
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
def dome_pdf(environment, ns, direction, position):
    """Return the density of `sample_dome` (per steradian); `position` is the map's texel."""
    if environment is None:
        return warp.cosine_hemisphere_pdf(vec.dot(ns, direction))
    return environment_pdf(environment, cell_of_normal(ns), position)


@jit
def start_at(lights, direction, x, y):
    """Return a point outside the scene, at (x, y) of the frame of a direction into it."""
    return vec.from_frame((x, y, -2.0 * lights.radius), direction)


@jit
def _start(lights, direction, point, density, texel):
    """Start a photon on a disk outside the scene, across its direction."""
    x, y = warp.uniform_disk(point[0], point[1])
    origin = start_at(lights, direction, lights.radius * x, lights.radius * y)
    weight = lights.radius * lights.radius / (density * warp.uniform_disk_pdf())
    return PhotonStart(weight, texel, origin, direction)


@jit
def emit_from_sun(lights, emitter, position, direction):
    """Start a photon, by two points of the unit square; a `PhotonStart`."""
    towards = direction_of_sun(lights, emitter, direction[0], direction[1])
    return _start(lights, towards, position, 1.0, NOWHERE)


@jit
def emit_from_dome(lights, environment, position, direction):
    """Start a photon, by two points of the unit square; a `PhotonStart`."""
    if environment is None:
        towards = warp.uniform_sphere(direction[0], direction[1])
        return _start(lights, towards, position, warp.uniform_sphere_pdf(), NOWHERE)
    u, v = direction
    outwards, texel, pdf = sample_environment(environment, ALL_AROUND, u, v)
    return _start(lights, vec.scale(outwards, -1.0), position, pdf, texel)
