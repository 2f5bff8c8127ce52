"""Check a camera, whoever describes it, and frame a scene that has none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from os import PathLike

import numpy as np

from photonmap.errors import InputError
from photonmap.messages import shown
from photonmap.scene import Camera
from photonmap.vectors import finite, unit, vector

_FRAMING_FOV = 40.0
_MARGIN = 1.05
FARTHEST = 1e30
"""Scene units from the origin: depths are float32."""
_PARALLEL = 1e-6
"""Sine of the angle between view and up below which nothing tells what is upright."""


def check_camera(
    camera: Camera,
    path: str | PathLike[str] | None = None,
    lines: Mapping[str, int | None] | None = None,
) -> Camera:
    """Check that a camera can see.

    Parameters
    ----------
    camera : attributes of any type
    path : the file that describes it, for messages
    lines : the line of each attribute in that file

    Returns
    -------
    Camera, the same in plain floats

    Raises
    ------
    InputError : a vector is not three finite numbers, target is origin, up is along the view,
        or fov is outside (0, 180) degrees; or coordinates are beyond 1e30
    """

    def error(attribute: str, problem: str) -> InputError:
        value = shown(getattr(camera, attribute))
        line = (lines or {}).get(attribute)
        return InputError(f"camera {attribute} {value} {problem}", path, line)

    vectors = {}
    for attribute in ("origin", "target", "up"):
        value = vector(getattr(camera, attribute))
        if value is None:
            raise error(attribute, "is no vector; give three finite numbers")
        if max(map(abs, value)) > FARTHEST:
            raise error(attribute, f"is out of sight; give coordinates up to {FARTHEST:g}")
        vectors[attribute] = value
    fov = finite(camera.fov)
    if fov is None or not 0 < fov < 180:
        raise error("fov", "is no angle of view; give degrees between 0 and 180")
    checked = Camera(**vectors, fov=fov)
    view = view_of(checked)
    if view is None:
        raise error("target", "is where the origin is; move one of them")
    up = unit(np.array(vectors["up"]))
    if up is None or np.linalg.norm(np.cross(view, up)) < _PARALLEL:
        raise error("up", "is zero or along the view; choose another direction")
    return checked


def view_of(camera: Camera) -> np.ndarray | None:
    """Return the direction in which a camera looks, of length 1; None where it is not known."""
    return unit(np.array(camera.target) / 2 - np.array(camera.origin) / 2)


def frame_of(camera: Camera) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a checked camera's view, right and up, of length 1 and at right angles."""
    view, up = view_of(camera), unit(np.array(camera.up))
    assert view is not None
    assert up is not None
    right = np.cross(view, up)
    right /= np.linalg.norm(right)
    return view, right, np.cross(right, view)


def frame_scene(vertices: np.ndarray, aspect: float = 1.0) -> Camera:
    """Look at a scene from +z, so that its bounding box fits the image with a margin.

    Parameters
    ----------
    vertices : (V, 3), scene units
    aspect : width / height of the image
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    center, half = 0.5 * (low + high), 0.5 * (high - low)
    reach = float(max(half[0] / aspect, half[1])) or float(half[2]) or 1.0
    distance = float(half[2]) + _MARGIN * reach / math.tan(math.radians(_FRAMING_FOV) / 2)
    x, y, z = map(float, center)
    return Camera((x, y, z + distance), (x, y, z), fov=_FRAMING_FOV)
