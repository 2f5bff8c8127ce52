"""Means and standard errors over independent passes."""

import math

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.gather import EMPTY, FOUND
from photonmap.kernels.mirrors import CUT
from photonmap.kernels.moments import (
    Moments,
    SmoothMoments,
    add_pass,
    finish_shading,
    sum_radiance,
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
        count = self.count + 1
        self._workers.ranges(
            lambda first, last: add_pass(
                self._moments, self._smooth, pixels, seen, count, first, last
            ),
            self._size,
            RANGE,
            whole=True,
        )
        self.count = count

    def error(self) -> float:
        """Return the relative standard error of radiance, as the run record states it.

        sqrt(mean(SE² / (v² + 0.01 m²))) over bands and over the pixels that surfaces cover
        wholly and none of which emits; v is radiance, m its mean in a band. Infinite before the
        second pass, 0 where there is no such pixel.
        """
        if self.count < 2:
            return math.inf
        moments = self._moments
        bands = moments.direct.shape[1]
        parts = np.zeros((-(-self._size // RANGE), bands + 1))
        self._workers.ranges(
            lambda first, last: sum_radiance(moments, first, last, parts[first // RANGE]),
            self._size,
            RANGE,
            whole=True,
        )
        totals = parts.sum(axis=0)
        if totals[-1] == 0.0:
            return 0.0
        mean = totals[:-1] / totals[-1]
        sums = self._workers.ranges(
            lambda first, last: sum_relative_variance(
                moments, mean, self._weights, self.count, first, last
            ),
            self._size,
            RANGE,
            whole=True,
        )
        return math.sqrt(math.fsum(sums) / (totals[-1] * self._weights.sum()))

    def finish(self, scale: float) -> tuple[Buffers, Buffers]:
        """Return the buffers and their standard errors, each (P, N) float32.

        Parameters
        ----------
        scale : multiplies all light

        Returns
        -------
        buffers : radiance, emission, direct, indirect, reflectance, shading, and caustics and
            residual where there are smooth surfaces; coverage (P,)
        errors : of all but the last; empty after a single pass
        """
        moments = self._moments
        shading = np.empty(moments.direct.shape, np.float32)
        errors: Buffers = {"shading": np.zeros_like(shading)}
        self._workers.ranges(
            lambda first, last: finish_shading(
                moments, self._smooth, self.count, first, last, scale, shading, errors["shading"]
            ),
            self._size,
            RANGE,
            whole=True,
        )
        buffers: Buffers = {"shading": shading}
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
        error *= factor / math.sqrt(self.count * max(self.count - 1, 1))
        return error
