"""Standard errors of means over blocks of pixels.

Pixels share photons: within a pass, a caustic photon counts in every pixel that its disk reaches,
and sharing windows overlap. So the error of a block's mean does not follow from its pixels' errors;
it is that of the block's means in the passes, which are independent.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.records import FIRST_CAUSTIC, SEEN_CAUSTIC, SEEN_INDIRECT, Film, Pixels

SIDE = 8
"""Pixels; blocks at the right and lower edges have what is left."""
BLOCKED = ("indirect", "caustics")
"""Buffers whose pixels share photons."""

Array = NDArray[Any]


def block_means(image: Array) -> NDArray[np.float64]:
    """Return the means of an image (H, W, …) over its blocks, (⌈H / 8⌉, ⌈W / 8⌉, …)."""
    rows, columns = _starts(image)
    sums = np.add.reduceat(image, rows, axis=0, dtype=np.float64)
    sums = np.add.reduceat(sums, columns, axis=1)
    heights = np.diff(rows, append=image.shape[0])
    widths = np.diff(columns, append=image.shape[1])
    counts = np.multiply.outer(heights, widths)
    return sums / counts.reshape(*counts.shape, *[1] * (image.ndim - 2))


def block_minima(image: Array) -> Array:
    """Return the least values of an image in its blocks."""
    rows, columns = _starts(image)
    return np.minimum.reduceat(np.minimum.reduceat(image, rows, axis=0), columns, axis=1)


def _starts(image: Array) -> tuple[Array, Array]:
    """Return the first row and the first column of each block."""
    height, width = image.shape[:2]
    return np.arange(0, height, SIDE), np.arange(0, width, SIDE)


def pool_errors(counts: list[Array], means: list[Array], errors: list[Array]) -> Array:
    """Return the standard error of the mean over the passes of several runs.

    Parameters
    ----------
    counts : passes of each run; all arrays are of shapes that go together
    means : of each run
    errors : standard errors of these; what they are does not matter where a run has one pass
    """
    total = np.maximum(np.sum(counts, axis=0), 1.0)
    mean = np.sum([n * value for n, value in zip(counts, means, strict=True)], axis=0) / total
    spread = np.zeros_like(mean)
    for n, value, error in zip(counts, means, errors, strict=True):
        own = np.where(n > 1.0, error, 0.0).astype(np.float64)
        spread += own**2 * n * (n - 1.0) + n * (value - mean) ** 2
    pooled = np.sqrt(spread / np.maximum(total * (total - 1.0), 1.0))
    return np.where(total > 1.0, pooled, np.inf)


class BlockMoments:
    """Takes in passes one by one; holds 16 bytes a block and band for each buffer.

    Parameters
    ----------
    film : the image
    bands : N
    smooth : the scene has smooth surfaces, and so caustics
    """

    def __init__(self, film: Film, bands: int, smooth: bool) -> None:
        self.count = 0
        self._shape = film.height, film.width, bands
        blocks = -(-film.height // SIDE), -(-film.width // SIDE), bands
        names = BLOCKED if smooth else BLOCKED[:1]
        self._moments = {name: (np.zeros(blocks), np.zeros(blocks)) for name in names}

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> None:
        """Take in one complete pass, and what it saw in smooth surfaces."""
        self.count += 1
        parts = {"indirect": self._means(pixels.indirect)}
        if seen is not None:
            parts["caustics"] = self._means(seen[FIRST_CAUSTIC]) + self._means(seen[SEEN_CAUSTIC])
            parts["indirect"] += self._means(seen[SEEN_INDIRECT]) + parts["caustics"]
        for name, value in parts.items():
            mean, spread = self._moments[name]
            before = value - mean
            mean += before / self.count
            spread += before * (value - mean)

    def _means(self, image: NDArray[np.float32]) -> NDArray[np.float64]:
        return block_means(image.reshape(self._shape))

    @property
    def arrays(self) -> dict[str, Array]:
        """All that passes leave behind but their number, by name: the arrays themselves."""
        return {
            f"{name} {part}": array
            for name, pair in self._moments.items()
            for part, array in zip(("block mean", "block spread"), pair, strict=True)
        }

    def finish(self, scale: float) -> dict[str, NDArray[np.float64]]:
        """Return the standard errors of blocks' means, by buffer; none after a single pass."""
        if self.count < 2:
            return {}
        divisor = self.count * (self.count - 1.0)
        return {
            name: scale * np.sqrt(spread / divisor) for name, (_, spread) in self._moments.items()
        }
