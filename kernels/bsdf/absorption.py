"""Light inside glass that absorbs: the Beer–Lambert law along rays.

The media are an argument of their own, None in a scene where nothing absorbs: then none of this is
compiled.
"""

import math

import numpy as np

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import side_of


@jit
def absorb(geometry, specular, hit, direction, from_specular, throughput):
    """Absorb light along the ray that meets `hit`, from a specular surface or to one.

    `throughput`, (N,), is multiplied by what the glass around the ray transmits.
    """
    if specular is None:
        return
    _absorb(geometry, specular, specular.media, hit, direction, from_specular, throughput)


@jit
def _absorb(geometry, specular, media, hit, direction, from_specular, throughput):
    if media is None:
        return
    if hit.triangle < 0:
        return
    if not from_specular and specular.kind[geometry.material[hit.triangle]] == 0:
        return
    _absorb_in(geometry, media, media.absorption, hit, direction, throughput)


@jit
def _absorb_in(geometry, media, absorption, hit, direction, throughput):
    if len(absorption) == 0:
        return
    medium = media.of_side[hit.triangle, side_of(geometry, hit.triangle, direction)]
    if medium < 0:
        return
    length = hit.distance * math.sqrt(vec.dot(direction, direction))
    for band in range(len(throughput)):
        throughput[band] *= np.float32(math.exp(-absorption[medium, band] * length))
