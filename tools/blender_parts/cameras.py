"""Cameras, with shifts, lenses and panoramas, which glTF does not hold."""

import math
from typing import Any

import numpy as np
from mathutils import Vector

from blender_parts.draft import Draft, is_flat, turn

NOT_IN_NAMES = '/\\:*?"<>|'
"""What names of cameras may not hold: they become parts of names of files."""


def add_cameras(draft: Draft) -> None:
    """Add all cameras, that of the scene first."""
    cameras = [item for item in draft.scene.objects if item.type == "CAMERA"]
    cameras.sort(key=lambda item: item != draft.scene.camera)
    for item in cameras:
        matrix = item.matrix_world.normalized()
        values = _projection(draft, item)
        origin = matrix @ values.pop("moved", Vector((0.0, 0.0, 0.0)))
        axes = matrix.to_3x3()
        draft.section(
            "[[camera]]",
            name="".join("_" if letter in NOT_IN_NAMES else letter for letter in item.name),
            origin=turn(origin),
            target=turn(origin - max(1.0, origin.length) * axes.col[2]),
            up=turn(axes.col[1]),
            **values,
        )


def _projection(draft: Draft, item: Any) -> dict[str, Any]:
    """Return what a camera projects, and through which lens."""
    data = item.data
    if data.type == "PANO":
        return {"projection": _panorama(draft, item)}
    frame = np.array(data.view_frame(scene=draft.scene))  # corners before the camera, of any depth
    (left, bottom, _), (right, top, _), depth = frame.min(axis=0), frame.max(axis=0), -frame[0, 2]
    wide, high, lens = float(right - left), float(top - bottom), _lens(draft, item)
    if data.type == "ORTHO":
        moved = Vector((0.5 * (left + right), 0.5 * (top + bottom), 0.0))
        return {"height": high, "moved": moved, "lens": lens}
    width, height = draft.size
    fx, fy = float(width * depth / wide), float(height * depth / high)
    if is_flat(left, -right) and is_flat(bottom, -top) and is_flat(fx / fy, 1.0, 2e-3):
        return {"fov": math.degrees(2.0 * math.atan(0.5 * high / depth)), "lens": lens}
    cx, cy = float(-left / wide * width), float(top / high * height)
    of = {"type": "intrinsics", "size": [width, height], "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    return {"projection": of, "lens": lens}


def _panorama(draft: Draft, item: Any) -> dict[str, Any]:
    """Return the projection of a panorama."""
    data = item.data if hasattr(item.data, "panorama_type") else item.data.cycles
    if data.panorama_type == "FISHEYE_EQUIDISTANT":
        return {"type": "fisheye", "fov": math.degrees(data.fisheye_fov)}
    seen = data.latitude_max - data.latitude_min, data.longitude_max - data.longitude_min
    is_whole = np.allclose(seen, (math.pi, 2.0 * math.pi), atol=1e-5)
    if data.panorama_type != "EQUIRECTANGULAR" or not is_whole:
        draft.lose(f"projection {data.panorama_type}, a whole panorama in its place,", item.name)
    return {"type": "panorama"}


def _lens(draft: Draft, item: Any) -> dict[str, Any] | None:
    """Return the lens of a camera with depth of field."""
    data, dof = item.data, item.data.dof
    if not dof.use_dof:
        return None
    focus = dof.focus_distance
    if dof.focus_object is not None:
        to_camera = item.matrix_world.normalized().inverted()
        focus = -(to_camera @ dof.focus_object.matrix_world.translation).z
    if not is_flat(dof.aperture_ratio, 1.0):
        draft.lose("ratio of the aperture", item.name)
    length = 1e-3 * data.lens if data.type == "PERSP" else 1.0
    lens = {"focus": focus, "radius": 0.5 * length / dof.aperture_fstop}
    if dof.aperture_blades > 2:
        lens |= {"blades": dof.aperture_blades, "rotation": math.degrees(dof.aperture_rotation)}
    return lens
