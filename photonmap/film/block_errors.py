"""Standard errors of means over blocks of pixels.

Pixels share photons: within a pass, a caustic photon counts in every pixel that its disk reaches,
and footprints of irradiance sharing overlap. So the error of a block's mean does not follow from
its pixels' errors; it is that of the block's means in the passes, which are independent.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.film.blocks import block_counts, block_means
from photonmap.film.pooling import error_of, take_in
from photonmap.kernels.core.passes import FIRST_CAUSTIC, VIA_CAUSTIC, VIA_INDIRECT, Film, Pixels

SIDE = 8
"""Pixels; blocks at the right and lower edges have what is left."""
BLOCKED = names_where(has_block_error=True)
"""Buffers whose pixels share photons."""

Array = NDArray[Any]


class BlockMoments:
    """Takes in passes one by one; holds 16 bytes a block and band for each buffer.

    Parameters
    ----------
    film : the image
    bands : N
    specular : the scene has mirrors, glass or rough surfaces, so caustics are kept
    """

    def __init__(self, film: Film, bands: int, specular: bool) -> None:
        self.count = 0
        self._shape = film.height, film.width, bands
        blocks = *block_counts((film.width, film.height), SIDE).shape, bands
        names = BLOCKED if specular else names_where(has_block_error=True, omitted="never")
        self._moments = {name: (np.zeros(blocks), np.zeros(blocks)) for name in names}

    def add(self, pixels: Pixels, seen: NDArray[np.float32] | None) -> None:
        """Take in one complete pass, and what it saw via specular surfaces."""
        self.count += 1
        parts = {"indirect": self._means(pixels.indirect)}
        if seen is not None:
            parts["caustics"] = self._means(seen[FIRST_CAUSTIC]) + self._means(seen[VIA_CAUSTIC])
            parts["indirect"] += self._means(seen[VIA_INDIRECT]) + parts["caustics"]
        for name, value in parts.items():
            take_in(value, self.count, *self._moments[name])

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
