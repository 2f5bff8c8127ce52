"""Sums, means and minima over square blocks of pixels, and the standard errors of these means.

Pixels share light: within a pass, a caustic photon counts in every pixel that its disk reaches, and
footprints of irradiance sharing overlap; direct light may be averaged over pixels. So the error of
a block's mean does not follow from its pixels' errors; it is that of the block's means in the
passes, which are independent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.film.pooling import error_of, take_in
from photonmap.film.replicates import ONE_PASS
from photonmap.kernels.core.passes import (
    FIRST_CAUSTIC,
    FLUORESCENT_DIRECT,
    FLUORESCENT_INDIRECT,
    VIA_CAUSTIC,
    VIA_DIRECT,
    VIA_INDIRECT,
    Film,
    Pixels,
)
from photonmap.kernels.film.moments import Weight

Array = NDArray[Any]


def block_sums(
    values: Callable[[slice], NDArray[np.number]], size: tuple[int, int], side: int
) -> NDArray[np.float64]:
    """Return the sums over blocks, (rows, columns, N), of an image of a width and height.

    `values` gives those of consecutive pixels, (n,) or (n, N). Blocks measure `side` pixels; those
    of the last row and column may be smaller.
    """
    (width, height), rows = size, []
    for line in range(0, height, side):
        lines = min(side, height - line)
        pixels = values(slice(line * width, (line + lines) * width))
        sums = pixels.reshape(lines, width, -1).sum(axis=0, dtype=np.float64)
        rows.append(np.add.reduceat(sums, np.arange(0, width, side), axis=0))
    return np.stack(rows)


def block_counts(size: tuple[int, int], side: int) -> NDArray[np.intp]:
    """Return how many pixels the blocks of an image have, (rows, columns)."""
    width, height = size
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    return np.multiply.outer(np.diff(rows, append=height), np.diff(columns, append=width))


def block_means(image: Array, side: int) -> NDArray[np.float64]:
    """Return the means of an image (H, W, …) over its blocks, (rows, columns, …)."""
    height, width = image.shape[:2]
    pixels = image.reshape(height * width, -1)
    sums = block_sums(lambda part: pixels[part], (width, height), side)
    means = sums / block_counts((width, height), side)[..., None]
    return means.reshape(*means.shape[:2], *image.shape[2:])


def block_minima(image: Array, side: int) -> Array:
    """Return the least values of an image (H, W, …) in its blocks, (rows, columns, …)."""
    height, width = image.shape[:2]
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    return np.minimum.reduceat(np.minimum.reduceat(image, rows, axis=0), columns, axis=1)


SIDE = 8
"""Pixels; blocks at the right and lower edges have what is left."""
BLOCKED = names_where(has_block_error=True)
"""Buffers whose pixels share light."""


class BlockMoments:
    """Takes in passes one by one; holds 16 bytes a block and band for each buffer.

    Caustics are kept if the scene has mirrors, glass or rough surfaces, and fluorescence if there
    are fluorescent ones.
    """

    def __init__(self, film: Film, bands: int, specular: bool, fluorescent: bool = False) -> None:
        self.count = 0
        self._shape = film.height, film.width, bands
        blocks = *block_counts((film.width, film.height), SIDE).shape, bands
        omitted = {"caustics": not specular, "fluorescence": not fluorescent}
        self._moments = {
            name: (np.zeros(blocks), np.zeros(blocks)) for name in BLOCKED if not omitted.get(name)
        }

    def add(
        self, pixels: Pixels, seen: NDArray[np.float32] | None, weight: Weight = ONE_PASS
    ) -> None:
        """Take in one complete pass, and what it saw via specular surfaces; or several's means."""
        self.count += int(weight.part)
        parts = {name: self._means(getattr(pixels, name)) for name in ("direct", "indirect")}
        if "caustics" in self._moments and seen is not None:
            parts["direct"] += self._means(seen[VIA_DIRECT])
            parts["caustics"] = self._means(seen[FIRST_CAUSTIC]) + self._means(seen[VIA_CAUSTIC])
            parts["indirect"] += self._means(seen[VIA_INDIRECT]) + parts["caustics"]
        if "fluorescence" in self._moments and seen is not None:
            glow = {"direct": FLUORESCENT_DIRECT, "indirect": FLUORESCENT_INDIRECT}
            glows = {name: self._means(seen[row]) for name, row in glow.items()}
            parts["fluorescence"] = glows["direct"] + glows["indirect"]
            for name, value in glows.items():
                parts[name] += value
        for name, value in parts.items():
            take_in(value, self.count, *self._moments[name], weight)

    def _means(self, image: NDArray[np.float32]) -> NDArray[np.float64]:
        return block_means(image.reshape(self._shape), SIDE)

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
        return {
            name: scale * error_of(spread, np.array(float(self.count)))
            for name, (_, spread) in self._moments.items()
        }
