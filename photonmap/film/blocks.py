"""Sums, means and minima over square blocks of pixels, without copies of whole images."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


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
