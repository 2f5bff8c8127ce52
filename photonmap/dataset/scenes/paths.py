"""Smooth paths through the free space of a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.scenes.sight import Sight, has_room, is_reached, is_way_free
from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.scene.camera import Camera

TRIES = 64
"""Paths that are tried, from as long as was asked for to hardly any."""
_KNOTS = 4
"""Points that a path is drawn through."""
_JITTER = 0.3
"""Largest deviation of a knot's yaw from even steps, relative to the range."""
_TARGET = 0.06
"""Standard deviation of the point that is looked at, relative to its distance."""
_STEPS = 8
"""Straight lines between two frames that rays test."""
_TURN = 40.0
"""Largest turn of a path over an eighth of it, degrees."""
_FINE = 512
"""Steps in which the length of a path is measured."""


def find_path(
    view: View, own: Camera, onlooker: Onlooker, rng: np.random.Generator
) -> list[Camera] | None:
    """Return the cameras of all frames of a path; None if no path of `TRIES` is free.

    A path is a cubic spline through random places around what the scene's own camera looks at,
    within the view's yaw, pitch and distance, without sharp turns; its frames are evenly spaced.
    Rays test that it can be reached from the own camera and crosses no surface; and its frames are
    good, as `photonmap.dataset.scenes.view_search.find_camera` has it.
    """
    usual = Sight(onlooker, own)
    for attempt in range(TRIES):
        drawn = _draw_knots(view, own, rng, 1.0 - attempt / TRIES)
        if drawn is None or not is_reached(onlooker, own, drawn[0]):
            continue
        way = _even_spline(drawn[1], max(view.frames - 1, 1) * _STEPS)
        frames = way[::_STEPS][: view.frames]
        cameras = [_camera_at(own, place) for place in frames]
        if not _is_smooth(way[:, 0]) or not is_way_free(onlooker, way[:, 0]):
            continue
        if all(
            Sight(onlooker, camera).is_good(usual) and has_room(onlooker, camera, view.baseline)
            for camera in cameras
        ):
            return cameras
    return None


def _draw_knots(
    view: View, own: Camera, rng: np.random.Generator, part: float
) -> tuple[View, NDArray[np.float64]] | None:
    """Draw places along a path, ordered by yaw; return the first and all, (K, 2, 3), scene units.

    Of each, where the camera is and what it looks at. None if a camera cannot be there.

    Parameters
    ----------
    part : how much of the view's range is taken
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


def _even_spline(knots: NDArray[np.float64], steps: int) -> NDArray[np.float64]:
    """Return places along a cubic spline through knots, evenly spaced: (steps + 1, 2, 3)."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.arange(len(knots)), knots)
    fine = np.linspace(0.0, len(knots) - 1.0, _FINE + 1)
    lengths = np.linalg.norm(np.diff(spline(fine)[:, 0], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    return spline(np.interp(np.linspace(0.0, along[-1], steps + 1), along, fine))


def _is_smooth(places: NDArray[np.float64]) -> bool:
    """Return whether a path turns by no more than `_TURN` from an eighth of it to the next."""
    eighths = places[np.linspace(0, len(places) - 1, 9).round().astype(np.intp)]
    steps = np.diff(eighths, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), np.finfo(float).tiny)
    return bool((steps[1:] * steps[:-1]).sum(axis=1).min() >= np.cos(np.radians(_TURN)))


def _camera_at(own: Camera, place: NDArray[np.float64]) -> Camera:
    origin, target = (tuple(point.tolist()) for point in place)
    return replace(own, origin=origin, target=target)
