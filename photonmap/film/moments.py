"""Means and standard errors over independent passes, and replicates of several."""

import math
from collections.abc import Callable, Container, Mapping
from copy import copy
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import BY_NAME, names_where
from photonmap.film.relative_error import Mask, dark_floor, valid_pixels
from photonmap.film.replicates import ONE_PASS
from photonmap.kernels.core.passes import EMPTY, FOUND, TRUNCATED, Pixels
from photonmap.kernels.film.add_pass import add_pass, make_chunk_scratch
from photonmap.kernels.film.moments import (
    GOAL_BUFFERS,
    FluorescenceMoments,
    Moments,
    SpecularMoments,
    Weight,
    change_light,
    finish_shading,
    list_relative_variance,
    sum_relative_variance,
    sum_valid,
)
from photonmap.runtime.storage import RAM, Storage, strips
from photonmap.runtime.workers import Workers

RANGE = 8192
ROUNDING = 1e-9
"""Of sums of light, relative."""
MEANS, SPREADS = 5, 8
BYTES_PER_VALUE = 8 * MEANS + 4 * SPREADS

Buffers = dict[str, NDArray[np.float32]]
ALL = names_where(source="passes")
"""Buffers that follow from moments."""
Finished = dict[str, tuple[NDArray[np.float64], NDArray[np.float32], float]]
"""Mean and spread of each buffer, and what multiplies them"""


class Change(NamedTuple):
    """What averaging over pixels makes of a kind of light."""

    gain: NDArray[np.float32]
    """(P, N), of its mean over reflectance; NaN where nothing changes"""
    variance: NDArray[np.float32]
    """(P, N), of that mean"""


class Accumulator:
    """Takes in passes one by one; holds 72 bytes a pixel and band, 24 more if specular.

    48 more are for fluorescence. `size` is the number of pixels P. `weights`, (N,), say how many
    bands a column stands for in the error; 1 each by default.
    """

    def __init__(
        self,
        size: int,
        bands: int,
        workers: Workers,
        specular: bool = False,
        weights: NDArray[np.float64] | None = None,
        storage: Storage = RAM,
        fluorescent: bool = False,
    ) -> None:
        self.count = 0
        self._weights = np.ones(bands) if weights is None else weights
        self._size, self._workers, self._storage = size, workers, storage
        self._moments = Moments(
            *storage.zeros((MEANS, size, bands), np.float64),
            *storage.zeros((SPREADS, size, bands)),
            coverage=storage.zeros(size, np.float64),
            found=storage.zeros(size, np.uint8),
            counts=storage.zeros(size, np.uint32),
            fluorescence=FluorescenceMoments(
                *storage.zeros((4, size, bands), np.float64), *storage.zeros((4, size, bands))
            )
            if fluorescent
            else None,
        )
        self._specular = (
            SpecularMoments(
                *storage.zeros((2, size, bands), np.float64), *storage.zeros((2, size, bands))
            )
            if specular
            else None
        )

    def add(
        self, pixels: Pixels, seen: NDArray[np.float32] | None = None, weight: Weight = ONE_PASS
    ) -> None:
        """Take in one complete pass, and what is seen via specular surfaces if there are any.

        Or with another weight, the means over the passes of a replicate.
        """
        what = *map(flat, (self._moments, self._specular, pixels)), flat(seen, 1), weight
        bands = len(self._weights)
        self._over_pixels(
            lambda first, last: add_pass(*what, first, last, make_chunk_scratch(bands))
        )
        self.count += int(weight.part)

    @property
    def counts(self) -> NDArray[np.uint32]:
        """Passes taken into each pixel, (P,)."""
        return self._moments.counts

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind but their number, by name: the arrays themselves."""
        own = self._moments._asdict()
        parts = own.pop("fluorescence"), self._specular
        return own | {k: v for part in parts if part is not None for k, v in part._asdict().items()}

    @property
    def parts(self) -> tuple[Moments, SpecularMoments | None]:
        """The arrays as kernels take them."""
        return self._moments, self._specular

    def with_light(self, changes: Mapping[str, Change]) -> "Accumulator":
        """Return moments of other direct or indirect light, by name; all else is shared.

        What changes is diffuse, where nothing emits. Direct and indirect light remain correlated as
        they were.
        """
        changed, own = copy(self), self._moments
        names = {part for name in changes for part in (name, f"{name}_spread")}
        arrays = {}
        for name in (*names, "diffuse_spread", "radiance_spread"):
            before = getattr(own, name)
            arrays[name] = self._storage.zeros(before.shape, before.dtype)
            for part in strips(self._size):
                arrays[name][part] = before[part]
        changed._moments = new = own._replace(**arrays)
        spreads = new.diffuse_spread, new.radiance_spread
        for name, other in (("direct", new.indirect_spread), ("indirect", new.direct_spread)):
            if name in changes:
                light = getattr(new, name), getattr(new, f"{name}_spread"), other
                what = tuple(changes[name]), own.counts, own.reflectance, light, spreads
                self._over_pixels(partial(change_light, *what))
        return changed

    def error(
        self, buffer: str = "radiance", percentile: float | None = None, lit: bool = True
    ) -> float:
        """Return the relative standard error of a buffer, as the run record states it.

        sqrt(mean(SE² / (v² + 0.01 m²))) over bands and valid pixels; v is the buffer, m its mean
        in a band. Infinite before the second pass, 0 where no pixel is valid.

        Parameters
        ----------
        buffer : one of the kernels' `GOAL_BUFFERS`
        percentile : in place of the root mean square, the least value that so many percent of
            SE / sqrt(v² + 0.01 m²) do not exceed
        lit : photons were stored, so that a pixel that found none is not valid
        """
        if self.count < 2:
            return math.inf
        what = self._moments, self._specular, GOAL_BUFFERS.index(buffer), lit
        parts = np.zeros((-(-self._size // RANGE), len(self._weights) + 1))
        self._over_pixels(lambda first, last: sum_valid(*what, first, last, parts[first // RANGE]))
        totals = parts.sum(axis=0)
        valid = max(totals[-1], 1.0)
        floor = dark_floor(totals[:-1] / valid)
        if percentile is not None:
            return self._percentile(what, floor, percentile)
        sums = self._over_pixels(
            lambda first, last: sum_relative_variance(*what, floor, self._weights, first, last)
        )
        return math.sqrt(math.fsum(sums) / (valid * self._weights.sum()))

    def valid(self, lit: bool = True) -> Mask:
        """Return which pixels are valid, (P,); `lit` as for `error`."""
        unresolved = self.unresolved() & lit
        return valid_pixels(self._moments.coverage, self._moments.emission, unresolved)

    def states_error(self, lit: bool = True) -> bool:
        """Return whether there is an error to state: of two passes, and of a valid pixel."""
        return self.count > 1 and bool(self.valid(lit).any())

    def shows_nothing(self) -> bool:
        """Return whether no pixel shows a surface or the sky."""
        return not (self._moments.coverage.any() or self._moments.emission.any())

    def is_unlit(self) -> bool:
        """Return whether surfaces that reflect are seen beside lights, and none sends light."""
        moments = self._moments
        if moments.direct.any() or moments.indirect.any():
            return False
        return bool((moments.reflectance.any(axis=1) & ~moments.emission.any(axis=1)).any())

    def reflected(self, part: slice) -> NDArray[np.float32]:
        """Return the light that surfaces send to some pixels: radiance where none emits."""
        return (self._moments.direct[part] + self._moments.indirect[part]).astype(np.float32)

    def _percentile(
        self, what: tuple[Any, ...], floor: NDArray[np.float64], percentile: float
    ) -> float:
        listed = self._storage.zeros((self._size, len(floor)))
        rows = self._over_pixels(
            lambda first, last: list_relative_variance(*what, floor, first, last, listed)
        )
        end = 0
        for index, count in enumerate(rows):
            listed[end : end + count] = listed[index * RANGE :][:count]
            end += count
        values = listed[:end]
        if not len(values):
            return 0.0
        even = (self._weights == 1.0).all()
        variance = np.percentile(
            values,
            percentile,
            method="inverted_cdf",
            weights=None if even else np.broadcast_to(self._weights, values.shape),
            overwrite_input=True,
        )
        return math.sqrt(variance)

    def finish(self, scale: float, kept: Container[str] = ALL) -> tuple[Buffers, Buffers]:
        """Return the kept buffers and their standard errors, each (P, N) float32.

        All light is multiplied by `scale`. Buffers are radiance, emission, direct, indirect,
        reflectance and shading, caustics and residual where there are specular surfaces, and
        fluorescence, its parts and excitation where surfaces fluoresce; covariance; coverage (P,).
        Errors are of all but the last two; empty after a single pass, infinite where a pixel of
        several passes has one.
        """
        table, size = self._table(scale), (self._size, len(self._weights))
        names = [name for name in ("shading", *table, "radiance") if name in kept]
        buffers = {name: self._storage.zeros(size) for name in names}
        errors = {name: self._storage.zeros(size) for name in names if self.count > 1}
        if "covariance" in kept:
            buffers["covariance"] = self._storage.zeros(size)
        if "coverage" in kept:
            buffers["coverage"] = self._storage.zeros(self._size)

        def fill(first: int, last: int) -> None:
            if "shading" in buffers:
                self._fill_shading(first, last, scale, buffers["shading"], errors.get("shading"))
            self._fill(slice(first, last), scale, table, buffers)
            self._fill_errors(slice(first, last), scale, table, errors)

        self._over_pixels(fill)
        return buffers, errors

    def _table(self, scale: float) -> Finished:
        """Return what most buffers are made of."""
        arrays = self.arrays
        return {
            name: (
                arrays[name],
                arrays[f"{name}_spread"],
                scale if BY_NAME[name].quantity == "radiance" else 1.0,
            )
            for name in names_where(source="passes", pooling="mean", has_error=True)
            if name in arrays
        }

    def _fill(self, part: slice, scale: float, table: Finished, buffers: Buffers) -> None:
        """Fill a part of all buffers but shading."""
        moments = self._moments
        for name, (mean, _, factor) in table.items():
            if name in buffers:
                buffers[name][part] = mean[part] * factor
        if "residual" in buffers:
            light = self._diffuse(part)
            np.copyto(buffers["residual"][part], light * scale, where=self._is_missed(part))
        if "radiance" in buffers:
            emission, direct, indirect = (
                (table[name][0][part] * scale).astype(np.float32)
                for name in ("emission", "direct", "indirect")
            )
            buffers["radiance"][part] = (emission + direct) + indirect
        if "covariance" in buffers:
            factors = (scale / self._divisor(part)).astype(np.float32)[:, None]
            buffers["covariance"][part] = moments.product[part] * factors
        if "coverage" in buffers:
            buffers["coverage"][part] = moments.coverage[part]

    def _fill_errors(self, part: slice, scale: float, table: Finished, errors: Buffers) -> None:
        """Fill a part of the standard errors of all buffers but shading."""
        spreads = {name: (spread, factor) for name, (_, spread, factor) in table.items()}
        moments = self._moments
        spreads["radiance"] = moments.radiance_spread, scale
        for name, (spread, factor) in spreads.items():
            if name in errors:
                factors = (factor / np.sqrt(self._divisor(part))).astype(np.float32)
                spread = spread[part]
                if name == "residual":
                    spread = np.where(self._is_missed(part), moments.radiance_spread[part], spread)
                error = np.sqrt(spread) * factors[:, None]
                error[self.counts[part] < 2] = np.inf
                errors[name][part] = error

    def _is_missed(self, part: slice) -> Mask:
        """Return where light comes from surfaces that no camera sample has met yet, (p, N).

        Photons that are connected to the camera meet them at the edge of a pixel. Its reflectance
        is 0, so that no shading accounts for that light: the residual does.
        """
        assert self._specular is not None
        moments = self._moments
        least = ROUNDING * (moments.direct[part] + moments.indirect[part])
        missed = self._diffuse(part) - self._specular.residual[part] > least
        return np.asarray(missed & (moments.reflectance[part] == 0.0))

    def _diffuse(self, part: slice) -> NDArray[np.float64]:
        """Return all light that surfaces send to some pixels without changing its band."""
        moments = self._moments
        light = moments.direct[part] + moments.indirect[part]
        glow = moments.fluorescence
        return light if glow is None else light - glow.fluorescence[part]

    def _fill_shading(
        self,
        first: int,
        last: int,
        scale: float,
        shading: NDArray[np.float32],
        error: NDArray[np.float32] | None,
    ) -> None:
        if error is None:
            error = np.empty((0, shading.shape[1]), np.float32)  # no pixel has had two passes
        else:
            error[first:last] = np.inf
        finish_shading(self._moments, self._specular, first, last, scale, shading, error)

    def unresolved(self) -> NDArray[np.bool_]:
        """Return where gather rays met surfaces but never light on them, (P,)."""
        return (self._moments.found & (EMPTY | FOUND)) == EMPTY

    def truncated(self) -> int:
        """Return how many pixels saw a chain of specular surfaces that was truncated."""
        return int(np.count_nonzero(self._moments.found & TRUNCATED))

    def _divisor(self, part: slice) -> NDArray[np.float64]:
        """Return what a sum of squared deviations is divided by for a mean's variance."""
        count = self.counts[part].astype(np.float64)
        return np.maximum(count * (count - 1.0), 1.0)

    def _over_pixels(self, task: Callable[[int, int], Any]) -> list[Any]:
        return self._workers.ranges(task, self._size, RANGE, uninterrupted=True)


def flat(record: Any, axis: int = 0) -> Any:
    """Return a record whose arrays, and those of records in it, have one axis from this one on."""
    if record is None:
        return None
    if isinstance(record, np.ndarray):
        return record.reshape(*record.shape[:axis], -1)
    return type(record)(*(flat(part, axis) for part in record))
