"""Find a camera for a view that is inside the scene, clear of surfaces, and sees objects."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.scene.camera import Camera
from photonmap.scene.scene import Scene

TRIES = 64
"""Cameras that are tried for a view, from what was asked for to what the scene has."""
_YAW, _PITCH, _DISTANCE = 25.0, 8.0, 0.25
"""Greatest standard deviations of tries: degrees, degrees, and of the logarithm of distance."""
_CLEARANCE = 0.08
"""Least distance to any surface, as a fraction of that to the target."""
_OF_USUAL = 0.7
"""The same as a fraction of that from the scene's own camera, if that is less."""
_NEAREST = 0.4
"""Least median of the distances seen, as a fraction of what the scene's own camera sees."""
_OBJECTS = 0.5
"""Least number of objects seen, as a fraction of what the scene's own camera sees."""
_GRID, _FACE = (48, 36), (12, 12)
"""Rays of the image, and of each of the six directions in which clearance is measured."""
_AXES = np.concatenate([np.eye(3), -np.eye(3)])


def find_camera(view: View, scene: Scene, identity: str) -> Camera:
    """Return the camera of a view, moved towards the scene's own until it sees the scene.

    A camera is good if it can be reached from the scene's own, straight or along the orbit, without
    crossing a surface; if no surface is close to it; and if it sees half as many objects as the
    scene's own camera, from not much closer. The lights do not matter, so that a view is the same
    under all of them.

    Parameters
    ----------
    scene : with a camera
    identity : of the scene and its view; draws the cameras that are tried

    Raises
    ------
    InputError : none of `TRIES` cameras is good, or the view cannot be
    """
    own = scene.camera
    assert own is not None
    if view.is_own:
        return own
    view.move(own)  # or say why it cannot be
    onlooker = Onlooker(scene)
    usual = _Sight(onlooker, own)
    for moved in (view, *_near(view, identity)):
        try:
            camera = moved.move(own)
        except InputError:
            continue
        if _is_reached(onlooker, own, moved) and _Sight(onlooker, camera).is_good(usual):
            return camera
    raise InputError(
        f"view {view.name!r} of {scene.name!r}: {TRIES} cameras near it are inside walls or see "
        f"too little; choose another yaw, pitch or distance"
    )


def _near(view: View, identity: str) -> Iterator[View]:
    """Yield views between the one asked for and the scene's own, ever closer to the latter."""
    rng = np.random.Generator(np.random.PCG64(zlib.crc32(f"{identity} {view.name}".encode())))
    for step in range(1, TRIES):
        part = step / TRIES
        asked = (1.0 - part) ** 2
        yaw, pitch, distance = rng.standard_normal(3) * min(part, 4.0 * (1.0 - part))
        yield replace(
            view,
            yaw=asked * view.yaw + _YAW * float(yaw),
            pitch=asked * view.pitch + _PITCH * float(pitch),
            distance=view.distance**asked * float(np.exp(_DISTANCE * distance)),
        )


class _Sight:
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

    def is_good(self, usual: _Sight) -> bool:
        """Return whether it sees enough, compared to what the scene's own camera sees."""
        return (
            self.clearance >= min(_OF_USUAL * usual.clearance, _CLEARANCE * self.arm)
            and self.objects >= max(_OBJECTS * usual.objects, 1)
            and self.median >= _NEAREST * usual.median
        )


def _is_reached(onlooker: Onlooker, own: Camera, view: View) -> bool:
    """Return whether the straight way or the orbit to a view's camera crosses no surface."""
    steps = [
        View(view.name, t * view.yaw, t * view.pitch, 1.0 + t * (view.distance - 1.0)).move(own)
        for t in np.linspace(0.0, 1.0, 9).tolist()
    ]
    orbit = [np.array(camera.origin, np.float64) for camera in steps]
    ways = ([orbit[0], orbit[-1]], orbit)
    return any(all(_is_free(onlooker, a, b) for a, b in pairwise(way)) for way in ways)


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
