"""The sun and a clear sky as spectra, by the height of the sun and the haze of the air.

A. J. Preetham, P. Shirley and B. Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999:
luminance and chromaticity follow Perez' formula, spectra are the CIE's daylight of a chromaticity,
and the sun's light has passed Rayleigh scattering, aerosols, ozone, mixed gases and water vapour.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from photonmap.errors import InputError
from photonmap.spectra.curves import Floats, Spectrum, integrate_products
from photonmap.spectra.names import daylight_series
from photonmap.spectra.observer import observer

TURBIDITY = (2.0, 10.0)
"""Range of haze: clear days have 2 to 4, hazy ones 6 to 10. In clearer air the formula makes
the horizon a hundred times too bright."""
ELEVATION = (5.0, 90.0)  # Range of heights of the sun above the horizon, degrees
SUN_DIAMETER = 0.533  # Mean angular diameter of the sun, degrees
SUN_SOLID_ANGLE = 2.0 * np.pi * (1.0 - np.cos(np.radians(0.5 * SUN_DIAMETER)))
"""Of the sun's disc, sr."""
LUMENS = 683.002  # Of a watt where the eye is most sensitive

_SEEN = (380.0, 780.0)  # nm
_NAMES = ("Y", "x", "y")
# Coefficients A to E of Perez' formula, by turbidity and alone (appendix A.2 of the paper).
_PEREZ = {
    "Y": [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771),
          (-0.0670, 0.3703)],
    "x": [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989),
          (-0.0033, 0.0452)],
    "y": [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537),
          (-0.0109, 0.0529)],
}  # fmt: skip
# Chromaticity of the zenith: rows by turbidity², turbidity and 1, columns by powers of the sun's
# zenith angle from the third down.
_ZENITH = {
    "x": [(0.00166, -0.00375, 0.00209, 0.0), (-0.02903, 0.06377, -0.03202, 0.00394),
          (0.11693, -0.21196, 0.06052, 0.25886)],
    "y": [(0.00275, -0.00610, 0.00317, 0.0), (-0.04214, 0.08970, -0.04153, 0.00516),
          (0.15346, -0.26756, 0.06670, 0.26688)],
}  # fmt: skip


def _numbers(text: str) -> Floats:
    return np.array(text.split(), np.float64)


WAVELENGTHS: Floats = np.arange(380.0, 751.0, 5.0)
"""Of the tables of sunlight: appendix A.1 and table 2 of the paper, nm."""
_EVERY_10 = _numbers("""
    165.5 162.3 211.2 258.8 258.2 242.3 267.6 296.6 305.4 300.6 306.6 288.3 287.1 278.2 271.0 272.3
    263.6 255.0 250.6 253.1 253.5 251.3 246.3 241.7 236.8 232.1 228.2 223.4 219.7 215.3 211.0 207.3
    202.4 198.7 194.3 190.7 186.3 182.6""")
SUN_RADIANCE: Floats = 100.0 * np.interp(WAVELENGTHS, WAVELENGTHS[::2], _EVERY_10)
"""Of the sun's disc above the air, W·m⁻²·sr⁻¹ a nanometre."""

_OZONE_WAVELENGTHS = np.concatenate(
    [[355.0], np.arange(445.0, 606.0, 5.0), np.arange(610.0, 791.0, 10.0)]
)
_OZONE = _numbers("""
    0 .003 .003 .004 .006 .008 .009 .012 .014 .017 .021 .025 .03 .035 .04 .045 .048 .057 .063 .07
    .075 .08 .085 .095 .103 .11 .12 .122 .12 .118 .115 .12 .125 .13 .12 .105 .09 .079 .067 .057
    .048 .036 .028 .023 .018 .014 .011 .01 .009 .007 .004 0 0""")
"""Absorption of ozone, cm⁻¹."""
_GASES_WAVELENGTHS, _GASES = np.array([(759, 0.0), (760, 3.0), (770, 0.21), (771, 0.0)]).T
_WATER_WAVELENGTHS = np.array([689, *range(690, 801, 10)], np.float64)
_WATER = _numbers("0 .016 .024 .0125 1 .87 .061 .001 .00001 .00001 .0006 .0175 .036")
_OZONE_PATH, _WATER_PATH = 0.35, 2.0
"""Of ozone and of water in the air straight up, cm."""
_ALPHA = 1.3  # Ångström's exponent, of the sizes of aerosol particles


@cache
def daylight_basis() -> tuple[Floats, Floats]:
    """Return wavelengths, (L,) nm, and the CIE's S0, S1 and S2, (3, L), which may be negative.

    All daylight is a sum of the three (CIE 15:2018, table T.2).
    """
    rows = daylight_series()
    return rows[0], rows[1:]


@dataclass(frozen=True)
class ClearSky:
    """The sky and the sun above a place, by haze (`TURBIDITY`) and the sun's height (`ELEVATION`).

    Out of these ranges, given in degrees for the height, they are an `InputError`.
    """

    turbidity: float
    elevation: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name, (low, high) in (("turbidity", TURBIDITY), ("elevation", ELEVATION)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{name} {value:g} is out of range; give {low:g} to {high:g}")

    @property
    def sun_zenith(self) -> float:
        """Angle between the sun and the zenith, radians."""
        return float(np.radians(90.0 - self.elevation))

    @property
    def zenith_luminance(self) -> float:
        """Luminance of the zenith, kcd·m⁻²."""
        t = self.turbidity
        chi = (4.0 / 9.0 - t / 120.0) * (np.pi - 2.0 * self.sun_zenith)
        return float((4.0453 * t - 4.9710) * np.tan(chi) - 0.2155 * t + 2.4192)

    @property
    def zenith_chromaticity(self) -> tuple[float, float]:
        """CIE 1931 x and y of the zenith."""
        haze = np.array([self.turbidity**2, self.turbidity, 1.0])
        powers = self.sun_zenith ** np.arange(3.0, -1.0, -1.0)
        x, y = (float(haze @ np.array(_ZENITH[name]) @ powers) for name in ("x", "y"))
        return x, y

    def appearance(self, zenith: ArrayLike, from_sun: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return luminances, kcd·m⁻², and chromaticities x and y of directions in the sky.

        They are given by angles to the zenith, below 90°, and to the sun, radians.
        """
        at_zenith = (self.zenith_luminance, *self.zenith_chromaticity)
        luminance, x, y = (
            value * self._perez(name, zenith, from_sun) / self._perez(name, 0.0, self.sun_zenith)
            for name, value in zip(_NAMES, at_zenith, strict=True)
        )
        return luminance, x, y

    def _perez(self, name: str, zenith: ArrayLike, from_sun: ArrayLike) -> Floats:
        a, b, c, d, e = np.array(_PEREZ[name]) @ (self.turbidity, 1.0)
        angle = np.asarray(from_sun, np.float64)
        horizon = 1.0 + a * np.exp(b / np.cos(zenith))
        return horizon * (1.0 + c * np.exp(d * angle) + e * np.cos(angle) ** 2)

    def weights(self, zenith: ArrayLike, from_sun: ArrayLike) -> Floats:
        """Return how much of S0, S1 and S2 makes up the sky's radiance, (..., 3).

        In W·m⁻²·sr⁻¹ a nanometre; directions are those of `appearance`. No daylight is as red as
        the formula wants the horizon away from a low sun: spectra there are paler, and just 0 at
        their least.
        """
        luminance, x, y = self.appearance(zenith, from_sun)
        scale = 0.0241 + 0.2562 * x - 0.7341 * y
        first = (-1.3515 - 1.7703 * x + 5.9114 * y) / scale
        second = (0.0300 - 31.4424 * x + 30.0717 * y) / scale
        mix = _not_negative(np.stack([np.ones_like(first), first, second], axis=-1))
        radiance = 1000.0 * luminance / (LUMENS * observer().efficiency)
        return mix * (radiance / (mix @ basis_luminance()))[..., None]

    @property
    def optical_mass(self) -> float:
        """How much more air sunlight passes than from the zenith (Kasten's formula)."""
        angle = self.sun_zenith
        return float(1.0 / (np.cos(angle) + 0.15 * (93.885 - np.degrees(angle)) ** -1.253))

    def sun(self) -> Spectrum:
        """Return the sun's irradiance on a surface that faces it, W·m⁻² a nanometre."""
        beta = 0.04608 * self.turbidity - 0.04586
        passed = transmittance(self.optical_mass, beta)
        values = SUN_RADIANCE * passed * SUN_SOLID_ANGLE
        return Spectrum(WAVELENGTHS, values, extrapolate=True)

    def skylight(self) -> Spectrum:
        """Return the sky's irradiance on level ground without the sun, W·m⁻² a nanometre."""
        (zenith, azimuth), area = _sphere_grid()
        angle = np.sin(zenith) * np.sin(self.sun_zenith) * np.cos(azimuth)
        angle = np.arccos(np.clip(angle + np.cos(zenith) * np.cos(self.sun_zenith), -1.0, 1.0))
        total = (self.weights(zenith, angle) * (np.cos(zenith) * area)[..., None]).sum(axis=(0, 1))
        wavelengths, basis = daylight_basis()
        return Spectrum(wavelengths, np.maximum(total @ basis, 0.0), extrapolate=True)


def _not_negative(mix: Floats) -> Floats:
    """Return sums of S0, S1 and S2, (..., 3), as much paler as they need to be above 0."""
    wavelengths, basis = daylight_basis()
    seen = basis[:, (wavelengths >= _SEEN[0]) & (wavelengths <= _SEEN[1])]
    least = (mix[..., 1:] @ (seen[1:] / seen[0])).min(axis=-1)
    pale = np.where(least < -1.0, -1.0 / least, 1.0)
    return mix * np.stack([np.ones_like(pale), pale, pale], axis=-1)


@cache
def basis_luminance() -> Floats:
    """Return ∫ S ȳ dλ / ∫ ȳ dλ of S0, S1 and S2, (3,)."""
    eye, (wavelengths, basis) = observer(), daylight_basis()
    xyz = integrate_products(eye.wavelengths, eye.rgb_to_xyz @ eye.matching, wavelengths, basis)
    return np.asarray(xyz)[1]


@cache
def _sphere_grid(rows: int = 90) -> tuple[tuple[Floats, Floats], Floats]:
    """Return zenith and azimuth angles over the sky, and solid angles, (rows, 4 rows)."""
    edges = np.linspace(0.0, 0.5 * np.pi, rows + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    turn = (np.arange(4 * rows) + 0.5) * (2.0 * np.pi / (4 * rows))
    zenith, azimuth = np.meshgrid(middle, turn, indexing="ij")
    area = -np.diff(np.cos(edges)) * (2.0 * np.pi / (4 * rows))
    return (zenith, azimuth), np.repeat(area[:, None], 4 * rows, axis=1)


def transmittance(mass: float, beta: float) -> Floats:
    """Return how much sunlight the air lets pass at `WAVELENGTHS`.

    `mass` is how much more air it passes than from the zenith, `beta` Ångström's coefficient, of
    the amount of aerosols.
    """
    micrometres = 1e-3 * WAVELENGTHS
    ozone = np.interp(WAVELENGTHS, _OZONE_WAVELENGTHS, _OZONE) * _OZONE_PATH
    gases = np.interp(WAVELENGTHS, _GASES_WAVELENGTHS, _GASES)
    water = np.interp(WAVELENGTHS, _WATER_WAVELENGTHS, _WATER) * _WATER_PATH
    depth = 0.008735 * micrometres**-4.08 + beta * micrometres**-_ALPHA + ozone
    depth += 1.41 * gases / (1.0 + 118.93 * gases * mass) ** 0.45
    depth += 0.2385 * water / (1.0 + 20.07 * water * mass) ** 0.45
    return np.asarray(np.exp(-mass * depth))
