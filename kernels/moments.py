"""Running means and spreads over passes, per pixel and band (Welford 1962)."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.gather import EMPTY, FOUND
from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.records import (
    FIRST_CAUSTIC,
    LIT_BY_CAUSTIC,
    SEEN_CAUSTIC,
    SEEN_DIRECT,
    SEEN_INDIRECT,
)
from photonmap.kernels.warp import INV_PI

JUDGED = ("radiance", "direct", "indirect", "caustics", "residual", "shading")
"""Buffers whose error may be asked for; kernels take their index."""
RADIANCE, DIRECT, INDIRECT, CAUSTICS, RESIDUAL, SHADING = range(len(JUDGED))


class Moments(NamedTuple):
    """Means, (P, N) float64, and sums of squared deviations, (P, N) float32, over passes.

    radiance = emission + direct + indirect, and diffuse is what of the last two first hits reflect;
    `product` is the sum of products of the deviations of diffuse and reflectance, from which the
    error of their ratio follows.
    """

    emission: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    reflectance: np.ndarray
    irradiance: np.ndarray
    """direct + indirect irradiance / π"""
    emission_spread: np.ndarray
    direct_spread: np.ndarray
    indirect_spread: np.ndarray
    reflectance_spread: np.ndarray
    irradiance_spread: np.ndarray
    diffuse_spread: np.ndarray
    radiance_spread: np.ndarray
    product: np.ndarray
    coverage: np.ndarray
    """(P,) float64, mean"""
    found: np.ndarray
    """(P,) uint8, flags of all passes, as in `Pixels`"""
    counts: np.ndarray
    """(P,) uint32, passes taken into each pixel"""


class SmoothMoments(NamedTuple):
    """The same for scenes with smooth surfaces, beside `Moments`: parts of direct and indirect."""

    caustics: np.ndarray
    residual: np.ndarray
    """what is not the reflection of first hits: all that is seen in mirrors and through glass"""
    caustics_spread: np.ndarray
    residual_spread: np.ndarray


@jit
def _add(mean, spread, pixel, band, value, share):
    """Take one value into a mean and its spread; return its deviation from the old mean."""
    before = value - mean[pixel, band]
    mean[pixel, band] += before * share
    spread[pixel, band] += before * (value - mean[pixel, band])
    return before


@jit
def _seen_parts(seen, pixel, band):
    """Return first hits' caustic and its irradiance, and direct, indirect, caustic seen beyond."""
    if seen is None:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    return (
        float(seen[FIRST_CAUSTIC, pixel, band]),
        float(seen[LIT_BY_CAUSTIC, pixel, band]),
        float(seen[SEEN_DIRECT, pixel, band]),
        float(seen[SEEN_INDIRECT, pixel, band]),
        float(seen[SEEN_CAUSTIC, pixel, band]),
    )


@jit
def _add_smooth(smooth, pixel, band, caustics, residual, share):
    """Take caustics and residual into their moments; return the residual's deviation."""
    if smooth is None:
        return 0.0
    _add(smooth.caustics, smooth.caustics_spread, pixel, band, caustics, share)
    return _add(smooth.residual, smooth.residual_spread, pixel, band, residual, share)


@kernel
def add_pass(moments, smooth, pixels, seen, first, last):
    """Take pixels first..last of a pass into the moments.

    `smooth` and `seen` are None in a scene without smooth surfaces.
    """
    for pixel in range(first, last):
        moments.counts[pixel] += 1
        share = 1.0 / moments.counts[pixel]
        rest = 1.0 - share
        moments.coverage[pixel] += (pixels.coverage[pixel] - moments.coverage[pixel]) * share
        moments.found[pixel] |= pixels.found[pixel]
        for band in range(pixels.direct.shape[1]):
            caustic, lit, seen_direct, seen_indirect, deep = _seen_parts(seen, pixel, band)
            emission = float(pixels.emission[pixel, band])
            direct = float(pixels.direct[pixel, band]) + seen_direct
            indirect = float(pixels.indirect[pixel, band]) + (caustic + seen_indirect + deep)
            reflectance = float(pixels.reflectance[pixel, band])
            irradiance = INV_PI * (
                float(pixels.irradiance_direct[pixel, band])
                + (float(pixels.irradiance_indirect[pixel, band]) + lit)
            )
            e = _add(moments.emission, moments.emission_spread, pixel, band, emission, share)
            d = _add(moments.direct, moments.direct_spread, pixel, band, direct, share)
            i = _add(moments.indirect, moments.indirect_spread, pixel, band, indirect, share)
            r = _add(
                moments.reflectance, moments.reflectance_spread, pixel, band, reflectance, share
            )
            _add(moments.irradiance, moments.irradiance_spread, pixel, band, irradiance, share)
            residual = seen_direct + seen_indirect + deep
            s = _add_smooth(smooth, pixel, band, caustic + deep, residual, share)
            moments.diffuse_spread[pixel, band] += (d + i - s) * (d + i - s) * rest
            moments.radiance_spread[pixel, band] += (e + d + i) * (e + d + i) * rest
            moments.product[pixel, band] += (d + i - s) * r * rest


@jit
def is_judged(moments, lit, pixel):
    """Tell whether a pixel counts in the error: covered by surfaces, none of which emits.

    Where photons are stored (`lit`), gather rays must have met some of their light, or none at all.
    """
    if lit and (moments.found[pixel] & (EMPTY | FOUND)) == EMPTY:
        return False
    for band in range(moments.emission.shape[1]):
        if moments.emission[pixel, band] != 0.0:
            return False
    return moments.coverage[pixel] == 1.0


@jit
def _residual(smooth, pixel, band):
    return 0.0 if smooth is None else smooth.residual[pixel, band]


@jit
def _shading(moments, smooth, pixel, band):
    """Return shading and its spread.

    The ratio of diffuse light to reflectance where that is not 0, with the spread of a ratio by
    the delta method; the mean irradiance / π elsewhere.
    """
    r = moments.reflectance[pixel, band]
    if r == 0.0:
        return moments.irradiance[pixel, band], float(moments.irradiance_spread[pixel, band])
    light = moments.direct[pixel, band] + moments.indirect[pixel, band]
    s = (light - _residual(smooth, pixel, band)) / r
    spread = (
        moments.diffuse_spread[pixel, band]
        - 2.0 * s * moments.product[pixel, band]
        + s * s * moments.reflectance_spread[pixel, band]
    ) / (r * r)
    return s, max(spread, 0.0)


@jit
def _smooth_light(smooth, buffer, pixel, band):
    """Return the mean and spread of caustics or residual: 0 without smooth surfaces."""
    if smooth is None:
        return 0.0, 0.0
    if buffer == CAUSTICS:
        return smooth.caustics[pixel, band], float(smooth.caustics_spread[pixel, band])
    return smooth.residual[pixel, band], float(smooth.residual_spread[pixel, band])


@jit
def _light(moments, smooth, buffer, pixel, band):
    """Return the mean and spread of a buffer of `JUDGED`, where nothing emits."""
    if buffer == RADIANCE:
        value = moments.direct[pixel, band] + moments.indirect[pixel, band]
        return value, float(moments.radiance_spread[pixel, band])
    if buffer == DIRECT:
        return moments.direct[pixel, band], float(moments.direct_spread[pixel, band])
    if buffer == INDIRECT:
        return moments.indirect[pixel, band], float(moments.indirect_spread[pixel, band])
    if buffer == SHADING:
        return _shading(moments, smooth, pixel, band)
    return _smooth_light(smooth, buffer, pixel, band)


@kernel
def sum_judged(moments, smooth, buffer, lit, first, last, total):
    """Set total (N + 1,) to the sums of a buffer over judged pixels, and their number."""
    total[:] = 0.0
    for pixel in range(first, last):
        if is_judged(moments, lit, pixel):
            total[-1] += 1.0
            for band in range(moments.direct.shape[1]):
                total[band] += _light(moments, smooth, buffer, pixel, band)[0]


@jit
def _relative_variance(moments, smooth, buffer, mean, pixel, band):
    """Return SE² / (v² + 0.01 mean²); infinite before the pixel's second pass."""
    count = float(moments.counts[pixel])
    if count < 2.0:
        return math.inf
    value, spread = _light(moments, smooth, buffer, pixel, band)
    norm = value * value + 0.01 * mean[band] * mean[band]
    return spread * (1.0 / (count * (count - 1.0))) / norm if norm > 0.0 else 0.0


@kernel
def sum_relative_variance(moments, smooth, buffer, lit, mean, weights, first, last):
    """Sum SE² / (v² + 0.01 mean²) over judged pixels first..last and bands.

    mean and weights are (N,): a column counts as often as its weight says.
    """
    total = 0.0
    for pixel in range(first, last):
        if is_judged(moments, lit, pixel):
            for band in range(len(mean)):
                variance = _relative_variance(moments, smooth, buffer, mean, pixel, band)
                total += weights[band] * variance
    return total


@kernel
def list_relative_variance(moments, smooth, buffer, lit, mean, first, last, out):
    """Write SE² / (v² + 0.01 mean²) of judged pixels first..last from row `first` on.

    mean is (N,), out (P, N) float32; returns how many rows were written.
    """
    row = first
    for pixel in range(first, last):
        if is_judged(moments, lit, pixel):
            for band in range(len(mean)):
                out[row, band] = _relative_variance(moments, smooth, buffer, mean, pixel, band)
            row += 1
    return row - first


@kernel
def finish_shading(moments, smooth, first, last, factor, shading, error):
    """Fill shading and its standard error, times factor, (P, N) float32, of pixels first..last.

    Before a pixel's second pass, error stays as it is.
    """
    for pixel in range(first, last):
        count = float(moments.counts[pixel])
        scale = 1.0 / (count * max(count - 1.0, 1.0))
        for band in range(shading.shape[1]):
            value, spread = _shading(moments, smooth, pixel, band)
            shading[pixel, band] = value * factor
            if count > 1.0:
                error[pixel, band] = factor * math.sqrt(spread * scale)
