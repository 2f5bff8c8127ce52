"""How far supports shift indirect light: the bias.

Supports are the cells, footprints and disks over which light is averaged; they narrow as passes add
up. Some passes are repeated with the same random numbers and supports twice as wide. The difference
is once the narrower ones' bias if that grows with their width, and three times if it grows with the
square: three quarters of the difference are taken, as measured. The passes form two halves, and the
product of their mean differences has no noise in its mean; blocks of pixels keep its spread small.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.film.blocks import block_counts, block_sums
from photonmap.film.moments import Accumulator
from photonmap.film.relative_error import relative_squares
from photonmap.film.replicates import replicate_size
from photonmap.kernels.core.passes import (
    FIRST_CAUSTIC,
    FLUORESCENT_INDIRECT,
    VIA_CAUSTIC,
    VIA_INDIRECT,
    Estimate,
    Film,
)

FOOTPRINTS_HOLD, REACH_HOLDS = 64, 16
"""Passes after which sharing footprints begin to narrow in pixels, and, where surfaces near limit
them, in space: there, their bias would soon be as large as the noise."""


def footprint_width(indices: ArrayLike, hold: int = FOOTPRINTS_HOLD) -> float:
    """Return the mean width of the footprints of passes, in units of the first pass's.

    Those in pixels are the supports that narrow the slowest (Knaus and Zwicker 2011).
    """
    return float(np.mean((1.0 + np.asarray(indices) / hold) ** (-1.0 / 6.0)))


FIRST, EVERY = 12, 32
"""Number of the first pass that is repeated, and after how many passes another one is. So is the
same pass of the next replicate, independent of it. In shorter runs noise exceeds the bias."""
OF_DIFFERENCE = 0.75
"""The bias, as a fraction of the difference to supports of twice the width."""
LARGEST_BLOCK, LEAST_ACROSS = 32, 4
"""Largest side of a block in pixels, and the least number of blocks across the shorter side."""


def is_repeated(index: int) -> bool:
    """Return whether pass `index` is repeated."""
    since = (index - FIRST) % EVERY
    return index >= FIRST and since in (0, replicate_size(index - since))


def _half(index: int) -> int:
    """Return to which half a repeated pass belongs."""
    return int((index - FIRST) % EVERY > 0)


class BlockBias(NamedTuple):
    """The estimated bias of blocks of pixels, W·m⁻²·sr⁻¹: means over bands and valid pixels."""

    value: NDArray[np.float32]
    """(rows, columns), estimate − truth; 0 in blocks without a valid pixel"""
    error: NDArray[np.float32]
    """its standard error by the two halves of the probed passes: one degree of freedom a block"""
    side: int
    """of a block, pixels; those at the right and lower edges have what is left"""

    def describe(self) -> dict[str, Any]:
        """Return it as the run record holds it, to 4 significant digits."""
        images = {"value": self.value, "error": self.error}
        lists = {
            name: [[float(f"{each:.4g}") for each in row] for row in image.tolist()]
            for name, image in images.items()
        }
        return {**lists, "side": self.side}

    @classmethod
    def read(cls, described: dict[str, Any]) -> BlockBias:
        """Return what was described."""
        value, error = (np.array(described[name], np.float32) for name in ("value", "error"))
        return cls(value, error, described["side"])

    @classmethod
    def pool(cls, parts: list[BlockBias], counts: list[int]) -> BlockBias:
        """Return that of the mean of runs of so many passes."""
        pairs = [(count / sum(counts), part) for count, part in zip(counts, parts, strict=True)]
        value = sum(weight * part.value for weight, part in pairs)
        square = sum((weight * part.error) ** 2 for weight, part in pairs)
        return cls(np.asarray(value), np.sqrt(square), parts[0].side)


class Repeatable(Protocol):
    """What a bias probe needs of an integrator."""

    @property
    def stores_photons(self) -> bool:
        """Whether photons are stored, so that a pixel that found none is unresolved."""

    @property
    def has_supports(self) -> bool:
        """Whether light is averaged over supports, which biases it."""

    def estimate(self, index: int, wider: int = 0) -> Estimate:
        """Run pass `index` with supports `wider` times doubled."""


class BiasProbe:
    """Estimates the bias of radiance by repeating passes of an integrator, unless it has none."""

    def __init__(
        self,
        integrator: Repeatable,
        film: Film,
        columns: SpectralColumns,
    ) -> None:
        self._integrator, self._film, self._columns = integrator, film, columns
        side = min(film.width, film.height) // LEAST_ACROSS
        self._block = min(max(side, 1), LARGEST_BLOCK)
        blocks = block_counts((film.width, film.height), self._block).size
        self.differences = np.zeros((2, blocks, columns.distinct))
        """Sums over the passes of either half"""
        self.stated = np.full(1, np.nan)
        """The bias for footprints of width 1; not a number before two passes were probed"""

    @property
    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """All that passes leave behind, by name: the arrays themselves."""
        return {"differences": self.differences, "bias": self.stated}

    def probe(self, index: int, estimate: Estimate, moments: Accumulator) -> None:
        """Repeat pass `index`, which gave `estimate`, if it is one to be probed."""
        if self.repeats(index):
            narrow = self.indirect(estimate, moments)
            wide = self.indirect(self._integrator.estimate(index, wider=1), moments)
            self.take_in(index, wide - narrow, moments)

    def repeats(self, index: int) -> bool:
        """Return whether pass `index` is to be probed."""
        return is_repeated(index) and self._integrator.has_supports

    def take_in(self, index: int, difference: NDArray[np.float64], moments: Accumulator) -> None:
        """Take in by how much wider supports change `indirect` in pass `index`."""
        half = _half(index)
        self.differences[half] += difference
        valid = moments.valid(lit=self._integrator.stores_photons)
        if half == 1 and valid.any():
            probed = [earlier for earlier in range(index + 1) if is_repeated(earlier)]
            self.stated[0] = self._estimate(moments, valid, len(probed) // 2)
            self.stated[0] /= footprint_width(np.array(probed))

    def bias(self, count: int) -> float | None:
        """Return the estimate after `count` passes, relative as the error is; None if unknown."""
        if not self._integrator.has_supports:
            return 0.0
        known = not math.isnan(self.stated[0])
        return float(self.stated[0]) * footprint_width(np.arange(count)) if known else None

    def blocks(self, count: int, moments: Accumulator, scale: float) -> BlockBias | None:
        """Return the bias of blocks after `count` passes, times `scale`; None if it is unknown."""
        if math.isnan(self.stated[0]):
            return None
        probed = [index for index in range(count) if is_repeated(index)]
        halves = [sum(_half(index) == half for index in probed) for half in range(2)]
        valid = moments.valid(lit=self._integrator.stores_photons)
        pixels = self._sums(lambda part: valid[part, None].astype(np.float64))[:, 0]
        factor = OF_DIFFERENCE * scale * footprint_width(np.arange(count))
        factor /= footprint_width(np.array(probed))
        weights = self._columns.weights / self._columns.weights.sum()
        first, second = (
            factor * (self.differences[half] @ weights) / np.maximum(halves[half] * pixels, 1.0)
            for half in range(2)
        )
        shape = block_counts((self._film.width, self._film.height), self._block).shape
        value, error = (first + second) / 2.0, np.abs(first - second) / 2.0
        value, error = (image.reshape(shape).astype(np.float32) for image in (value, error))
        return BlockBias(value, error, self._block)

    def _estimate(self, moments: Accumulator, valid: NDArray[np.bool_], pairs: int) -> float:
        """Return sqrt(mean(bias² / (v² + 0.01 m²))) over bands and blocks of valid pixels.

        v is a block's radiance, m its mean in a band. What is noise alone comes out 0 or small.
        """
        pixels = self._sums(lambda part: valid[part, None].astype(np.float64))
        value = self._sums(lambda part: moments.reflected(part) * valid[part, None])
        square = self.differences.prod(axis=0) / pairs**2
        relative = relative_squares(square, value, pixels * value.sum(axis=0) / pixels.sum())
        mean = np.average(relative, axis=0, weights=pixels[:, 0])
        mean = np.average(mean, weights=self._columns.weights)
        return OF_DIFFERENCE * math.sqrt(max(float(mean), 0.0))

    def indirect(self, estimate: Estimate, moments: Accumulator) -> NDArray[np.float64]:
        """Return the indirect light of valid pixels, summed over blocks, (B, N)."""
        via, valid = estimate.via_specular, moments.valid(lit=self._integrator.stores_photons)

        def light(part: slice) -> NDArray[np.float32]:
            some = estimate.pixels.indirect[part]
            if via is not None:
                some = some + via[FIRST_CAUSTIC, part] + via[VIA_INDIRECT, part]
                some += via[VIA_CAUSTIC, part]
                if len(via) > FLUORESCENT_INDIRECT:
                    some += via[FLUORESCENT_INDIRECT, part]
            return self._columns.whole(some) * valid[part, None]

        return self._sums(light)

    def _sums(self, image: Callable[[slice], NDArray[np.floating]]) -> NDArray[np.float64]:
        """Return the sums over blocks, (B, N), of an image given pixels by pixels."""
        sums = block_sums(image, (self._film.width, self._film.height), self._block)
        return sums.reshape(-1, sums.shape[-1])
