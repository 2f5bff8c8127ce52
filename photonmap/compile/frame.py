"""The frame in which kernels work: near the origin, at unit size, whatever the scene's."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from photonmap.errors import InputError
from photonmap.scene.camera import Camera
from photonmap.spectra.curves import Floats

SMALLEST, LARGEST = 1e-30, 1e30
"""Size of a scene in its units, at least and at most: images are float32."""
CLOSE = 1e-3
"""Fraction of the scene's size below which the nearest vertex makes the camera the origin."""


class Frame(NamedTuple):
    """Origin and unit of length of the kernels' numbers, in scene units."""

    center: Floats  # (3,)
    size: float

    def into(self, points: Floats) -> Floats:
        """Return points, (…, 3), in the kernels' units."""
        return (points - self.center) / self.size


def choose_frame(vertices: Floats, camera: Camera | None) -> Frame:
    """Return where the kernels' numbers have their origin, and their unit of length.

    That is the longest side of the scene, or 1 where all is in one point. The origin, about which
    float32 is finest, is the scene's middle, or the camera where it stands among things that are
    small against the scene.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    with np.errstate(over="ignore"):
        size = float((high - low).max()) or 1.0
    if not SMALLEST <= size <= LARGEST:
        raise InputError(
            f"the scene measures {size:.3g} units: depths from {SMALLEST:g} to {LARGEST:g} can be "
            f"represented; choose another unit"
        )
    middle = 0.5 * (low + high)
    if camera is None:
        return Frame(middle, size)
    origin = np.array(camera.origin)
    nearest = np.maximum.reduce([*np.abs(vertices - origin).T]).min()
    inside = np.abs(origin - middle).max() <= size
    return Frame(origin if inside and nearest < CLOSE * size else middle, size)
