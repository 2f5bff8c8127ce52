"""The floor of a room: where things stand, and whether one can still walk about."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

_CELL = 0.1
"""Side of a cell, metres."""
_WALKER = 0.2
"""Radius of someone who walks about, metres."""
_STEP, _HEAD = 0.05, 1.9
"""What is lower is stepped over, what is higher is passed beneath, metres."""
_CONNECTED = 0.92
"""Least share of the free floor that is in one piece."""
_OPEN = 0.22
"""Least share of the floor that stays open to walk on."""


class FloorPlan:
    """Cells of a floor around the y axis, and which of them a walker can stand in.

    Parameters
    ----------
    width, depth : of the floor along x and z, metres
    """

    def __init__(self, width: float, depth: float) -> None:
        counts = max(1, round(width / _CELL)), max(1, round(depth / _CELL))
        self._axes = [
            (np.arange(n) + 0.5) * (side / n) - 0.5 * side
            for n, side in zip(counts, (width, depth), strict=True)
        ]
        half = 0.5 * np.array([width, depth]) - _WALKER
        inside = [np.abs(axis) <= limit for axis, limit in zip(self._axes, half, strict=True)]
        self._free = inside[0][:, None] & inside[1][None, :]

    def leaves_ways(self, boxes: NDArray[np.float64]) -> bool:
        """Return whether the floor stays open and in one piece if boxes, (n, 2, 3), stand on it."""
        free = self._without(boxes)
        reached = _largest_piece(free)
        return bool(reached.sum() >= _CONNECTED * free.sum() and reached.sum() >= _OPEN * free.size)

    def occupy(self, boxes: NDArray[np.float64]) -> None:
        """Mark the cells that boxes, (n, 2, 3), take up."""
        self._free = self._without(boxes)

    def standing_places(self) -> NDArray[np.float64]:
        """Return x and z of the cells that are reached on foot, (n, 2), metres."""
        i, k = np.nonzero(_largest_piece(self._free))
        return np.stack([self._axes[0][i], self._axes[1][k]], axis=1)

    def _without(self, boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        free = self._free.copy()
        x, z = self._axes
        for low, high in boxes[(boxes[:, 1, 1] > _STEP) & (boxes[:, 0, 1] < _HEAD)]:
            i = np.searchsorted(x, (low[0] - _WALKER, high[0] + _WALKER))
            k = np.searchsorted(z, (low[2] - _WALKER, high[2] + _WALKER))
            free[i[0] : i[1], k[0] : k[1]] = False
        return free


def _largest_piece(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    pieces, count = ndimage.label(free)
    if not count:
        return free
    return pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))
