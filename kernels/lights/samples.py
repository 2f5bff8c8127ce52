"""What kinds of lights return: samples towards a point, and the starts of photons."""

from typing import NamedTuple

from photonmap.kernels.core.jit import jit

NOWHERE = (0.0, 0.0)  # Position on an emitter that has no positions


class NoParameters(NamedTuple):
    """Of a kind of emitters that places and axes describe."""


class LightSample(NamedTuple):
    """A direction from a surface point to an emitter."""

    segment: tuple  # vector to the emitter; for one that is infinitely far, of any length
    length: float  # of the shadow ray, in lengths of the segment
    direction: tuple  # unit vector
    weight: float  # irradiance for an emission of 1, per cosine; 0 where nothing arrives
    pdf: float  # per steradian, to weigh against scattered rays; 0 where these cannot hit it
    position: tuple
    """barycentrics on an emitting triangle; of an environment map, and of portals to it, the texel
    (row, column)"""


class PhotonStart(NamedTuple):
    """A photon that leaves an emitter."""

    weight: float  # flux for an emission of 1
    position: tuple
    """barycentrics on an emitting triangle; of an environment map, and of portals to it, the texel
    (row, column)"""
    origin: tuple
    direction: tuple


@jit
def no_sample(direction):
    """Return a `LightSample` of weight 0."""
    return LightSample(direction, 0.0, direction, 0.0, 0.0, NOWHERE)
