"""Lights described apart from surfaces: each class declares its attributes once, and is checked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, Line
from photonmap.runtime.wording import brief, shown
from photonmap.scene.images import read_panorama, save_panorama
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import (
    Direction,
    Emission,
    File,
    Number,
    Point,
    Text,
    Vector,
    check_parameters,
    parameters_of,
    unit,
)
from photonmap.scene.photometric import as_table, read_ies, save_ies
from photonmap.spectra.curves import Color, Floats, Spectrum

LIGHTS: dict[str, type[Light]] = {}  # All kinds of lights by their name; each class enters itself

NARROWEST = 1e-3  # Least outer half-angle of a spot, degrees

DISK_SIDES = 64  # Sides of the regular polygon that stands for a disk, and has its area

_Name = Annotated[str, Text()]
_Length = Annotated[float, Number("length", "scene units", at_least=0.0)]
_HalfAngle = Annotated[float, Number("half-angle", "degrees", at_least=0.0, below=180.0)]


@dataclass(frozen=True)
class Profile:
    """The intensity of a light as a table over directions."""

    frame: Floats  # (3, 3), rows are the axes x, y, z of the table in the world
    intensity: NDArray[np.float32]
    """(V, H) relative to the mean over all directions; V polar angles evenly from +z to -z, H
    azimuths evenly from +x towards +y, the last one that of the first again"""


@dataclass(frozen=True)
class Emitter:
    """What a light is to the renderer, in scene units; its amount apart."""

    kind: str  # of `photonmap.kernels.lights.kinds`
    extent: Callable[[float], float]
    """the power of an emission of 1, by the radius of a sphere that holds the scene"""
    position: Vector | None = None  # None for a light infinitely far away
    axis: Vector = (0.0, 0.0, 0.0)  # unit vector in which it shines
    parameters: Mapping[str, float] = field(default_factory=dict)
    """that its kind has beside: the fields of `Parameters` of its module"""
    cone: float = 1.0  # cosine of the half angle of the directions in which it shines
    profile: Profile | None = None  # None for a light that has none


class Light:
    """A light that is not a surface.

    A subclass is a dataclass with a `kind` of its own; readers, writers and checks follow from the
    parameters that its annotations declare (`photonmap.scene.parameters`). A `name` left empty
    becomes that of its kind, with a number where several lights have none; `group`, left empty,
    becomes the name.
    """

    kind: ClassVar[str]
    name: str
    group: str

    def __init_subclass__(cls) -> None:
        """Enter the class under its kind."""
        if "kind" in vars(cls):
            LIGHTS[cls.kind] = cls

    @property
    def color(self) -> Color:
        """Its amount of light, in the unit of its kind; white where an image holds the colours."""
        attribute = self.color_attribute
        return (1.0, 1.0, 1.0) if attribute is None else getattr(self, attribute)

    @property
    def color_attribute(self) -> str | None:
        """The attribute that is its colour: "intensity"; None where an image holds the colours."""
        declared = parameters_of(type(self)).items()
        return next((name for name, kind in declared if isinstance(kind, Emission)), None)

    def find_conflict(self) -> tuple[str, str] | None:
        """Return an attribute at odds with the others, and the problem; None if there is none."""
        return None

    def emitter(self) -> Emitter:
        """Return what a checked light is to the renderer."""
        raise NotImplementedError


@dataclass(frozen=True)
class PointLight(Light):
    """An isotropic point: radiant intensity, W·sr⁻¹, from a position in scene units."""

    position: Annotated[Vector, Point()]
    intensity: Annotated[Color, Emission("radiant intensity", "W·sr⁻¹")] = 1.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "point"

    def emitter(self) -> Emitter:
        """Return a point that shines in all directions."""
        return Emitter("point", lambda radius: 4.0 * np.pi, self.position, cone=-1.0)


@dataclass(frozen=True)
class SpotLight(Light):
    """A point that shines into a cone.

    Parameters
    ----------
    position, target : scene units; the cone's axis leads from one to the other
    intensity : radiant intensity along the axis, W·sr⁻¹
    inner, outer : half-angles, degrees: the intensity is constant up to the inner and 0 from the
        outer on; in between it is 3t² - 2t³ of that on the axis, where the cosine of the angle to
        the axis runs from that of the outer (t = 0) to that of the inner (t = 1)
    """

    position: Annotated[Vector, Point()]
    target: Annotated[Vector, Point()]
    intensity: Annotated[Color, Emission("radiant intensity", "W·sr⁻¹")] = 1.0
    inner: _HalfAngle = 20.0
    outer: Annotated[float, Number("half-angle", "degrees", at_least=NARROWEST, below=180.0)] = 30.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "spot"

    def find_conflict(self) -> tuple[str, str] | None:
        """Compare the target with the position, and the inner angle with the outer."""
        if not unit(_half_way(self)).any():
            return "target", "is at the light's position; move one of them"
        if self.inner > self.outer:
            return "inner", f"exceeds the outer half-angle, {self.outer:g} degrees; reduce it"
        return None

    def emitter(self) -> Emitter:
        """Return a point that shines into a cone; its falloff has a mean of 1/2 over cosines."""
        inner, outer = np.cos(np.radians([self.inner, self.outer])).tolist()
        extent = np.pi * (2.0 - (inner + outer))
        axis, numbers = tuple(unit(_half_way(self))), {"inner": inner, "outer": outer}
        return Emitter("spot", lambda radius: extent, self.position, axis, numbers, outer)


@dataclass(frozen=True, eq=False, repr=False)
class PhotometricLight(Light):
    """A point whose intensity depends on direction as a photometric file says.

    Parameters
    ----------
    position : scene units
    table : an IES file of type C without tilt; or intensities (V, H) over polar angles, evenly
        from the direction to its opposite, and azimuths, evenly over a full turn, ends included
    intensity : mean radiant intensity over all directions, W·sr⁻¹; the table is relative
    direction : in which polar angles are 0
    azimuth : towards which azimuths are 0, as far as it is at right angles to the direction;
        others follow counterclockwise as seen from behind the lamp, which is from above if it
        points down: by default, 90° lies towards -z
    """

    position: Annotated[Vector, Point()]
    table: Annotated[
        str | PathLike[str] | ArrayLike,
        File("photometric file", key="file", read=read_ies, save=save_ies, suffix=".ies"),
    ]
    intensity: Annotated[Color, Emission("radiant intensity", "W·sr⁻¹")] = 1.0
    direction: Annotated[Vector, Direction()] = (0.0, -1.0, 0.0)
    azimuth: Annotated[Vector, Direction()] = (1.0, 0.0, 0.0)
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "photometric"

    __repr__ = brief

    def find_conflict(self) -> tuple[str, str] | None:
        """Compare the azimuth with the direction."""
        if np.linalg.norm(np.cross(*self._axes())) < 1e-6:
            return "azimuth", "is parallel to the direction; choose another one"
        return None

    def _axes(self) -> tuple[Floats, Floats]:
        return unit(np.array(self.direction)), unit(np.array(self.azimuth))

    def emitter(self) -> Emitter:
        """Return a point whose intensity is a table."""
        z, azimuth = self._axes()
        y = np.cross(azimuth, z)
        y /= np.linalg.norm(y)
        profile = Profile(np.stack([np.cross(z, y), y, z]), as_table(self.table))
        return Emitter(
            "photometric", lambda radius: 4.0 * np.pi, self.position, cone=-1.0, profile=profile
        )


@dataclass(frozen=True)
class DirectionalLight(Light):
    """A sun: light from infinitely far away, parallel or of an evenly bright disc.

    The disc lights surfaces and is not seen itself.

    Parameters
    ----------
    direction : in which the light travels, of any length
    irradiance : on a surface that faces it, W·m⁻²
    angle : diameter of the disc, degrees; that of the sun is 0.533
    """

    direction: Annotated[Vector, Direction()]
    irradiance: Annotated[Color, Emission("irradiance", "W·m⁻²")] = 1.0
    name: _Name = ""
    group: _Name = ""
    angle: Annotated[float, Number("angle", "degrees", at_least=0.0, at_most=90.0)] = 0.0
    kind: ClassVar[str] = "directional"

    def emitter(self) -> Emitter:
        """Return light over a disk as large as the scene."""
        axis = tuple(unit(np.array(self.direction)))
        numbers = {"edge": float(np.cos(np.radians(0.5 * self.angle)))}
        return Emitter("directional", lambda radius: np.pi * radius**2, None, axis, numbers)


class AllAround(Light):
    """Light from all around, infinitely far away."""

    def emitter(self) -> Emitter:
        """Return that of a dome."""
        return Emitter("dome", lambda radius: (2.0 * np.pi * radius) ** 2)


@dataclass(frozen=True)
class DomeLight(AllAround):
    """The same radiance, W·m⁻²·sr⁻¹, from every direction, infinitely far away."""

    radiance: Annotated[Color, Emission("radiance", "W·m⁻²·sr⁻¹")] = 1.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "dome"


@dataclass(frozen=True, eq=False, repr=False)
class EnvironmentLight(AllAround):
    """A map of radiance all around, infinitely far away.

    Row 0 surrounds +y. At a rotation of 0 the centre column looks along -z, and columns to its
    right turn towards +x. The map is constant over each texel, in the camera's view as in light.

    Parameters
    ----------
    image : (H, 2H, 3) linear RGB, W·m⁻²·sr⁻¹, or the file of such an image; integers of a
        file, and uint8 of an array, are sRGB, as in a PNG
    scale : multiplies radiances
    rotation : of the map about +y, degrees, counter-clockwise seen from above: at 90 the centre
        column looks along -x
    """

    image: Annotated[
        str | PathLike[str] | ArrayLike,
        File("image", key="file", read=read_panorama, save=save_panorama, suffix=".exr"),
    ]
    scale: Annotated[float, Number("factor", at_least=0.0)] = 1.0
    rotation: Annotated[float, Number("angle", "degrees")] = 0.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "environment"

    __repr__ = brief


@dataclass(frozen=True)
class AreaLight(Light):
    """A rectangle or a disk that emits the same radiance in all directions from its front.

    A `Scene` makes it a mesh of triangles whose black material emits; both bear its name. It is
    seen by the camera, casts shadows, and is dark from behind.

    Parameters
    ----------
    position : of the centre, scene units
    target : a point that the front faces
    width, height : of a rectangle, scene units; the height is that along `up`
    radius : of a disk, scene units, in place of width and height
    radiance : W·m⁻²·sr⁻¹
    power : radiant flux that leaves the front, W, in place of the radiance: π · area · radiance,
        for an area in scene units squared
    up : as far as it is at right angles to the direction to the target; where it is parallel to
        that, z is in its place, or y if that is parallel, too: so a light that points straight down
        has its width along x
    """

    position: Annotated[Vector, Point()]
    target: Annotated[Vector, Point()]
    width: _Length = 0.0
    height: _Length = 0.0
    radius: _Length = 0.0
    radiance: Annotated[Color | None, Emission("radiance", "W·m⁻²·sr⁻¹")] = None
    power: Annotated[Color | None, Emission("power", "W")] = None
    up: Annotated[Vector, Direction()] = (0.0, 1.0, 0.0)
    name: _Name = ""
    kind: ClassVar[str] = "area"

    def find_conflict(self) -> tuple[str, str] | None:
        """Compare the target with the position, the sizes, and the radiance with the power."""
        if self.target == self.position:
            return "target", "is at the light's position; move one of them"
        sides = bool(self.width), bool(self.height)
        if self.radius and any(sides):
            return "radius", "is given beside width or height; leave out one or the other"
        if not self.radius and not all(sides):
            lacking = "height" if self.width else "width"
            return lacking, "is missing or 0; give width and height, or radius, above 0"
        if self.radiance is not None and self.power is not None:
            return "power", "is given beside radiance; leave out one of them"
        return None

    @property
    def area(self) -> float:
        """Its area, scene units squared."""
        return float(np.pi * self.radius**2 if self.radius else self.width * self.height)

    @property
    def emission(self) -> Color:
        """The radiance of its front, W·m⁻²·sr⁻¹; 1 where neither it nor the power is given."""
        if self.power is None:
            return 1.0 if self.radiance is None else self.radiance
        factor = 1.0 / (np.pi * self.area)
        if isinstance(self.power, float | int | Spectrum):
            return self.power * factor
        red, green, blue = (float(factor * value) for value in self.power)
        return red, green, blue

    def mesh(self) -> Mesh:
        """Return its triangles, wound counter-clockwise seen from the target."""
        outline = self._outline()
        x, y = self._axes()
        vertices = np.array(self.position) + outline[:, :1] * x + outline[:, 1:] * y
        last = np.arange(1, len(outline) - 1)
        faces = np.stack([np.zeros_like(last), last, last + 1], axis=1)
        return Mesh(vertices, faces, Material(self.name, 0.0, self.emission), self.name)

    def _outline(self) -> Floats:
        """Return the corners in the light's plane, (N, 2), counter-clockwise."""
        if not self.radius:
            signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
            return signs * (self.width / 2.0, self.height / 2.0)
        turn = 2.0 * np.pi / DISK_SIDES
        radius = self.radius * np.sqrt(turn / np.sin(turn))
        angles = turn * np.arange(DISK_SIDES)
        return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    def _axes(self) -> tuple[Floats, Floats]:
        """Return unit vectors along the width and the height; their product faces the target."""
        ahead = unit(np.array(self.target) - np.array(self.position))
        across = np.cross(unit(np.array(self.up)), ahead)
        if np.linalg.norm(across) < 1e-6:
            across = np.cross(np.eye(3)[2 - np.argmin(np.abs(ahead[::-1]))], ahead)
        across /= np.linalg.norm(across)
        return across, np.cross(ahead, across)


def check_light(
    light: Any,
    path: str | PathLike[str] | None = None,
    lines: Mapping[str, Line] | None = None,
) -> Light:
    """Return a light, in plain floats, with all checked but the values of its colour and its image.

    Attributes may be of any type. An `InputError`, with the file and the line of the attribute if
    there is one, says that it is not a light, or an attribute is of the wrong type or out of range.
    """
    if not isinstance(light, Light) or light.kind not in LIGHTS:
        known = ", ".join(kind.__name__ for kind in LIGHTS.values())
        raise InputError(f"{shown(light)} is not a light; give one of {known}")

    def error(attribute: str, problem: str) -> InputError:
        line = (lines or {}).get(attribute)
        label = shown(light.name or light.kind)
        return InputError(f"light {label}: {attribute} {problem}", path, line)

    described: Any = light
    checked: Light = replace(described, **check_parameters(light, error))
    if conflict := checked.find_conflict():
        attribute, problem = conflict
        is_given = bool(getattr(checked, attribute))  # a 0 may not be
        raise error(attribute, f"{shown(getattr(light, attribute))} " * is_given + problem)
    return checked


def _half_way(light: SpotLight) -> np.ndarray:
    """Return half of the vector to the target, which is finite at any scale."""
    return np.array(light.target) / 2 - np.array(light.position) / 2


def check_lights(unchecked: Sequence[Any], others: Iterable[str] = ()) -> list[Light]:
    """Return checked lights, all with names; `others` are those of materials that emit.

    A light without a name is called after its kind: "point", then "point 2". Two of one name are an
    `InputError`, as is what `check_light` refuses.
    """
    used, lights = set(others), [check_light(light) for light in unchecked]
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
        described: Any = light
        named.append(replace(described, name=name))
    return named


def area_meshes(lights: Sequence[AreaLight], meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes of unchecked area lights; one without a name is called after its kind.

    Materials of the scene's meshes have other names. An `InputError` says that an attribute is out
    of range or at odds with another, or a name is taken.
    """
    names = {mesh.material.name for mesh in meshes}
    checked = check_lights(lights, names)
    return [light.mesh() for light in checked if isinstance(light, AreaLight)]
