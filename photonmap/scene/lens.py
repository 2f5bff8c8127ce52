"""A camera's lens: a thin one, whose opening is a disk or a polygon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from photonmap.scene.parameters import Number, Whole

_LARGEST = 1e30


@dataclass(frozen=True)
class Lens:
    """A thin lens: what is not at its focus distance is blurred.

    Its size is given by `radius`, or by `f_number` and `focal_length`.

    Parameters
    ----------
    focus : distance, along the view, of the plane that is sharp, scene units
    radius : of the opening, scene units
    f_number : focal length / diameter of the opening
    focal_length : scene units: 0.05 for 50 mm in a scene in metres; it decides the size of the
        opening, and not the angle of view
    blades : sides of the opening, a regular polygon whose corners lie at the radius; 0 for a disk
    rotation : of the polygon, degrees, counter-clockwise in the image
    """

    focus: Annotated[
        float | None, Number("focus distance", "scene units", above=0.0, at_most=_LARGEST)
    ] = None
    radius: Annotated[
        float | None, Number("radius", "scene units", above=0.0, at_most=_LARGEST)
    ] = None
    f_number: Annotated[float | None, Number("f-number", above=0.0, such_as="2.8")] = None
    focal_length: Annotated[
        float | None, Number("focal length", "scene units", above=0.0, at_most=_LARGEST)
    ] = None
    blades: Annotated[int, Whole("number of blades", at_least=3, at_most=64, or_none=True)] = 0
    rotation: Annotated[float, Number("rotation", "degrees")] = 0.0
    kind: ClassVar[str] = "thin"

    @property
    def opening(self) -> float:
        """The radius of a checked lens, scene units."""
        if self.radius is not None:
            return self.radius
        assert self.focal_length is not None
        assert self.f_number is not None
        return 0.5 * self.focal_length / self.f_number

    def find_conflict(self) -> str | None:
        """Return what is wrong with the attributes taken together; None if nothing is."""
        by_number = self.f_number is not None or self.focal_length is not None
        if self.focus is None:
            return "has no focus distance; add focus"
        if self.radius is not None and by_number:
            return "has a radius and an f-number or focal length; give the one or the other"
        if self.radius is None and (self.f_number is None or self.focal_length is None):
            return "has no size; add radius, or f_number and focal_length"
        return None

    def describe(self) -> dict[str, Any]:
        """Return the JSON-able record of a checked lens."""
        return {
            "kind": self.kind,
            "radius": self.opening,
            "focus": self.focus,
            "f_number": self.f_number,
            "focal_length": self.focal_length,
            "blades": self.blades,
            "rotation": self.rotation,
        }
