"""Light inside glass that absorbs: the Beer–Lambert law along rays."""

import math

import numpy as np

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import side_of


@jit
def absorb(scene, hit, direction, from_specular, throughput):
    """Absorb light along the ray that meets `hit`, from a specular surface or to one.

    `throughput`, (N,), is multiplied by what the glass around the ray transmits.
    """
    specular = scene.specular
    if specular is None:
        return
    media = specular.media
    if media is None or len(media.absorption) == 0 or hit.triangle < 0:
        return
    if not from_specular and specular.kind[scene.geometry.material[hit.triangle]] == 0:
        return
    medium = media.of_side[hit.triangle, side_of(scene.geometry, hit.triangle, direction)]
    if medium < 0:
        return
    length = hit.distance * math.sqrt(vec.dot(direction, direction))
    for band in range(len(throughput)):
        throughput[band] *= np.float32(math.exp(-media.absorption[medium, band] * length))
