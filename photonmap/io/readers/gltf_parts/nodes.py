"""Read the cameras and the lights that stand at the nodes of glTF files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, note_loss
from photonmap.runtime.wording import shown
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.lights import (
    NARROWEST,
    DirectionalLight,
    Light,
    PointLight,
    SpotLight,
    check_light,
)
from photonmap.scene.vectors import Vector

_WIDEST = math.pi / 4.0
"""Default outer half-angle of a spot, radians."""
_ROUNDING = 1.0 + 1e-6
"""Of angles in float32: a spot of a hard edge has two equal ones."""
_BRIGHT = 200.0
"""W·sr⁻¹ or W·m⁻² that hardly any light of Blender has: a point of 2.5 kW, a sun of strength 200;
in candela and lux those of 3.7 W and 0.3 have them."""
_Color = tuple[float, float, float]


@dataclass(frozen=True)
class NodeItem:
    """A camera or a light, where a node puts it.

    Parameters
    ----------
    path : the file, for messages
    item : its JSON
    name : its own in the scene
    matrix : from the node's coordinates to the scene's, 4×4
    losses : takes what is not simulated
    """

    path: Path
    item: Mapping[str, Any]
    name: str
    matrix: NDArray[np.float64]
    losses: Losses

    @property
    def origin(self) -> Vector:
        """Where the node stands, scene units."""
        return _plain(self.matrix[:3, 3])

    @property
    def ahead(self) -> Vector:
        """A unit vector along the node's -z: in which cameras look and lights shine."""
        return self._axis(2, -1.0)

    @property
    def up(self) -> Vector:
        """A unit vector along the node's +y."""
        return self._axis(1, 1.0)

    @property
    def target(self) -> Vector:
        """A point ahead, so far away that rounding does not turn the view."""
        distance = max(1.0, float(np.abs(self.matrix[:3, 3]).max()))
        return _plain(self.matrix[:3, 3] + distance * np.array(self.ahead))

    def number(self, key: str, default: float | None, values: Mapping[str, Any]) -> float:
        """Return a finite number of at least 0; `default` where it is not given.

        Raises
        ------
        InputError : it is anything else, or there is no default
        """
        value = values.get(key, default)
        if type(value) not in (int, float) or not 0.0 <= value < math.inf:
            raise self.error(f"{key} {shown(value)} is not a number of at least 0; correct it")
        return float(value)

    def lose(self, what: str) -> None:
        """Note what is not simulated."""
        note_loss(self.losses, what, self.name)

    def error(self, message: str) -> InputError:
        """Return an error about this item."""
        return InputError(f"node {shown(self.name)}: {message}", self.path)

    def _axis(self, column: int, sign: float) -> Vector:
        axis = self.matrix[:3, column]
        length = float(np.linalg.norm(axis))
        if not 0.0 < length < math.inf:
            raise self.error("its scale is 0, so it has no direction; correct the scale")
        return _plain(sign / length * axis)


def read_camera(node: NodeItem) -> Camera:
    """Read a camera; its picture's shape is the render's, and what is near or far is not cut off.

    Raises
    ------
    InputError : it has no known type, or a value is out of range
    """
    kind = node.item.get("type")
    if kind not in ("perspective", "orthographic"):
        raise node.error(f"a camera of type {shown(kind)} is unknown; export it again")
    lens = node.item[kind]
    look: dict[str, Any] = {}
    if kind == "perspective":
        look["fov"] = math.degrees(node.number("yfov", None, lens))
    else:
        scale = float(np.linalg.norm(node.matrix[:3, 1]))
        look["height"] = 2.0 * scale * node.number("ymag", None, lens)
    if np.linalg.det(node.matrix[:3, :3]) < 0.0:
        node.lose("mirrored view")
    try:
        return check_camera(Camera(node.origin, node.target, node.up, name=node.name, **look))
    except InputError as invalid:
        raise node.error(str(invalid)) from None


def read_light(node: NodeItem) -> Light:
    """Read a light of KHR_lights_punctual: candela count as W·sr⁻¹, lux as W·m⁻².

    Raises
    ------
    InputError : it has no known type, or a value is out of range
    """
    item, amount = node.item, _amount(node)
    if "range" in item:
        node.lose("range")
    light: Light
    match item.get("type"):
        case "point":
            light = PointLight(node.origin, amount, name=node.name)
        case "directional":
            light = DirectionalLight(node.ahead, amount, name=node.name)
        case "spot":
            inner, outer = _cone(node)
            light = SpotLight(node.origin, node.target, amount, inner, outer, name=node.name)
        case unknown:
            raise node.error(f"a light of type {shown(unknown)} is unknown; export it again")
    return check_light(light, node.path)


def are_photometric(lights: Sequence[Light]) -> bool:
    """Return whether Blender's lights are in candela and lux, as by default, not in W·sr⁻¹."""
    colors = (getattr(light, "intensity", getattr(light, "irradiance", 0.0)) for light in lights)
    return max(map(np.max, colors), default=0.0) >= _BRIGHT


def _cone(node: NodeItem) -> tuple[float, float]:
    """Return the half-angles of a spot, degrees, the inner lowered to the outer with a warning."""
    spot = node.item.get("spot") or {}
    inner = math.degrees(node.number("innerConeAngle", 0.0, spot))
    outer = max(math.degrees(node.number("outerConeAngle", _WIDEST, spot)), NARROWEST)
    if inner > outer * _ROUNDING:
        node.lose("innerConeAngle above outerConeAngle")
    return min(inner, outer), outer


def _amount(node: NodeItem) -> _Color:
    """Return intensity times colour."""
    intensity = node.number("intensity", 1.0, node.item)
    color = node.item.get("color", [1.0, 1.0, 1.0])
    if not isinstance(color, list) or len(color) != 3:
        raise node.error(f"color {shown(color)} is not three numbers; correct it")
    red, green, blue = (node.number("color", None, {"color": part}) for part in color)
    return red * intensity, green * intensity, blue * intensity


def _plain(vector: NDArray[np.float64]) -> Vector:
    x, y, z = vector.tolist()
    return x, y, z
