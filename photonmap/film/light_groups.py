"""The moments of a render: of the whole image, and of each light group where these are split."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import BY_NAME, group_name, names_where, split_name
from photonmap.compile.spectral_columns import SpectralColumns, split_pixels
from photonmap.film.blocks import BlockMoments
from photonmap.film.light_filter import LightFilter
from photonmap.film.moments import ALL, Accumulator, Buffers
from photonmap.film.replicates import ONE_PASS, Replicate, replicate_size, weigh
from photonmap.kernels.core.passes import Film, Pixels
from photonmap.kernels.film.moments import Weight
from photonmap.runtime.storage import RAM, Storage, strips
from photonmap.runtime.workers import Workers

OF_GROUPS = names_where(per_light=True)
"""Buffers that are split by light group."""


class LightGroups:
    """Takes in passes one by one, each with what `columns` carry.

    Light is filtered by `light_filter`, if it is given.
    """

    def __init__(
        self,
        columns: SpectralColumns,
        film: Film,
        workers: Workers,
        specular: bool,
        storage: Storage = RAM,
        fluorescent: bool = False,
        replicates: bool = True,
        light_filter: LightFilter | None = None,
    ) -> None:
        self._columns, self._storage, size = columns, storage, film.width * film.height
        self.whole = Accumulator(
            size, columns.distinct, workers, specular, columns.weights, storage, fluorescent
        )
        rows = 9 if fluorescent else 5 if specular else 0
        self._replicate = Replicate((size, columns.count), rows, workers, storage)
        self._replicates = replicates
        self._blocks = BlockMoments(film, columns.distinct, specular, fluorescent)
        split = columns.groups != ("",)
        self._groups = {
            group: Accumulator(
                size, columns.distinct, workers, specular, None, storage, fluorescent
            )
            if len(columns.groups) > 1
            else self.whole
            for group in (columns.groups if split else ())
        }
        self.filter = light_filter
        self._first = 0 if light_filter is None else light_filter.follow(self._accumulators)

    @property
    def _accumulators(self) -> list[Accumulator]:
        """The whole, and the light groups that it is split into."""
        return [self.whole, *(each for each in self._groups.values() if each is not self.whole)]

    @property
    def passes(self) -> int:
        """How many were taken in, with those of the replicate that has begun."""
        return self.whole.count + self._replicate.passes

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> None:
        """Take in one complete pass, and what it saw via specular surfaces.

        It counts as soon as its replicate is complete.
        """
        size = self._size(self.whole.count)
        if size == 1:
            self._take(pixels, seen, ONE_PASS)
        else:
            self._replicate.add(pixels, seen)
            if self._replicate.passes == size:
                self.close()

    def close(self) -> None:
        """Take in a replicate that has begun: the last one, which may have fewer passes."""
        if passes := self._replicate.passes:
            self._take(*self._replicate.take(), weigh(self.whole.count, passes))

    def _size(self, index: int) -> int:
        return replicate_size(index) if self._replicates else 1

    def _take(self, pixels: Pixels, seen: NDArray[np.float32] | None, weight: Weight) -> None:
        columns, index = self._columns, self.whole.count
        for light, accumulator in enumerate(self._accumulators):
            own = split_pixels(columns, pixels, light - 1 if light else None)
            specular = seen
            if seen is not None:
                specular = columns.of_group(seen, light - 1) if light else columns.whole(seen)
            accumulator.add(own, specular, weight)
            if light == 0:
                self._blocks.add(own, specular, weight)
            if self.filter is not None:
                self.filter.add(own, self._first + light, index, weight.part)

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind but their number, by name: the arrays themselves."""
        return (
            self._blocks.arrays
            | self._replicate.arrays
            | ({} if self.filter is None else self.filter.arrays)
            | {
                f"{index} {name}": array
                for index, accumulator in enumerate(self._accumulators)
                for name, array in accumulator.arrays.items()
            }
        )

    @property
    def filters(self) -> bool:
        """Whether light is filtered when it is read out, after enough passes."""
        return self.filter is not None

    @property
    def filtered(self) -> Accumulator:
        """The moments of the whole as they are read out: of filtered light."""
        return self._filtered[0]

    @property
    def _filtered(self) -> Sequence[Accumulator]:
        own = self._accumulators
        if self.filter is None:
            return own
        return self.filter.apply()[self._first : self._first + len(own)]

    def describe_filters(self) -> dict[str, dict[str, Any]]:
        """Return how many pixels were filtered, and what that changed before it was given back.

        Of each buffer, relative to all its light.
        """
        filters = {} if self.filter is None else self.filter.filters
        return {
            name: {"pixels": each.pixels, "change": float(each.changes[self._first])}
            for name, each in filters.items()
            if each.pixels > 0
        }

    def resume(self, count: int) -> None:
        """Go on after `count` passes, those that `arrays` were filled with."""
        self._replicate.passes = count % self._size(count)
        self._blocks.count = count - self._replicate.passes
        for accumulator in self._accumulators:
            accumulator.count = self._blocks.count

    def clear(self) -> None:
        """Forget all passes."""
        for array in self.arrays.values():
            array[:] = 0
        self.resume(0)

    def finish(self, scale: float, kept: Container[str] = ALL) -> tuple[Buffers, Buffers]:
        """Return buffers and their standard errors, as `Accumulator.finish`, in all bands.

        Those of groups are named as in "direct@sun". Where lights are split, buffers of the whole
        are the sums of theirs, in their order. A covariance that is 0 everywhere is left out.
        """
        lights = list(zip(self._accumulators, self._filtered, strict=True))
        filters = () if self.filter is None else self.filter.filters
        plain = [name for name in filters if f"{name}_unfiltered" in kept]
        buffers, errors = _finish(*lights[0], scale, ALL if self._groups else kept, plain)
        for index, group in enumerate(self._groups):
            parts, spreads = _finish(*lights[index - len(self._groups)], scale, OF_GROUPS, plain)
            for name, part in parts.items():
                buffers[name][:] = part if index == 0 else buffers[name] + part
                buffers[group_name(name, group)] = part
            errors |= {group_name(name, group): spread for name, spread in spreads.items()}
        for rows in strips(len(buffers["radiance"]) if self._groups else 0):
            light = buffers["emission"][rows] + buffers["direct"][rows]
            buffers["radiance"][rows] = light + buffers["indirect"][rows]
        for name in list(buffers):
            row = BY_NAME[split_name(name)[0]]
            if row.omitted == "where it is 0 everywhere" and not buffers[name].any():
                del buffers[name]
        return self._expand(buffers, kept), self._expand(errors, kept)

    def block_errors(self, scale: float, kept: Container[str] = ALL) -> Buffers:
        """Return the standard errors of blocks' means of the whole, in all bands."""
        return {
            name: error[..., self._columns.of_band].astype(np.float32)
            for name, error in self._blocks.finish(scale).items()
            if name in kept
        }

    def _expand(self, images: Buffers, kept: Container[str]) -> Buffers:
        """Return what is kept of images, in all bands."""
        return {
            name: self._in_all_bands(image) if image.ndim == 2 else image
            for name, image in images.items()
            if split_name(name)[0] in kept
        }

    def _in_all_bands(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        of_band = self._columns.of_band
        if len(of_band) == self._columns.distinct:
            return image
        expanded = self._storage.zeros((len(image), len(of_band)))
        for part in strips(len(image)):
            expanded[part] = image[part][:, of_band]
        return expanded


def _finish(
    own: Accumulator,
    filtered: Accumulator,
    scale: float,
    kept: Container[str],
    plain: Sequence[str],
) -> tuple[Buffers, Buffers]:
    """Return what was filtered, and the plain means of some buffers."""
    buffers, errors = filtered.finish(scale, kept)
    if plain and filtered is not own:
        for images, unfiltered in zip((buffers, errors), own.finish(scale, plain), strict=True):
            images |= {f"{name}_unfiltered": image for name, image in unfiltered.items()}
    return buffers, errors
