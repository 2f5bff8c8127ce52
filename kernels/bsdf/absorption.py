"""Light inside glass that absorbs: Beer and Lambert's law along rays.

The media are an argument of their own, None in a scene where nothing absorbs: then none of this is
compiled.
"""

import math

import numpy as np

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import side_of


@jit
def absorb(geometry, specular, hit, direction, throughput):
    """Multiply throughput, (N,), by what is transmitted along the ray that meets a hit, if any."""
    if specular is None:
        return
    _absorb(geometry, specular.media, hit, direction, throughput)


@jit
def _absorb(geometry, media, hit, direction, throughput):
    if media is None:
        return
    if hit.triangle < 0:
        return
    medium = media.of_side[hit.triangle, side_of(geometry, hit.triangle, direction)]
    if medium < 0:
        return
    length = hit.distance * math.sqrt(vec.dot(direction, direction))
    for band in range(len(throughput)):
        throughput[band] *= np.float32(math.exp(-media.absorption[medium, band] * length))
