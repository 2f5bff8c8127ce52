"""What averaging gains in the sum over a block of pixels, given back to them.

It is a bias, which is so known with little noise.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.film.blocks import SIDE

DIGITS = 6
"""Of reflectances that are one: means of equal samples differ by rounding"""
Image = NDArray[np.float64]


class Blocks:
    """Pixels of one reflectance in a block, of all that are filtered in some lines of the image.

    They are numbered as in `kept`, (n,), and have a reflectance, (n, N).
    """

    def __init__(self, kept: NDArray[np.int64], reflectance: NDArray[Any], width: int) -> None:
        lines, columns = np.divmod(kept, width)
        blocks = lines // SIDE * width + columns // SIDE
        keys = np.stack([*np.round(reflectance, DIGITS).T, blocks])
        self._order = np.lexsort(keys)
        begins = np.diff(keys[:, self._order], prepend=-1.0).any(axis=0)
        self._starts, self._places = np.flatnonzero(begins), np.empty(len(kept), np.intp)
        self._places[self._order] = np.cumsum(begins) - 1

    def sums(self, image: Image) -> Image:
        """Return the sums over pixels alike of an image of those that are filtered, for each."""
        return np.asarray(np.add.reduceat(image[self._order], self._starts, axis=0)[self._places])


def mean_of_groups(image: Image, parts: Image) -> Image:
    """Return the mean over groups of passes, (n, N, G), which have these parts of it, (G,)."""
    return np.asarray((image.reshape(-1, len(parts)) @ parts).reshape(image.shape[:-1]))


def give_back(
    gain: Image, variance: Image, light: Image, parts: Image, blocks: Blocks
) -> tuple[Image, Image]:
    """Take from gain, (n, N, G), what pixels of a block gained together.

    Pixels return it in proportion to their variance before, (n, N), those that vary alone all of
    it; where that is more than the light of one of them, (n, N), in proportion to light. Shares are
    those of all bands, so that the light keeps its colour. Return the variance of all that blocks
    hold, (n, N), and a pixel's share, (n,). `parts`, (G,), are those of the groups in the mean.
    """
    sums = blocks.sums
    returned = sums(gain)
    share, by_light = (
        each / np.maximum(sums(each), np.finfo(np.float64).tiny)
        for each in (variance.mean(axis=1), light.mean(axis=1))
    )
    is_more = (share[:, None] * mean_of_groups(returned, parts) > light).any(axis=1)
    share = np.where(sums(is_more.astype(np.float64)) > 0.0, by_light, share)
    gain -= share[:, None, None] * returned
    return sums(variance), share
