"""Running means and spreads over passes, per pixel and band (Welford 1962).

A spread is a sum of squared deviations from a mean, a co-moment a sum of products of the deviations
of two quantities. `welford_step` and `shift_ratio` serve NumPy's arrays too.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.core import passes
from photonmap.kernels.core.jit import jit, kernel, vectorized
from photonmap.kernels.core.record_types import by_reference

GOAL_BUFFERS = (
    "radiance", "direct", "indirect", "caustics", "residual", "fluorescence", "shading",
)  # fmt: skip
"""Buffers whose error may be asked for; kernels take their index"""
RADIANCE, DIRECT, INDIRECT, CAUSTICS, RESIDUAL, FLUORESCENCE, SHADING = range(len(GOAL_BUFFERS))


def welford_step(value, mean, weight):
    """Take one value more into a mean, with weight 1 / count (Welford 1962).

    Returns the new mean, what its spread gains, and the deviation from the old mean.
    """
    deviation = value - mean
    new_mean = mean + deviation * weight
    return new_mean, deviation * (value - new_mean), deviation


def shift_ratio(spread, comoment, denominator_spread, old, new):
    """Return the spread of x − new·y from that of x − old·y: the delta method.

    To first order, the ratio ρ of the means of x and y has the error of the mean of x − ρ y over
    the mean of y. So `old` is 0 where the spread is that of x itself. With an earlier ratio as
    `old`, an error known about it moves to another, without the cancellation of going through x.
    `spread` is that of x − old·y, `comoment` of x and y, `denominator_spread` of y.
    """
    step = new - old
    return spread - 2.0 * step * comoment + step * (new + old) * denominator_spread


_shift_ratio = jit(shift_ratio)


@vectorized
def copy(values, target):
    """Copy values into the first places of a row."""
    for i in range(len(values)):
        target[i] = values[i]


@by_reference
class FluorescenceMoments(NamedTuple):
    """What scenes with fluorescent surfaces have beside `Moments`: parts of direct and indirect."""

    fluorescence: np.ndarray  # what first hits re-emit
    fluorescence_direct: np.ndarray
    fluorescence_indirect: np.ndarray
    excitation: np.ndarray  # of irradiance / π, what makes them do so
    fluorescence_spread: np.ndarray
    fluorescence_direct_spread: np.ndarray
    fluorescence_indirect_spread: np.ndarray
    excitation_spread: np.ndarray


@by_reference
class Moments(NamedTuple):
    """Means, (P, N) float64, and sums of squared deviations, (P, N) float32, over passes.

    radiance = emission + direct + indirect, and diffuse is what of the last two first hits reflect
    by Lambert's law;
    `product` is the sum of products of the deviations of diffuse and reflectance, from which the
    error of their ratio follows.
    """

    emission: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    reflectance: np.ndarray
    irradiance: np.ndarray  # direct + indirect irradiance / π
    emission_spread: np.ndarray
    direct_spread: np.ndarray
    indirect_spread: np.ndarray
    reflectance_spread: np.ndarray
    irradiance_spread: np.ndarray
    diffuse_spread: np.ndarray
    radiance_spread: np.ndarray
    product: np.ndarray
    coverage: np.ndarray  # (P,) float64, mean
    found: np.ndarray  # (P,) uint8, flags of all passes, as in `Pixels`
    counts: np.ndarray  # (P,) uint32, passes taken into each pixel
    fluorescence: FluorescenceMoments | None = None  # None where no surface fluoresces


@by_reference
class SpecularMoments(NamedTuple):
    """What scenes with specular surfaces have beside `Moments`: parts of direct and indirect."""

    caustics: np.ndarray
    residual: np.ndarray
    """what is not the reflection of first hits: all that is seen in mirrors and through glass"""
    caustics_spread: np.ndarray
    residual_spread: np.ndarray


class Weight(NamedTuple):
    """How a value, the mean of some passes, is taken in: see `photonmap.film.replicates`."""

    part: float  # number of these passes; in a pixel, over that of all so far
    keep: float  # factor on the spread so far
    gain: float  # factor on what the spread gains


@kernel
def change_light(change, counts, reflectance, light, spreads, first, last):
    """Change the mean of direct or indirect light of some pixels by a gain over reflectance.

    `change` is that gain and the variance of the mean with it, over reflectance, (P, N); where gain
    is NaN, nothing changes. `light` is the mean, its spread, and that of the other light, with
    which it remains as correlated as it was; `spreads` are those of diffuse light and radiance,
    which are the same there.
    """
    gain, variance = change
    mean, spread, others = light
    diffuse_spread, radiance_spread = spreads
    for pixel in range(first, last):
        count = float(counts[pixel])
        for band in range(mean.shape[1]):
            if math.isnan(gain[pixel, band]):
                continue
            r, old = reflectance[pixel, band], float(spread[pixel, band])
            new = variance[pixel, band] * r * r * max(count * (count - 1.0), 1.0)
            both = radiance_spread[pixel, band] - (old + others[pixel, band])
            both *= math.sqrt(new / old) if old > 0.0 else 1.0
            whole = max(new + others[pixel, band] + both, 0.0)
            mean[pixel, band] = max(mean[pixel, band] + gain[pixel, band] * r, 0.0)
            spread[pixel, band] = new
            diffuse_spread[pixel, band] = radiance_spread[pixel, band] = whole


@jit
def is_valid(moments, lit, pixel):
    """Return whether a pixel is valid: covered by surfaces, none of which emits, and resolved.

    Where photons are stored (`lit`), gather rays must have met some of their light, or no surface
    at all: a pixel is unresolved otherwise. `relative_error.valid_pixels` does the same for images.
    """
    if lit and (moments.found[pixel] & (passes.EMPTY | passes.FOUND)) == passes.EMPTY:
        return False
    for band in range(moments.emission.shape[1]):
        if moments.emission[pixel, band] != 0.0:
            return False
    return moments.coverage[pixel] == 1.0


@jit
def _shading(moments, specular, pixel, band):
    """Return shading and its spread."""
    # The ratio of diffuse light to reflectance where that is not 0, with the spread of a ratio by
    # the delta method; the mean irradiance / π elsewhere. Diffuse light is what remains without the
    # residual and fluorescence; where that is nothing, rounding would leave less. Fluorescence may
    # light other surfaces by less than nothing in a band, by what its bands cannot hold.
    r = moments.reflectance[pixel, band]
    if r == 0.0:
        return moments.irradiance[pixel, band], float(moments.irradiance_spread[pixel, band])
    light = moments.direct[pixel, band] + moments.indirect[pixel, band]
    light -= 0.0 if specular is None else specular.residual[pixel, band]
    if moments.fluorescence is not None:
        light -= moments.fluorescence.fluorescence[pixel, band]
        s = light / r
    else:
        s = max(light, 0.0) / r
    spread = _shift_ratio(
        moments.diffuse_spread[pixel, band],
        moments.product[pixel, band],
        moments.reflectance_spread[pixel, band],
        0.0,
        s,
    )
    return s, max(spread / (r * r), 0.0)


@jit
def _specular_light(specular, buffer, pixel, band):
    """Return the mean and spread of caustics or residual: 0 without a specular part."""
    if specular is None:
        return 0.0, 0.0
    if buffer == CAUSTICS:
        return specular.caustics[pixel, band], float(specular.caustics_spread[pixel, band])
    return specular.residual[pixel, band], float(specular.residual_spread[pixel, band])


@jit
def _fluorescence(fluorescence, pixel, band):
    """Return the mean and spread of fluorescence: 0 where no surface fluoresces."""
    if fluorescence is None:
        return 0.0, 0.0
    spread = fluorescence.fluorescence_spread[pixel, band]
    return fluorescence.fluorescence[pixel, band], float(spread)


@jit
def _light(moments, specular, buffer, pixel, band):
    """Return the mean and spread of a buffer of `GOAL_BUFFERS`, where nothing emits."""
    if buffer == RADIANCE:
        value = moments.direct[pixel, band] + moments.indirect[pixel, band]
        return value, float(moments.radiance_spread[pixel, band])
    if buffer == DIRECT:
        return moments.direct[pixel, band], float(moments.direct_spread[pixel, band])
    if buffer == INDIRECT:
        return moments.indirect[pixel, band], float(moments.indirect_spread[pixel, band])
    if buffer == SHADING:
        return _shading(moments, specular, pixel, band)
    if buffer == FLUORESCENCE:
        return _fluorescence(moments.fluorescence, pixel, band)
    return _specular_light(specular, buffer, pixel, band)


@kernel
def sum_valid(moments, specular, buffer, lit, first, last, total):
    """Set total (N + 1,) to the sums of a buffer over valid pixels, and their number."""
    total[:] = 0.0
    for pixel in range(first, last):
        if is_valid(moments, lit, pixel):
            total[-1] += 1.0
            for band in range(moments.direct.shape[1]):
                total[band] += _light(moments, specular, buffer, pixel, band)[0]


@jit
def _relative_variance(moments, specular, buffer, floor, pixel, band):
    """Return SE² / (v² + floor); infinite before the pixel's second pass."""
    count = float(moments.counts[pixel])
    if count < 2.0:
        return math.inf
    value, spread = _light(moments, specular, buffer, pixel, band)
    norm = value * value + floor[band]
    return spread * (1.0 / (count * (count - 1.0))) / norm if norm > 0.0 else 0.0


@kernel
def sum_relative_variance(moments, specular, buffer, lit, floor, weights, first, last):
    """Sum weights, (N,), · SE² / (v² + floor), (N,), over valid pixels first..last and bands."""
    total = 0.0
    for pixel in range(first, last):
        if is_valid(moments, lit, pixel):
            for band in range(len(floor)):
                variance = _relative_variance(moments, specular, buffer, floor, pixel, band)
                total += weights[band] * variance
    return total


@kernel
def list_relative_variance(moments, specular, buffer, lit, floor, first, last, out):
    """Write SE² / (v² + floor) of valid pixels first..last from row `first` on.

    floor is (N,), out (P, N) float32; returns how many rows were written.
    """
    row = first
    for pixel in range(first, last):
        if is_valid(moments, lit, pixel):
            for band in range(len(floor)):
                out[row, band] = _relative_variance(moments, specular, buffer, floor, pixel, band)
            row += 1
    return row - first


@kernel
def finish_shading(moments, specular, first, last, factor, shading, error):
    """Fill shading · factor, and its error from a second pass on, (P, N), of first..last."""
    for pixel in range(first, last):
        count = float(moments.counts[pixel])
        scale = 1.0 / (count * max(count - 1.0, 1.0))
        for band in range(shading.shape[1]):
            value, spread = _shading(moments, specular, pixel, band)
            shading[pixel, band] = value * factor
            if count > 1.0:
                error[pixel, band] = factor * math.sqrt(spread * scale)
