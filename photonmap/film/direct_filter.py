"""Direct light averaged over pixels of a surface when a render is read out.

It needs the means of direct light in four groups of replicates beside the moments: the weights of
each follow from the other three. See `photonmap.kernels.film.direct_filter`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from photonmap.film.blocks import SIDE
from photonmap.film.moments import RANGE, Accumulator
from photonmap.film.pooling import take_in
from photonmap.film.replicates import replicate_size
from photonmap.kernels.core.passes import Film, Span
from photonmap.kernels.film.direct_filter import (
    GROUPS,
    PATCHES,
    Compared,
    Grouped,
    compare_pixels,
    filter_direct,
    smooth_patches,
)
from photonmap.kernels.film.irradiance_sharing import Footprint
from photonmap.kernels.film.moments import Moments, Weight
from photonmap.runtime.storage import RAM, Storage
from photonmap.runtime.workers import Workers

Array = NDArray[np.float32]
Surfaces = Callable[[], Array]
"""Gives the plane that each pixel shows, (P, 7), by geometry alone"""
RADIUS, TURN = 4.0, 0.08
"""How far pixels are averaged, at most: pixels, and radians between their normals."""
LEAST_PASSES = 16
"""Of a render that is filtered: four in each group."""


def group_of(index: int) -> int:
    """Return the group of the replicate that begins with pass `index`."""
    return index // replicate_size(index) % GROUPS


def sizes_of_groups(count: int) -> NDArray[np.float64]:
    """Return how many passes, and how many replicates, each group of `count` has, (2, G)."""
    sizes, index = np.zeros((2, GROUPS)), 0
    while index < count:
        taken = min(replicate_size(index), count - index)
        sizes[:, group_of(index)] += taken, 1.0
        index += taken
    return sizes


class DirectFilter:
    """Keeps direct light by groups of passes, 16 bytes a pixel and band, and filters it."""

    def __init__(
        self,
        film: Film,
        bands: int,
        workers: Workers,
        surfaces: Surfaces,
        storage: Storage = RAM,
    ) -> None:
        self._film, self._workers, self._storage = film, workers, storage
        self._surfaces = surfaces
        size = film.width * film.height
        self.arrays = {
            "direct by groups": storage.zeros((GROUPS, size, bands)),
            "mean by groups": storage.zeros((GROUPS, size), np.float64),
            "spread by groups": storage.zeros((GROUPS, size)),
        }
        """All that passes leave behind, by name: the arrays themselves, as `Grouped` has them."""
        self._last: tuple[int, Accumulator] | None = None
        self.pixels, self.change = 0, 0.0
        """Number of pixels that were filtered last; what their light gained, of all direct light"""

    def add(self, direct: NDArray[np.float32], index: int, passes: float) -> None:
        """Take in direct light, (P, N): the mean of so many passes from number `index` on."""
        group = group_of(index)
        total, mean, spread = (array[group] for array in self.arrays.values())
        count = int(sizes_of_groups(index)[0, group] + passes)
        weight = Weight(passes, 1.0, passes)

        def add(first: int, last: int) -> None:
            part = slice(first, last)
            total[part] += direct[part] * np.float32(passes)
            value = direct[part].mean(axis=1, dtype=np.float64)
            take_in(value, count, mean[part], spread[part], weight)

        self._workers.ranges(add, len(direct), RANGE, uninterrupted=True)

    def _over_pixels(self, task: Callable[[Span], None], size: int) -> None:
        self._workers.ranges(lambda first, last: task(Span(first, last)), size, RANGE, True)

    def apply(self, moments: Accumulator) -> Accumulator:
        """Return the moments with direct light filtered; the same ones after few passes."""
        if moments.count < LEAST_PASSES:
            return moments
        if self._last is None or self._last[0] != moments.count:
            self._last = moments.count, self._filter(moments)
        return self._last[1]

    def _filter(self, moments: Accumulator) -> Accumulator:
        own, specular = moments.parts
        size, bands = own.direct.shape
        zeros, film, sizes = self._storage.zeros, self._film, sizes_of_groups(moments.count)
        grouped = Grouped(*self.arrays.values(), *sizes)
        everywhere = np.ones(size, np.float32)
        compared = Compared(
            Footprint(self._surfaces(), everywhere, np.inf, RADIUS, TURN),
            *zeros((2, GROUPS, size, bands)),
            *zeros((2, size, len(PATCHES), GROUPS)),
        )
        gain, variance = zeros((2, size, bands))
        parts = sizes[0] / sizes[0].sum()

        def average(span: Span) -> None:
            scratch = np.empty((2 * bands + 2, GROUPS))
            filter_direct(film, compared, parts, scratch, span, gain, variance)

        for task in (
            lambda span: compare_pixels(own, specular, grouped, compared, span),
            lambda span: smooth_patches(film, compared, span),
            average,
        ):
            self._over_pixels(task, size)
        changed = ~np.isnan(gain[:, 0])
        self.pixels = int(np.count_nonzero(changed))
        light = own.reflectance[changed] * gain[changed], own.direct.sum()
        self.change = float(light[0].sum() / light[1]) if self.pixels else 0.0
        give_back(gain, variance, own, film.width)
        return moments.with_direct(gain, variance)


def give_back(gain: Array, variance: Array, own: Moments, width: int) -> None:
    """Take from blocks of pixels what their direct light gained in sum, and widen their variance.

    What averaging changes in the mean is a bias, which is so known with little noise. Pixels return
    it in proportion to their variance, those that vary alone all of it.
    """
    bands, starts = gain.shape[1], np.arange(0, width, SIDE)
    widths = np.diff(starts, append=width)
    for first in range(0, len(gain), SIDE * width):
        part = slice(first, first + SIDE * width)
        r, count = own.reflectance[part], own.counts[part, None].astype(np.float64)
        change, spread = gain[part] * r, own.direct_spread[part] / (count * (count - 1.0))
        spread[np.isnan(change)] = 0.0

        def sums(image: NDArray[np.float64]) -> NDArray[np.float64]:
            lines = image.reshape(-1, width, bands)
            blocks = np.add.reduceat(lines.sum(axis=0), starts, axis=0)
            return np.tile(np.repeat(blocks, widths, axis=0), (len(lines), 1))

        share = spread / np.maximum(sums(spread), np.finfo(np.float64).tiny)
        known = np.where(r > 0.0, r, 1.0)
        gain[part] -= share * sums(np.nan_to_num(change)) / known
        variance[part] += share * spread / known**2
