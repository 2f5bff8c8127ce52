"""Daylight: a clear sky all around and its sun, by haze and hour, and an overcast sky."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from photonmap.scene.lights import AllAround, DirectionalLight, Emitter, Light
from photonmap.scene.parameters import Emission, Number, Text, Vector
from photonmap.spectra.curves import Color, Floats
from photonmap.spectra.daylight import ELEVATION, SUN_DIAMETER, TURBIDITY, ClearSky, basis_luminance

ROWS = 256  # Rows of the map of a sky, half of which lie above the horizon

_Name = Annotated[str, Text()]
_Haze = Annotated[
    float, Number("turbidity", "turbidity", at_least=TURBIDITY[0], at_most=TURBIDITY[1])
]
_Elevation = Annotated[
    float, Number("elevation", "degrees", at_least=ELEVATION[0], at_most=ELEVATION[1])
]
_Azimuth = Annotated[float, Number("azimuth", "degrees")]
_Scale = Annotated[float, Number("factor", at_least=0.0)]
_Ground = Annotated[float, Number("reflectance", at_least=0.0, at_most=1.0)]


@dataclass(frozen=True)
class _ClearDay(Light):
    """What a clear sky and its sun have in common.

    Parameters
    ----------
    turbidity : haze of the air, 2 to 10
    elevation : of the sun above the horizon, degrees, 5 to 90
    azimuth : of the sun, degrees: at 0 it stands towards -z, at 90 towards +x
    scale : multiplies what the model says
    """

    turbidity: _Haze = 3.0
    elevation: _Elevation = 45.0
    azimuth: _Azimuth = 0.0
    scale: _Scale = 1.0
    name: _Name = ""
    group: _Name = ""

    @property
    def _model(self) -> ClearSky:
        return ClearSky(self.turbidity, self.elevation)


@dataclass(frozen=True)
class SkyLight(_ClearDay, AllAround):
    """A clear sky without its sun; +y is up, and below the horizon lies level ground.

    Radiances are W·m⁻²·sr⁻¹ a nanometre: see `photonmap.spectra.daylight`.

    Parameters
    ----------
    turbidity, elevation, azimuth, scale : as of its `SunLight`
    ground : reflectance of the grey ground below the horizon, which the sky lights, without the sun
    """

    ground: _Ground = 0.0
    kind: ClassVar[str] = "sky"

    @property
    def color(self) -> Color:
        """Its irradiance on level ground over π."""
        return self._model.skylight() * (self.scale / np.pi)

    def weights(self) -> NDArray[np.float32]:
        """Return a map of how much of the CIE's S0, S1 and S2 it is made of, (H, 2H, 3).

        Laid out as that of an `EnvironmentLight`.
        """
        azimuth = (np.arange(2 * ROWS) + 0.5) * (np.pi / ROWS) - np.pi
        height = np.radians(self.elevation)
        zenith = np.repeat(_zenith_angles()[:, None], 2 * ROWS, axis=1)
        cosine = np.cos(height) * np.sin(zenith) * np.cos(azimuth - np.radians(self.azimuth))
        cosine += np.sin(height) * np.cos(zenith)
        from_sun = np.arccos(np.clip(cosine, -1.0, 1.0))
        return _with_ground(self._model.weights(zenith, from_sun), self.ground)

    def luminance(self) -> NDArray[np.float32]:
        """Return a map of radiances by luminance, 1 for the constant 1, (H, 2H), before `scale`."""
        return (self.weights() @ basis_luminance()).astype(np.float32)


@dataclass(frozen=True)
class SunLight(_ClearDay):
    """The sun of a clear sky, a disc of 0.533 degrees that lights surfaces and is not seen itself.

    Its irradiance on a surface that faces it is W·m⁻² a nanometre: see
    `photonmap.spectra.daylight`. Parameters are those of the `SkyLight` that it belongs to.
    """

    kind: ClassVar[str] = "sun"

    @property
    def color(self) -> Color:
        """Its irradiance on a surface that faces it."""
        return self._model.sun() * self.scale

    @property
    def direction(self) -> Vector:
        """In which its light travels, of length 1."""
        height, turn = np.radians([self.elevation, self.azimuth])
        x, z = -np.cos(height) * np.sin(turn), np.cos(height) * np.cos(turn)
        return float(x), float(-np.sin(height)), float(z)

    def emitter(self) -> Emitter:
        """Return light that is parallel but for the size of the disc."""
        return DirectionalLight(self.direction, angle=SUN_DIAMETER).emitter()


@dataclass(frozen=True)
class OvercastLight(AllAround):
    """The sky under clouds, of one spectrum, three times as bright at the zenith as at the horizon.

    The CIE's standard overcast sky (Moon and Spencer 1942; CIE S 011:2003): at an elevation γ it
    has (1 + 2 sin γ) / 3 of the zenith's radiance, so level ground gets 7 π / 9 of that.

    Parameters
    ----------
    radiance : of the zenith, W·m⁻²·sr⁻¹
    ground : reflectance of the grey ground below the horizon, which the sky lights
    """

    radiance: Annotated[Color, Emission("radiance", "W·m⁻²·sr⁻¹")] = 1.0
    ground: _Ground = 0.0
    name: _Name = ""
    group: _Name = ""
    kind: ClassVar[str] = "overcast"

    def amounts(self) -> NDArray[np.float32]:
        """Return a map of radiances, relative to the zenith's, (H, 2H).

        Laid out as that of an `EnvironmentLight`.
        """
        above = (1.0 + 2.0 * np.cos(_zenith_angles())) / 3.0
        above = np.repeat(above[:, None, None], 2 * ROWS, axis=1)
        return _with_ground(above, self.ground)[..., 0]


def _zenith_angles() -> Floats:
    """Return the zenith angles of the rows above the horizon, (H / 2,) radians."""
    return np.asarray((np.arange(ROWS // 2) + 0.5) * (np.pi / ROWS), np.float64)


def _with_ground(above: Floats, reflectance: float) -> NDArray[np.float32]:
    """Return a map, (H, 2H, C), of its upper half and the Lambertian ground that that lights."""
    edges = np.sin(np.arange(ROWS // 2 + 1) * (np.pi / ROWS)) ** 2
    irradiance = np.pi * np.diff(edges) @ above.mean(axis=1)
    ground = np.broadcast_to(reflectance / np.pi * irradiance, above.shape)
    return np.concatenate([above, ground]).astype(np.float32)
