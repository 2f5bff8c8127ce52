"""Read the cameras of USD stages, with lenses and shifted apertures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pxr import UsdGeom

from photonmap.io.readers.usd_parts.stage import Stage, point
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.lens import Lens
from photonmap.scene.projections import Intrinsics

TENTH = 0.1
"""Apertures and focal lengths are in tenths of scene units."""
_PIXELS = 1000.0


def read_camera(stage: Stage, prim: Any) -> Camera:
    """Return a camera; the shape of its picture is that of the render.

    Raises
    ------
    InputError : a value is out of range
    """
    camera, matrix = UsdGeom.Camera(prim), stage.matrix(prim)
    value = stage.value
    origin, ahead = matrix[:3, 3], -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    high = float(value(camera.GetVerticalApertureAttr(), 15.2908))
    wide = float(value(camera.GetHorizontalApertureAttr(), 20.955))
    shifts = (camera.GetHorizontalApertureOffsetAttr(), camera.GetVerticalApertureOffsetAttr())
    across, up = (float(value(attribute, 0.0)) for attribute in shifts)
    focal = float(value(camera.GetFocalLengthAttr(), 50.0))
    look: dict[str, Any] = {"fov": math.degrees(2.0 * math.atan(0.5 * high / focal))}
    if value(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic:
        look = {"height": TENTH * high}
        origin = origin + TENTH * (across * matrix[:3, 0] + up * matrix[:3, 1])
    elif across or up:
        size = (round(_PIXELS * wide), round(_PIXELS * high))
        fx, cx, cy = _PIXELS * focal, 0.5 * wide - across, 0.5 * high + up
        look = {"projection": Intrinsics(fx, size, fx, _PIXELS * cx, _PIXELS * cy)}
    number = float(value(camera.GetFStopAttr(), 0.0))
    if number > 0.0:
        focus = float(value(camera.GetFocusDistanceAttr(), 0.0))
        look["lens"] = Lens(focus, f_number=number, focal_length=TENTH * focal)
    target = origin + max(1.0, float(np.abs(origin).max())) * ahead
    return check_camera(
        Camera(point(origin), point(target), point(matrix[:3, 1]), name=stage.name(prim), **look),
        stage.path,
    )
