"""What cameras see of a scene, how near surfaces are, and whether ways are free."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.scenes.views import View
from photonmap.integrators.look import Onlooker
from photonmap.scene.camera import Camera

_CLEARANCE = 0.08
"""Least distance to any surface, as a fraction of that to the target."""
_OF_USUAL = 0.7
"""The same as a fraction of that from the scene's own camera, if that is less."""
_NEAREST = 0.4
"""Least median of the distances seen, as a fraction of what the scene's own camera sees."""
_OBJECTS = 0.5
"""Least number of objects seen, as a fraction of what the scene's own camera sees."""
_BEYOND = 1.25
"""How far the ways to the two cameras of a pair must be free, relative to their length."""
_GRID, _FACE = (48, 36), (12, 12)
"""Rays of the image, and of each of the six directions in which clearance is measured."""
_AXES = np.concatenate([np.eye(3), -np.eye(3)])


class Sight:
    """What a camera sees, and how far it is from the nearest surface."""

    def __init__(self, onlooker: Onlooker, camera: Camera) -> None:
        seen = onlooker.see(camera, _GRID, ("distance", "object_id"))
        hit = seen["object_id"] > 0
        self.objects = len(np.unique(seen["object_id"][hit]))
        self.median = float(np.median(seen["distance"][hit])) if hit.any() else 0.0
        self.arm = float(np.linalg.norm(np.subtract(camera.target, camera.origin)))
        self.clearance = min(
            _nearest(onlooker, np.array(camera.origin, np.float64), axis) for axis in _AXES
        )

    def is_good(self, usual: Sight) -> bool:
        """Return whether it sees enough, compared to what the scene's own camera sees."""
        return (
            self.clearance >= min(_OF_USUAL * usual.clearance, _CLEARANCE * self.arm)
            and self.objects >= max(_OBJECTS * usual.objects, 1)
            and self.median >= _NEAREST * usual.median
        )


def is_reached(onlooker: Onlooker, own: Camera, view: View) -> bool:
    """Return whether the straight way or the orbit to a view's camera crosses no surface."""
    steps = [
        View(view.name, t * view.yaw, t * view.pitch, 1.0 + t * (view.distance - 1.0)).move(own)
        for t in np.linspace(0.0, 1.0, 9).tolist()
    ]
    orbit = [np.array(camera.origin, np.float64) for camera in steps]
    return any(is_way_free(onlooker, way) for way in ([orbit[0], orbit[-1]], orbit))


def is_way_free(onlooker: Onlooker, points: Iterable[NDArray[np.float64]]) -> bool:
    """Return whether straight lines from point to point cross no surface."""
    return all(_is_free(onlooker, a, b) for a, b in pairwise(points))


def has_room(onlooker: Onlooker, camera: Camera, baseline: float) -> bool:
    """Return whether both cameras of a pair about a camera have room beside it."""
    if not baseline:
        return True
    middle = np.array(camera.origin, np.float64)
    sides = [np.array(eye.origin) - middle for eye in camera.stereo(baseline)]
    return all(_is_free(onlooker, middle, middle + _BEYOND * side) for side in sides)


def _is_free(onlooker: Onlooker, start: NDArray[np.float64], end: NDArray[np.float64]) -> bool:
    length = float(np.linalg.norm(end - start))
    if length == 0.0:
        return True
    distance = _distances(onlooker, start, end - start, 1.0, (1, 1))[0, 0]
    return not 0.0 < distance <= length


def _nearest(onlooker: Onlooker, origin: NDArray[np.float64], axis: NDArray[np.float64]) -> float:
    distances = _distances(onlooker, origin, axis, 90.0, _FACE)
    return float(np.where(distances > 0.0, distances, np.inf).min())


def _distances(
    onlooker: Onlooker,
    origin: NDArray[np.float64],
    towards: NDArray[np.float64],
    fov: float,
    size: tuple[int, int],
) -> NDArray[np.float32]:
    """Return the distances in a direction, 0 where nothing is."""
    up = (0.0, 0.0, 1.0) if abs(towards[1]) > np.abs(towards[[0, 2]]).max() else (0.0, 1.0, 0.0)
    camera = Camera(tuple(origin.tolist()), tuple((origin + towards).tolist()), up=up, fov=fov)
    return onlooker.see(camera, size, ("distance",))["distance"]
