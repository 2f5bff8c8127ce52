"""Read sensors as cameras."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.mitsuba_parts.context import Context
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.values import number_of, plain
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.camera import NOT_IN_FILES, Camera, check_camera
from photonmap.scene.lens import Lens
from photonmap.scene.projections import Intrinsics
from photonmap.scene.vectors import Vector, unit

_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC = "perspective", "thinlens", "orthographic"
_TYPES = (_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC)
_IGNORED = ("near_clip", "far_clip", "shutter_open", "shutter_close", "srf")
_FULL_FRAME = math.hypot(36.0, 24.0)
"""Diagonal of the film, mm, to which focal lengths refer"""
_AXES = ("x", "y", "diagonal", "smaller", "larger")


def read_sensor(context: Context, node: Node) -> Camera:
    """Return the camera of a sensor; near and far planes cut nothing off.

    Raises
    ------
    InputError : it is of an unknown type, or a value is not valid
    """
    if node.type not in _TYPES:
        raise node.unknown(_TYPES)
    matrix = node.transform()
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        context.lose("mirrored view", node)
    origin, up = plain(matrix[:3, 3]), plain(matrix[:3, 1])
    size = _film_size(context, node)
    look: dict[str, Any]
    if node.type == _ORTHOGRAPHIC:
        look = {"height": 2.0 * float(np.linalg.norm(matrix[:3, 1])) * size[1] / size[0]}
    else:
        look = _perspective(node, size)
    if node.type == _THIN_LENS and (radius := node.number("aperture_radius", 0.0)) != 0.0:
        look["lens"] = Lens(_focus(node), radius)
    node.read.update(("", *_IGNORED))
    context.lose_unread(node)
    name = re.sub(f"[{re.escape(NOT_IN_FILES)}]", "_", context.name("camera", node))
    try:
        return check_camera(Camera(origin, _target(matrix), up, name=name, **look))
    except InputError as invalid:
        raise node.error(str(invalid)) from None


def _focus(node: Node) -> float:
    focus = node.number("focus_distance", 0.0)
    if focus == 0.0:
        raise node.error("aperture_radius is given and no focus_distance; add one above 0")
    return focus


def _target(matrix: np.ndarray) -> Vector:
    """Return a point ahead, so far away that rounding does not turn the view."""
    ahead = unit(matrix[:3, 2])
    assert ahead is not None  # transformations do not flatten
    return plain(matrix[:3, 3] + max(1.0, float(np.abs(matrix[:3, 3]).max())) * ahead)


def _film_size(context: Context, node: Node) -> tuple[int, int]:
    """Return width and height of the film: only their ratio, and a crop, matter."""
    films = node.parts("film")
    if not films:
        return 768, 576
    size = films[-1].whole("width", 768), films[-1].whole("height", 576)
    if not 0 < min(size) <= max(size) <= 1 << 20:
        raise films[-1].error(f"a film of {size[0]}x{size[1]} is not possible; correct its size")
    if any(films[-1].find(f"crop_{what}") for what in ("width", "height")):
        context.lose("crop", node)
    return size


def _perspective(node: Node, size: tuple[int, int]) -> dict[str, Any]:
    """Return the vertical angle of view; or intrinsics, if the principal point is not central."""
    width, height = size
    axis = node.text("fov_axis", "x").lower()
    if axis not in _AXES:
        raise node.error(f"fov_axis {shown(axis)} is not known; {suggest(axis, _AXES)}")
    if node.find("fov"):
        fov = node.number("fov", 0.0)
    else:
        text = node.text("focal_length", "50mm").removesuffix("mm")
        millimetres = number_of(node.element, text)
        fov = 2.0 * math.degrees(math.atan2(0.5 * _FULL_FRAME, millimetres))
        axis = "diagonal"
    if not 0.0 < fov < 180.0:
        raise node.error(f"an angle of view of {fov:g} degrees is not within 0 and 180; correct it")
    across = {
        "x": width,
        "y": height,
        "diagonal": math.hypot(width, height),
        "smaller": min(size),
        "larger": max(size),
    }[axis]
    focal = 0.5 * across / math.tan(math.radians(fov) / 2.0)
    right, down = (node.number(f"principal_point_offset_{axis}", 0.0) for axis in "xy")
    if right == down == 0.0:
        return {"fov": 2.0 * math.degrees(math.atan(0.5 * height / focal))}
    center = (0.5 - right) * width, (0.5 - down) * height
    return {"projection": Intrinsics(focal, size, cx=center[0], cy=center[1])}
