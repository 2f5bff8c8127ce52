"""The lights and cameras of USD stages."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers import decoding, meshes
from photonmap.io.readers.decoding import plain
from photonmap.io.readers.environment_maps import turned_map
from photonmap.io.readers.usd.stage import Stage
from photonmap.scene.camera import Camera, Lens, check_camera
from photonmap.scene.images import Image
from photonmap.scene.lights import (
    DirectionalLight,
    DomeLight,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
)
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.photometric import AZIMUTHS, POLAR, mean_over_directions
from photonmap.scene.projections import Intrinsics
from photonmap.spectra.curves import Floats

if find_spec("pxr") is not None:
    from pxr import Usd, UsdGeom, UsdLux

WHITE = 6500.0  # Temperature, K, of lights whose colour is as given
TENTH = 0.1  # Apertures and focal lengths are in tenths of scene units
_PIXELS = 1000.0
_SIZED = ("RectLight", "DiskLight", "SphereLight", "CylinderLight")
_SUN, _SKIES = "DistantLight", ("DomeLight", "DomeLight_1")
_EVERYWHERE = 180.0  # Half-angle of a cone, degrees, that holds all directions
_AHEAD = 90.0  # That of all directions in which a flat light shines
_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])  # From shapes that face +z to lights that face -z
_ALONG_X = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
_POLE = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""From a sky whose pole is +y to one whose pole is +z: its middle looks along -y."""
WIDEST_SUN = 90.0  # Degrees
_EXPOSURE = ("time", "fStop", "responsivity")
_ABSENT = {"shadow:enable": True, "shadow:color": (0.0, 0.0, 0.0), "shadow:distance": -1.0}
"""Inputs of lights that are not simulated, and the values at which they change nothing."""
_SHAPING = {"shaping:focus": 0.0, "shaping:ies:file": ""}
"""Those that are simulated of points only."""


def is_light(prim: Any) -> bool:
    """Return whether a prim is a light."""
    return bool(prim.HasAPI(UsdLux.LightAPI))


def read_camera(stage: Stage, prim: Any) -> Camera:
    """Return a camera; the shape of its picture is that of the render."""
    camera, matrix = UsdGeom.Camera(prim), stage.matrix(prim)
    value = stage.value
    _note_camera(stage, prim, matrix)
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
    target, top = decoding.point_ahead(origin, ahead), plain(matrix[:3, 1])
    seen = Camera(plain(origin), target, top, name=stage.name(prim), **look)
    return check_camera(seen, stage.path)


def _note_camera(stage: Stage, prim: Any, matrix: Floats) -> None:
    """Note what a camera does to a picture that is not simulated."""
    camera, value, linear = UsdGeom.Camera(prim), stage.value, matrix[:3, :3]
    if not np.allclose(linear @ linear.T, np.eye(3), atol=1e-5) or np.linalg.det(linear) < 0.0:
        stage.lose("scale or mirroring of cameras", prim)
    if value(camera.GetShutterCloseAttr(), 0.0) > value(camera.GetShutterOpenAttr(), 0.0):
        stage.lose("motion blur", prim)
    of = {name: value(prim.GetAttribute(f"exposure:{name}")) or 1.0 for name in _EXPOSURE}
    seconds = of["time"] * (value(prim.GetAttribute("exposure:iso")) or 100.0) / 100.0
    stops = value(camera.GetExposureAttr(), 0.0)
    if of["responsivity"] * seconds * 2.0**stops / of["fStop"] ** 2 != 1.0:
        stage.lose("exposure of cameras", prim)
    if value(camera.GetClippingPlanesAttr()):
        stage.lose("clipping planes", prim)


def note_clipped(stage: Stage, prim: Any, vertices: Iterable[Floats]) -> None:
    """Note a camera before or behind whose clipping range there are vertices that it sees."""
    camera, matrix, value = UsdGeom.Camera(prim), stage.matrix(prim), stage.value
    near, far = value(camera.GetClippingRangeAttr(), (1.0, 1e6))
    sizes = (camera.GetHorizontalApertureAttr(), camera.GetVerticalApertureAttr())
    radius = 0.5 * math.hypot(*(value(attribute, 0.0) for attribute in sizes))
    is_flat = value(camera.GetProjectionAttr()) == UsdGeom.Tokens.orthographic
    slope = radius / max(value(camera.GetFocalLengthAttr(), 50.0), 1e-9)
    reach = (TENTH * radius, 0.0) if is_flat else (0.0, slope)
    if meshes.are_clipped(vertices, matrix, (near, far), *reach):
        stage.lose("the clipping range of cameras", prim)


@dataclass(frozen=True)
class _Lamp:
    """A light: its prim, its name, and how it shines."""

    stage: Stage
    prim: Any
    name: str
    amount: Floats  # intensity · 2^exposure · colour, (3,)
    is_whole: bool  # `normalize`: it is divided by the size


def read_light(stage: Stage, prim: Any) -> Light | Mesh | None:
    """Return a light, or the mesh that it becomes; None, and noted, for other types."""
    kind, name = prim.GetTypeName(), stage.name(prim)
    if kind not in (*_SIZED, _SUN, *_SKIES):
        stage.lose(f"lights of type {kind}", prim)
        return None
    base = UsdLux.BoundableLightBase if kind in _SIZED else UsdLux.NonboundableLightBase
    light = base(prim)
    _note_light(stage, prim, light)
    is_whole = bool(stage.value(light.GetNormalizeAttr(), False))
    lamp = _Lamp(stage, prim, name, radiance_of(stage, light), is_whole)
    if kind == _SUN:
        return _sun(lamp)
    return _shape(lamp) if kind in _SIZED else _sky(lamp)


def _note_light(stage: Stage, prim: Any, light: Any) -> None:
    """Note what a light has that is not simulated."""
    if light.GetFiltersRel().GetTargets():
        stage.lose("filters of lights", prim)
    for name in ("lightLink", "shadowLink"):
        links = Usd.CollectionAPI(prim, name)
        rels = (links.GetIncludesRel(), links.GetExcludesRel())
        if not stage.value(links.GetIncludeRootAttr(), True) or any(
            rel and rel.GetTargets() for rel in rels
        ):
            stage.lose("lights that light some surfaces only", prim)
    is_shaped = _is_point(stage, prim) and prim.HasAPI(UsdLux.ShapingAPI)
    for name, usual in (_ABSENT if is_shaped else _ABSENT | _SHAPING).items():
        found = stage.value(prim.GetAttribute(f"inputs:{name}"), usual)
        if getattr(found, "path", found) != usual and not (name == "shaping:focus" and found < 0.0):
            stage.lose(f"{name} of lights", prim)
    cone = prim.GetAttribute("inputs:shaping:cone:angle")
    if prim.GetTypeName() not in _SIZED and cone and cone.HasAuthoredValue():
        stage.lose("cones of suns and skies", prim)
    if stage.value(prim.GetAttribute("treatAsLine"), False):
        stage.lose("treatAsLine of lights", prim)
    diffuse, specular = light.GetDiffuseAttr(), light.GetSpecularAttr()
    if stage.value(diffuse, 1.0) != stage.value(specular, 1.0):
        stage.lose("diffuse and specular multipliers of lights that differ", prim)


def radiance_of(stage: Stage, light: Any) -> Floats:
    """Return intensity · 2^exposure · colour of a light, (3,), before any normalisation."""
    color = np.array(stage.color(light.GetColorAttr(), (1.0, 1.0, 1.0)), np.float64)
    if stage.value(light.GetEnableColorTemperatureAttr(), False):
        kelvin = stage.value(light.GetColorTemperatureAttr(), 6500.0)
        warmth = [UsdLux.BlackbodyTemperatureAsRgb(each) for each in (kelvin, WHITE)]
        color = color * np.array(warmth[0], np.float64) / warmth[1]
    exposure = stage.value(light.GetExposureAttr(), 0.0)
    factor = stage.value(light.GetIntensityAttr(), 1.0) * 2.0**exposure
    amount: Floats = factor * color * stage.value(light.GetDiffuseAttr(), 1.0)
    if not (np.isfinite(amount).all() and (amount >= 0.0).all() and math.isfinite(factor)):
        raise InputError(f"light {light.GetPrim().GetName()} is negative or not finite; correct it")
    return amount


def _sky(lamp: _Lamp) -> Light:
    """Return a dome, or a map whose pole is the axis that a `DomeLight_1` states."""
    stage, prim = lamp.stage, lamp.prim
    asset = stage.value(prim.GetAttribute("inputs:texture:file"))
    if not getattr(asset, "path", ""):
        return DomeLight(plain(lamp.amount), name=lamp.name)
    form = stage.value(prim.GetAttribute("inputs:texture:format"), "automatic")
    if form not in ("automatic", "latlong"):
        raise InputError(f"its map is of the format {form}; convert it to latlong")
    linear = stage.matrix(prim)[:3, :3]
    pole = stage.value(prim.GetAttribute("poleAxis")) if prim.GetTypeName() == _SKIES[1] else "Y"
    if pole == "Z" or (pole != "Y" and stage.is_z_up):
        linear = linear @ _POLE
    light, factor = stage.image(asset)[0].sky(), float(lamp.amount.mean())
    if np.ptp(lamp.amount) > 0.0:
        light = light * np.array(lamp.amount / factor, np.float32)
    return turned_map(Image(light, False), linear, factor, lamp.name)


def _sun(lamp: _Lamp) -> Light:
    """Return a sun; without `normalize` its radiance counts, over a disk of its angle."""
    stage, amount = lamp.stage, lamp.amount
    angle = float(stage.value(UsdLux.DistantLight(lamp.prim).GetAngleAttr(), 0.53))
    half = min(max(math.radians(0.5 * angle), 0.0), math.pi)
    if not lamp.is_whole and half > 0.0:
        part = math.sin(half) ** 2
        amount = amount * math.pi * (part if half <= 0.5 * math.pi else 2.0 - part)
    if angle > WIDEST_SUN:
        stage.lose(f"angles of suns above {WIDEST_SUN:g} degrees", lamp.prim)
    ahead = plain(-stage.matrix(lamp.prim)[:3, 2])
    disk = min(max(angle, 0.0), WIDEST_SUN)
    return DirectionalLight(ahead, plain(amount), name=lamp.name, angle=disk)


def _shape(lamp: _Lamp) -> Mesh | Light | None:
    """Return the mesh of a light that has a size; `normalize` divides by its area."""
    stage, prim, amount = lamp.stage, lamp.prim, lamp.amount
    matrix, kind = stage.matrix(prim), prim.GetTypeName()
    size = {
        name: float(stage.value(prim.GetAttribute(f"inputs:{name}"), 0.0))
        for name in ("radius", "width", "height", "length")
    }
    radius = size["radius"]
    if kind == "SphereLight":
        if _is_point(stage, prim):
            if radius == 0.0 and not lamp.is_whole:
                stage.lose("light of points without normalize, which is none,", prim)
            factor = 0.25 if lamp.is_whole else math.pi * radius**2 * _larger(matrix)
            return _point(lamp, amount * factor)
        part = meshes.move(meshes.sphere(np.zeros(3), radius), matrix)
    elif kind == "DiskLight":
        part = meshes.move(meshes.disk(), matrix @ _FLIP @ np.diag([radius, radius, 1.0, 1.0]))
    elif kind == "CylinderLight":
        end = np.array([0.0, 0.0, 0.5 * size["length"]])
        part = meshes.move(meshes.cylinder(-end, end, radius), matrix @ _ALONG_X)
    else:
        if stage.value(UsdLux.RectLight(prim).GetTextureFileAttr()):
            stage.lose("textures of lights", prim)
        half = np.diag([0.5 * size["width"], 0.5 * size["height"], 1.0, 1.0])
        part = meshes.move(meshes.rectangle(), matrix @ _FLIP @ half)
    is_flat = kind in ("DiskLight", "RectLight")
    if _cone(stage, prim)[0] < (_AHEAD if is_flat else _EVERYWHERE):
        stage.lose("cones of lights that have a size", prim)
    if lamp.is_whole:
        amount = amount / _area(part)
    return meshes.build_mesh(stage.path, part, Material(lamp.name, 0.0, plain(amount)), lamp.name)


def _is_point(stage: Stage, prim: Any) -> bool:
    """Return whether a light has no size."""
    if prim.GetTypeName() != "SphereLight":
        return False
    light = UsdLux.SphereLight(prim)
    return bool(
        stage.value(light.GetTreatAsPointAttr(), False)
        or stage.value(light.GetRadiusAttr(), 0.0) == 0.0
    )


def _larger(matrix: Floats) -> float:
    """Return by which factor a matrix enlarges the area of a sphere."""
    if _is_even(matrix):
        return float((matrix[:3, 0] ** 2).sum())
    ball = meshes.sphere(np.zeros(3), 1.0)
    return _area(meshes.move(ball, matrix)) / _area(ball)


def _is_even(matrix: Floats) -> bool:
    """Return whether a matrix scales alike in all directions."""
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    return bool(np.allclose(gram, gram[0, 0] * np.eye(3), atol=1e-5 * gram[0, 0]))


def _area(part: meshes.Part) -> float:
    a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _point(lamp: _Lamp, intensity: Floats) -> Light | None:
    stage, prim = lamp.stage, lamp.prim
    matrix, (outer, softness) = stage.matrix(prim), _cone(stage, prim)
    place, table = matrix[:3, 3], _table(lamp)
    if table is None and outer >= _EVERYWHERE:
        return PointLight(plain(place), plain(intensity), name=lamp.name)
    if not _is_even(matrix):
        stage.lose("uneven scale or shear of cones and IES files", prim)
    if table is not None:
        return _photometric(lamp, intensity, table)
    if softness > 0.0:
        stage.lose("falloff of soft cones, which is even in the cosine and not in the angle,", prim)
    target, inner = place - matrix[:3, 2], outer * (1.0 - min(max(softness, 0.0), 1.0))
    return SpotLight(plain(place), plain(target), plain(intensity), inner, outer, name=lamp.name)


def _table(lamp: _Lamp) -> Floats | None:
    """Return the factors by which an IES file and a focus shape a point, (181, 361), over angles.

    Polar angles are those from -z. None without a file and a focus.
    """
    stage, shaping = lamp.stage, UsdLux.ShapingAPI(lamp.prim)
    if not lamp.prim.HasAPI(UsdLux.ShapingAPI):
        return None
    asset = stage.value(shaping.GetShapingIesFileAttr())
    focus = float(stage.value(shaping.GetShapingFocusAttr(), 0.0))
    table: Floats = np.ones((POLAR, AZIMUTHS))
    is_read = bool(getattr(asset, "path", ""))
    if is_read:
        try:
            table = stage.photometry(asset).astype(np.float64)
        except InputError as error:
            if "lies outside" in str(error):
                raise
            stage.lose(f"an IES file ({error})", lamp.prim)
            is_read = False
    if not is_read and focus <= 0.0:
        return None
    if is_read and stage.value(shaping.GetShapingIesNormalizeAttr(), False):
        table = table / (4.0 * math.pi * mean_over_directions(table))
    polar = np.arange(POLAR, dtype=float)
    if scale := float(stage.value(shaping.GetShapingIesAngleScaleAttr(), 0.0)):
        origin = 0.0 if scale > 0.0 else 180.0
        at = (polar - origin) / abs(scale) + origin
        table = np.stack([np.interp(at, polar, row, 0.0, 0.0) for row in table.T], axis=1)
    if focus > 0.0:
        tint = np.array(stage.color(shaping.GetShapingFocusTintAttr(), (0.0, 0.0, 0.0)))
        if np.ptp(tint) > 0.0:
            stage.lose("colours of focusTint, of which the mean counts,", lamp.prim)
        ahead = np.abs(np.cos(np.radians(polar))) ** focus
        table = table * (ahead + (1.0 - ahead) * tint.mean())[:, None]
    return table


def _photometric(lamp: _Lamp, intensity: Floats, table: Floats) -> Light | None:
    """Return a point of a table, cut by its cone; None where nothing is left.

    As in USD's reference renderer, hdEmbree, azimuths begin at -x and go to -y.
    """
    matrix, (outer, softness) = lamp.stage.matrix(lamp.prim), _cone(lamp.stage, lamp.prim)
    polar = np.arange(POLAR, dtype=float)
    width = max(outer * min(max(softness, 0.0), 1.0), 1e-9)
    part = np.clip((polar - outer) / width + (softness > 0.0), 0.0, 1.0)
    table = table * (1.0 - part * part * (3.0 - 2.0 * part))[:, None]
    mean = mean_over_directions(table)
    if mean == 0.0:
        return None
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        table = table[:, ::-1]  # a mirrored lamp, whose azimuths go the other way
    place, axis, azimuth = (plain(each) for each in (matrix[:3, 3], -matrix[:3, 2], -matrix[:3, 0]))
    whole = plain(mean * intensity)
    return PhotometricLight(place, table.astype(np.float32), whole, axis, azimuth, name=lamp.name)


def _cone(stage: Stage, prim: Any) -> tuple[float, float]:
    """Return the half-angle of a light's cone, degrees, and how soft its edge is."""
    if not prim.HasAPI(UsdLux.ShapingAPI):
        return _EVERYWHERE, 0.0
    shaping = UsdLux.ShapingAPI(prim)
    softness = stage.value(shaping.GetShapingConeSoftnessAttr(), 0.0)
    return stage.value(shaping.GetShapingConeAngleAttr(), _AHEAD), softness
