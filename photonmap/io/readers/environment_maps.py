"""Environment maps of Mitsuba and USD, turned as photonmap has them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.images import Image, read_channels
from photonmap.scene.lights import EnvironmentLight
from photonmap.spectra.curves import Floats

_BEHIND = 180.0  # Between the centres of the maps: Mitsuba's is +z
_ROWS = 64  # Rows resampled at a time, so that temporary arrays stay small


def turned_map(source: Path | Image, linear: Floats, scale: float, name: str) -> EnvironmentLight:
    """Return a map whose middle looks along +z of its own coordinates, +y up.

    linear : (3, 3), from its coordinates to the world's
    """
    if isinstance(source, Image):
        texels = source.linear(slice(None), slice(None))
        texels = np.broadcast_to(texels, (*texels.shape[:2], 3))
    else:
        texels = read_channels(source).light()
    height, width = texels.shape[:2]
    angle = _turn(linear)
    if angle is None or width != 2 * height:
        texels = _resampled(texels, linear)
        angle = _BEHIND
    return EnvironmentLight(np.ascontiguousarray(texels), scale, angle, name)


def _turn(linear: Floats) -> float | None:
    """Return the rotation of photonmap's map if a matrix is a turn about +y; None if it is not."""
    length = np.cbrt(np.linalg.det(linear))
    axes = linear / length if length > 0.0 else linear
    is_rotation = np.allclose(axes @ axes.T, np.eye(3), atol=1e-6)
    if length <= 0.0 or not is_rotation or axes[1, 1] < 1.0 - 1e-9:
        return None
    return _BEHIND + math.degrees(math.atan2(axes[0, 2], axes[2, 2]))


def _resampled(texels: NDArray[np.float32], to_world: Floats) -> NDArray[np.float32]:
    """Return a map (H, 2H, 3) that shows another in turned coordinates, interpolated bilinearly.

    texels : (h, w, 3)
    to_world : (3, 3), from directions of this map to those of the world
    """
    size = max(len(texels), (texels.shape[1] + 1) // 2)
    padded = np.concatenate([texels[:, -1:], texels, texels[:, :1]], axis=1)
    to_map = np.linalg.inv(to_world)
    result = np.empty((size, 2 * size, 3), np.float32)
    azimuth = (np.arange(2 * size) + 0.5) / size * np.pi
    for begin in range(0, size, _ROWS):
        polar = (np.arange(begin, min(begin + _ROWS, size)) + 0.5)[:, None] / size * np.pi
        across = np.sin(polar)
        height = np.broadcast_to(np.cos(polar), (len(polar), len(azimuth)))
        world = np.stack([across * np.sin(azimuth), height, -across * np.cos(azimuth)], axis=-1)
        result[begin : begin + len(polar)] = _looked_up(padded, world @ to_map.T)
    return result


def _looked_up(padded: NDArray[np.float32], directions: Floats) -> NDArray[np.float32]:
    """Return what a map, with a column added on each side, holds in directions, (..., 3)."""
    from scipy.ndimage import map_coordinates

    x, y, z = np.moveaxis(directions, -1, 0)
    height, width = len(padded), padded.shape[1] - 2
    rows = np.arctan2(np.hypot(x, z), y) / np.pi * height - 0.5
    columns = np.arctan2(x, -z) / (2.0 * np.pi) % 1.0 * width + 0.5
    places = np.stack([rows, columns])
    channels = [
        map_coordinates(padded[..., channel], places, order=1, mode="nearest")
        for channel in range(3)
    ]
    return np.stack(channels, axis=-1)
