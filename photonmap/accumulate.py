"""Means and standard errors over independent passes."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.gather import EMPTY, FOUND
from photonmap.kernels.mirrors import CUT
from photonmap.kernels.moments import (
    JUDGED,
    Moments,
    SmoothMoments,
    add_pass,
    finish_shading,
    list_relative_variance,
    sum_judged,
    sum_relative_variance,
)
from photonmap.kernels.records import Pixels
from photonmap.workers import Workers

RANGE = 8192
MEANS, SPREADS = 5, 8
BYTES_PER_VALUE = 8 * MEANS + 4 * SPREADS

Buffers = dict[str, NDArray[np.float32]]


class Accumulator:
    """Takes in passes one by one; holds 72 bytes a pixel and band.

    Parameters
    ----------
    size : number of pixels P
    bands : N
    workers : that share the work
    smooth : the scene has smooth surfaces; 24 bytes more
    weights : (N,) how many bands a column stands for in the error; 1 each by default
    """

    def __init__(
        self,
        size: int,
        bands: int,
        workers: Workers,
        smooth: bool = False,
        weights: NDArray[np.float64] | None = None,
    ) -> None:
        self.count = 0
        self._weights = np.ones(bands) if weights is None else weights
        self._size, self._workers = size, workers
        self._moments = Moments(
            *(np.zeros((size, bands)) for _ in range(MEANS)),
            *(np.zeros((size, bands), np.float32) for _ in range(SPREADS)),
            coverage=np.zeros(size),
            found=np.zeros(size, np.uint8),
            counts=np.zeros(size, np.uint32),
        )
        self._smooth = (
            SmoothMoments(
                *(np.zeros((size, bands)) for _ in range(2)),
                *(np.zeros((size, bands), np.float32) for _ in range(2)),
            )
            if smooth
            else None
        )

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None = None) -> None:
        """Take in one complete pass, and what is seen in smooth surfaces if there are any."""
        self._over_pixels(
            lambda first, last: add_pass(self._moments, self._smooth, pixels, seen, first, last)
        )
        self.count += 1

    @property
    def counts(self) -> NDArray[np.uint32]:
        """Passes taken into each pixel, (P,)."""
        return self._moments.counts

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that passes leave behind but their number, by name: the arrays themselves."""
        smooth = {} if self._smooth is None else self._smooth._asdict()
        return {**self._moments._asdict(), **smooth}

    def error(
        self, buffer: str = "radiance", percentile: float | None = None, lit: bool = True
    ) -> float:
        """Return the relative standard error of a buffer, as the run record states it.

        sqrt(mean(SE² / (v² + 0.01 m²))) over bands and over the pixels that surfaces cover
        wholly, none of which emits, and whose indirect light was found; v is the buffer, m its
        mean in a band. Infinite before the second pass, 0 where there is no such pixel.

        Parameters
        ----------
        buffer : one of the kernels' `JUDGED`
        percentile : in place of the root mean square, the least value that so many percent of
            SE / sqrt(v² + 0.01 m²) do not exceed
        lit : photons were stored, so that a pixel that found none is left out
        """
        if self.count < 2:
            return math.inf
        what = self._moments, self._smooth, JUDGED.index(buffer), lit
        parts = np.zeros((-(-self._size // RANGE), len(self._weights) + 1))
        self._over_pixels(lambda first, last: sum_judged(*what, first, last, parts[first // RANGE]))
        totals = parts.sum(axis=0)
        judged = max(totals[-1], 1.0)
        mean = totals[:-1] / judged
        if percentile is not None:
            return self._percentile(what, mean, percentile)
        sums = self._over_pixels(
            lambda first, last: sum_relative_variance(*what, mean, self._weights, first, last)
        )
        return math.sqrt(math.fsum(sums) / (judged * self._weights.sum()))

    def judged_radiance(self) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Return radiance, (P, N), and which pixels surfaces cover wholly and none emits, (P,)."""
        moments = self._moments
        judged = (moments.coverage == 1.0) & ~moments.emission.any(axis=1)
        return (moments.direct + moments.indirect).astype(np.float32), judged

    def _percentile(
        self, what: tuple[Any, ...], mean: NDArray[np.float64], percentile: float
    ) -> float:
        listed = np.empty((self._size, len(mean)), np.float32)
        rows = self._over_pixels(
            lambda first, last: list_relative_variance(*what, mean, first, last, listed)
        )
        values = np.concatenate([listed[i * RANGE :][:count] for i, count in enumerate(rows)])
        if not len(values):
            return 0.0
        even = (self._weights == 1.0).all()
        variance = np.percentile(
            values,
            percentile,
            method="inverted_cdf",
            weights=None if even else np.broadcast_to(self._weights, values.shape),
        )
        return math.sqrt(variance)

    def finish(self, scale: float) -> tuple[Buffers, Buffers]:
        """Return the buffers and their standard errors, each (P, N) float32.

        Parameters
        ----------
        scale : multiplies all light

        Returns
        -------
        buffers : radiance, emission, direct, indirect, reflectance, shading, and caustics and
            residual where there are smooth surfaces; covariance; coverage (P,)
        errors : of all but the last two; empty after a single pass, infinite where a pixel of
            several passes has one
        """
        moments = self._moments
        shading = np.empty(moments.direct.shape, np.float32)
        errors: Buffers = {"shading": np.full_like(shading, np.inf)}
        self._over_pixels(
            lambda first, last: finish_shading(
                moments, self._smooth, first, last, scale, shading, errors["shading"]
            )
        )
        buffers: Buffers = {"shading": shading, "covariance": self._covariance(scale)}
        for name, spread, factor in (
            ("emission", moments.emission_spread, scale),
            ("direct", moments.direct_spread, scale),
            ("indirect", moments.indirect_spread, scale),
            ("reflectance", moments.reflectance_spread, 1.0),
        ):
            buffers[name] = (getattr(moments, name) * factor).astype(np.float32)
            errors[name] = self._standard_error(spread, factor)
        buffers["radiance"] = (buffers["emission"] + buffers["direct"]) + buffers["indirect"]
        errors["radiance"] = self._standard_error(moments.radiance_spread, scale)
        if self._smooth is not None:
            for name in ("caustics", "residual"):
                buffers[name] = (getattr(self._smooth, name) * scale).astype(np.float32)
                spread = getattr(self._smooth, f"{name}_spread")
                errors[name] = self._standard_error(spread, scale)
        buffers["coverage"] = moments.coverage.astype(np.float32)
        return buffers, errors if self.count > 1 else {}

    def unresolved(self) -> NDArray[np.bool_]:
        """Return where gather rays met surfaces but never light on them, (P,)."""
        return (self._moments.found & (EMPTY | FOUND)) == EMPTY

    def cut(self) -> int:
        """Return how many pixels saw a chain of smooth surfaces that was cut."""
        return int(np.count_nonzero(self._moments.found & CUT))

    def _standard_error(self, spread: NDArray[np.float32], factor: float) -> NDArray[np.float32]:
        error = np.sqrt(spread)
        error *= (factor / np.sqrt(self._divisor())).astype(np.float32)[:, None]
        error[self.counts < 2] = np.inf
        return error

    def _covariance(self, factor: float) -> NDArray[np.float32]:
        """Return the covariance of the means of diffuse light and reflectance."""
        return self._moments.product * (factor / self._divisor()).astype(np.float32)[:, None]

    def _divisor(self) -> NDArray[np.float64]:
        """Return what a sum of squared deviations is divided by for a mean's variance, (P,)."""
        count = self.counts.astype(np.float64)
        return np.maximum(count * (count - 1.0), 1.0)

    def _over_pixels(self, task: Callable[[int, int], Any]) -> list[Any]:
        return self._workers.ranges(task, self._size, RANGE, whole=True)
