"""What averaging gains in the sum over a block of pixels, given back to them.

It is a bias, which is so known with little noise. Pixels of one reflectance are taken together.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.core.record_types import by_reference

ALIKE = 1e-6
"""By which reflectances that are one differ at most: means of equal samples differ by rounding"""
TINY = 1e-300
"""In place of no sum at all"""


@by_reference
class Averaged(NamedTuple):
    """One kind of light in P pixels, and what averaging makes of it, over reflectance."""

    mean: np.ndarray  # (P, N) float64, of the light before
    variance: np.ndarray  # (P, N) float64, of its mean over reflectance
    reflectance: np.ndarray  # (P, N) float32
    shown: np.ndarray  # (N G, P) float32, its mean over reflectance in each group of passes
    parts: np.ndarray  # (G,) float64, of groups in the mean
    gain: np.ndarray  # (P, N, G) float32, in each group; NaN where nothing changes
    after: np.ndarray  # (P, N) float32, variance of the mean with that


@by_reference
class Returned(NamedTuple):
    """What is left of it, of light over reflectance."""

    gain: np.ndarray  # (P, N) float32; NaN where nothing changes
    stated: np.ndarray  # (P, N) float32, variance of its mean, if the noise of pixels is their own
    between: np.ndarray  # (P, N) float32, variance of its mean that differences of groups show


@by_reference
class BlockScratch(NamedTuple):
    """Room for a block of a side of S pixels."""

    members: np.ndarray  # (S S,) int64, pixels that are averaged
    gain: np.ndarray  # (N, G) float64, sums over some of them: of gain,
    variance: np.ndarray  # (N,) float64, and of variance before


def make_block_scratch(side, bands, groups):
    """Return room for a block."""
    sums = np.empty((bands, groups)), np.empty(bands)
    return BlockScratch(np.empty(side * side, np.int64), *sums)


@jit
def _list_averaged(averaged, lines, columns, width, members, out):
    """List the pixels of some lines and columns that are averaged; return how many they are."""
    count = 0
    for line in range(lines[0], lines[1]):
        for pixel in range(line * width + columns[0], line * width + columns[1]):
            if np.isnan(averaged.gain[pixel, 0, 0]):
                out.gain[pixel] = np.nan
            else:
                members[count] = pixel
                count += 1
    return count


@jit
def _is_alike(reflectance, pixel, other):
    for band in range(reflectance.shape[1]):
        if abs(reflectance[pixel, band] - reflectance[other, band]) > ALIKE:
            return False
    return True


@jit
def _gather_alike(reflectance, members, first, count):
    """Move the pixels of the first one's reflectance to the front; return where others begin."""
    end = first + 1
    for i in range(first + 1, count):
        if _is_alike(reflectance, members[i], members[first]):
            members[i], members[end] = members[end], members[i]
            end += 1
    return end


@jit
def _gain_of(averaged, pixel, band):
    """Return what the mean of a pixel gains."""
    total = 0.0
    for group in range(len(averaged.parts)):
        total += averaged.parts[group] * averaged.gain[pixel, band, group]
    return total


@jit
def _value_of(averaged, pixel, band):
    """Return the mean of a pixel, over reflectance, with all that it gains."""
    before = averaged.mean[pixel, band] / averaged.reflectance[pixel, band]
    return before + _gain_of(averaged, pixel, band)


@jit
def _add_up(averaged, members, scratch):
    """Fill sums over pixels; return those of variance and light, (2,), and of what light gains."""
    bands, groups = scratch.gain.shape
    scratch.gain[:], scratch.variance[:] = 0.0, 0.0
    variance = gained = light = 0.0
    for pixel in members:
        for band in range(bands):
            for group in range(groups):
                scratch.gain[band, group] += averaged.gain[pixel, band, group]
            scratch.variance[band] += averaged.variance[pixel, band]
            variance += averaged.variance[pixel, band]
            gained += averaged.reflectance[pixel, band] * _gain_of(averaged, pixel, band)
            light += _value_of(averaged, pixel, band)
    return (max(variance, TINY), max(light, TINY)), gained


@jit
def _share(averaged, pixel, sums, by_light):
    """Return the share of a pixel in the sums over bands of variance, or of light."""
    own = 0.0
    for band in range(averaged.mean.shape[1]):
        value = averaged.variance[pixel, band]
        own += _value_of(averaged, pixel, band) if by_light else value
    return own / (sums[1] if by_light else sums[0])


@jit
def _exceeds_light(averaged, members, sums, scratch):
    """Return whether pixels would return more than the light of one of them."""
    for pixel in members:
        share = _share(averaged, pixel, sums, False)
        for band in range(len(scratch.variance)):
            returned = 0.0
            for group in range(len(averaged.parts)):
                returned += averaged.parts[group] * scratch.gain[band, group]
            if share * returned > _value_of(averaged, pixel, band):
                return True
    return False


@jit
def _return_gain(averaged, pixel, share, scratch, out):
    """Fill what is left of a pixel that returns a share of the sums."""
    groups = len(averaged.parts)
    for band in range(len(scratch.variance)):
        left = mean = between = 0.0
        for group in range(groups):
            own = averaged.gain[pixel, band, group] - share * scratch.gain[band, group]
            left += averaged.parts[group] * own
            mean += averaged.parts[group] * (own + averaged.shown[groups * band + group, pixel])
        for group in range(groups):
            own = averaged.gain[pixel, band, group] - share * scratch.gain[band, group]
            off = own + averaged.shown[groups * band + group, pixel] - mean
            between += averaged.parts[group] * off * off
        out.gain[pixel, band] = left
        out.stated[pixel, band] = averaged.after[pixel, band] + share**2 * scratch.variance[band]
        out.between[pixel, band] = between / (groups - 1)


@jit
def _give_back_alike(averaged, members, scratch, out):
    """Give back what pixels of one reflectance gained together.

    Return the sums of what light gained, and of light over reflectance.
    """
    sums, gained = _add_up(averaged, members, scratch)
    by_light = _exceeds_light(averaged, members, sums, scratch)
    for pixel in members:
        share = _share(averaged, pixel, sums, by_light)
        _return_gain(averaged, pixel, share, scratch, out)
    return gained, sums[1]


@kernel
def give_back(averaged, width, side, scratch, out):
    """Take from gain what pixels of a block of `side` pixels gained together; fill what is left.

    Pixels return it in proportion to their variance before, those that vary alone all of it; where
    that is more than the light of one of them, in proportion to light. Shares are those of all
    bands, so that the light keeps its colour. What is stated includes the variance of all that
    blocks hold. Returns sums over averaged pixels and bands: of what light was to gain, and of
    light over reflectance.
    """
    lines, members, gained, light = len(averaged.mean) // width, scratch.members, 0.0, 0.0
    for line in range(0, lines, side):
        for column in range(0, width, side):
            span = (line, min(line + side, lines)), (column, min(column + side, width))
            count, first = _list_averaged(averaged, *span, width, members, out), 0
            while first < count:
                end = _gather_alike(averaged.reflectance, members, first, count)
                sums = _give_back_alike(averaged, members[first:end], scratch, out)
                gained, light, first = gained + sums[0], light + sums[1], end
    return gained, light
