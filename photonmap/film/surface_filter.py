"""One kind of light averaged over pixels of a surface when a render is read out.

It needs the means of that light in four groups of replicates beside the moments: the weights of
each follow from the other three. See `photonmap.kernels.film.surface_filter`. All lights, those of
light groups and of illuminations that are rendered together, are averaged by the same weights, so
that they add up, and differ by their spectra and shares alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from photonmap.film.blocks import SIDE
from photonmap.film.moments import RANGE, Accumulator, Change
from photonmap.film.replicates import replicate_size
from photonmap.kernels.core.passes import Film, Span
from photonmap.kernels.film.give_back import Averaged, Returned, give_back, make_block_scratch
from photonmap.kernels.film.irradiance_sharing import Footprint, Strip, cut_strip
from photonmap.kernels.film.surface_filter import (
    GROUPS,
    PATCHES,
    TINY,
    Compared,
    Grouped,
    Own,
    add_to_group,
    compare_pixels,
    filter_light,
    make_scratch,
    smooth_patches,
)
from photonmap.runtime.storage import RAM, Storage
from photonmap.runtime.workers import Workers

Array = NDArray[np.float32]
Surfaces = Callable[[], Array]
"""Gives the plane that each pixel shows, (P, 7), by geometry alone"""
STRICTNESS = {"direct": 4.0, "indirect": 8.0}
"""Square of how many standard errors a pair is off when its weight has fallen to 0, of each kind;
twice that where noise is partly common to neighbours, which does not set them apart"""
RADIUS, TURN = 4, 0.08
"""How far pixels are averaged, at most: pixels, and radians between their normals."""
CLASSES, PRIOR = 8, 500.0
"""Of pixels, by how often averaging halves their variance; pixels that count as if these errors
were right, as neighbours average the same"""
HIDDEN, MOST_HIDDEN = 1.1, 1.6
"""Squared error over the variance that shows, as weights let through what is not told from noise:
0.85 to 1.2, over six scenes and 8 and 16 passes; 1.5 to 1.7 with a single value in a group"""
OWN = np.float32(0.44)
"""The least of the variance that differences between the groups of a pixel show that is stated"""
WINDOW = 11
"""Pixels across over which that of indirect light is averaged"""
LINES, MARGIN = 40, RADIUS + PATCHES[-1]
"""Of the image that are filtered at a time, and around them that these need"""
DARK = 0.1
"""Of mean light, below which variance is taken to be no less"""


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


def list_pairs(strictness: float) -> tuple[NDArray[np.int64], Array]:
    """Return the pairs on opposite sides of a pixel, (R, 2), and how strictly each is compared.

    (R, L): by patches, the variance of the mean of two less the one between, over that of three
    that have no pixel in common, times `strictness`.
    """
    y, x = np.mgrid[: RADIUS + 1, -RADIUS : RADIUS + 1].reshape(2, -1)
    is_pair = ((y > 0) | (x > 0)) & (x * x + y * y <= RADIUS * RADIUS)
    pairs = np.stack([x, y], axis=1)[is_pair]
    sides = 2 * np.array(PATCHES) + 1
    one, two = (
        np.maximum(sides[:, None] - n * np.abs(pairs[:, None]), 0).prod(axis=-1) for n in (1, 2)
    )
    apart = 1.0 + (two - 4.0 * one) / (3.0 * sides**2)
    return pairs, (strictness * apart).astype(np.float32)


class _Light(NamedTuple):
    """One of the lights that are averaged alike: its moments, and its arrays as in `Grouped`."""

    moments: Accumulator
    sums: Array  # (G, P, N)
    mean: NDArray[np.float64]  # (G, P)
    spread: Array  # (G, P)


class _Filtered(NamedTuple):
    """What averaging makes of all lights."""

    gain: Array  # (K, P, N) of light over reflectance; NaN where nothing changes
    stated: Array  # (K, P, N) variance of its mean, as if the noise of pixels were their own
    between: Array  # (K, P, N) variance of its mean that differences between groups show

    @property
    def kept(self) -> NDArray[np.bool_]:
        """Which pixels are averaged, (P,)."""
        return ~np.isnan(self.gain[0, :, 0])

    def part(self, rows: slice) -> _Filtered:
        """Return that of some pixels."""
        return _Filtered(*(array[:, rows] for array in self))


class SurfaceFilter:
    """Keeps light of one kind by groups of passes, 16 bytes a pixel and band, and averages it.

    The kind is the name of its buffer: `direct` or `indirect`.
    """

    def __init__(
        self, kind: str, film: Film, workers: Workers, surfaces: Surfaces, storage: Storage = RAM
    ) -> None:
        self.kind, self._film, self._workers, self._storage = kind, film, workers, storage
        self._surfaces, self._pairs = surfaces, list_pairs(STRICTNESS[kind])
        self._lights: list[_Light] = []
        self.pixels, self.changes = 0, np.zeros(0)
        """Number of pixels that were filtered last; what each light gained, of all of it, (K,)"""

    def follow(self, moments: Sequence[Accumulator]) -> None:
        """Filter further lights by the same weights."""
        for each in moments:
            shape = GROUPS, len(each.parts[0].direct)
            bands = each.parts[0].direct.shape[1]
            zeros = self._storage.zeros
            arrays = zeros((*shape, bands)), zeros(shape, np.float64), zeros(shape)
            self._lights.append(_Light(each, *arrays))

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind, by name: the arrays themselves."""
        return {
            f"{self.kind} {name} by groups {number}": getattr(light, name)
            for number, light in enumerate(self._lights)
            for name in ("sums", "mean", "spread")
        }

    def add(self, value: Array, light: int, index: int, passes: float) -> None:
        """Take in one light, (P, N): the mean of so many passes from number `index` on."""
        group = group_of(index)
        sums = [array[group] for array in self._lights[light][1:]]
        count = sizes_of_groups(index)[0, group] + passes

        def add(first: int, last: int) -> None:
            add_to_group(value, passes, count, Span(first, last), *sums)

        self._workers.ranges(add, len(value), RANGE, uninterrupted=True)

    def filter(self) -> list[Change]:
        """Return what averaging changes in each light."""
        film, shape = self._film, self._lights[0].sums.shape[1:]
        filtered = _Filtered(*self._storage.zeros((3, len(self._lights), *shape)))
        plane = self._surfaces()  # before tasks: a resumed render has yet to look, by all workers
        everywhere = np.broadcast_to(np.float32(1.0), len(plane))
        footprint = Footprint(plane, everywhere, np.inf, MARGIN, TURN)

        def task(first: int, last: int) -> NDArray[np.float64]:
            lines = slice(first * film.width, last * film.width)
            return self._filter_lines(Span(first, last), footprint, filtered.part(lines))

        gained, totals, light = sum(
            self._workers.ranges(task, film.height, LINES, uninterrupted=True)
        )
        self.changes = gained / np.where(totals > 0.0, totals, 1.0)
        self.pixels = int(np.count_nonzero(filtered.kept))
        if self.pixels > 0 and self.kind == "direct":
            self._pool_classes(filtered)
        elif self.pixels > 0:
            self._pool_around(filtered, DARK * light / self.pixels)
        return [Change(*pair) for pair in zip(filtered.gain, filtered.stated, strict=True)]

    def _own(self, light: _Light, rows: slice) -> Own:
        """Return this kind of one of the lights."""
        moments, specular = (_rows(part, rows) for part in light.moments.parts)
        count, r = moments.counts[:, None].astype(np.float64), moments.reflectance
        norm = count * (count - 1.0) * np.where(r == 0.0, 1.0, r * r)
        beyond = None if specular is None else specular.residual_spread
        if self.kind == "direct":
            return Own(moments.direct, moments.direct_spread / norm, beyond)
        if specular is not None:
            beyond = specular.residual_spread + specular.caustics_spread
        return Own(moments.indirect, moments.indirect_spread / norm, beyond)

    def _filter_lines(
        self, lines: Span, footprint: Footprint, out: _Filtered
    ) -> NDArray[np.float64]:
        """Fill some lines of the image; return of each light, (3, K), what it gained, of how much.

        And the sum of its means over bands and reflectance of what is filtered.
        """
        width, sizes = self._film.width, sizes_of_groups(self._lights[0].moments.count)
        strip, _ = cut_strip(self._film, footprint, lines, np.empty((len(footprint.plane), 0)))
        inside = Span(lines.first - strip.first, lines.last - strip.first)
        inner = slice(inside.first * width, inside.last * width)
        rows = slice(strip.first * width, strip.first * width + strip.planes.shape[1])
        owns = [self._own(light, rows) for light in self._lights]
        compared = self._compare(strip, rows, owns, sizes)
        scratch = make_scratch(compared)
        smooth_patches(compared, scratch)
        shape = len(owns), *out.gain.shape[1:]
        gain, after = np.empty((*shape, GROUPS), np.float32), np.empty(shape, np.float32)
        parts = sizes[0] / sizes[0].sum()
        filter_light(compared, parts, inside, scratch, gain, after)
        reflectance = self._lights[0].moments.parts[0].reflectance[rows][inner]
        room, gained = make_block_scratch(SIDE, *gain.shape[2:]), np.empty((3, len(owns)))
        for number, own in enumerate(owns):
            before, shown = _rows(own, inner), compared.light[number, : gain[0, 0].size, inner]
            averaged = Averaged(*before[:2], reflectance, shown, parts, gain[number], after[number])
            left = Returned(*(array[number] for array in out))
            gain_of, light = give_back(averaged, width, SIDE, room, left)
            gained[:, number] = gain_of, before.mean.sum(), light / shape[2]
        return gained

    def _compare(
        self, strip: Strip, rows: slice, owns: list[Own], sizes: NDArray[np.float64]
    ) -> Compared:
        """Return what the pixels of a strip, which are rows of the image, are compared by."""
        lights, bands = len(self._lights), self._lights[0].sums.shape[2]
        size = rows.stop - rows.start
        compared = Compared(
            strip,
            *self._pairs,
            np.zeros((lights, 2 * bands * GROUPS, size), np.float32),
            *np.zeros((2, lights, len(PATCHES), GROUPS, size), np.float32),
        )
        for number, (light, own) in enumerate(zip(self._lights, owns, strict=True)):
            grouped = Grouped(*(array[:, rows] for array in light[1:]), *sizes)
            compare_pixels(_rows(light.moments.parts[0], rows), own, grouped, compared, number)
        return compared

    def _pool_classes(self, filtered: _Filtered) -> None:
        """Narrow the stated variance by what shows in all pixels that are averaged as much."""
        classes = self._storage.zeros(filtered.gain.shape[:2], np.uint8)

        def classify(first: int, last: int) -> NDArray[np.float64]:
            rows, tables = slice(first, last), []
            for number, light in enumerate(self._lights):
                before, part = self._own(light, rows).variance, filtered.part(rows)
                left, shown = (_relative(image[number], before) for image in part[1:])
                halvings = np.rint(-np.log2(np.where(left > 0.0, left, 1.0)))
                own = classes[number, rows] = np.clip(halvings, 0, CLASSES - 1)
                each = own.astype(np.intp)
                tables.append(
                    [np.bincount(each, sums, CLASSES) for sums in (part.kept, left, shown)]
                )
            return np.array(tables)

        size = len(filtered.kept)
        tables = sum(self._workers.ranges(classify, size, RANGE, uninterrupted=True))
        counts, left, shown = np.moveaxis(tables, 1, 0)
        alike, ones = PRIOR * left / np.maximum(counts, 1.0), np.ones(left.shape)
        values = sizes_of_groups(self._lights[0].moments.count)[1]
        hidden, widest = (HIDDEN, 1.0) if values.min() > 1.0 else (MOST_HIDDEN, MOST_HIDDEN)
        factors = np.divide(hidden * shown + alike, left + alike, out=ones, where=left > 0.0)
        factors[:, 0] = 1.0  # hardly averaged
        factors = np.minimum(factors, widest).astype(np.float32)

        def narrow(first: int, last: int) -> None:
            _, stated, between = filtered.part(slice(first, last))
            for number, factor in enumerate(factors):
                stated[number] *= factor[classes[number, first:last], None]
            np.maximum(stated, OWN * between, out=stated)

        self._workers.ranges(narrow, size, RANGE, uninterrupted=True)

    def _pool_around(self, filtered: _Filtered, floors: NDArray[np.float64]) -> None:
        """State the variance that shows around pixels, but no less than if noise were their own.

        It is taken to be proportional to light, or to `floors`, (K,), where that is darker.
        """
        film, half, size = self._film, WINDOW // 2, (WINDOW, WINDOW, 1)

        def task(first: int, last: int) -> None:
            top, end = max(first - half, 0), min(last + half, film.height)
            rows = slice(top * film.width, end * film.width)
            inner = slice((first - top) * film.width, (last - top) * film.width)
            part = filtered.part(rows)
            kept = part.kept[:, None]

            def around(image: Array) -> Array:
                lines = np.where(kept, image, np.float32(0.0)).reshape(end - top, film.width, -1)
                return uniform_filter(lines, size, mode="constant").reshape(image.shape)[inner]

            count = np.maximum(around(np.ones(kept.shape, np.float32)), np.float32(0.5 / WINDOW**2))
            for number, light in enumerate(self._lights):
                own, r = self._own(light, rows), light.moments.parts[0].reflectance[rows]
                value = own.mean / np.where(r == 0.0, 1.0, r) + part.gain[number]
                value = np.maximum(value, max(floors[number], TINY)).astype(np.float32)
                between, stated = part.between[number], part.stated[number, inner]
                variance = around(between / value) / count * value[inner]
                variance = np.maximum(variance, OWN * between[inner])
                np.maximum(stated, variance, out=stated)

        self._workers.ranges(task, film.height, LINES, uninterrupted=True)


def _rows(record: Any, rows: slice) -> Any:
    """Return the rows of the arrays of a record, and of records in it; None for None."""
    if record is None or isinstance(record, np.ndarray):
        return None if record is None else record[rows]
    return type(record)(*(_rows(part, rows) for part in record))


def _relative(image: Array, before: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean over bands of a variance over that before; 0 where there was none."""
    ratio = np.divide(image, before, out=np.zeros_like(before), where=before > 0.0)
    return np.asarray(ratio.mean(axis=1))
