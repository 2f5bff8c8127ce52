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
from photonmap.kernels.film.irradiance_sharing import Strip, find_pairs
from photonmap.kernels.film.moments import copy, welford_step
from photonmap.kernels.film.pixels import FLAT

GROUPS = 4
"""Of passes"""
PATCHES = 0, 1, 2
"""Radii of the patches by which pixels are compared: of 1, 3×3 and 5×5 pixels"""
CONSTANT = 1e-12
"""Variance of reflectance, relative to its square, that is rounding"""
TINY = 1e-30
"""In place of no variance at all"""

_welford_step = jit(welford_step)


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
    """Of K lights on some lines of the image, what pixels are compared by, and what is averaged.

    That is radiance at reflectance 1. Pixels that stay as they are count as not flat in the strip.
    """

    strip: Strip
    pairs: np.ndarray  # (R, 2) int64, columns and lines from a pixel to one of a pair beside it
    strictness: np.ndarray  # (R, L) float32: times a difference's variance, the square to weigh 0
    light: np.ndarray  # (K, 2 N G, P) float32, mean in each group, and its variance by itself
    smooth: np.ndarray  # (K, L, G, P) float32, mean over bands, a patch and all groups but one
    noise: np.ndarray  # (K, L, G, P) float32, variance of that


@by_reference
class LineScratch(NamedTuple):
    """Room for a line of pixels."""

    found: np.ndarray  # (W,) uint8, which are averaged with a pair beside them
    counts: np.ndarray  # (L, W) float32, pixels of patches; pairs, in the second row
    weights: np.ndarray  # (G, W) float32, of that pair
    totals: np.ndarray  # (G, W) float32, of all pairs
    sums: np.ndarray  # (K, 2 N G, W) float32


def make_scratch(compared):
    """Return room for a line."""
    lights, columns, _ = compared.light.shape
    width, single = compared.strip.width, np.float32
    found, counts = np.empty(width, np.uint8), np.empty((len(PATCHES), width), single)
    groups = np.empty((2, GROUPS, width), single)
    return LineScratch(found, counts, *groups, np.empty((lights, columns, width), single))


@kernel
def add_to_group(value, passes, count, span, sums, mean, spread):
    """Take the mean of some passes into what a group has of a light, in a span of pixels.

    `value` is (P, N) float32; the group has `count` passes with them. The rest are rows of its
    arrays in `Grouped`.
    """
    bands = value.shape[1]
    for pixel in range(span.first, span.last):
        average = 0.0
        for band in range(bands):
            sums[pixel, band] += value[pixel, band] * np.float32(passes)
            average += value[pixel, band]
        average /= bands
        mean[pixel], gain, _ = _welford_step(average, mean[pixel], passes / count)
        spread[pixel] += gain * passes


@jit
def _is_uniform(moments, beyond, pixel):
    """Return whether light is one reflectance times irradiance / π all over a pixel.

    Not where what is `beyond` that, (P, N), unless it is None, is not 0.
    """
    if moments.coverage[pixel] != 1.0:
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
def compare_pixels(moments, own, grouped, compared, light):
    """Fill what the pixels of a strip have of one of the lights, and what they compare."""
    bands, flat = own.mean.shape[1], compared.strip.planes[FLAT]
    shown, smooth, noise = compared.light[light], compared.smooth[light], compared.noise[light]
    total, least = 0.0, math.inf
    for group in range(GROUPS):
        total += grouped.passes[group]
        least = min(least, grouped.values[group])
    for pixel in range(len(flat)):
        if flat[pixel] == 0.0 or not _is_uniform(moments, own.beyond, pixel):
            flat[pixel] = 0.0
            continue
        mean, even = 0.0, 0.0
        for band in range(bands):
            mean += own.mean[pixel, band]
            even += own.mean[pixel, band] / moments.reflectance[pixel, band]
        factor, whole = even / mean if mean > 0.0 else 0.0, _pool(grouped, pixel, -1)[1]
        for group in range(GROUPS):
            others, variance = _pool(grouped, pixel, group)
            smooth[0, group, pixel] = factor * others
            noise[0, group, pixel] = factor * factor * variance
            passes = grouped.passes[group]
            if least > 1.0:
                part = grouped.spread[group, pixel] / ((grouped.values[group] - 1.0) * passes)
                part /= max(whole, TINY)
            else:  # one value alone shows no variance
                part = total / passes
            for band in range(bands):  # its variance, times that in this group over that in all
                r = moments.reflectance[pixel, band]
                column = GROUPS * band + group
                shown[column, pixel] = grouped.sums[group, pixel, band] / (passes * r)
                shown[GROUPS * bands + column, pixel] = own.variance[pixel, band] * part


@jit
def _find_line(compared, line, pair, scratch):
    """Find which pixels of a line are averaged with a pair beside them.

    Returns the columns that may be, (first, last), which are none where none is, and its step.
    """
    strip, (x, y) = compared.strip, compared.pairs[pair]
    left, right, step = abs(x), strip.width - abs(x), y * strip.width + x
    if left >= right or min(line, strip.height - 1 - line) < y:
        return 0, 0, step
    found, unused = scratch.found[left:right], scratch.counts[0, left:right]
    find_pairs(strip, line * strip.width + left, step, found, unused)
    return (left, right, step) if found.any() else (0, 0, step)


@vectorized
def _add_found(found, ahead, behind, sums):
    """Add to sums, (n,), the values of the pairs that were found."""
    for i in range(len(found)):
        sums[i] += ahead[i] if found[i] else np.float32(0.0)
        sums[i] += behind[i] if found[i] else np.float32(0.0)


@vectorized
def _count_found(found, counts):
    """Count the pixels of the pairs that were found."""
    for i in range(len(found)):
        counts[i] += np.float32(2.0) * np.float32(found[i])


@vectorized
def _divide(values, counts):
    for i in range(len(counts)):
        values[i] /= counts[i]


@jit
def _add_to_patches(compared, light, level, at, scratch):
    """Add what the pairs found have of a light to the patches around pixels."""
    first, left, right, step = at
    begin, end, found = first + left, first + right, scratch.found[left:right]
    for image in (compared.smooth[light], compared.noise[light]):
        for group in range(GROUPS):
            own, patches = image[0, group], image[level, group, begin:end]
            _add_found(
                found, own[begin + step : end + step], own[begin - step : end - step], patches
            )


@kernel
def smooth_patches(compared, scratch):
    """Fill what larger patches compare, of all lights."""
    width, counts, images = compared.strip.width, scratch.counts, (compared.smooth, compared.noise)
    for line in range(compared.strip.height):
        counts[:] = 1.0
        whole = slice(line * width, (line + 1) * width)
        for light in range(len(compared.light)):
            for level in range(1, len(PATCHES)):
                for group in range(GROUPS):
                    for image in images:
                        copy(image[light, 0, group, whole], image[light, level, group, whole])
        for pair in range(len(compared.pairs)):
            reach, first = max(abs(compared.pairs[pair, 0]), compared.pairs[pair, 1]), line * width
            left, right, step = 0, 0, 0
            if reach <= PATCHES[len(PATCHES) - 1]:
                left, right, step = _find_line(compared, line, pair, scratch)
            for level in range(1, len(PATCHES) if right > 0 else 0):
                if reach <= PATCHES[level]:
                    _count_found(scratch.found[left:right], counts[level, left:right])
                    for light in range(len(compared.light)):
                        _add_to_patches(compared, light, level, (first, left, right, step), scratch)
        for level in range(1, len(PATCHES)):
            for light in range(len(compared.light)):
                for group in range(GROUPS):
                    _divide(compared.smooth[light, level, group, whole], counts[level])
                    _divide(compared.noise[light, level, group, whole], counts[level])
                    _divide(compared.noise[light, level, group, whole], counts[level])


@vectorized
def _begin(found, noise, weights):
    """Set weights, (n,), to 1 where a pair was found, unless a pixel has no noise of its own.

    Such a one takes none from others.
    """
    for i in range(len(found)):
        weights[i] = 1.0 if found[i] and noise[i] > 0.0 else 0.0


@vectorized
def _lower(smooth, noise, strictness, group, first, step, weights):
    """Lower weights, (n,), of pairs a `step` to both sides of pixels to what a light allows.

    They are those of passes of one group; smooth and noise, (L, G, P), are of that light.
    """
    here, ahead, behind = np.uint64(first), np.uint64(first + step), np.uint64(first - step)
    last, half = len(PATCHES) - 1, np.float32(0.5)
    for i in range(len(weights)):
        j, own = np.uint64(i), np.float32(1.0)
        for level in range(len(PATCHES)):
            off = half * (smooth[level, group, ahead + j] + smooth[level, group, behind + j])
            off -= smooth[level, group, here + j]
            beside = noise[level, group, ahead + j] + noise[level, group, behind + j]
            variance = noise[level, group, here + j] + half * half * beside
            variance = max(strictness[level] * variance, np.float32(TINY))
            own = min(own, np.float32(1.0) - off * off / variance)
        # by the variance over the largest patch
        noisy = max(noise[last, group, here + j], np.float32(TINY))
        beside = half * (noise[last, group, ahead + j] + noise[last, group, behind + j])
        even = noisy / max(noisy, beside)
        weights[i] = min(weights[i], max(own, np.float32(0.0)) * even)


@vectorized
def _add_means(light, first, step, weights, sums):
    """Add to sums, (n,), what pairs have in a column of light, (P,), less what pixels have."""
    here, ahead, behind = np.uint64(first), np.uint64(first + step), np.uint64(first - step)
    for i in range(len(weights)):
        j = np.uint64(i)
        pair = light[ahead + j] + light[behind + j]
        sums[i] += weights[i] * (pair - np.float32(2.0) * light[here + j])


@vectorized
def _add_variances(light, first, step, weights, sums):
    """Add to sums, (n,), the variances that pairs have in a column of light, (P,)."""
    ahead, behind = np.uint64(first + step), np.uint64(first - step)
    for i in range(len(weights)):
        j = np.uint64(i)
        sums[i] += weights[i] * weights[i] * (light[ahead + j] + light[behind + j])


@vectorized
def _add_weights(weights, totals, counts):
    """Add the weights of pairs to totals, (n,), and count pairs that have any."""
    for i in range(len(weights)):
        totals[i] += np.float32(2.0) * weights[i]
        counts[i] += np.float32(weights[i] > 0.0)


@jit
def _add_pairs(compared, line, scratch):
    """Add up the pairs beside the pixels of a line."""
    found, half = scratch.found, compared.light.shape[1] // 2
    first, counts = line * compared.strip.width, scratch.counts[1]
    for pair in range(len(compared.pairs)):
        left, right, step = _find_line(compared, line, pair, scratch)
        for group in range(GROUPS if right > 0 else 0):
            weights, here = scratch.weights[group, left:right], first + left
            noise = compared.noise[0, len(PATCHES) - 1, group, here : first + right]
            _begin(found[left:right], noise, weights)
            for light in range(len(compared.light)):
                smooth, own = compared.smooth[light], compared.noise[light]
                _lower(smooth, own, compared.strictness[pair], group, here, step, weights)
            _add_weights(weights, scratch.totals[group, left:right], counts[left:right])
            for light in range(len(compared.light)):
                shown, sums = compared.light[light], scratch.sums[light]
                for column in range(group, half, GROUPS):
                    mean, variance = sums[column, left:right], sums[half + column, left:right]
                    _add_means(shown[column], here, step, weights, mean)
                    _add_variances(shown[half + column], here, step, weights, variance)


@kernel
def filter_light(compared, parts, lines, scratch, gain, variance):
    """Set what light gains in each group, (K, P, N, G), and the variance of its mean, (K, P, N).

    Of a span of lines of the strip, both float32. Gain is NaN where nothing changes. `parts`,
    (G,), are those of the groups in the mean.
    """
    lights, _, bands, _ = gain.shape
    width, half = compared.strip.width, bands * GROUPS
    totals, sums, counts = scratch.totals, scratch.sums, scratch.counts[1]
    for line in range(lines.first, lines.last):
        first = line * width
        totals[:], counts[:], sums[:, :half] = 1.0, 0.0, 0.0
        for light in range(lights):
            for row in range(half, 2 * half):
                copy(compared.light[light, row, first : first + width], sums[light, row])
        _add_pairs(compared, line, scratch)
        for column in range(width):
            pixel = (line - lines.first) * width + column
            if counts[column] == 0.0:
                gain[:, pixel] = np.nan
                continue
            for light in range(lights):
                for band in range(bands):
                    after = 0.0
                    for group in range(GROUPS):
                        row, total = GROUPS * band + group, totals[group, column]
                        gain[light, pixel, band, group] = sums[light, row, column] / total
                        after += (parts[group] / total) ** 2 * sums[light, half + row, column]
                    variance[light, pixel, band] = after
