"""Views: cameras that orbit what the camera of the scene looks at, pairs, and frames of a path."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.scene.camera import Camera
from photonmap.scene.projections import RayMap

SIDES = ("left", "right")
"""The cameras of a stereo pair."""


@dataclass(frozen=True)
class View:
    """A camera position relative to that of the scene, around the same target.

    Parameters
    ----------
    name : "" for the camera of the scene itself
    yaw : degrees about the up direction, counter-clockwise seen from above
    pitch : degrees upwards
    distance : from the target, relative to that of the scene's camera
    fov : full vertical angle of view of a pinhole, degrees; None for that of the scene's camera
    side : "left" or "right" camera of a stereo pair about this view; "" for the middle
    baseline : distance between the two, scene units
    path : name of the path through the scene that this is a frame of, "" for none; yaw, pitch and
        distance then say how far the path leads from the scene's camera, at most
    frame, frames : number of the frame, from 0, and how many the path has
    """

    name: str = ""
    yaw: float = 0.0
    pitch: float = 0.0
    distance: float = 1.0
    fov: float | None = None
    side: str = ""
    baseline: float = 0.0
    path: str = ""
    frame: int = 0
    frames: int = 0

    def __post_init__(self) -> None:
        """Reject numbers that do not define a camera position."""
        numbers = (self.yaw, self.pitch, self.distance)
        if not all(isinstance(n, int | float) and math.isfinite(n) for n in numbers):
            raise InputError(f"view {self.name!r}: yaw, pitch and distance must be finite numbers")
        if self.distance <= 0.0:
            raise InputError(f"view {self.name!r}: distance {self.distance} must be above 0")
        if not (isinstance(self.baseline, int | float) and 0.0 <= self.baseline < math.inf):
            raise InputError(f"view {self.name!r}: baseline {self.baseline} must be 0 or more")
        if self.fov is not None and not (
            isinstance(self.fov, int | float) and 0.0 < self.fov < 180.0
        ):
            raise InputError(
                f"view {self.name!r}: fov {self.fov} must be between 0 and 180 degrees"
            )

    @property
    def is_own(self) -> bool:
        """Whether the camera stays where the scene has it."""
        still = (self.yaw, self.pitch, self.distance) == (0.0, 0.0, 1.0)
        return still and not self.path

    @property
    def search(self) -> str:
        """By what its place is sought: the name of the path, or of the view without its side."""
        return self.path or (self.name.removesuffix(f"_{self.side}") if self.side else self.name)

    def renamed(self) -> View:
        """Return the frame of a path by its own name."""
        side = f"_{self.side}" if self.side else ""
        return replace(self, name=f"{self.path}-{self.frame:04}{side}")

    def pair(self) -> tuple[View, ...]:
        """Return the views of both cameras of a pair; the view alone without a baseline."""
        if not self.baseline:
            return (self,)
        return tuple(replace(self, name=f"{self.name}_{side}", side=side) for side in SIDES)

    def describe(self) -> dict[str, Any]:
        """Return the view as a JSON-able dict, without what is at its default, but for a place."""
        always = ("name", "yaw", "pitch", "distance")
        return {
            each.name: getattr(self, each.name)
            for each in fields(self)
            if each.name in always or getattr(self, each.name) != each.default
        }

    def move(self, camera: Camera) -> Camera:
        """Return the camera moved to this view.

        Raises
        ------
        InputError : the camera would look straight up or down, or its rays do not move with it
        """
        if self.is_own:
            return camera
        if isinstance(camera.projection, RayMap):
            raise InputError(f"view {self.name!r} cannot move a ray map; give each view its own")
        target, up = np.array(camera.target, np.float64), np.array(camera.up, np.float64)
        up /= np.linalg.norm(up)
        back = np.array(camera.origin) - target
        high = float(back @ up)
        flat = back - high * up
        length, wide = float(np.linalg.norm(back)), float(np.linalg.norm(flat))
        rise = math.atan2(high, wide) + math.radians(self.pitch)
        if not abs(rise) < math.radians(89.0):
            raise InputError(f"view {self.name!r} looks straight up or down; choose another pitch")
        turn = math.radians(self.yaw)
        ahead = flat / wide
        ahead = math.cos(turn) * ahead + math.sin(turn) * np.cross(up, ahead)
        arm = self.distance * length * (math.cos(rise) * ahead + math.sin(rise) * up)
        x, y, z = (target + arm).tolist()
        return replace(camera, origin=(x, y, z))
