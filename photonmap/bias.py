"""How far supports that are still wide shift indirect light.

Some passes are repeated with the same random numbers and supports twice as wide: cells, windows
and the disks of caustics. What that changes is once the narrower ones' bias if it grows with their
width, thrice if with the square: three quarters are taken, by what was measured. The passes form
two halves, and the product of their mean differences has no noise in its mean; blocks of pixels
keep its spread small.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from photonmap.accumulate import Accumulator
from photonmap.blocks import block_sums
from photonmap.columns import Columns
from photonmap.kernels.records import FIRST_CAUSTIC, SEEN_CAUSTIC, SEEN_INDIRECT, Film, Pixels
from photonmap.passes import Passes, window_width

FIRST, EVERY = 12, 32
"""Number of the first pass that is repeated, as is the one after it; so many passes later, again.
Both have cells of one size, which is what a bias depends on; shorter runs are noisy beyond it."""
OF_DIFFERENCE = 0.75
"""The bias of a width, of the difference to that of twice the width."""
LARGEST_BLOCK, LEAST_ACROSS = 32, 4
"""Side of a block in pixels, and how many lie across the image's shorter side at least."""


def is_probed(index: int) -> bool:
    """Tell whether pass `index` is repeated."""
    return index >= FIRST and (index - FIRST) % EVERY < 2


class BiasProbe:
    """Estimates the bias of radiance by repeating passes.

    Parameters
    ----------
    run : that runs the passes
    film : the image
    columns : what passes carry
    """

    def __init__(self, run: Passes, film: Film, columns: Columns) -> None:
        self._run, self._film, self._columns = run, film, columns
        side = min(film.width, film.height) // LEAST_ACROSS
        self._block = min(max(side, 1), LARGEST_BLOCK)
        blocks = -(-film.width // self._block) * -(-film.height // self._block)
        self.differences = np.zeros((2, blocks, columns.distinct))
        """Sums over the passes of either half"""
        self.stated = np.full(1, np.nan)
        """The bias for windows of width 1, not a number before two passes were probed"""

    @property
    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """All that passes leave behind, by name: the arrays themselves."""
        return {"differences": self.differences, "bias": self.stated}

    def probe(self, index: int, pixels: Pixels, moments: Accumulator) -> None:
        """Repeat pass `index`, which gave `pixels`, if it is one to be probed."""
        if not is_probed(index) or not self._run.has_supports:
            return
        judged = moments.judged()
        narrow = self._indirect(pixels, judged)
        wide = self._indirect(self._run.run(index, wider=1), judged)
        half = (index - FIRST) % EVERY
        self.differences[half] += wide - narrow
        if half == 1 and judged.any():
            probed = [earlier for earlier in range(index + 1) if is_probed(earlier)]
            self.stated[0] = self._estimate(moments, judged, len(probed) // 2)
            self.stated[0] /= window_width(np.array(probed))

    def bias(self, count: int) -> float | None:
        """Return the estimate after `count` passes, relative as the error is; None if unknown."""
        known = not math.isnan(self.stated[0])
        return float(self.stated[0]) * window_width(np.arange(count)) if known else None

    def _estimate(self, moments: Accumulator, judged: NDArray[np.bool_], pairs: int) -> float:
        """Return sqrt(mean(bias² / (v² + 0.01 m²))) over bands and blocks, by judged pixels.

        v is a block's radiance, m its mean in a band. What is noise alone comes out 0 or small.
        """
        pixels = self._sums(lambda part: judged[part, None].astype(np.float64))
        value = self._sums(lambda part: moments.reflected(part) * judged[part, None])
        norm = value**2 + 0.01 * (pixels * value.sum(axis=0) / pixels.sum()) ** 2
        square = self.differences.prod(axis=0) / pairs**2
        relative = np.divide(square, norm, out=np.zeros_like(norm), where=norm > 0.0)
        mean = np.average(relative, axis=0, weights=pixels[:, 0])
        mean = np.average(mean, weights=self._columns.weights)
        return OF_DIFFERENCE * math.sqrt(max(float(mean), 0.0))

    def _indirect(self, pixels: Pixels, judged: NDArray[np.bool_]) -> NDArray[np.float64]:
        seen = self._run.seen

        def light(part: slice) -> NDArray[np.float32]:
            some = pixels.indirect[part]
            if seen is not None:
                some = some + seen[FIRST_CAUSTIC, part] + seen[SEEN_INDIRECT, part]
                some += seen[SEEN_CAUSTIC, part]
            return self._columns.whole(some) * judged[part, None]

        return self._sums(light)

    def _sums(self, image: Callable[[slice], NDArray[np.floating]]) -> NDArray[np.float64]:
        """Return the sums over blocks, (B, N), of an image given pixels by pixels."""
        sums = block_sums(image, (self._film.width, self._film.height), self._block)
        return sums.reshape(-1, sums.shape[-1])
