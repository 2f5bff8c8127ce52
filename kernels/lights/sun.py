"""Suns: light from infinitely far away, parallel or of an evenly bright disc."""

import math
from typing import NamedTuple

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.dome import start_on_disk
from photonmap.kernels.lights.portal import emit_through
from photonmap.kernels.lights.samples import NOWHERE, LightSample


class Parameters(NamedTuple):
    """What describes a sun, beside its axis."""

    edge: float  # cosine of the radius of its disc; 1 where it is parallel


@jit
def _edge(lights, emitter):
    return Parameters(lights.parameters[emitter, 0]).edge


@jit
def importance(geometry, lights, emitter, at, ns):
    """Estimate a sun's irradiance, of power 1 through portals, if any; high at the horizon."""
    edge, portals = _edge(lights, emitter), lights.portals
    reach = math.sqrt(1.0 - edge * edge)  # a part of the disc may be above the horizon
    facing = max(reach - vec.dot(ns, vec.row(lights.axis, emitter)), 0.0)
    if portals is not None:
        return facing / portals.extent[portals.row[emitter]]
    return facing * warp.INV_PI / (lights.radius * lights.radius)


@jit
def direction_of_sun(lights, emitter, u, v):
    """Return a direction in which a sun shines, uniform over its disc if it has one."""
    axis, edge = vec.row(lights.axis, emitter), _edge(lights, emitter)
    if edge == 1.0:
        return axis
    return vec.from_frame(warp.uniform_cone(u, v, edge), axis)


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Return a `LightSample` of a point of the disc, the only one there is of a parallel sun."""
    direction = vec.scale(direction_of_sun(lights, emitter, u, v), -1.0)
    return LightSample(direction, math.inf, direction, 1.0, 0.0, NOWHERE)


@jit
def emit_from_outside(lights, emitter, position, direction):
    """Start a photon outside the scene, by two points of the unit square; a `PhotonStart`."""
    towards = direction_of_sun(lights, emitter, direction[0], direction[1])
    return start_on_disk(lights, towards, position, 1.0, NOWHERE)


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by two points of the unit square; a `PhotonStart`: at portals, if any."""
    if lights.portals is not None:
        towards = direction_of_sun(lights, emitter, direction[0], direction[1])
        return emit_through(geometry, lights.portals, emitter, position, towards)
    return emit_from_outside(lights, emitter, position, direction)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return nothing: a `PhotonStart` of a sun has one direction."""
    return 0.0, 0.0
