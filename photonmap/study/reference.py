"""The reference that errors are measured against: two long renders of independent seeds.

Their noise does not bias a measured error: for halves A and B, the expectation of
mean((I − A)(I − B) / …) is the squared error of I alone. Their difference measures the error of
the reference itself.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from photonmap.results.result import Result
from photonmap.study.metrics import (
    BUFFERS,
    Floats,
    Mask,
    counted_pixels,
    mean_difference,
    mean_relative,
)


class Reference:
    """Two independent renders of the same settings, and their mean.

    Parameters
    ----------
    first, second : results of equal size, bands and pixel mode, with at least one valid pixel
    """

    def __init__(self, first: Result, second: Result) -> None:
        self._halves = first, second

    @cached_property
    def mask(self) -> Mask:
        """Valid pixels, (H, W) bool."""
        return counted_pixels(self._halves[0])

    @property
    def shape(self) -> tuple[int, ...]:
        """Height, width and bands of its images."""
        return self._halves[0].radiance.shape

    @property
    def passes(self) -> int:
        """Number of passes of both halves."""
        return sum(half.record["passes"] for half in self._halves)

    @property
    def seconds(self) -> float:
        """Seconds of rendering both halves."""
        return sum(half.record["seconds"]["render"] for half in self._halves)

    @cached_property
    def exposure(self) -> float:
        """Exposure of all pictures of the study."""
        return self._halves[0].exposure

    @cached_property
    def luminance(self) -> Floats:
        """Luminance of radiance, (H, W)."""
        return np.mean([half.xyz()[..., 1] for half in self._halves], axis=0, dtype=np.float64)

    def value(self, buffer: str) -> Floats:
        """Return the mean of the halves over valid pixels, (P, N)."""
        return np.mean([h.buffers[buffer][self.mask] for h in self._halves], 0, dtype=np.float64)

    def own_error(self, buffer: str) -> float:
        """Return the relative error of the reference, from the difference of its halves."""
        first, second = (half.buffers[buffer][self.mask] for half in self._halves)
        half_difference = (first.astype(np.float64) - second) / 2.0
        return math.sqrt(mean_relative(half_difference**2, self.value(buffer)))

    def own_errors(self) -> dict[str, float]:
        """Return `own_error` of every studied buffer."""
        return {buffer: self.own_error(buffer) for buffer in BUFFERS}

    def fits(self, result: Result) -> bool:
        """Return whether a result has the size and the bands of the reference."""
        return result.radiance.shape == self.shape and result.bands == self._halves[0].bands

    def true_error(self, result: Result, buffer: str) -> float:
        """Return the true relative error of a result; 0 where it is too small to be measured."""
        image = result.buffers[buffer][self.mask].astype(np.float64)
        first, second = (image - half.buffers[buffer][self.mask] for half in self._halves)
        return math.sqrt(max(mean_relative(first * second, self.value(buffer)), 0.0))

    def mean_difference(self, result: Result) -> float:
        """Return the relative difference of a result's mean radiance from the reference's."""
        return mean_difference(result.radiance[self.mask], self.value("radiance"))
