"""The sky above a place outdoors, and its sun."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from photonmap.dataset.models.shapes import Floats
from photonmap.dataset.scenes.exposure import SKY, LightMeter
from photonmap.dataset.scenes.illumination import clear_sky, light_spectrum
from photonmap.scene.light_parts.daylight import SkyLight, SunLight
from photonmap.scene.lights import DomeLight, Light
from photonmap.spectra.observer import luminance

SUN = "sun"
"""The light group of the sun."""


@dataclass(frozen=True, eq=False)
class OpenSky:
    """The sky of a place: what it sends to the points that the camera sees, and its lights.

    Parameters
    ----------
    azimuth : of the sun, degrees, as of `SunLight`
    evenly : irradiance of the points, (P,), from a sky of radiance 1
    sunlit : returns the irradiance of the points, (P,), from a sun of irradiance 1 at an elevation
    """

    azimuth: float
    evenly: Floats
    sunlit: Callable[[float], Floats]

    @classmethod
    def over(cls, meter: LightMeter, azimuth: float) -> OpenSky:
        """Return the sky over what a meter measures."""

        def sunlit(elevation: float) -> Floats:
            direction = SunLight(elevation=elevation, azimuth=azimuth).direction
            return meter.from_afar(-np.array(direction))

        return cls(azimuth, meter.from_sky(), sunlit)

    def received(self, color: str) -> Floats:
        """Return the irradiance of the points, (P,), from a light of level 1 by its name."""
        sky = clear_sky(color)
        if sky is None:
            return self.evenly
        even = self.evenly * luminance(sky.skylight()) / math.pi
        return even + luminance(sky.sun()) * self.sunlit(sky.elevation)

    def lights(self, color: str, level: float) -> list[Light]:
        """Return the lights of a colour: a clear sky and its sun, or an even sky."""
        sky = clear_sky(color)
        if sky is None:
            return [DomeLight(light_spectrum(color) * level, SKY)]
        place = sky.turbidity, sky.elevation, self.azimuth, level
        return [SkyLight(*place, name=SKY), SunLight(*place, name=SUN)]
