"""Lights that are no surface, and the checks of all that describe one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from os import PathLike
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from photonmap.errors import InputError
from photonmap.messages import shown
from photonmap.spectra.curves import Color
from photonmap.vectors import Vector, finite, unit, vector

NARROWEST = 1e-3
"""Degrees, of a spot's outer half-angle."""


class Light:
    """A light that is no surface.

    A `name` left empty becomes that of its kind, with a number where several lights have none;
    `group`, left empty, becomes the name.
    """

    kind: ClassVar[str]
    name: str
    group: str

    @property
    def color(self) -> Color:
        """Its amount of light, in the unit of its kind."""
        raise NotImplementedError


@dataclass(frozen=True)
class PointLight(Light):
    """An isotropic point: radiant intensity, W·sr⁻¹, from a position in scene units."""

    position: Vector
    intensity: Color = 1.0
    name: str = ""
    group: str = ""
    kind: ClassVar[str] = "point"

    @property
    def color(self) -> Color:
        """The intensity."""
        return self.intensity


@dataclass(frozen=True)
class SpotLight(Light):
    """A point that shines into a cone.

    Parameters
    ----------
    position, target : scene units; the cone's axis leads from one to the other
    intensity : radiant intensity along the axis, W·sr⁻¹
    inner, outer : half-angles, degrees: the intensity is constant up to the inner, 0 from the
        outer; between it is 3t² - 2t³ of that on the axis, where the cosine of the angle to the
        axis goes from that of the outer (t = 0) to that of the inner (t = 1)
    """

    position: Vector
    target: Vector
    intensity: Color = 1.0
    inner: float = 20.0
    outer: float = 30.0
    name: str = ""
    group: str = ""
    kind: ClassVar[str] = "spot"

    @property
    def color(self) -> Color:
        """The intensity along the axis."""
        return self.intensity


@dataclass(frozen=True)
class DirectionalLight(Light):
    """A sun: parallel light from infinitely far away.

    Parameters
    ----------
    direction : in which the light travels, of any length
    irradiance : on a surface that faces it, W·m⁻²
    """

    direction: Vector
    irradiance: Color = 1.0
    name: str = ""
    group: str = ""
    kind: ClassVar[str] = "directional"

    @property
    def color(self) -> Color:
        """The irradiance."""
        return self.irradiance


@dataclass(frozen=True)
class DomeLight(Light):
    """The same radiance, W·m⁻²·sr⁻¹, from every direction, infinitely far away."""

    radiance: Color = 1.0
    name: str = ""
    group: str = ""
    kind: ClassVar[str] = "dome"

    @property
    def color(self) -> Color:
        """The radiance."""
        return self.radiance


@dataclass(frozen=True, eq=False)
class EnvironmentLight(Light):
    """A map of radiance all around, infinitely far away.

    Row 0 surrounds +y. At a rotation of 0 the centre column looks along -z, and columns to its
    right turn towards +x. The map is constant over each texel, in the camera's view as in light.

    Parameters
    ----------
    image : (H, 2H, 3) linear RGB, W·m⁻²·sr⁻¹, or the file of such an image; whole numbers in a
        file are sRGB, as in a PNG
    scale : what radiances are multiplied by
    rotation : of the map about +y, degrees, counter-clockwise seen from above: at 90 the centre
        column looks along -x
    """

    image: str | PathLike[str] | ArrayLike
    scale: float = 1.0
    rotation: float = 0.0
    name: str = ""
    group: str = ""
    kind: ClassVar[str] = "environment"

    @property
    def color(self) -> Color:
        """White: the map is RGB, and no spectrum."""
        return (1.0, 1.0, 1.0)


LIGHTS: dict[str, type[Light]] = {
    light.kind: light
    for light in (PointLight, SpotLight, DirectionalLight, DomeLight, EnvironmentLight)
}
"""All kinds by their name."""

_VECTORS = {"position": "point", "target": "point", "direction": "direction"}
_NUMBERS = {"inner": "angle", "outer": "angle", "scale": "factor", "rotation": "angle"}


def check_light(
    light: Any,
    path: str | PathLike[str] | None = None,
    lines: Mapping[str, int | None] | None = None,
) -> Light:
    """Check all of a light but its colour and its map.

    Parameters
    ----------
    light : attributes of any type
    path : the file that describes it, for messages
    lines : the line of each attribute in that file

    Returns
    -------
    Light, the same in plain floats

    Raises
    ------
    InputError : it is none, a vector is not three finite numbers, or a number is out of range
    """
    if not any(isinstance(light, kind) for kind in LIGHTS.values()):
        known = ", ".join(kind.__name__ for kind in LIGHTS.values())
        raise InputError(f"{shown(light)} is neither of {known}")

    def error(attribute: str, problem: str) -> InputError:
        value = shown(getattr(light, attribute))
        line = (lines or {}).get(attribute)
        label = shown(light.name or light.kind)
        return InputError(f"light {label}: {attribute} {value} {problem}", path, line)

    for attribute in ("name", "group"):
        if not isinstance(getattr(light, attribute), str):
            raise error(attribute, "is no text; write it in quotes")
    plain: dict[str, Any] = {}
    for attribute in (field.name for field in fields(light)):
        value = getattr(light, attribute)
        if attribute in _VECTORS:
            plain[attribute] = vector(value)
            if plain[attribute] is None:
                raise error(attribute, f"is no {_VECTORS[attribute]}; give three finite numbers")
        if attribute in _NUMBERS:
            plain[attribute] = finite(value)
            if plain[attribute] is None:
                raise error(attribute, f"is no {_NUMBERS[attribute]}; give a finite number")
    checked: Any = replace(light, **plain)
    match checked:
        case DirectionalLight() if unit(np.array(checked.direction)) is None:
            raise error("direction", "has no length; point it somewhere")
        case SpotLight() if unit(_half_way(checked)) is None:
            raise error("target", "is where the position is; move one of them")
        case SpotLight() if not NARROWEST <= checked.outer < 180.0:
            raise error("outer", f"is no half-angle; give degrees from {NARROWEST:g} to below 180")
        case SpotLight() if not 0.0 <= checked.inner <= checked.outer:
            raise error("inner", f"is no half-angle from 0 to the outer, {checked.outer:g} degrees")
        case EnvironmentLight() if checked.scale < 0.0:
            raise error("scale", "is negative; give 0 or more")
    return checked


def spot_axis(light: SpotLight) -> np.ndarray:
    """Return the unit vector along which a checked spot shines, (3,)."""
    axis = unit(_half_way(light))
    assert axis is not None
    return axis


def _half_way(light: SpotLight) -> np.ndarray:
    """Return half the way to the target, which is finite whatever the scale."""
    return np.array(light.target) / 2 - np.array(light.position) / 2


def name_lights(lights: Sequence[Any], others: Iterable[str] = ()) -> list[Light]:
    """Return lights that all have names; `others` are those of materials that emit.

    One without a name is called after its kind, and the second of them "point 2".

    Raises
    ------
    InputError : two have one name
    """
    used = set(others)
    for light in lights:
        if light.name in used:
            raise InputError(f"two lights are named {light.name!r}; give each its own name")
        used.update({light.name} - {""})
    named, counts = [], {light.kind: 1 for light in lights}
    for light in lights:
        name = light.name or light.kind
        while not light.name and name in used:
            counts[light.kind] += 1
            name = f"{light.kind} {counts[light.kind]}"
        used.add(name)
        named.append(replace(light, name=name))
    return named
