"""Cameras and lights of glTF files."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.writers.gltf_parts.draft import Draft
from photonmap.io.writers.gltf_parts.materials import rgb_emission, split_exactly
from photonmap.scene.camera import ALL, NOT_IN_FILES, Camera, frame_of
from photonmap.scene.lights import (
    DirectionalLight,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
)
from photonmap.scene.projections import Orthographic, Pinhole

_LIGHTS = "KHR_lights_punctual"
_NEAR = 1e-3
"""Distance of the near plane, by the size of the scene"""
_FAR = 1e3


def add_cameras(draft: Draft, cameras: Sequence[Camera], size: float) -> list[int]:
    """Add the cameras that glTF knows; return their nodes.

    Parameters
    ----------
    size : of the scene, which planes that cut off nothing lie at
    """
    nodes = []
    for camera in cameras:
        look: dict[str, Any]
        match camera.model:
            case Pinhole(fov):
                lens = {"yfov": math.radians(fov), "znear": _NEAR * size}
                look = {"type": "perspective", "perspective": lens}
            case Orthographic(height):
                lens = {"xmag": height / 2.0, "ymag": height / 2.0}
                lens |= {"znear": 0.0, "zfar": _FAR * size}
                look = {"type": "orthographic", "orthographic": lens}
            case _:
                continue
        view, right, up = frame_of(camera)
        node = {
            "name": camera.name or "camera",
            "camera": draft.add("cameras", look),
            "matrix": _matrix(right, up, -view, camera.origin),
        }
        nodes.append(draft.add("nodes", node))
    return nodes


def add_lights(draft: Draft, lights: Sequence[Light], taken: Collection[str]) -> list[int]:
    """Add the lights that glTF knows under names that its reader keeps; return their nodes.

    Parameters
    ----------
    lights : with names; a photometric light is written as a point
    taken : names that lights in glTF files cannot have
    """
    items: list[dict[str, Any]] = []
    nodes = []
    for light in lights:
        described = _describe(light)
        if described is None or light.name in (ALL, *taken) or set(light.name) & set(NOT_IN_FILES):
            continue
        item, axis, position = described
        x, y, z = _frame_about(axis)
        color, intensity = split_exactly(rgb_emission(light.color))
        node = {
            "name": light.name,
            "extensions": draft.use(_LIGHTS, {"light": len(items)}),
            "matrix": _matrix(x, y, z, position),
        }
        items.append({"name": light.name, "color": color, "intensity": intensity, **item})
        nodes.append(draft.add("nodes", node))
    if items:
        draft.tree["extensions"] = {_LIGHTS: {"lights": items}}
    return nodes


def _describe(light: Light) -> tuple[dict[str, Any], Any, Any] | None:
    """Return the JSON of a light without its colour, its axis and position; None if unknown."""
    match light:
        case PointLight() | PhotometricLight():
            return {"type": "point"}, (0.0, 0.0, -1.0), light.position
        case DirectionalLight():
            return {"type": "directional"}, light.emitter().axis, (0.0, 0.0, 0.0)
        case SpotLight(outer=outer) if outer <= 90.0:
            angles = {
                "innerConeAngle": math.radians(light.inner),
                "outerConeAngle": math.radians(outer),
            }
            return {"type": "spot", "spot": angles}, light.emitter().axis, light.position
    return None


def _frame_about(axis: Any) -> tuple[NDArray[np.float64], ...]:
    """Return x, y and z of a node whose -z is a unit vector."""
    z = -np.array(axis, np.float64)
    other = np.zeros(3)
    other[int(np.abs(z).argmin())] = 1.0
    x = np.cross(other, z)
    x /= np.linalg.norm(x)
    return x, np.cross(z, x), z


def _matrix(x: Any, y: Any, z: Any, origin: Any) -> list[float]:
    """Return a 4×4 matrix by columns."""
    columns = np.zeros((4, 4))
    columns[:, :3] = np.array([x, y, z, origin])
    columns[3, 3] = 1.0
    return [float(value) for value in columns.ravel() + 0.0]
