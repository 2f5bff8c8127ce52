"""Sums over square blocks of pixels, without copies of whole images."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray


def block_sums(
    values: Callable[[slice], NDArray[np.number]], size: tuple[int, int], side: int
) -> NDArray[np.float64]:
    """Return the sums over blocks, (rows, columns, N).

    Parameters
    ----------
    values : gives those of consecutive pixels, (n,) or (n, N)
    size : width and height of the image
    side : of a block, pixels; the last row and column of blocks may be smaller
    """
    (width, height), rows = size, []
    for line in range(0, height, side):
        lines = min(side, height - line)
        pixels = values(slice(line * width, (line + lines) * width))
        sums = pixels.reshape(lines, width, -1).sum(axis=0, dtype=np.float64)
        rows.append(np.add.reduceat(sums, np.arange(0, width, side), axis=0))
    return np.stack(rows)
