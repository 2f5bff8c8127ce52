"""A camera for scenes without one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.scene.camera import FOV, Camera
from photonmap.scene.parameters import parameters_of
from photonmap.scene.vectors import Vector, unit, vector

_MARGIN = 1.05
_AZIMUTH, _ELEVATION = math.radians(30.0), math.radians(25.0)
"""Of the camera, to the right of the front and above it."""


def frame_scene(
    vertices: NDArray[np.float64],
    aspect: float = 1.0,
    up: Vector = (0.0, 1.0, 0.0),
    fov: float = FOV,
) -> Camera:
    """Look at a scene from the front, right and above, so that it fits the image with a margin.

    The front is +z where y is up, and −y where z is up.

    Parameters
    ----------
    vertices : (V, 3), scene units
    aspect : width / height of the image
    up : direction that is up
    fov : full vertical angle of view, degrees

    Raises
    ------
    InputError : `up` is no direction, or `fov` no angle
    """
    checked = vector(up)
    upright = None if checked is None else unit(np.array(checked))
    if upright is None:
        raise InputError(f"up {shown(up)} is not a direction; give three numbers, as in (0, 0, 1)")
    angle = parameters_of(Camera)["fov"].check(fov)
    toward = _three_quarters(upright)
    right = np.cross(upright, toward)
    right /= np.linalg.norm(right)
    center = 0.5 * vertices.min(axis=0) + 0.5 * vertices.max(axis=0)
    slope = math.tan(math.radians(angle) / 2.0) / _MARGIN
    offsets = vertices - center
    depths = offsets @ toward
    aside, width = _fit(offsets @ right, depths, slope * aspect)
    above, height = _fit(offsets @ np.cross(toward, right), depths, slope)
    target = center + aside * right + above * np.cross(toward, right)
    origin = target + (max(width, height) or 1.0) * toward
    return Camera(_plain(origin), _plain(target), _plain(upright), angle)


def _fit(
    across: NDArray[np.float64], depths: NDArray[np.float64], slope: float
) -> tuple[float, float]:
    """Return where two planes meet that touch all points from both sides.

    Parameters
    ----------
    across, depths : of the points, (V,); depths increase towards the camera
    slope : of the planes: half their distance over the depth at which they are so far apart

    Returns
    -------
    That place, across and in depth
    """
    one, other = (slope * depths + across).max(), (slope * depths - across).max()
    return float(one - other) / 2.0, float(one + other) / (2.0 * slope)


def _plain(values: NDArray[np.float64]) -> Vector:
    x, y, z = map(float, values)
    return x, y, z


def _three_quarters(up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the direction towards the camera."""
    front = np.array([0.0, 0.0, 1.0] if abs(up[2]) < 0.9 else [0.0, -1.0, 0.0])
    front -= (front @ up) * up
    front /= np.linalg.norm(front)
    side = math.cos(_AZIMUTH) * front + math.sin(_AZIMUTH) * np.cross(up, front)
    return math.cos(_ELEVATION) * side + math.sin(_ELEVATION) * up
