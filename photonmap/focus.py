"""Sampling goes where the error is, without a bias.

The first passes form two halves, those of even and of odd number. What one half shows of the
variance decides on the sampling of all later passes of the other: no pass is planned by its own
numbers, so each is an unbiased estimate, uncorrelated with the rest, and their plain mean and
spread stay honest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.columns import Columns
from photonmap.kernels.records import SEEN_DIRECT, SEEN_INDIRECT, Film, Pixels, Plan

LEARNED = 8
"""Passes after which sampling is focused."""
TILE = 8
"""Side of the tiles that are sampled alike, pixels."""
LEAST, MOST = -1, 2
"""Powers of two by which the samples of a tile change."""
WORTH = 1.2
"""Variance to be saved at least, as a factor."""


class Focus:
    """Learns from the first passes where samples are needed.

    Parameters
    ----------
    film : the image
    columns : what passes carry
    """

    def __init__(self, film: Film, columns: Columns) -> None:
        pixels = film.width * film.height
        self._film, self._columns = film, columns
        self.moments = np.zeros((2, 2, pixels), np.float32)
        """Of either half: means of radiance over bands, and sums of squared deviations"""
        self.powers = np.zeros((2, pixels), np.int8)
        """By which samples change in passes of even and of odd number, as powers of two"""

    def learn(
        self, index: int, pixels: Pixels, seen: NDArray[np.float32] | None, plan: Plan
    ) -> None:
        """Take in pass `index`; after the last of the first ones, decide."""
        if index >= LEARNED:
            return
        mean, spread = self.moments[index % 2]
        radiance = self._radiance(pixels, seen)
        before = radiance - mean
        mean += before / (index // 2 + 1)
        spread += before * (radiance - mean)
        if index == LEARNED - 1:
            for half in range(2):
                self.powers[half] = self._decide(self.moments[1 - half], plan)

    def _radiance(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Return what more samples make less noisy, (P,): all but emission and caustics."""
        light = pixels.direct + pixels.indirect
        if seen is not None:
            light += seen[SEEN_DIRECT] + seen[SEEN_INDIRECT]
        weights = self._columns.weights / self._columns.weights.sum()
        return np.einsum("pb,b->p", self._columns.whole(light), weights.astype(np.float32))

    def _decide(self, moments: NDArray[np.float32], plan: Plan) -> NDArray[np.int8]:
        """Return powers for all pixels: samples in proportion to sqrt(variance / cost)."""
        mean, spread = moments
        norm = mean**2 + 0.01 * mean.mean() ** 2
        relative = np.divide(spread, norm, out=np.zeros_like(norm), where=norm > 0.0)
        variance, cost = self._tiles(relative), self._tiles(rays_of(plan))
        need = np.log2(np.maximum(variance, 1e-30) / np.maximum(cost, 1e-30)) / 2.0
        powers = _share_out(need, cost)
        if variance.sum() < WORTH * (variance * 2.0**-powers).sum():
            return np.zeros(len(mean), np.int8)
        rows, columns = np.arange(self._film.height) // TILE, np.arange(self._film.width) // TILE
        return powers.astype(np.int8)[rows[:, None], columns].ravel()

    def _tiles(self, values: NDArray) -> NDArray[np.float64]:
        """Return the sums over tiles, (rows, columns), of (P,)."""
        sums = values.reshape(self._film.height, self._film.width).astype(np.float64)
        for axis in range(2):
            sums = np.add.reduceat(sums, np.arange(0, sums.shape[axis], TILE), axis=axis)
        return sums


def _share_out(need: NDArray[np.float64], cost: NDArray[np.float64]) -> NDArray[np.float64]:
    """Round `need` plus a constant to powers that cost as much in all as before, or less."""
    low, high = LEAST - need.max(), MOST - need.min()
    for _ in range(40):
        middle = 0.5 * (low + high)
        powers = np.clip(np.rint(need + middle), LEAST, MOST)
        low, high = (middle, high) if (cost * 2.0**powers).sum() <= cost.sum() else (low, middle)
    return np.clip(np.rint(need + low), LEAST, MOST)


def rays_of(plan: Plan) -> NDArray[np.int64]:
    """Return the camera, shadow and gather rays of pixels whose every sample hits, (P,)."""
    return plan.samples * (1 + plan.lights.astype(np.int64) + plan.gathers)


def focused(plan: Plan, powers: NDArray[np.int8], film: Film) -> Plan:
    """Return a plan with more or fewer samples: of the camera, or at the pixels' centres."""
    factor = 2.0**powers

    def scaled(counts: NDArray[np.uint16]) -> NDArray[np.uint16]:
        return np.maximum(counts * factor, np.minimum(counts, 1)).astype(np.uint16)

    if film.jitter:
        return plan._replace(samples=scaled(plan.samples))
    return plan._replace(lights=scaled(plan.lights), gathers=scaled(plan.gathers))
