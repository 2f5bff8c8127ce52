"""Read UsdLux: lights with a size become meshes, suns and skies lights."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import UsdLux

from photonmap.io.readers.meshes import Part, build_mesh, move
from photonmap.io.readers.mitsuba_parts import surfaces
from photonmap.io.readers.mitsuba_parts.environment import turned_map
from photonmap.io.readers.usd_parts.stage import Stage, point, radiance_of
from photonmap.runtime.named_files import named_image
from photonmap.scene.lights import DirectionalLight, DomeLight, Light, PointLight, SpotLight
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.spectra.curves import Color

_SHAPES = ("RectLight", "DiskLight", "SphereLight")
_SUN, _SKY = "DistantLight", "DomeLight"
_EVERYWHERE = 90.0
"""Half-angle of a cone, degrees, from which on a light shines as without one."""
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
"""From shapes that face +z to lights that face -z."""


def read_light(stage: Stage, prim: Any) -> Light | Mesh | None:
    """Return a light, or the mesh that it becomes; None, and noted, for other types.

    Raises
    ------
    InputError : its amount is negative, or an image cannot be read
    """
    kind, name = prim.GetTypeName(), stage.name(prim)
    light = (
        UsdLux.BoundableLightBase(prim) if kind in _SHAPES else UsdLux.NonboundableLightBase(prim)
    )
    if kind not in (*_SHAPES, _SUN, _SKY, "DomeLight_1"):
        stage.lose(f"lights of type {kind}", prim)
        return None
    amount, is_whole = radiance_of(stage, light), stage.value(light.GetNormalizeAttr(), False)
    if kind == _SUN:
        return _sun(stage, prim, name, (amount, is_whole))
    if kind in _SHAPES:
        return _shape(stage, prim, name, (amount, is_whole))
    file = getattr(stage.value(UsdLux.DomeLight(prim).GetTextureFileAttr()), "path", "")
    if not file:
        return DomeLight(_plain(amount), name=name)
    if np.ptp(amount) > 0.0:
        stage.lose("colour of a sky with an image", prim)
    path: Path = named_image(stage.path.parent, file)
    return turned_map(path, stage.matrix(prim)[:3, :3], float(amount.mean()), name)


def _sun(stage: Stage, prim: Any, name: str, light: tuple[NDArray[np.float64], bool]) -> Light:
    """Return a sun; without `normalize` its radiance counts, over a disk of its angle."""
    amount, is_whole = light
    angle = math.radians(stage.value(UsdLux.DistantLight(prim).GetAngleAttr(), 0.53))
    if not is_whole and angle > 0.0:
        amount = amount * math.pi * math.sin(0.5 * min(angle, math.pi)) ** 2
    ahead = -stage.matrix(prim)[:3, 2]
    return DirectionalLight(point(ahead), _plain(amount), name=name)


def _shape(
    stage: Stage, prim: Any, name: str, light: tuple[NDArray[np.float64], bool]
) -> Mesh | Light:
    """Return the mesh of a light that has a size; `normalize` divides by its area."""
    amount, is_whole = light
    matrix, kind = stage.matrix(prim), prim.GetTypeName()
    if kind == "SphereLight":
        sphere = UsdLux.SphereLight(prim)
        radius = stage.value(sphere.GetRadiusAttr(), 0.5)
        if stage.value(sphere.GetTreatAsPointAttr(), False) or radius == 0.0:
            factor = 0.25 if is_whole else math.pi * radius**2
            return _point(stage, prim, name, amount * factor)
        part = move(surfaces.sphere(np.zeros(3), radius), matrix)
    elif kind == "DiskLight":
        radius = stage.value(UsdLux.DiskLight(prim).GetRadiusAttr(), 0.5)
        part = move(surfaces.disk(), matrix @ _FLIP @ np.diag([radius, radius, 1.0, 1.0]))
    else:
        rectangle = UsdLux.RectLight(prim)
        if stage.value(rectangle.GetTextureFileAttr()):
            stage.lose("textures of lights", prim)
        wide = 0.5 * stage.value(rectangle.GetWidthAttr(), 1.0)
        high = 0.5 * stage.value(rectangle.GetHeightAttr(), 1.0)
        part = move(surfaces.rectangle(), matrix @ _FLIP @ np.diag([wide, high, 1.0, 1.0]))
    if _cone(stage, prim)[0] < _EVERYWHERE:
        stage.lose("cones of lights that have a size", prim)
    radiance = amount / _area(part) if is_whole else amount
    return build_mesh(stage.path, part, Material(name, 0.0, _plain(radiance)), name)


def _point(stage: Stage, prim: Any, name: str, intensity: NDArray[np.float64]) -> Light:
    """Return a light without a size, a spot where it has a cone."""
    matrix, (outer, softness) = stage.matrix(prim), _cone(stage, prim)
    place = matrix[:3, 3]
    if outer >= _EVERYWHERE:
        return PointLight(point(place), _plain(intensity), name=name)
    target, inner = place - matrix[:3, 2], outer * (1.0 - min(max(softness, 0.0), 1.0))
    return SpotLight(point(place), point(target), _plain(intensity), inner, outer, name=name)


def _cone(stage: Stage, prim: Any) -> tuple[float, float]:
    """Return the half-angle of a light's cone, degrees, and how soft its edge is."""
    if not prim.HasAPI(UsdLux.ShapingAPI):
        return 180.0, 0.0
    shaping = UsdLux.ShapingAPI(prim)
    if stage.value(shaping.GetShapingFocusAttr(), 0.0) or shaping.GetShapingIesFileAttr().Get():
        stage.lose("focus or IES file of lights", prim)
    softness = stage.value(shaping.GetShapingConeSoftnessAttr(), 0.0)
    return stage.value(shaping.GetShapingConeAngleAttr(), _EVERYWHERE), softness


def _area(part: Part) -> float:
    corners = part.vertices[part.faces]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(0.5 * np.linalg.norm(sides, axis=1).sum())


def _plain(amount: NDArray[np.float64]) -> Color:
    return point(amount)
