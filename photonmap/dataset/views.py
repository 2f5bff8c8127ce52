"""Views: where the camera stands, told from the scene's own camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from photonmap.errors import InputError
from photonmap.scene import Camera


@dataclass(frozen=True)
class View:
    """A camera that is moved around what it looks at.

    Parameters
    ----------
    name : "" for the scene's own
    yaw : degrees around the upward direction, counter-clockwise seen from above
    pitch : degrees upwards
    distance : from the target, in units of the camera's own
    """

    name: str = ""
    yaw: float = 0.0
    pitch: float = 0.0
    distance: float = 1.0

    def __post_init__(self) -> None:
        """Refuse numbers that move the camera nowhere."""
        numbers = (self.yaw, self.pitch, self.distance)
        if not all(isinstance(n, int | float) and math.isfinite(n) for n in numbers):
            raise InputError(f"view {self.name!r}: yaw, pitch and distance must be finite numbers")
        if self.distance <= 0.0:
            raise InputError(f"view {self.name!r}: distance {self.distance} must be above 0")

    def move(self, camera: Camera) -> Camera:
        """Return the camera in its new place.

        Raises
        ------
        InputError : it would look straight up or down
        """
        if (self.yaw, self.pitch, self.distance) == (0.0, 0.0, 1.0):
            return camera
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
