"""Sunlight above the air, and what the air lets pass: appendix A.1 and table 2 of Preetham 1999."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def _numbers(text: str) -> Floats:
    return np.array(text.split(), np.float64)


WAVELENGTHS: Floats = np.arange(380.0, 751.0, 5.0)
"""nm"""
_EVERY_10 = _numbers("""
    165.5 162.3 211.2 258.8 258.2 242.3 267.6 296.6 305.4 300.6 306.6 288.3 287.1 278.2 271.0 272.3
    263.6 255.0 250.6 253.1 253.5 251.3 246.3 241.7 236.8 232.1 228.2 223.4 219.7 215.3 211.0 207.3
    202.4 198.7 194.3 190.7 186.3 182.6""")
RADIANCE: Floats = 100.0 * np.interp(WAVELENGTHS, WAVELENGTHS[::2], _EVERY_10)
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
_ALPHA = 1.3
"""Ångström's exponent, of the sizes of aerosol particles."""


def transmittance(mass: float, beta: float) -> Floats:
    """Return how much sunlight the air lets pass at `WAVELENGTHS`.

    Parameters
    ----------
    mass : how much more air it passes than from the zenith
    beta : Ångström's coefficient, of the amount of aerosols
    """
    micrometres = 1e-3 * WAVELENGTHS
    ozone = np.interp(WAVELENGTHS, _OZONE_WAVELENGTHS, _OZONE) * _OZONE_PATH
    gases = np.interp(WAVELENGTHS, _GASES_WAVELENGTHS, _GASES)
    water = np.interp(WAVELENGTHS, _WATER_WAVELENGTHS, _WATER) * _WATER_PATH
    depth = 0.008735 * micrometres**-4.08 + beta * micrometres**-_ALPHA + ozone
    depth += 1.41 * gases / (1.0 + 118.93 * gases * mass) ** 0.45
    depth += 0.2385 * water / (1.0 + 20.07 * water * mass) ** 0.45
    return np.asarray(np.exp(-mass * depth))
