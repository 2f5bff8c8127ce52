"""Find cameras for views and paths: inside the scene, clear of surfaces, and seeing objects."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.shapes import Floats, Random
from photonmap.dataset.scenes.views import SIDES, View
from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.scene.camera import Camera
from photonmap.scene.projections import Pinhole
from photonmap.scene.scene import Scene

TRIES = 64
"""Cameras that are tried for a view, from what was asked for to what the scene has; and paths, from
as long as was asked for to hardly any."""
_KNOTS = 4  # points that a path is drawn through
_JITTER = 0.3  # largest deviation of a knot's yaw from even steps, relative to the range
_TARGET = 0.06  # standard deviation of the point that is looked at, relative to its distance
_STEPS = 8  # straight lines between two frames that rays test
_TURN = 40.0  # largest turn of a path over an eighth of it, degrees
_FINE = 512  # steps in which the length of a path is measured
_CLEARANCE = 0.08  # least distance to any surface, as a fraction of that to the target
_OF_USUAL = 0.7  # the same as a fraction of that from the scene's own camera, if that is less
_NEAREST = 0.4
"""Least median of the distances seen, as a fraction of what the scene's own camera sees."""
_OBJECTS = 0.5  # least number of objects seen, as a fraction of what the scene's own camera sees
_BEYOND = 1.25
"""How far the ways to the two cameras of a pair must be free, relative to their length."""
_GRID, _FACE = (48, 36), (12, 12)
"""Rays of the image, and of each of the six directions in which clearance is measured."""
_AXES = np.concatenate([np.eye(3), -np.eye(3)])


def _find_path(
    view: View, own: Camera, onlooker: Onlooker, rng: Random, is_good: Callable[[Camera], bool]
) -> list[Camera] | None:
    """Return the cameras of all frames of a path; None if no path of `TRIES` is free.

    A path is a cubic spline through random places around what the scene's own camera looks at,
    within the view's yaw, pitch and distance, without sharp turns; its frames are evenly spaced.
    Rays test that it can be reached from the own camera and crosses no surface.
    """
    for attempt in range(TRIES):
        drawn = _draw_knots(view, own, rng, 1.0 - attempt / TRIES)
        if drawn is None or not _is_reached(onlooker, own, drawn[0]):
            continue
        way = _even_spline(drawn[1], max(view.frames - 1, 1) * _STEPS)
        if not _is_smooth(way[:, 0]) or not is_way_free(onlooker, way[:, 0]):
            continue
        places = way[::_STEPS][: view.frames].tolist()
        cameras = [replace(own, origin=tuple(at), target=tuple(to)) for at, to in places]
        if all(map(is_good, cameras)):
            return cameras
    return None


def _draw_knots(view: View, own: Camera, rng: Random, part: float) -> tuple[View, Floats] | None:
    """Draw places along a path, in a part of the view's range; return the first and all, (K, 2, 3).

    Of each, where the camera is and what it looks at. None if a camera cannot be there.
    """
    turns = np.linspace(-1.0, 1.0, _KNOTS) + _JITTER * rng.uniform(-1.0, 1.0, _KNOTS)
    turns *= part * rng.choice([-1.0, 1.0])
    rises, ways = part * rng.uniform(-1.0, 1.0, (2, _KNOTS))
    views = [
        View(view.name, turn * view.yaw, rise * view.pitch, view.distance**way)
        for turn, rise, way in zip(turns.tolist(), rises.tolist(), ways.tolist(), strict=True)
    ]
    arm = float(np.linalg.norm(np.subtract(own.target, own.origin)))
    targets = np.array(own.target) + part * _TARGET * arm * rng.standard_normal((_KNOTS, 3))
    try:
        places = [each.move(own).origin for each in views]
    except InputError:
        return None
    return views[0], np.stack([np.array(places, np.float64), targets], axis=1)


def _even_spline(knots: Floats, steps: int) -> Floats:
    """Return places along a cubic spline through knots, evenly spaced: (steps + 1, 2, 3)."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(len(knots)), knots)
    fine = np.linspace(0.0, len(knots) - 1.0, _FINE + 1)
    lengths = np.linalg.norm(np.diff(spline(fine)[:, 0], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    return spline(np.interp(np.linspace(0.0, along[-1], steps + 1), along, fine))


def _is_smooth(places: Floats) -> bool:
    """Return whether a path turns by no more than `_TURN` from an eighth of it to the next."""
    eighths = places[np.linspace(0, len(places) - 1, 9).round().astype(np.intp)]
    steps = np.diff(eighths, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), np.finfo(float).tiny)
    return bool((steps[1:] * steps[:-1]).sum(axis=1).min() >= np.cos(np.radians(_TURN)))


_KEPT = 64  # views whose cameras are remembered: they are sought once for all lights and frames
_YAW, _PITCH, _DISTANCE = 25.0, 8.0, 0.25
"""Greatest standard deviations of tries: degrees, degrees, and of the logarithm of distance."""

_found: dict[tuple[str, Camera, View], list[Camera] | None] = {}
"""Cameras that were found in this process, by identity, the scene's own camera, and view."""


def find_camera(view: View, scene: Scene, identity: str) -> Camera:
    """Return the camera of a view, moved towards the scene's own until it sees the scene.

    A camera is good if it can be reached from the scene's own, straight or along the orbit, without
    crossing a surface; if no surface is close to it; and if it sees half as many objects as the
    scene's own camera, from not much closer. The two cameras of a pair have room on either side of
    it. The lights do not matter, so that a view is the same under all of them.

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
    if view.fov is not None:
        if not isinstance(own.model, Pinhole):
            raise InputError(
                f"view {view.name!r} has a fov, but the scene's camera is of the kind "
                f"{own.model.kind}; leave it out"
            )
        own = own.changed(fov=view.fov)
    if view.is_own and not view.baseline:
        return own
    view.move(own)  # or say why it cannot be
    key = identity, own, replace(view, name=view.search, side="", frame=0)
    if key not in _found:
        while len(_found) >= _KEPT:
            del _found[next(iter(_found))]
        _found[key] = _search(view, own, scene, identity)
    if (cameras := _found[key]) is None:
        raise InputError(
            f"view {view.name!r} of {scene.name!r}: {TRIES} cameras near it are inside walls or "
            f"see too little; choose another yaw, pitch, distance or baseline"
        )
    camera = cameras[view.frame]
    if not view.side:
        return camera
    return replace(camera.stereo(view.baseline)[SIDES.index(view.side)], name=camera.name)


def _search(view: View, own: Camera, scene: Scene, identity: str) -> list[Camera] | None:
    """Return the cameras of all frames of a path, or of a view alone; None if none are good."""
    onlooker = Onlooker(scene)
    usual = _Sight(onlooker, own)
    seed = zlib.crc32(f"{identity} {view.search}".encode())
    rng = np.random.Generator(np.random.PCG64(seed))

    def is_good(camera: Camera) -> bool:
        seen = _Sight(onlooker, camera)
        return seen.is_good(usual) and _has_room(onlooker, camera, view.baseline)

    if view.path:
        return _find_path(view, own, onlooker, rng, is_good)
    for moved in (view, *_near(view, rng)):
        try:
            camera = moved.move(own)
        except InputError:
            continue
        if _is_reached(onlooker, own, moved) and is_good(camera):
            return [camera]
    return None


def _near(view: View, rng: Random) -> Iterator[View]:
    """Yield views between the one asked for and the scene's own, ever closer to the latter."""
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
        origin = np.array(camera.origin, np.float64)
        around = np.stack([_distances(onlooker, origin, axis, 90.0, _FACE) for axis in _AXES])
        self.clearance = float(np.where(around > 0.0, around, np.inf).min())

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
    return any(is_way_free(onlooker, way) for way in ([orbit[0], orbit[-1]], orbit))


def is_way_free(onlooker: Onlooker, points: Iterable[Floats]) -> bool:
    """Return whether straight lines from point to point cross no surface."""
    return all(_is_free(onlooker, a, b) for a, b in pairwise(points))


def _has_room(onlooker: Onlooker, camera: Camera, baseline: float) -> bool:
    """Return whether both cameras of a pair about a camera have room beside it."""
    if not baseline:
        return True
    middle = np.array(camera.origin, np.float64)
    sides = [np.array(eye.origin) - middle for eye in camera.stereo(baseline)]
    return all(_is_free(onlooker, middle, middle + _BEYOND * side) for side in sides)


def _is_free(onlooker: Onlooker, start: Floats, end: Floats) -> bool:
    length = float(np.linalg.norm(end - start))
    if length == 0.0:
        return True
    distance = _distances(onlooker, start, end - start, 1.0, (1, 1))[0, 0]
    return not 0.0 < distance <= length


def _distances(
    onlooker: Onlooker, origin: Floats, towards: Floats, fov: float, size: tuple[int, int]
) -> NDArray[np.float32]:
    """Return the distances in a direction, 0 where nothing is."""
    up = (0.0, 0.0, 1.0) if abs(towards[1]) > np.abs(towards[[0, 2]]).max() else (0.0, 1.0, 0.0)
    camera = Camera(tuple(origin.tolist()), tuple((origin + towards).tolist()), up=up, fov=fov)
    return onlooker.see(camera, size, ("distance",))["distance"]
