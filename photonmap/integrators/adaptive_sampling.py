"""How many samples later passes take, and where: decided by the first ones, without bias.

**Where.** Passes form two halves, those of even and those of odd number; after the warm-up, every
other replicate. The variance that the first passes of one half show decides on the sampling of all
later ones of the other: no pass is planned by its own numbers, so each replicate is an unbiased
estimate, uncorrelated with the rest, and their plain mean and spread stay honest.

**How many.** A render needs `LEAST_PASSES` before it can trust its own error. Where that many full
passes would be more work than the goal needs, passes take half of the samples. The first ones,
which are such halves, tell; if they turn out too small, they are discarded.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.film.blocks import block_sums
from photonmap.film.budget import LEAST_PASSES, Goal
from photonmap.film.pooling import take_in
from photonmap.film.relative_error import relative_squares
from photonmap.kernels.core.passes import (
    FLUORESCENT_DIRECT,
    FLUORESCENT_INDIRECT,
    VIA_DIRECT,
    VIA_INDIRECT,
    Estimate,
    Film,
    SamplingPlan,
)
from photonmap.runtime.storage import RAM, Storage, strips

WARM_UP_PASSES = 8
"""Passes after which sampling adapts."""
TILE = 8
"""Side of a tile, whose pixels are sampled alike, pixels."""
LEAST, MOST = -1, 2
"""Log2 of the factor on the samples of a tile, at least and at most."""
MOST_SAMPLES = 128
"""Samples of one kind in a pixel, at most."""
WORTH = 1.2
"""Factor by which the variance must fall for sampling to adapt."""


class AdaptiveSampling:
    """Learns from the first passes where samples are needed."""

    def __init__(self, film: Film, columns: SpectralColumns, storage: Storage = RAM) -> None:
        pixels = film.width * film.height
        self._film, self._columns = film, columns
        self.moments = storage.zeros((2, 2, pixels))
        """Of either half: means of radiance over bands, and sums of squared deviations"""
        self.sample_scales = storage.zeros((2, pixels), np.int8)
        """Log2 of the factors on samples in later passes of either half"""

    def learn(self, index: int, estimate: Estimate, plan: SamplingPlan) -> None:
        """Take in pass `index`; after the last of the first ones, decide."""
        if index >= WARM_UP_PASSES:
            return
        for part in strips(len(estimate.pixels.direct)):
            mean, spread = self.moments[index % 2][:, part]
            take_in(self._radiance(estimate, part), index // 2 + 1, mean, spread)
        if index == WARM_UP_PASSES - 1:
            for half in range(2):
                self.sample_scales[half] = self._decide(self.moments[1 - half], plan)

    def _radiance(self, estimate: Estimate, part: slice) -> NDArray[np.float32]:
        """Return the means over bands of what more samples improve: no emission and no caustics."""
        pixels, via = estimate.pixels, estimate.via_specular
        light = pixels.direct[part] + pixels.indirect[part]
        if via is not None:
            light += via[VIA_DIRECT, part] + via[VIA_INDIRECT, part]
            if len(via) > FLUORESCENT_INDIRECT:
                light += via[FLUORESCENT_DIRECT, part] + via[FLUORESCENT_INDIRECT, part]
        weights = self._columns.weights / self._columns.weights.sum()
        return np.einsum("pb,b->p", self._columns.whole(light), weights.astype(np.float32))

    def _decide(self, moments: NDArray[np.float32], plan: SamplingPlan) -> NDArray[np.int8]:
        """Return log2 scales for all pixels: samples in proportion to sqrt(variance / cost)."""
        mean, spread = moments
        overall = mean.mean()

        def relative(part: slice) -> NDArray[np.float32]:
            return relative_squares(spread[part], mean[part], overall)

        variance, cost = self._tiles(relative), self._tiles(lambda part: rays_of(plan, part))
        need = np.log2(np.maximum(variance, 1e-30) / np.maximum(cost, 1e-30)) / 2.0
        sample_scales = _share_out(need, cost)
        if variance.sum() < WORTH * (variance * 2.0**-sample_scales).sum():
            return np.zeros(len(mean), np.int8)
        rows, columns = np.arange(self._film.height) // TILE, np.arange(self._film.width) // TILE
        return sample_scales.astype(np.int8)[rows[:, None], columns].ravel()

    def _tiles(self, values: Callable[[slice], NDArray]) -> NDArray[np.float64]:
        """Return the sums over tiles, (rows, columns), of values given pixels by pixels."""
        return block_sums(values, (self._film.width, self._film.height), TILE)[..., 0]


def _share_out(need: NDArray[np.float64], cost: NDArray[np.float64]) -> NDArray[np.float64]:
    """Round `need` plus a constant to powers that cost as much in all as before, or less."""
    low, high = LEAST - need.max(), MOST - need.min()
    for _ in range(40):
        middle = 0.5 * (low + high)
        sample_scales = np.clip(np.rint(need + middle), LEAST, MOST)
        low, high = (
            (middle, high) if (cost * 2.0**sample_scales).sum() <= cost.sum() else (low, middle)
        )
    return np.clip(np.rint(need + low), LEAST, MOST)


def rays_of(plan: SamplingPlan, part: slice) -> NDArray[np.int64]:
    """Return the camera, shadow and gather rays of some pixels whose every sample hits."""
    return plan.samples[part] * (1 + plan.lights[part].astype(np.int64) + plan.gathers[part])


def scale_plan(plan: SamplingPlan, sample_scales: NDArray[np.int8], spreads: bool) -> SamplingPlan:
    """Return a plan with more or fewer samples: of the camera, or where all of these are one."""

    def scaled(counts: NDArray[np.uint8]) -> NDArray[np.uint8]:
        result = np.empty_like(counts)
        for part in strips(len(counts)):
            some = counts[part]
            result[part] = np.clip(
                some * 2.0 ** sample_scales[part], np.minimum(some, 1), MOST_SAMPLES
            )
        return result

    if spreads:
        return plan._replace(samples=scaled(plan.samples))
    return plan._replace(lights=scaled(plan.lights), gathers=scaled(plan.gathers))


PILOT_PASSES = 2
"""Passes after which the size of the others is chosen."""
LOOSE = 0.01
"""Error from which on a goal is worth the pilot passes."""
COSTS = {0.5: (0.58, 1.0), 1.0: (1.0, 0.45)}
"""By fractions of the usual samples: the time of a pass over that of a full one, and the passes
needed over those of halves. Means over the Cornell box, and over `vase`, `living_room`, `kitchen`
and `terrace` under one and two lights, 160×120."""


def first_size(goal: Goal | None) -> float:
    """Return the size of the first passes of a render that aims at an error, or at none."""
    return min(COSTS) if goal is not None and goal.limit >= LOOSE else 1.0


def choose_size(needed: float) -> float:
    """Return the size of passes that costs least, where so many halves would meet the goal."""
    if not math.isfinite(needed):
        return 1.0

    def time(size: float) -> float:
        seconds, passes = COSTS[size]
        return seconds * max(needed * passes, LEAST_PASSES)

    return min(COSTS, key=time)


def resize(plan: SamplingPlan, size: float) -> SamplingPlan:
    """Return a plan with fewer samples of the camera, or where these are one, of everything."""
    if size == 1.0:
        return plan
    samples, lights, gathers = (
        np.empty_like(counts) for counts in (plan.samples, plan.lights, plan.gathers)
    )
    for part in strips(len(samples)):
        wanted = plan.samples[part] * size
        samples[part] = np.maximum(wanted, 1.0)
        rest = wanted / samples[part]
        lights[part] = _scaled(plan.lights[part], rest)
        gathers[part] = _scaled(plan.gathers[part], rest)
    return plan._replace(samples=samples, lights=lights, gathers=gathers)


def _scaled(counts: NDArray[np.uint8], factor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return scaled counts, of which none becomes 0 that was not."""
    return np.ceil(counts * factor)
