"""Light averaged over pixels of one surface, where other passes show it to be the same.

Passes form groups. How far the light of two pixels on opposite sides is from that between them is
seen in all groups but one, by single pixels and over patches; the light of that one is averaged by
what follows. So weights are independent of the noise that they average, and of its variance, which
is that within the group, unless a group is a single value. A pair cancels what changes linearly.

Where light is split by light group, or there are several illuminations, all these lights are
averaged by the same weights, which each of them allows.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.core.jit import jit, kernel, vectorized
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.film.irradiance_sharing import Footprint, may_share
from photonmap.kernels.film.pixels import FLAT

GROUPS = 4
"""Of passes"""
PATCHES = 0, 1, 2
"""Radii of the patches by which pixels are compared: of 1, 3×3 and 5×5 pixels"""
CONSTANT = 1e-12
"""Variance of reflectance, relative to its square, that is rounding"""
TINY = 1e-30
"""In place of no variance at all"""


@by_reference
class Grouped(NamedTuple):
    """Light of G groups of passes, and its mean over bands."""

    sums: np.ndarray  # (G, P, N) float32, over passes
    mean: np.ndarray  # (G, P) float64, over passes and bands
    spread: np.ndarray  # (G, P) float32, of that: squared deviations, times passes of each value
    passes: np.ndarray  # (G,) float64, how many
    values: np.ndarray  # (G,) float64, how many replicates they form


@by_reference
class Own(NamedTuple):
    """One kind of light in pixels before it is averaged."""

    mean: np.ndarray  # (P, N) float64
    variance: np.ndarray  # (P, N) float64, of its mean over reflectance
    beyond: np.ndarray | None  # (P, N) float32, what stays as it is where this is not 0


@by_reference
class Compared(NamedTuple):
    """What pixels are compared by, and what is averaged: of radiance at reflectance 1.

    Of K lights, `noise` of the first tells which pixels stay as they are: by NaN.
    """

    footprint: Footprint  # which pixels show one surface
    pairs: np.ndarray  # (R, 2) int64, columns and lines from a pixel to one of a pair beside it
    strictness: np.ndarray  # (R, L) float32: times a difference's variance, the square to weigh 0
    light: np.ndarray  # (K, P, 2 N G) float32, mean in each group, and its variance by itself
    smooth: np.ndarray  # (K, P, L, G) float32, mean over bands, a patch and all groups but one
    noise: np.ndarray  # (K, P, L, G) float32, variance of that


@jit
def _is_uniform(moments, beyond, plane, pixel):
    """Return whether light is one reflectance times irradiance / π all over a pixel.

    Not where what is `beyond` that, (P, N), unless it is None, is not 0.
    """
    if plane[pixel, FLAT] == 0.0 or moments.coverage[pixel] != 1.0:
        return False
    least, glow = CONSTANT * float(moments.counts[pixel]) ** 2, moments.fluorescence
    for band in range(moments.direct.shape[1]):
        r = moments.reflectance[pixel, band]
        if (
            r == 0.0
            or moments.emission[pixel, band] != 0.0
            or moments.reflectance_spread[pixel, band] > least * r * r
            or (beyond is not None and beyond[pixel, band] != 0.0)
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
def compare_pixels(moments, own, grouped, compared, light, span):
    """Fill what pixels of a span have of one of the lights, its variance, and what they compare."""
    bands, all_noise = own.mean.shape[1], compared.noise[0]
    shown, smooth, noise = compared.light[light], compared.smooth[light], compared.noise[light]
    total, least = 0.0, math.inf
    for group in range(GROUPS):
        total += grouped.passes[group]
        least = min(least, grouped.values[group])
    for pixel in range(span.first, span.last):
        if not _is_uniform(moments, own.beyond, compared.footprint.plane, pixel):
            all_noise[pixel, 0, 0] = np.nan
        if math.isnan(all_noise[pixel, 0, 0]):
            continue
        mean, even = 0.0, 0.0
        for band in range(bands):
            mean += own.mean[pixel, band]
            even += own.mean[pixel, band] / moments.reflectance[pixel, band]
        factor, whole = even / mean if mean > 0.0 else 0.0, _pool(grouped, pixel, -1)[1]
        for group in range(GROUPS):
            others, variance = _pool(grouped, pixel, group)
            smooth[pixel, 0, group] = factor * others
            noise[pixel, 0, group] = factor * factor * variance
            passes = grouped.passes[group]
            if least > 1.0:
                part = grouped.spread[group, pixel] / ((grouped.values[group] - 1.0) * passes)
                part /= max(whole, TINY)
            else:  # one value alone shows no variance
                part = total / passes
            for band in range(bands):  # its variance, times that in this group over that in all
                r = moments.reflectance[pixel, band]
                column = GROUPS * band + group
                shown[pixel, column] = grouped.sums[group, pixel, band] / (passes * r)
                shown[pixel, GROUPS * bands + column] = own.variance[pixel, band] * part


@jit
def _step_of_pair(film, compared, pixel, pair):
    """Return how many pixels apart those of a pair beside one are; 0 if they are not averaged."""
    x, y = compared.pairs[pair]
    column, row, step = pixel % film.width, pixel // film.width, y * film.width + x
    noise, footprint = compared.noise[0], compared.footprint
    if (
        min(column, film.width - 1 - column) < abs(x)
        or min(row, film.height - 1 - row) < y
        or math.isnan(noise[pixel + step, 0, 0] + noise[pixel - step, 0, 0])
        or not may_share(footprint, pixel, pixel + step)
        or not may_share(footprint, pixel, pixel - step)
    ):
        return 0
    return step


@jit
def _add_patch(patch, pixel, level):
    """Add to a larger patch what a pixel has by itself."""
    for group in range(GROUPS):
        patch[level, group] += pixel[0, group]


@kernel
def smooth_patches(film, compared, light, span):
    """Fill what larger patches of a span of pixels compare, of one of the lights."""
    smooth, noise = compared.smooth[light], compared.noise[light]
    for pixel in range(span.first, span.last):
        for level in range(1, 1 if math.isnan(compared.noise[0, pixel, 0, 0]) else len(PATCHES)):
            for group in range(GROUPS):
                smooth[pixel, level, group] = smooth[pixel, 0, group]
                noise[pixel, level, group] = noise[pixel, 0, group]
            count = 1.0
            for pair in range(len(compared.pairs)):
                if max(abs(compared.pairs[pair, 0]), compared.pairs[pair, 1]) <= PATCHES[level]:
                    step = _step_of_pair(film, compared, pixel, pair)
                    if step > 0:
                        count += 2.0
                        for side in (step, -step):
                            _add_patch(smooth[pixel], smooth[pixel + side], level)
                            _add_patch(noise[pixel], noise[pixel + side], level)
            for group in range(GROUPS):
                smooth[pixel, level, group] /= count
                noise[pixel, level, group] /= count * count


@vectorized
def _weigh(compared, light, pixel, step, pair, own, weights):
    """Lower the weights, (G,), of a pair a `step` to both sides of a pixel to what a light allows.

    They are those of passes of each group; `own` is overwritten. Returns their sum.
    """
    smooth, noise, strictness = compared.smooth, compared.noise, compared.strictness
    here, ahead, behind = np.uint64(pixel), np.uint64(pixel + step), np.uint64(pixel - step)
    total, last, half = np.float32(0.0), len(PATCHES) - 1, np.float32(0.5)
    for group in range(GROUPS):
        own[group] = np.float32(1.0)
    for level in range(len(PATCHES)):
        for group in range(GROUPS):
            off = half * (smooth[light, ahead, level, group] + smooth[light, behind, level, group])
            off -= smooth[light, here, level, group]
            beside = noise[light, ahead, level, group] + noise[light, behind, level, group]
            variance = noise[light, here, level, group] + half * half * beside
            variance = max(strictness[pair, level] * variance, np.float32(TINY))
            own[group] = min(own[group], np.float32(1.0) - off * off / variance)
    for group in range(GROUPS):  # by the variance over the largest patch
        noisy = max(noise[light, here, last, group], np.float32(TINY))
        beside = half * (noise[light, ahead, last, group] + noise[light, behind, last, group])
        even = noisy / max(noisy, beside)
        weights[group] = min(weights[group], max(own[group], np.float32(0.0)) * even)
        total += weights[group]
    return total


@jit
def _weigh_all(compared, pixel, step, pair, own, weights):
    """Set the weights of a pair, (G,), to what all lights allow; return their sum."""
    total, last = 1.0, len(PATCHES) - 1
    for group in range(GROUPS):  # what has no noise of its own takes none from others
        weights[group] = 1.0 if compared.noise[0, pixel, last, group] > 0.0 else 0.0
    for light in range(len(compared.noise)):
        if total > 0.0:
            total = _weigh(compared, light, pixel, step, pair, own, weights)
    return total


@vectorized
def _add_pair(shown, light, pixel, step, factors, sums):
    """Add what a pair has of a light, less the pixel's, and its variance to sums, (K, 2 N G).

    Both times factors, (2, 2 N G): those of a pair, and of the pixel itself beside it.
    """
    here, ahead, behind = np.uint64(pixel), np.uint64(pixel + step), np.uint64(pixel - step)
    for column in range(sums.shape[1]):
        pair = shown[light, ahead, column] + shown[light, behind, column]
        pair -= factors[1, column] * shown[light, here, column]
        sums[light, column] += factors[0, column] * pair


@kernel
def filter_light(film, compared, parts, scratch, span, gain, variance):
    """Set what light gains in each group, (K, P, N, G), and the variance of its mean.

    (K, P, N), both float32, in a span of pixels. Gain is NaN where nothing changes. `parts`, (G,),
    are those of the groups in the mean; scratch is overwritten: weights, (3, G), factors,
    (2, 2 N G), and sums, (K, 2 N G), float32.
    """
    lights, _, bands, _ = gain.shape
    (allowed, own, totals), factors, sums = scratch
    half = bands * GROUPS
    for column in range(2 * half):
        factors[1, column] = 2.0 if column < half else 0.0
    for pixel in range(span.first, span.last):
        gain[0, pixel, 0, 0] = np.nan
        if math.isnan(compared.noise[0, pixel, 0, 0]):
            continue
        pairs = 0
        for group in range(GROUPS):
            totals[group] = 1.0
        for light in range(lights):
            for column in range(half):
                sums[light, column] = 0.0
                sums[light, half + column] = compared.light[light, pixel, half + column]
        for pair in range(len(compared.pairs)):
            step = _step_of_pair(film, compared, pixel, pair)
            if step > 0 and _weigh_all(compared, pixel, step, pair, own, allowed) > 0.0:
                for band in range(bands):
                    for group in range(GROUPS):
                        factors[0, GROUPS * band + group] = allowed[group]
                        factors[0, half + GROUPS * band + group] = allowed[group] * allowed[group]
                for light in range(lights):
                    _add_pair(compared.light, light, pixel, step, factors, sums)
                for group in range(GROUPS):
                    totals[group] += np.float32(2.0) * allowed[group]
                pairs += 1
        for light in range(lights if pairs > 0 else 0):
            for band in range(bands):
                after = 0.0
                for group in range(GROUPS):
                    column = GROUPS * band + group
                    gain[light, pixel, band, group] = sums[light, column] / totals[group]
                    after += (parts[group] / totals[group]) ** 2 * sums[light, half + column]
                variance[light, pixel, band] = after
