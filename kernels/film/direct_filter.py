"""Direct light averaged over pixels of one surface, where other passes show it to be the same.

Passes form groups. How far the light of two pixels on opposite sides is from that between them is
seen in all groups but one, by single pixels and over patches; the light of that one is averaged by
what follows. So weights are independent of the noise that they average, and of its variance, which
is that within the group. A pair cancels what changes linearly.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.film.irradiance_sharing import Footprint, may_share
from photonmap.kernels.film.pixels import FLAT

GROUPS = 4
"""Of passes"""
PATCHES = 0, 1, 2
"""Radii of the patches by which pixels are compared: of 1, 3×3 and 5×5 pixels"""
STRICTNESS = 4.0
"""Square of how many standard errors a pair is off when its weight has fallen to 0"""
CONSTANT = 1e-12
"""Variance of reflectance, relative to its square, that is rounding"""
TINY = 1e-30
"""In place of no variance at all"""


@by_reference
class Grouped(NamedTuple):
    """Direct light of G groups of passes, and its mean over bands."""

    sums: np.ndarray  # (G, P, N) float32, over passes
    mean: np.ndarray  # (G, P) float64, over passes and bands
    spread: np.ndarray  # (G, P) float32, of that: squared deviations, times passes of each value
    passes: np.ndarray  # (G,) float64, how many
    values: np.ndarray  # (G,) float64, how many replicates they form


@by_reference
class Compared(NamedTuple):
    """What pixels are compared by, and what is averaged: of radiance at reflectance 1."""

    footprint: Footprint  # how far pixels are averaged
    light: np.ndarray  # (G, P, N) float32, mean in each group
    variance: np.ndarray  # (G, P, N) float32, of that, as its own group says
    smooth: np.ndarray  # (P, L, G) float32, mean over bands, a patch and all groups but one
    noise: np.ndarray  # (P, L, G) float32, variance of that; NaN where a pixel stays as it is


@jit
def _is_uniform(moments, specular, plane, pixel):
    """Return whether direct light is one reflectance times irradiance / π all over a pixel."""
    if plane[pixel, FLAT] == 0.0 or moments.coverage[pixel] != 1.0:
        return False
    least, glow = CONSTANT * float(moments.counts[pixel]) ** 2, moments.fluorescence
    for band in range(moments.direct.shape[1]):
        r = moments.reflectance[pixel, band]
        if (
            r == 0.0
            or moments.emission[pixel, band] != 0.0
            or moments.reflectance_spread[pixel, band] > least * r * r
            or (specular is not None and specular.residual_spread[pixel, band] != 0.0)
            or (glow is not None and glow.excitation[pixel, band] != 0.0)
        ):
            return False
    return True


@jit
def _pool(grouped, pixel, left_out):
    """Return the mean over bands in all groups but one, if it is one, and its variance."""
    count, values, total, squares = 0.0, -1.0, 0.0, 0.0
    for group in range(GROUPS):
        if group != left_out:
            count += grouped.passes[group]
            values += grouped.values[group]
            total += grouped.passes[group] * grouped.mean[group, pixel]
    for group in range(GROUPS):
        if group != left_out:
            step = grouped.mean[group, pixel] - total / count
            squares += grouped.spread[group, pixel] + grouped.passes[group] * step * step
    return total / count, squares / (values * count)


@kernel
def compare_pixels(moments, specular, grouped, compared, span):
    """Fill the light of a span of pixels, its variance, and what single pixels compare."""
    bands = moments.direct.shape[1]
    for pixel in range(span.first, span.last):
        compared.noise[pixel, 0, 0] = np.nan
        if not _is_uniform(moments, specular, compared.footprint.plane, pixel):
            continue
        mean, light, count = 0.0, 0.0, float(moments.counts[pixel])
        for band in range(bands):
            mean += moments.direct[pixel, band]
            light += moments.direct[pixel, band] / moments.reflectance[pixel, band]
        factor, whole = light / max(mean, TINY), _pool(grouped, pixel, -1)[1]
        for group in range(GROUPS):
            others, variance = _pool(grouped, pixel, group)
            compared.smooth[pixel, 0, group] = factor * others
            compared.noise[pixel, 0, group] = factor * factor * variance
            passes = grouped.passes[group]
            own = grouped.spread[group, pixel] / ((grouped.values[group] - 1.0) * passes)
            own /= max(whole, TINY) * count * (count - 1.0)
            for band in range(bands):  # its variance, times that in this group over that in all
                r = moments.reflectance[pixel, band]
                compared.light[group, pixel, band] = grouped.sums[group, pixel, band] / (passes * r)
                spread = moments.direct_spread[pixel, band]
                compared.variance[group, pixel, band] = spread * own / (r * r)


@jit
def _is_pair(film, compared, pixel, x, y):
    """Return whether the pixels (x, y) to both sides of one show its surface, and are averaged."""
    column, row, step = pixel % film.width, pixel // film.width, y * film.width + x
    noise, footprint = compared.noise, compared.footprint
    if (
        min(column, film.width - 1 - column) < abs(x)
        or min(row, film.height - 1 - row) < y
        or math.isnan(noise[pixel + step, 0, 0] + noise[pixel - step, 0, 0])
    ):
        return False
    return may_share(footprint, pixel, pixel + step) and may_share(footprint, pixel, pixel - step)


@kernel
def smooth_patches(film, compared, span):
    """Fill `smooth` and `noise` of larger patches in a span of pixels."""
    smooth, noise = compared.smooth, compared.noise
    for pixel in range(span.first, span.last):
        for level in range(1, 1 if math.isnan(noise[pixel, 0, 0]) else len(PATCHES)):
            radius, count = PATCHES[level], 1.0
            for group in range(GROUPS):
                smooth[pixel, level, group] = smooth[pixel, 0, group]
                noise[pixel, level, group] = noise[pixel, 0, group]
            for y in range(radius + 1):
                for x in range(-radius if y > 0 else 1, radius + 1):
                    if _is_pair(film, compared, pixel, x, y):
                        one, other = pixel + y * film.width + x, pixel - y * film.width - x
                        count += 2.0
                        for group in range(GROUPS):
                            smooth[pixel, level, group] += smooth[one, 0, group]
                            smooth[pixel, level, group] += smooth[other, 0, group]
                            noise[pixel, level, group] += noise[one, 0, group]
                            noise[pixel, level, group] += noise[other, 0, group]
            for group in range(GROUPS):
                smooth[pixel, level, group] /= count
                noise[pixel, level, group] /= count * count


@jit
def _apart(radius, x, y):
    """Return the variance of a difference of patches, over that if they had no pixel in common.

    Of the mean of two that are (x, y) pixels away on opposite sides, less the one between.
    """
    side = 2 * radius + 1
    one = max(side - abs(x), 0) * max(side - abs(y), 0)
    two = max(side - 2 * abs(x), 0) * max(side - 2 * abs(y), 0)
    return 1.0 + (two - 4.0 * one) / (3.0 * side * side)


@jit
def _weigh(compared, pixel, step, x, y, weights):
    """Set the weights, (G,), of a pair (x, y) beside the pixel between; return their sum."""
    total = 0.0
    for group in range(GROUPS):
        weight, even = 1.0, 0.0
        for level in range(len(PATCHES)):
            smooth, noise = compared.smooth[:, level, group], compared.noise[:, level, group]
            own, beside = noise[pixel], 0.5 * (noise[pixel + step] + noise[pixel - step])
            off = 0.5 * (smooth[pixel + step] + smooth[pixel - step]) - smooth[pixel]
            variance = STRICTNESS * _apart(PATCHES[level], x, y) * (own + 0.5 * beside)
            weight = min(weight, 1.0 - off * off / max(variance, TINY))
            even = own / max(own, max(beside, TINY))
        weights[group] = max(weight, 0.0) * even  # by the variance over the largest patch
        total += weights[group]
    return total


@jit
def _add_pair(compared, pixel, step, weights, totals, sums):
    """Add a pair's light, less the pixel's, and its variance to sums, (2 N, G)."""
    bands = compared.light.shape[2]
    for group in range(GROUPS):
        weight, light, variance = weights[group], compared.light[group], compared.variance[group]
        totals[group] += 2.0 * weight
        for band in range(bands):
            pair = light[pixel + step, band] + light[pixel - step, band]
            sums[band, group] += weight * (pair - 2.0 * light[pixel, band])
            pair = variance[pixel + step, band] + variance[pixel - step, band]
            sums[bands + band, group] += weight * weight * pair


@kernel
def filter_direct(film, compared, parts, scratch, span, gain, variance):
    """Set what direct light gains, and its new variance, both (P, N) float32, in a span of pixels.

    Gain is NaN where nothing changes. `parts`, (G,), are those of the groups in the mean; scratch,
    (2 N + 2, G) float64, is overwritten.
    """
    bands, radius = gain.shape[1], int(compared.footprint.radius)
    weights, totals = scratch[2 * bands], scratch[2 * bands + 1]
    for pixel in range(span.first, span.last):
        for band in range(bands):
            gain[pixel, band] = np.nan
        if math.isnan(compared.noise[pixel, 0, 0]):
            continue
        pairs = 0
        for group in range(GROUPS):
            totals[group] = 1.0
            for band in range(bands):
                scratch[band, group] = 0.0
                scratch[bands + band, group] = compared.variance[group, pixel, band]
        for y in range(radius + 1):
            for x in range(-radius if y > 0 else 1, radius + 1):
                if x * x + y * y <= radius * radius and _is_pair(film, compared, pixel, x, y):
                    step = y * film.width + x
                    if _weigh(compared, pixel, step, x, y, weights) > 0.0:
                        _add_pair(compared, pixel, step, weights, totals, scratch)
                        pairs += 1
        for band in range(bands if pairs > 0 else 0):
            gain[pixel, band], variance[pixel, band] = 0.0, 0.0
            for group in range(GROUPS):
                part = parts[group] / totals[group]
                gain[pixel, band] += part * scratch[band, group]
                variance[pixel, band] += part * part * scratch[bands + band, group]
