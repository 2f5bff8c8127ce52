"""Dispersion: glass whose index of refraction depends on wavelength.

Light of all bands goes together until it is refracted: then one index of refraction is chosen by
the light that it carries, and the path goes on in the bands that have it (M. Radziszewski, K.
Boryczko and W. Alda, "An improved technique for full spectral rendering", 2009). Within a band, the
wavelength differs from pass to pass.
"""

import numpy as np

from photonmap.kernels.bsdf import microsurface
from photonmap.kernels.core import warp
from photonmap.kernels.core.fresnel import fresnel
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.records import METAL, THIN


@jit
def _index(media, medium, column):
    if medium < 0:
        return 1.0
    dispersion = media.dispersion
    return media.ior[medium] if dispersion is None else dispersion.ior[medium, column]


@jit
def _ratio(specular, material, arrival, column):
    media = specular.media
    if media is None:
        return specular.ior[material] if arrival.side == 1 else 1.0 / specular.ior[material]
    here = media.of_side[arrival.triangle, arrival.side]
    there = media.of_side[arrival.triangle, 1 - arrival.side]
    return _index(media, here, column) / _index(media, there, column)


@jit
def index_ratio(specular, material, arrival, column):
    """Return the index of the side that light comes from over the other's; of metal `METAL`.

    Of a rough pane it is minus the index: see `microsurface`. `column` matters where glass
    disperses.
    """
    if specular.kind[material] == METAL:
        return microsurface.METAL
    if specular.kind[material] == THIN:
        return -specular.ior[material]
    return _ratio(specular, material, arrival, column)


@jit
def _disperses(media, arrival):
    """Return whether the bands have different ratios of indices at a surface."""
    if media is None or media.dispersion is None:
        return False
    for side in range(2):
        medium = media.of_side[arrival.triangle, side]
        if medium >= 0 and media.dispersion.disperses[medium]:
            return True
    return False


@jit
def _choose(dispersion, throughput, xi):
    """Return (column, its probability, uniform number); (0, 1, …) where nothing is carried."""
    total = 0.0
    for band in range(len(throughput)):
        total += throughput[band]
    if total <= 0.0:
        return 0, 1.0, xi
    left, column = xi * total, 0
    for band in range(len(throughput)):
        if throughput[band] > 0.0:
            column = band
            if left < throughput[band]:
                break
            left -= throughput[band]
    own = 0.0
    for band in range(len(throughput)):
        if dispersion.wave[band] == dispersion.wave[column]:
            own += throughput[band]
    xi = min(max(left / throughput[column], 0.0), warp.BELOW_ONE)
    return column, own / total, xi


@jit
def _keep(dispersion, column, probability, values):
    """Leave those of values, (N,), of the bands that have the index of a column."""
    for band in range(len(values)):
        if dispersion.wave[band] == dispersion.wave[column]:
            values[band] /= np.float32(probability)
        else:
            values[band] = np.float32(0.0)


@jit
def choose_index(media, arrival, throughput, xi):
    """Return (column, its probability, uniform number) where glass disperses: for `keep_index`."""
    if not _disperses(media, arrival):
        return 0, 1.0, xi
    return _choose(media.dispersion, throughput, xi)


@jit
def keep_index(media, arrival, choice, values):
    """Leave those of values, (N,), in the bands of a `choice` = (column, probability)."""
    if _disperses(media, arrival):
        _keep(media.dispersion, choice[0], choice[1], values)


@jit
def column_of(media, throughput):
    """Return a column of the index in which a path goes on, once it was chosen; else any."""
    if media is None or media.dispersion is None:
        return 0
    return np.argmax(throughput)


@jit
def reflects(specular, material, arrival, cosine, xi, throughput):
    """Choose between reflection and refraction at smooth glass; return (which, ratio of indices).

    `cosine` is that of the angle of arrival. Where glass disperses, `throughput`, (N,), is
    multiplied by what the choice calls for.
    """
    eta = _ratio(specular, material, arrival, 0)
    if not _disperses(specular.media, arrival):
        return xi < fresnel(cosine, eta), eta
    total = reflected = 0.0
    for band in range(len(throughput)):
        total += throughput[band]
        own = _ratio(specular, material, arrival, band)
        reflected += throughput[band] * fresnel(cosine, own)
    if total <= 0.0:
        return True, eta
    reflectance = reflected / total
    is_reflected = xi < reflectance
    for band in range(len(throughput)):
        own = fresnel(cosine, _ratio(specular, material, arrival, band))
        factor = own / reflectance if is_reflected else (1.0 - own) / (1.0 - reflectance)
        throughput[band] *= np.float32(factor)
    if is_reflected:
        return True, eta
    dispersion = specular.media.dispersion
    column, probability, _ = _choose(
        dispersion, throughput, (xi - reflectance) / (1.0 - reflectance)
    )
    _keep(dispersion, column, probability, throughput)
    return False, _ratio(specular, material, arrival, column)
