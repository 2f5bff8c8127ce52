"""Find a camera for a view that is inside the scene, clear of surfaces, and sees objects."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from photonmap.dataset.scenes.paths import find_path
from photonmap.dataset.scenes.sight import Sight, has_room, is_reached
from photonmap.dataset.scenes.views import SIDES, View
from photonmap.errors import InputError
from photonmap.integrators.look import Onlooker
from photonmap.scene.camera import Camera
from photonmap.scene.projections import Pinhole
from photonmap.scene.scene import Scene

TRIES = 64
"""Cameras that are tried for a view, from what was asked for to what the scene has."""
_KEPT = 64
"""Views whose cameras are remembered: they are sought once for all lights and frames."""
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
    own = _with_fov(own, view)
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
    return _on_side(cameras[view.frame], view)


def _search(view: View, own: Camera, scene: Scene, identity: str) -> list[Camera] | None:
    """Return the cameras of all frames of a path, or of a view alone; None if none are good."""
    onlooker = Onlooker(scene)
    seed = zlib.crc32(f"{identity} {view.search}".encode())
    rng = np.random.Generator(np.random.PCG64(seed))
    if view.path:
        return find_path(view, own, onlooker, rng)
    camera = _find_near(view, own, onlooker, rng)
    return None if camera is None else [camera]


def _with_fov(camera: Camera, view: View) -> Camera:
    """Return the camera with the angle of view that is asked for."""
    if view.fov is None:
        return camera
    if not isinstance(camera.model, Pinhole):
        raise InputError(
            f"view {view.name!r} has a fov, but the scene's camera is of the kind "
            f"{camera.model.kind}; leave it out"
        )
    return camera.changed(fov=view.fov)


def _on_side(camera: Camera, view: View) -> Camera:
    """Return the camera of a pair that a view is; the camera itself where it is none."""
    if not view.side:
        return camera
    return replace(camera.stereo(view.baseline)[SIDES.index(view.side)], name=camera.name)


def _find_near(
    view: View, own: Camera, onlooker: Onlooker, rng: np.random.Generator
) -> Camera | None:
    usual = Sight(onlooker, own)
    for moved in (view, *_near(view, rng)):
        try:
            camera = moved.move(own)
        except InputError:
            continue
        if (
            is_reached(onlooker, own, moved)
            and Sight(onlooker, camera).is_good(usual)
            and has_room(onlooker, camera, view.baseline)
        ):
            return camera
    return None


def _near(view: View, rng: np.random.Generator) -> Iterator[View]:
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
