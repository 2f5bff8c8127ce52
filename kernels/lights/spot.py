"""Spot lights: a position whose intensity falls off about an axis."""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.point import TINY, importance_at, sample_position
from photonmap.kernels.lights.samples import NOWHERE, LightSample, PhotonStart


@jit
def falloff(cosines, emitter, cosine):
    """Return which part of a spot's intensity goes where the angle to its axis has a cosine.

    All of it inside the inner cone, nothing outside the outer one; between them 3t² - 2t³, where t
    goes from 0 to 1 in proportion to the cosine.
    """
    inner, outer = cosines[emitter, 0], cosines[emitter, 1]
    if cosine >= inner:
        return 1.0
    if cosine <= outer:
        return 0.0
    t = (cosine - outer) / (inner - outer)
    return t * t * (3.0 - 2.0 * t)


@jit
def importance(lights, emitter, point, ns):
    """Return the irradiance at a point from a light of power 1, unless it is occluded.

    An intensity of 1 has a power of π (2 - cos inner - cos outer): t² (3 - 2t) has a mean of 1/2.
    """
    position, cosines = vec.row(lights.position, emitter), lights.cosines
    step = vec.sub(position, point)
    length = math.sqrt(max(vec.dot(step, step), TINY))
    cosine = -vec.dot(vec.row(lights.axis, emitter), step) / length
    power = math.pi * (2.0 - cosines[emitter, 0] - cosines[emitter, 1])
    return importance_at(position, point, ns) * falloff(cosines, emitter, cosine) / power


@jit
def sample_towards(lights, emitter, surface):
    """Return the only `LightSample` there is."""
    sample = sample_position(vec.row(lights.position, emitter), surface)
    cosine = -vec.dot(vec.row(lights.axis, emitter), sample.direction)
    weight = sample.weight * falloff(lights.cosines, emitter, cosine)
    return LightSample(sample.segment, 1.0, sample.direction, weight, 0.0, NOWHERE)


@jit
def emit(lights, emitter, direction):
    """Start a photon, by a point of the unit square; a `PhotonStart`."""
    cosine = lights.cosines[emitter, 1]
    local = warp.uniform_cone(direction[0], direction[1], cosine)
    weight = falloff(lights.cosines, emitter, local[2]) / warp.uniform_cone_pdf(cosine)
    direction = vec.from_frame(local, vec.row(lights.axis, emitter))
    return PhotonStart(weight, NOWHERE, vec.row(lights.position, emitter), direction)


@jit
def emitted(lights, emitter, direction):
    """Return what is sent in a direction, per steradian, and the density of `emit`."""
    cosine, edge = vec.dot(direction, vec.row(lights.axis, emitter)), lights.cosines[emitter, 1]
    pdf = warp.uniform_cone_pdf(edge) if cosine >= edge else 0.0
    return falloff(lights.cosines, emitter, cosine), pdf
