"""What errors are measured against: two long renders of independent seeds.

Their noise does not bias a measured error, as mean((I − A)(I − B) / …) of halves A and B is, over
seeds, the error of I alone; and their difference measures the reference's own error.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from photonmap.result import Result
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
    first, second : results that share size, bands and pixel mode; some of their pixels count
    """

    def __init__(self, first: Result, second: Result) -> None:
        self._halves = first, second

    @cached_property
    def mask(self) -> Mask:
        """(H, W): the pixels that count."""
        return counted_pixels(self._halves[0])

    @property
    def shape(self) -> tuple[int, ...]:
        """Height, width and bands of its images."""
        return self._halves[0].radiance.shape

    @property
    def passes(self) -> int:
        """Of both halves."""
        return sum(half.record["passes"] for half in self._halves)

    @property
    def seconds(self) -> float:
        """Of rendering both halves."""
        return sum(half.record["seconds"]["render"] for half in self._halves)

    @cached_property
    def exposure(self) -> float:
        """By which all pictures of the study are shown."""
        return self._halves[0].exposure

    @cached_property
    def luminance(self) -> Floats:
        """(H, W): Y of radiance."""
        return np.mean([half.xyz()[..., 1] for half in self._halves], axis=0, dtype=np.float64)

    def value(self, buffer: str) -> Floats:
        """Return the mean of the halves where pixels count, (P, N)."""
        return np.mean([h.buffers[buffer][self.mask] for h in self._halves], 0, dtype=np.float64)

    def own_error(self, buffer: str) -> float:
        """Return the error of the mean, measured by the halves' difference."""
        first, second = (half.buffers[buffer][self.mask] for half in self._halves)
        half_difference = (first.astype(np.float64) - second) / 2.0
        return math.sqrt(mean_relative(half_difference**2, self.value(buffer)))

    def own_errors(self) -> dict[str, float]:
        """Return `own_error` of every buffer that is studied."""
        return {buffer: self.own_error(buffer) for buffer in BUFFERS}

    def fits(self, result: Result) -> bool:
        """Tell whether a result has the size and the bands to be measured against this."""
        return result.radiance.shape == self.shape and result.bands == self._halves[0].bands

    def true_error(self, result: Result, buffer: str) -> float:
        """Return what a result is truly off by; 0 where it is too little to be told."""
        image = result.buffers[buffer][self.mask].astype(np.float64)
        first, second = (image - half.buffers[buffer][self.mask] for half in self._halves)
        return math.sqrt(max(mean_relative(first * second, self.value(buffer)), 0.0))

    def mean_difference(self, result: Result) -> float:
        """Return by which part a result's mean radiance exceeds the reference's."""
        return mean_difference(result.radiance[self.mask], self.value("radiance"))
