"""Spot lights: a position whose intensity falls off about an axis."""

import math
from typing import NamedTuple

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.point import TINY, importance_at, sample_position
from photonmap.kernels.lights.samples import NOWHERE, LightSample, PhotonStart


class Parameters(NamedTuple):
    """What describes a spot, beside its place and axis."""

    inner: float  # cosine of the angle to the axis up to which it is full
    outer: float  # of that beyond which it is dark


@jit
def _parameters(lights, emitter):
    return Parameters(lights.parameters[emitter, 0], lights.parameters[emitter, 1])


@jit
def falloff(spot, cosine):
    """Return which part of a spot's intensity goes where the angle to its axis has a cosine.

    All of it inside the inner cone, nothing outside the outer one; between them 3t² - 2t³, where t
    goes from 0 to 1 in proportion to the cosine.
    """
    if cosine >= spot.inner:
        return 1.0
    if cosine <= spot.outer:
        return 0.0
    t = (cosine - spot.outer) / (spot.inner - spot.outer)
    return t * t * (3.0 - 2.0 * t)


@jit
def importance(geometry, lights, emitter, at, ns):
    """Return the irradiance at a point from a light of power 1, unless it is occluded.

    An intensity of 1 has a power of π (2 - cos inner - cos outer): t² (3 - 2t) has a mean of 1/2.
    """
    position, spot = vec.row(lights.position, emitter), _parameters(lights, emitter)
    step = vec.sub(position, at)
    length = math.sqrt(max(vec.dot(step, step), TINY))
    cosine = -vec.dot(vec.row(lights.axis, emitter), step) / length
    power = math.pi * (2.0 - spot.inner - spot.outer)
    return importance_at(position, at, ns) * falloff(spot, cosine) / power


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Return the only `LightSample` there is."""
    sample = sample_position(vec.row(lights.position, emitter), surface)
    cosine = -vec.dot(vec.row(lights.axis, emitter), sample.direction)
    weight = sample.weight * falloff(_parameters(lights, emitter), cosine)
    return LightSample(sample.segment, 1.0, sample.direction, weight, 0.0, NOWHERE)


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by a point of the unit square; a `PhotonStart`."""
    spot = _parameters(lights, emitter)
    local = warp.uniform_cone(direction[0], direction[1], spot.outer)
    weight = falloff(spot, local[2]) / warp.uniform_cone_pdf(spot.outer)
    direction = vec.from_frame(local, vec.row(lights.axis, emitter))
    return PhotonStart(weight, NOWHERE, vec.row(lights.position, emitter), direction)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return what is sent in a direction, per steradian, and the density of `emit`."""
    cosine, spot = vec.dot(direction, vec.row(lights.axis, emitter)), _parameters(lights, emitter)
    pdf = warp.uniform_cone_pdf(spot.outer) if cosine >= spot.outer else 0.0
    return falloff(spot, cosine), pdf
