"""Direct light averaged over pixels of a surface when a render is read out.

It needs the means of direct light in four groups of replicates beside the moments: the weights of
each follow from the other three. See `photonmap.kernels.film.direct_filter`. All lights, those of
light groups and of illuminations that are rendered together, are averaged by the same weights, so
that they add up, and differ by their spectra and shares alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

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
    STRICTNESS,
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
RADIUS, TURN = 4, 0.08
"""How far pixels are averaged, at most: pixels, and radians between their normals."""
CLASSES, PRIOR = 8, 500.0
"""Of pixels, by how often averaging halves their variance; pixels that count as if these errors
were right, as neighbours average the same"""
HIDDEN = 1.1
"""Squared error over the variance that shows, as weights let through what is not told from noise:
0.85 to 1.2, over six scenes and 8 and 16 passes."""
LINES, MARGIN = 24, RADIUS + PATCHES[-1]
"""Of the image that are filtered at a time, and around them that these need"""
DIGITS = 6
"""Of reflectances that are one: means of equal samples differ by rounding"""
LEAST_PASSES = 8
"""Of a render that is filtered: two in each group."""
EXPECTED = 0.85
"""By how much an error is taken to fall when passes are planned: it was 0.71 to 0.96 in rooms."""


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


def list_pairs() -> tuple[NDArray[np.int64], Array]:
    """Return the pairs on opposite sides of a pixel, (R, 2), and how strictly each is compared.

    (R, L): by patches, the variance of the mean of two less the one between, over that of three
    that have no pixel in common, times `STRICTNESS`.
    """
    y, x = np.mgrid[: RADIUS + 1, -RADIUS : RADIUS + 1].reshape(2, -1)
    is_pair = ((y > 0) | (x > 0)) & (x * x + y * y <= RADIUS * RADIUS)
    pairs = np.stack([x, y], axis=1)[is_pair]
    sides = 2 * np.array(PATCHES) + 1
    one, two = (
        np.maximum(sides[:, None] - n * np.abs(pairs[:, None]), 0).prod(axis=-1) for n in (1, 2)
    )
    apart = 1.0 + (two - 4.0 * one) / (3.0 * sides**2)
    return pairs, (STRICTNESS * apart).astype(np.float32)


class _Light(NamedTuple):
    """One of the lights that are averaged alike: its moments, and its arrays as in `Grouped`."""

    moments: Accumulator
    sums: Array  # (G, P, N)
    mean: NDArray[np.float64]  # (G, P)
    spread: Array  # (G, P)


class _Lines(NamedTuple):
    """What filtering changes in some lines of the image."""

    gain: Array  # (K, P, N) of direct light; NaN where nothing changes
    variance: Array  # (K, P, N) of its mean
    seen: Array  # (K, 2, P) see `_see`
    gained: NDArray[np.float64]  # (K,) before blocks gave it back


class DirectFilter:
    """Keeps direct light by groups of passes, 16 bytes a pixel and band, and filters it."""

    def __init__(
        self, film: Film, workers: Workers, surfaces: Surfaces, storage: Storage = RAM
    ) -> None:
        self._film, self._workers, self._storage = film, workers, storage
        self._surfaces, self._pairs = surfaces, list_pairs()
        self._lights: list[_Light] = []
        self._last: tuple[int, list[Accumulator]] | None = None
        self.pixels, self.changes = 0, np.zeros(0)
        """Number of pixels that were filtered last; what each light gained, of all of it, (K,)"""

    def follow(self, moments: Sequence[Accumulator]) -> int:
        """Filter further lights by the same weights; return the number of the first of them."""
        for each in moments:
            shape = GROUPS, len(each.parts[0].direct)
            bands = each.parts[0].direct.shape[1]
            zeros = self._storage.zeros
            arrays = zeros((*shape, bands)), zeros(shape, np.float64), zeros(shape)
            self._lights.append(_Light(each, *arrays))
        return len(self._lights) - len(moments)

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind, by name: the arrays themselves."""
        return {
            f"{name} by groups {number}": getattr(light, name)
            for number, light in enumerate(self._lights)
            for name in ("sums", "mean", "spread")
        }

    def add(self, direct: Array, light: int, index: int, passes: float) -> None:
        """Take in one light, (P, N): the mean of so many passes from number `index` on."""
        group = group_of(index)
        total, mean, spread = (array[group] for array in self._lights[light][1:])
        count = int(sizes_of_groups(index)[0, group] + passes)
        weight = Weight(passes, 1.0, passes)

        def add(first: int, last: int) -> None:
            part = slice(first, last)
            total[part] += direct[part] * np.float32(passes)
            value = direct[part].mean(axis=1, dtype=np.float64)
            take_in(value, count, mean[part], spread[part], weight)

        self._workers.ranges(add, len(direct), RANGE, uninterrupted=True)

    def apply(self) -> list[Accumulator]:
        """Return the moments of all lights, filtered; the same ones after few passes."""
        count = self._lights[0].moments.count
        if count < LEAST_PASSES:
            return [light.moments for light in self._lights]
        if self._last is None or self._last[0] != count:
            self._last = count, self._filter()
        return self._last[1]

    def _filter(self) -> list[Accumulator]:
        moments, film = [light.moments for light in self._lights], self._film
        owns = [each.parts[0] for each in moments]
        gain, variance = self._storage.zeros((2, len(owns), *owns[0].direct.shape))
        classes = self._storage.zeros(gain.shape[:2], np.uint8)

        def task(first: int, last: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
            rows = slice(first * film.width, last * film.width)
            lines = self._filter_lines(first, last)
            gain[:, rows], variance[:, rows] = lines.gain, lines.variance
            stated = lines.seen[:, 0]
            halvings = np.rint(-np.log2(np.where(stated > 0.0, stated, 1.0)))
            classes[:, rows] = np.clip(halvings, 0, CLASSES - 1)
            filtered = ~np.isnan(lines.gain[0, :, 0])
            tables = [
                [np.bincount(own, each, CLASSES) for each in (filtered, *seen)]
                for own, seen in zip(classes[:, rows], lines.seen, strict=True)
            ]
            return np.array(tables), lines.gained

        tables, gained = zip(*self._workers.ranges(task, film.height, LINES, True), strict=True)
        counts, stated, between = np.moveaxis(sum(tables), 1, 0)
        self.pixels = int(counts[0].sum())
        if self.pixels == 0:
            return moments
        alike = PRIOR * stated / np.maximum(counts, 1.0)
        shown, ones = HIDDEN * between + alike, np.ones(stated.shape)
        factors = np.divide(shown, stated + alike, out=ones, where=stated > 0.0)
        factors[:, 0] = 1.0  # hardly averaged
        for own, each, factor in zip(variance, classes, factors, strict=True):
            own *= np.minimum(factor, 1.0).astype(np.float32)[each, None]
        totals = np.array([own.direct.sum() for own in owns])
        self.changes = sum(gained) / np.where(totals > 0.0, totals, 1.0)
        parts = zip(moments, gain, variance, strict=True)
        return [own.with_direct(change, spread) for own, change, spread in parts]

    def _filter_lines(self, first: int, last: int) -> _Lines:
        film, sizes = self._film, sizes_of_groups(self._lights[0].moments.count)
        top, end = max(first - MARGIN, 0), min(last + MARGIN, film.height)
        rows, strip = slice(top * film.width, end * film.width), film._replace(height=end - top)
        compared = self._compare(rows, strip, sizes)
        lights, size, both = compared.light.shape[:3]
        gain = np.full((lights, size, both // 2, GROUPS), np.nan, np.float32)
        variance, parts = np.zeros(gain.shape[:3], np.float32), sizes[0] / sizes[0].sum()
        scratch = (np.empty(shape, np.float32) for shape in ((3, GROUPS), (lights, both, GROUPS)))
        inner = Span((first - top) * film.width, (last - top) * film.width)
        filter_direct(strip, compared, parts, *scratch, inner, gain, variance)
        inside, own_rows = slice(*inner), slice(first * film.width, last * film.width)
        gain, variance, light = gain[:, inside], variance[:, inside], compared.light[:, inside]
        owns = [_rows(light.moments.parts[0], own_rows) for light in self._lights]
        kept = np.flatnonzero(~np.isnan(gain[0, :, 0, 0]))
        blocks = Blocks(kept, owns[0].reflectance, film.width)
        gained = [
            give_back(change, spread, own, parts, blocks)
            for change, spread, own in zip(gain, variance, owns, strict=True)
        ]
        seen = [_see(*each, parts, kept) for each in zip(gain, variance, light, strict=True)]
        return _Lines(gain @ parts, variance, np.array(seen), np.array(gained))

    def _compare(self, rows: slice, strip: Film, sizes: NDArray[np.float64]) -> Compared:
        """Return what the pixels of a strip are compared by."""
        size, lights = rows.stop - rows.start, len(self._lights)
        bands, everything = self._lights[0].sums.shape[2], Span(0, size)
        compared = Compared(
            Footprint(self._surfaces()[rows], np.ones(size, np.float32), np.inf, RADIUS, TURN),
            *self._pairs,
            np.empty((lights, size, 2 * bands, GROUPS), np.float32),
            *np.zeros((2, lights, size, len(PATCHES), GROUPS), np.float32),
        )
        for number, light in enumerate(self._lights):
            own, specular = (_rows(part, rows) for part in light.moments.parts)
            grouped = Grouped(*(array[:, rows] for array in light[1:]), *sizes)
            compare_pixels(own, specular, grouped, compared, number, everything)
        for number in range(lights):
            smooth_patches(strip, compared, number, everything)
        return compared


def _rows(record: Any, rows: slice) -> Any:
    """Return the rows of the arrays of a record, and of records in it; None for None."""
    if record is None or isinstance(record, np.ndarray):
        return None if record is None else record[rows]
    return type(record)(*(_rows(part, rows) for part in record))


def _see(
    gain: Array,
    variance: Array,
    light: Array,
    parts: NDArray[np.float64],
    kept: NDArray[np.int64],
) -> Array:
    """Return the variance that is stated, and that which differences between groups show, (2, P).

    Means over bands of each over the variance before; 0 where nothing changes.
    """
    seen, bands = np.zeros((2, len(gain)), np.float32), gain.shape[1]
    before, after = light[kept, bands:] @ parts**2, light[kept, :bands] + gain[kept]
    between = (after - (after @ parts)[..., None]) ** 2 @ parts / (GROUPS - 1)
    for row, image in zip(seen, (variance[kept], between), strict=True):
        ratio = np.divide(image, before, out=np.zeros_like(before), where=before > 0.0)
        row[kept] = ratio.mean(axis=1)
    return seen


class Blocks:
    """Pixels of one reflectance in a block, of all that are filtered in some lines of the image."""

    def __init__(self, kept: NDArray[np.int64], reflectance: NDArray[Any], width: int) -> None:
        self.kept, self._places = kept, np.zeros(len(kept), np.int64)
        lines, columns = np.divmod(kept, width)
        blocks = lines // SIDE * width + columns // SIDE
        for each in (blocks, *np.round(reflectance[kept], DIGITS).T):
            _, numbers = np.unique(each, return_inverse=True)
            _, self._places = np.unique(self._places * len(kept) + numbers, return_inverse=True)
        self._order = np.argsort(self._places, kind="stable")
        self._starts = np.flatnonzero(np.diff(self._places[self._order], prepend=-1))

    def sums(self, image: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sums over pixels alike of an image of those that are filtered, for each."""
        return np.asarray(np.add.reduceat(image[self._order], self._starts, axis=0)[self._places])


def give_back(
    gain: Array, variance: Array, own: Moments, parts: NDArray[np.float64], blocks: Blocks
) -> float:
    """Take from blocks what their direct light gained, (P, N, G), and widen its variance, (P, N).

    What averaging changes in the mean is a bias, which is so known with little noise. Pixels return
    it in proportion to their variance, those that vary alone all of it; where that is more than the
    light of one of them, in proportion to light. Shares are those of all bands, so that the light
    keeps its colour. Return the sum of radiance that was gained.
    """
    kept, sums = blocks.kept, blocks.sums
    if len(kept) == 0:
        return 0.0
    r, count = own.reflectance[kept], own.counts[kept, None].astype(np.float64)
    changes = gain[kept].astype(np.float64)
    spread = own.direct_spread[kept] / (count * (count - 1.0) * r * r)
    light = own.direct[kept] / r + changes @ parts
    gained, returned, whole = (r * (changes @ parts)).sum(), sums(changes), sums(spread)
    share, by_light = (
        each / np.maximum(sums(each), np.finfo(np.float64).tiny)
        for each in (spread.mean(axis=1), light.mean(axis=1))
    )
    is_more = (share[:, None] * (returned @ parts) > light).any(axis=1)
    share = np.where(sums(is_more.astype(np.float64)) > 0.0, by_light, share)
    gain[kept] -= share[:, None, None] * returned
    variance[kept] += share[:, None] ** 2 * whole
    return float(gained)
