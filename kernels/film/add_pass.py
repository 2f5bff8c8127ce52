"""A pass is taken into the moments, some pixels and bands at a time, quantity by quantity.

So each loop is over few arrays, which it turns into vectors.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.core import passes
from photonmap.kernels.core.jit import jit, kernel, vectorized
from photonmap.kernels.core.record_types import by_reference
from photonmap.kernels.core.warp import INV_PI
from photonmap.kernels.film.moments import copy, welford_step

CHUNK = 512
"""Pixels times bands at a time, about: they stay in the first cache"""

_welford_step = jit(welford_step)


@by_reference
class ChunkScratch(NamedTuple):
    """Room for a chunk of n pixels times bands: (n,) float64 each."""

    parts: np.ndarray  # of the pass in the mean
    term: np.ndarray  # of a quantity
    value: np.ndarray  # of a quantity
    unused: np.ndarray  # a deviation that nothing asks for
    emission: np.ndarray  # deviations from old means, of this and the following
    direct: np.ndarray
    indirect: np.ndarray
    reflectance: np.ndarray
    residual: np.ndarray  # with fluorescence


def make_chunk_scratch(bands):
    """Return room for a chunk, which holds whole pixels."""
    size = max(CHUNK // bands, 1) * bands
    return ChunkScratch(*np.zeros((len(ChunkScratch._fields), size)))


@vectorized
def _add(values, target):
    for i in range(len(values)):
        target[i] += values[i]


@vectorized
def _subtract(values, target):
    for i in range(len(values)):
        target[i] -= values[i]


@vectorized
def _scale(factor, target):
    for i in range(len(target)):
        target[i] *= factor


@vectorized
def _step(value, parts, weight, mean, spread, deviation):
    """Take values into means and their spreads; fill their deviations from the old means."""
    for i in range(len(mean)):
        mean[i], gain, deviation[i] = _welford_step(value[i], mean[i], parts[i])
        spread[i] = spread[i] * weight.keep + gain * weight.gain


@vectorized
def _widen(one, other, parts, weight, spread):
    """Take products of two deviations into their sums."""
    for i in range(len(spread)):
        gain = one[i] * other[i] * (1.0 - parts[i])
        spread[i] = spread[i] * weight.keep + gain * weight.gain


@jit
def _take(mean, spread, chunk, weight, room, deviation):
    """Take the values of a chunk into moments."""
    _step(room.value, room.parts, weight, mean[chunk], spread[chunk], deviation)


@jit
def _sum(first, second, target):
    copy(first, target)
    _add(second, target)


@jit
def _take_specular(specular, seen, chunk, weight, room):
    """Take what is seen via specular surfaces into its moments."""
    value, residual = room.value, room.residual
    _sum(seen[passes.FIRST_CAUSTIC, chunk], seen[passes.VIA_CAUSTIC, chunk], value)
    _take(specular.caustics, specular.caustics_spread, chunk, weight, room, room.unused)
    _sum(seen[passes.VIA_DIRECT, chunk], seen[passes.VIA_INDIRECT, chunk], value)
    _add(seen[passes.VIA_CAUSTIC, chunk], value)
    _take(specular.residual, specular.residual_spread, chunk, weight, room, residual)


@jit
def _take_fluorescence(glow, seen, chunk, weight, room):
    """Take fluorescence and excitation into their moments."""
    value, unused = room.value, room.unused
    direct = seen[passes.FLUORESCENT_DIRECT, chunk]
    indirect = seen[passes.FLUORESCENT_INDIRECT, chunk]
    excited = seen[passes.EXCITATION_DIRECT, chunk], seen[passes.EXCITATION_INDIRECT, chunk]
    copy(direct, value)
    _take(glow.fluorescence_direct, glow.fluorescence_direct_spread, chunk, weight, room, unused)
    copy(indirect, value)
    spread = glow.fluorescence_indirect_spread
    _take(glow.fluorescence_indirect, spread, chunk, weight, room, unused)
    _sum(excited[0], excited[1], value)
    _take(glow.excitation, glow.excitation_spread, chunk, weight, room, unused)
    _sum(direct, indirect, value)
    _take(glow.fluorescence, glow.fluorescence_spread, chunk, weight, room, unused)
    _add(unused, room.residual)


@jit
def _take_direct(moments, pixels, seen, chunk, weight, room):
    value, term = room.value, room.term
    copy(pixels.direct[chunk], value)
    if seen is not None:
        copy(seen[passes.VIA_DIRECT, chunk], term)
        if moments.fluorescence is not None:
            _add(seen[passes.FLUORESCENT_DIRECT, chunk], term)
        _add(term, value)
    _take(moments.direct, moments.direct_spread, chunk, weight, room, room.direct)


@jit
def _take_indirect(moments, pixels, seen, chunk, weight, room):
    value, term = room.value, room.term
    copy(pixels.indirect[chunk], value)
    if seen is not None:
        _sum(seen[passes.FIRST_CAUSTIC, chunk], seen[passes.VIA_INDIRECT, chunk], term)
        _add(seen[passes.VIA_CAUSTIC, chunk], term)
        if moments.fluorescence is not None:
            _add(seen[passes.FLUORESCENT_INDIRECT, chunk], term)
        _add(term, value)
    _take(moments.indirect, moments.indirect_spread, chunk, weight, room, room.indirect)


@jit
def _take_irradiance(moments, pixels, seen, chunk, weight, room):
    value = room.value
    copy(pixels.irradiance_indirect[chunk], value)
    if seen is not None:
        _add(seen[passes.CAUSTIC_IRRADIANCE, chunk], value)
    _add(pixels.irradiance_direct[chunk], value)
    _scale(INV_PI, value)
    _take(moments.irradiance, moments.irradiance_spread, chunk, weight, room, room.unused)


@jit
def _take_sums(moments, chunk, weight, room):
    """Take what diffuse light and radiance deviate by into their moments."""
    parts, diffuse, radiance = room.parts, room.value, room.term
    _sum(room.emission, room.direct, radiance)
    _add(room.indirect, radiance)
    _sum(room.direct, room.indirect, diffuse)
    _subtract(room.residual, diffuse)
    _widen(diffuse, diffuse, parts, weight, moments.diffuse_spread[chunk])
    _widen(radiance, radiance, parts, weight, moments.radiance_spread[chunk])
    _widen(diffuse, room.reflectance, parts, weight, moments.product[chunk])


@jit
def _count(moments, pixels, step, first, last, bands, parts):
    """Take what has no bands into the moments of some pixels; fill the parts of the pass."""
    for pixel in range(first, last):
        moments.counts[pixel] += np.uint32(step.part)
        part = step.part / moments.counts[pixel]
        moments.coverage[pixel] += (pixels.coverage[pixel] - moments.coverage[pixel]) * part
        moments.found[pixel] |= pixels.lookups[pixel]
        for band in range(bands):
            parts[bands * (pixel - first) + band] = part


@kernel
def add_pass(moments, specular, pixels, seen, step, first, last, room):
    """Take pixels of a pass into the moments; `specular`, `seen` are None in Lambertian scenes.

    Arrays with bands are flat, (P N,). `seen`, (R, P N), is `Estimate.via_specular`. By the
    `Weight` of `step`, they may be means over passes.
    """
    bands = len(moments.direct) // len(moments.counts)
    size = len(room.parts) // bands
    for begin in range(first, last, size):
        end = min(begin + size, last)
        chunk = slice(begin * bands, end * bands)
        _count(moments, pixels, step, begin, end, bands, room.parts)
        copy(pixels.emission[chunk], room.value)
        _take(moments.emission, moments.emission_spread, chunk, step, room, room.emission)
        _take_direct(moments, pixels, seen, chunk, step, room)
        _take_indirect(moments, pixels, seen, chunk, step, room)
        copy(pixels.reflectance[chunk], room.value)
        spread = moments.reflectance_spread
        _take(moments.reflectance, spread, chunk, step, room, room.reflectance)
        _take_irradiance(moments, pixels, seen, chunk, step, room)
        room.residual[:] = 0.0
        if specular is not None:
            _take_specular(specular, seen, chunk, step, room)
        if moments.fluorescence is not None:
            _take_fluorescence(moments.fluorescence, seen, chunk, step, room)
        _take_sums(moments, chunk, step, room)
