"""Sampling goes where the error is, without a bias.

The first passes form two halves, those of even and of odd number. What one half shows of the
variance decides on the sampling of all later passes of the other: no pass is planned by its own
numbers, so each is an unbiased estimate, uncorrelated with the rest, and their plain mean and
spread stay honest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from photonmap.blocks import block_sums
from photonmap.columns import Columns
from photonmap.kernels.records import SEEN_DIRECT, SEEN_INDIRECT, Film, Pixels, Plan
from photonmap.storage import RAM, Storage, strips

LEARNED = 8
"""Passes after which sampling is focused."""
TILE = 8
"""Side of the tiles that are sampled alike, pixels."""
LEAST, MOST = -1, 2
"""Powers of two by which the samples of a tile change."""
MOST_SAMPLES = 128
"""Of a kind, in a pixel."""
WORTH = 1.2
"""Variance to be saved at least, as a factor."""


class Focus:
    """Learns from the first passes where samples are needed.

    Parameters
    ----------
    film : the image
    columns : what passes carry
    storage : where the arrays lie
    """

    def __init__(self, film: Film, columns: Columns, storage: Storage = RAM) -> None:
        pixels = film.width * film.height
        self._film, self._columns = film, columns
        self.moments = storage.zeros((2, 2, pixels))
        """Of either half: means of radiance over bands, and sums of squared deviations"""
        self.powers = storage.zeros((2, pixels), np.int8)
        """By which samples change in passes of even and of odd number, as powers of two"""

    def learn(
        self, index: int, pixels: Pixels, seen: NDArray[np.float32] | None, plan: Plan
    ) -> None:
        """Take in pass `index`; after the last of the first ones, decide."""
        if index >= LEARNED:
            return
        for part in strips(len(pixels.direct)):
            mean, spread = self.moments[index % 2][:, part]
            radiance = self._radiance(pixels, seen, part)
            before = radiance - mean
            mean += before / (index // 2 + 1)
            spread += before * (radiance - mean)
        if index == LEARNED - 1:
            for half in range(2):
                self.powers[half] = self._decide(self.moments[1 - half], plan)

    def _radiance(
        self, pixels: Pixels, seen: NDArray[np.float32] | None, part: slice
    ) -> NDArray[np.float32]:
        """Return what more samples make less noisy of some pixels: all but emission and caustics.

        The mean over bands.
        """
        light = pixels.direct[part] + pixels.indirect[part]
        if seen is not None:
            light += seen[SEEN_DIRECT, part] + seen[SEEN_INDIRECT, part]
        weights = self._columns.weights / self._columns.weights.sum()
        return np.einsum("pb,b->p", self._columns.whole(light), weights.astype(np.float32))

    def _decide(self, moments: NDArray[np.float32], plan: Plan) -> NDArray[np.int8]:
        """Return powers for all pixels: samples in proportion to sqrt(variance / cost)."""
        mean, spread = moments
        floor = 0.01 * mean.mean() ** 2

        def relative(part: slice) -> NDArray[np.float32]:
            norm = mean[part] ** 2 + floor
            return np.divide(spread[part], norm, out=np.zeros_like(norm), where=norm > 0.0)

        variance, cost = self._tiles(relative), self._tiles(lambda part: rays_of(plan, part))
        need = np.log2(np.maximum(variance, 1e-30) / np.maximum(cost, 1e-30)) / 2.0
        powers = _share_out(need, cost)
        if variance.sum() < WORTH * (variance * 2.0**-powers).sum():
            return np.zeros(len(mean), np.int8)
        rows, columns = np.arange(self._film.height) // TILE, np.arange(self._film.width) // TILE
        return powers.astype(np.int8)[rows[:, None], columns].ravel()

    def _tiles(self, values: Callable[[slice], NDArray]) -> NDArray[np.float64]:
        """Return the sums over tiles, (rows, columns), of values given pixels by pixels."""
        return block_sums(values, (self._film.width, self._film.height), TILE)[..., 0]


def _share_out(need: NDArray[np.float64], cost: NDArray[np.float64]) -> NDArray[np.float64]:
    """Round `need` plus a constant to powers that cost as much in all as before, or less."""
    low, high = LEAST - need.max(), MOST - need.min()
    for _ in range(40):
        middle = 0.5 * (low + high)
        powers = np.clip(np.rint(need + middle), LEAST, MOST)
        low, high = (middle, high) if (cost * 2.0**powers).sum() <= cost.sum() else (low, middle)
    return np.clip(np.rint(need + low), LEAST, MOST)


def rays_of(plan: Plan, part: slice) -> NDArray[np.int64]:
    """Return the camera, shadow and gather rays of some pixels whose every sample hits."""
    return plan.samples[part] * (1 + plan.lights[part].astype(np.int64) + plan.gathers[part])


def count_rays(plan: Plan) -> int:
    """Return how many they are in all."""
    return sum(int(rays_of(plan, part).sum()) for part in strips(len(plan.samples)))


def focused(plan: Plan, powers: NDArray[np.int8], film: Film) -> Plan:
    """Return a plan with more or fewer samples: of the camera, or at the pixels' centres."""

    def scaled(counts: NDArray[np.uint8]) -> NDArray[np.uint8]:
        result = np.empty_like(counts)
        for part in strips(len(counts)):
            some = counts[part]
            result[part] = np.clip(some * 2.0 ** powers[part], np.minimum(some, 1), MOST_SAMPLES)
        return result

    if film.jitter:
        return plan._replace(samples=scaled(plan.samples))
    return plan._replace(lights=scaled(plan.lights), gathers=scaled(plan.gathers))
