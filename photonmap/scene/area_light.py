"""Area lights: flat meshes that emit, described as lights are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.lights import Light, check_light, name_lights
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Direction, Emission, Number, Point, Text, Vector, unit
from photonmap.spectra.curves import Color, Spectrum

DISK_SIDES = 64
"""Sides of the regular polygon that stands for a disk, and has its area."""

_Length = Annotated[float, Number("length", "scene units", at_least=0.0)]


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
    up : as far as it is at right angles to the direction to the target
    """

    position: Annotated[Vector, Point()]
    target: Annotated[Vector, Point()]
    width: _Length = 0.0
    height: _Length = 0.0
    radius: _Length = 0.0
    radiance: Annotated[Color | None, Emission("radiance", "W·m⁻²·sr⁻¹")] = None
    power: Annotated[Color | None, Emission("power", "W")] = None
    up: Annotated[Vector, Direction()] = (0.0, 1.0, 0.0)
    name: Annotated[str, Text()] = ""
    kind: ClassVar[str] = "area"

    def find_conflict(self) -> tuple[str, str] | None:
        """Compare the target with the position, the sizes, and the radiance with the power."""
        if unit(np.array(self.target) - np.array(self.position)) is None:
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

    def _outline(self) -> NDArray[np.float64]:
        """Return the corners in the light's plane, (N, 2), counter-clockwise."""
        if not self.radius:
            signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
            return signs * (self.width / 2.0, self.height / 2.0)
        turn = 2.0 * np.pi / DISK_SIDES
        radius = self.radius * np.sqrt(turn / np.sin(turn))
        angles = turn * np.arange(DISK_SIDES)
        return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    def _axes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return unit vectors along the width and the height; their product faces the target."""
        ahead, up = unit(np.array(self.target) - np.array(self.position)), unit(np.array(self.up))
        assert ahead is not None
        assert up is not None
        across = np.cross(up, ahead)
        if np.linalg.norm(across) < 1e-6:
            across = np.cross(np.eye(3)[np.argmin(np.abs(ahead))], ahead)
        across /= np.linalg.norm(across)
        return across, np.cross(ahead, across)


def area_meshes(lights: Sequence[AreaLight], meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes of unchecked area lights; one without a name is called after its kind.

    Materials of the scene's meshes have other names. An `InputError` says that an attribute is out
    of range or at odds with another, or a name is taken.
    """
    names = {mesh.material.name for mesh in meshes}
    checked = name_lights([check_light(light) for light in lights], names)
    return [light.mesh() for light in checked if isinstance(light, AreaLight)]
