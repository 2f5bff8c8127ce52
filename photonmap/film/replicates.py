"""Replicates: passes whose samples go on in one sequence, and whose mean is one value.

All samples of a pixel in a replicate are one set of stratified points, so the mean of its passes
varies less than that of independent ones. They are not independent, so errors come from replicates.
How many passes a replicate has follows from the number of its first pass alone. As passes add up,
replicates get longer, and stay so many that their spread is as certain as that of 16 passes.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.passes import Pixels
from photonmap.kernels.film.moments import Weight
from photonmap.runtime.storage import Storage
from photonmap.runtime.workers import Workers

SIZES = ((48, 8), (24, 4), (16, 2))
"""From which pass on replicates have how many passes; powers of two that divide that number."""
RANGE = 8192
ONE_PASS = Weight(1.0, 1.0, 1.0)
"""Of an independent pass"""


def replicate_size(index: int) -> int:
    """Return how many passes the replicate has that pass `index`, from 0, belongs to."""
    return next((size for first, size in SIZES if index >= first), 1)


def replicate_place(index: int) -> int:
    """Return which pass of its replicate pass `index` is, from 0."""
    return index % replicate_size(index)


def weigh(count: int, passes: int) -> Weight:
    """Return how the mean of a replicate is taken into moments of `count` passes.

    `passes` is how many it has: all, or fewer of the last one. With r = count / size the number of
    replicates, a spread S of values of weight `passes` / size is S = V r (r − 1), if V is the
    variance of the mean. Moments keep V count (count − 1) instead, whatever the size, so that runs
    can be pooled by their passes: exactly what V is, also of replicates of several sizes.
    """
    size = replicate_size(count)
    if size == 1:
        return ONE_PASS

    def per(n: int) -> float:
        return n * (n - 1.0) / (n / size * (n / size - 1.0))

    new = per(count + passes)
    return Weight(float(passes), new / per(count), new * (passes / size) ** 2)


class Replicate:
    """Adds up the passes of a replicate: (P, N) values, and `rows` of what is seen specularly."""

    def __init__(
        self, shape: tuple[int, int], rows: int, workers: Workers, storage: Storage
    ) -> None:
        self._shape, self._rows = shape, rows
        self._workers, self._storage = workers, storage
        self.passes = 0

    @cached_property
    def _sums(self) -> tuple[Pixels, NDArray[np.float32] | None]:
        zeros, size = self._storage.zeros, self._shape[0]
        pixels = Pixels(
            *zeros((6, *self._shape)), zeros(size), zeros(size, np.uint8), zeros((0, 7))
        )
        return pixels, zeros((self._rows, *self._shape)) if self._rows else None

    @property
    def arrays(self) -> dict[str, NDArray]:
        """The sums by name, if there is a pass in them: the arrays themselves."""
        if self.passes == 0:
            return {}
        pixels, seen = self._sums
        named = {**pixels._asdict(), "seen": seen}
        return {f"replicate {name}": array for name, array in named.items() if array is not None}

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> None:
        """Add a pass, and what it saw via specular surfaces."""
        own, own_seen = self._sums
        names = [name for name in Pixels._fields if name not in ("lookups", "plane")]
        pairs = [(getattr(own, name), getattr(pixels, name)) for name in names]
        if own_seen is not None and seen is not None:
            pairs += zip(own_seen, seen, strict=True)
        is_first = self.passes == 0

        def add(first: int, last: int) -> None:
            for total, value in pairs:
                np.add(0.0 if is_first else total[first:last], value[first:last], total[first:last])
            if is_first:
                own.lookups[first:last] = 0
            own.lookups[first:last] |= pixels.lookups[first:last]

        self._workers.ranges(add, self._shape[0], RANGE, uninterrupted=True)
        self.passes += 1

    def take(self) -> tuple[Pixels, NDArray[np.float32] | None]:
        """Return the means over the passes, which are forgotten."""
        pixels, seen = self._sums
        for image in (*pixels[:6], pixels.coverage, *(() if seen is None else seen)):
            image /= np.float32(self.passes)
        self.passes = 0
        return pixels, seen
