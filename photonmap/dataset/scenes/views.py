"""Views: cameras that orbit what the camera of the scene looks at."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from photonmap.errors import InputError
from photonmap.scene.camera import Camera
from photonmap.scene.projections import RayMap


@dataclass(frozen=True)
class View:
    """A camera position relative to that of the scene, around the same target.

    Parameters
    ----------
    name : "" for the camera of the scene itself
    yaw : degrees about the up direction, counter-clockwise seen from above
    pitch : degrees upwards
    distance : from the target, relative to that of the scene's camera
    """

    name: str = ""
    yaw: float = 0.0
    pitch: float = 0.0
    distance: float = 1.0

    def __post_init__(self) -> None:
        """Reject numbers that do not define a camera position."""
        numbers = (self.yaw, self.pitch, self.distance)
        if not all(isinstance(n, int | float) and math.isfinite(n) for n in numbers):
            raise InputError(f"view {self.name!r}: yaw, pitch and distance must be finite numbers")
        if self.distance <= 0.0:
            raise InputError(f"view {self.name!r}: distance {self.distance} must be above 0")

    @property
    def is_own(self) -> bool:
        """Whether the camera stays where the scene has it."""
        return (self.yaw, self.pitch, self.distance) == (0.0, 0.0, 1.0)

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
