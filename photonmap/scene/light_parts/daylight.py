"""Daylight: a clear sky all around, and the sun, as spectra that follow from haze and hour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.lights import DirectionalLight, Emitter, Light
from photonmap.scene.parameters import Number, Text
from photonmap.scene.vectors import Vector
from photonmap.spectra.curves import Color
from photonmap.spectra.daylight.sky import (
    ELEVATION,
    SUN_DIAMETER,
    TURBIDITY,
    ClearSky,
    basis_luminance,
)

ROWS = 256
"""Rows of the map of a sky, half of which lie above the horizon."""

_Name = Annotated[str, Text()]
_Haze = Annotated[
    float, Number("turbidity", "turbidity", at_least=TURBIDITY[0], at_most=TURBIDITY[1])
]
_Elevation = Annotated[
    float, Number("elevation", "degrees", at_least=ELEVATION[0], at_most=ELEVATION[1])
]
_Azimuth = Annotated[float, Number("azimuth", "degrees")]
_Scale = Annotated[float, Number("factor", at_least=0.0)]


@dataclass(frozen=True)
class SkyLight(Light):
    """A clear sky without its sun, black below the horizon; +y is up.

    Radiances are W·m⁻²·sr⁻¹ a nanometre: see `photonmap.spectra.daylight.sky`.

    Parameters
    ----------
    turbidity : haze of the air, 2 to 10
    elevation : of the sun above the horizon, degrees, 5 to 90
    azimuth : of the sun, degrees: at 0 it stands towards -z, at 90 towards +x
    scale : multiplies radiances
    """

    turbidity: _Haze = 3.0
    elevation: _Elevation = 45.0
    azimuth: _Azimuth = 0.0
    scale: _Scale = 1.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "sky"

    @property
    def color(self) -> Color:
        """Its irradiance on level ground over π."""
        return ClearSky(self.turbidity, self.elevation).skylight() * (self.scale / np.pi)

    def weights(self) -> NDArray[np.float32]:
        """Return a map of how much of the CIE's S0, S1 and S2 it is made of, (H, 2H, 3).

        Laid out as that of an `EnvironmentLight`.
        """
        polar = (np.arange(ROWS // 2) + 0.5) * (np.pi / ROWS)
        azimuth = (np.arange(2 * ROWS) + 0.5) * (np.pi / ROWS) - np.pi
        height = np.radians(self.elevation)
        zenith = np.repeat(polar[:, None], 2 * ROWS, axis=1)
        cosine = np.cos(height) * np.sin(zenith) * np.cos(azimuth - np.radians(self.azimuth))
        cosine += np.sin(height) * np.cos(zenith)
        from_sun = np.arccos(np.clip(cosine, -1.0, 1.0))
        above = ClearSky(self.turbidity, self.elevation).weights(zenith, from_sun)
        return np.concatenate([above, np.zeros_like(above)]).astype(np.float32)

    def luminance(self) -> NDArray[np.float32]:
        """Return a map of radiances by luminance, 1 for the constant 1, (H, 2H), before `scale`."""
        return (self.weights() @ basis_luminance()).astype(np.float32)

    def emitter(self) -> Emitter:
        """Return light from all around, as of a dome."""
        return Emitter("dome", lambda radius: (2.0 * np.pi * radius) ** 2)


@dataclass(frozen=True)
class SunLight(Light):
    """The sun of a clear sky, a disc of 0.533 degrees that lights surfaces and is not seen itself.

    Its irradiance on a surface that faces it is W·m⁻² a nanometre: see
    `photonmap.spectra.daylight.sky`.

    Parameters
    ----------
    turbidity, elevation, azimuth, scale : as of the `SkyLight` that it belongs to
    """

    turbidity: _Haze = 3.0
    elevation: _Elevation = 45.0
    azimuth: _Azimuth = 0.0
    scale: _Scale = 1.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "sun"

    @property
    def color(self) -> Color:
        """Its irradiance on a surface that faces it."""
        return ClearSky(self.turbidity, self.elevation).sun() * self.scale

    @property
    def direction(self) -> Vector:
        """In which its light travels, of length 1."""
        height, turn = np.radians([self.elevation, self.azimuth])
        x, z = -np.cos(height) * np.sin(turn), np.cos(height) * np.cos(turn)
        return float(x), float(-np.sin(height)), float(z)

    def emitter(self) -> Emitter:
        """Return light that is parallel but for the size of the disc."""
        return DirectionalLight(self.direction, angle=SUN_DIAMETER).emitter()
