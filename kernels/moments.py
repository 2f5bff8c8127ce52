"""Running means and spreads over passes, per pixel and band (Welford 1962)."""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.jit import jit, kernel
from photonmap.kernels.records import (
    FIRST_CAUSTIC,
    LIT_BY_CAUSTIC,
    SEEN_CAUSTIC,
    SEEN_DIRECT,
    SEEN_INDIRECT,
)
from photonmap.kernels.warp import INV_PI


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
def add_pass(moments, smooth, pixels, seen, count, first, last):
    """Take pixels first..last of the pass number `count` (from 1) into the moments.

    `smooth` and `seen` are None in a scene without smooth surfaces.
    """
    share = 1.0 / count
    rest = 1.0 - share
    for pixel in range(first, last):
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
def is_judged(moments, pixel):
    """Tell whether a pixel counts in the error: covered by surfaces, none of which emits."""
    for band in range(moments.emission.shape[1]):
        if moments.emission[pixel, band] != 0.0:
            return False
    return moments.coverage[pixel] == 1.0


@kernel
def sum_radiance(moments, first, last, total):
    """Set total (N + 1,) to the sums of radiance over judged pixels, and their number."""
    total[:] = 0.0
    for pixel in range(first, last):
        if is_judged(moments, pixel):
            total[-1] += 1.0
            for band in range(moments.direct.shape[1]):
                total[band] += moments.direct[pixel, band] + moments.indirect[pixel, band]


@kernel
def sum_relative_variance(moments, mean, weights, count, first, last):
    """Sum SE² / (v² + 0.01 mean²) over judged pixels first..last and bands.

    mean and weights are (N,): a column counts as often as its weight says.
    """
    total = 0.0
    scale = 1.0 / (count * (count - 1.0))
    for pixel in range(first, last):
        if is_judged(moments, pixel):
            for band in range(len(mean)):
                value = moments.direct[pixel, band] + moments.indirect[pixel, band]
                norm = value * value + 0.01 * mean[band] * mean[band]
                if norm > 0.0:
                    spread = moments.radiance_spread[pixel, band]
                    total += weights[band] * (spread * scale / norm)
    return total


@jit
def _residual(smooth, pixel, band):
    return 0.0 if smooth is None else smooth.residual[pixel, band]


@kernel
def finish_shading(moments, smooth, count, first, last, factor, shading, error):
    """Fill shading and its standard error, times factor, (P, N) float32, of pixels first..last.

    The ratio of diffuse light to reflectance where that is not 0, with the error of a ratio by
    the delta method; the mean irradiance / π elsewhere. With one pass, error stays as it is.
    """
    scale = 1.0 / (count * max(count - 1.0, 1.0))
    for pixel in range(first, last):
        for band in range(shading.shape[1]):
            r = moments.reflectance[pixel, band]
            if r > 0.0:
                light = moments.direct[pixel, band] + moments.indirect[pixel, band]
                s = (light - _residual(smooth, pixel, band)) / r
                variance = (
                    moments.diffuse_spread[pixel, band]
                    - 2.0 * s * moments.product[pixel, band]
                    + s * s * moments.reflectance_spread[pixel, band]
                ) / (r * r)
            else:
                s = moments.irradiance[pixel, band]
                variance = float(moments.irradiance_spread[pixel, band])
            shading[pixel, band] = s * factor
            if count > 1:
                error[pixel, band] = factor * math.sqrt(max(variance, 0.0) * scale)
