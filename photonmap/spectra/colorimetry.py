"""XYZ to colours: linear sRGB within its gamut, smooth spectra outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.observer import observer

Floats = NDArray[np.float64]
XYZ = tuple[float, float, float]

_TOLERANCE = 1e-6  # of the largest of XYZ
_STEPS = 8  # from grey to the colour
_DIMMER = (0.5, 0.2, 0.05, 0.01, 0.002)


def reflectance_of_xyz(xyz: XYZ) -> Color:
    """Return a reflectance that has this colour under D65.

    Within the gamut of sRGB it is linear sRGB; outside it is a smooth curve by W. Jakob and J.
    Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", Computer Graphics
    Forum 38(2), 2019.

    Parameters
    ----------
    xyz : CIE 1931, Y = 1 for a perfect diffuser

    Raises
    ------
    InputError
        if no reflectance has it
    """
    rgb = _to_rgb(xyz)
    if rgb.min() >= 0.0 and rgb.max() <= 1.0:
        return _triple(rgb)
    curve = _recover(np.array(xyz))
    if curve is None:
        percent = "divide values of 0 to 100 by 100" if 2.0 < xyz[1] <= 100.0 else ""
        remedy = percent or "lower its saturation"
        raise InputError(f"no reflectance has the XYZ {_listed(xyz)} under D65; {remedy}")
    return curve


def emission_of_xyz(xyz: XYZ) -> Color:
    """Return a light of this colour, like `reflectance_of_xyz` without an upper bound.

    Raises
    ------
    InputError
        if no light has it
    """
    rgb = _to_rgb(xyz)
    if rgb.min() >= 0.0:
        return _triple(rgb)
    eye, brightest = observer(), max(*xyz, 1e-300)
    for dimmer in _DIMMER:
        curve = _recover(np.array(xyz) / brightest * dimmer)
        if curve is not None:
            light = curve(eye.wavelengths) * eye.d65 * (brightest / dimmer)
            return Spectrum(eye.wavelengths, light, extrapolate=True)
    raise InputError(f"no light has the XYZ {_listed(xyz)}; lower its saturation")


def _to_rgb(xyz: XYZ) -> Floats:
    """Return linear sRGB, with rounding errors next to 0 and 1 removed."""
    if min(xyz) < 0.0:
        raise InputError(f"no colour has the XYZ {_listed(xyz)}; give three values from 0")
    rgb = np.linalg.solve(observer().rgb_to_xyz, xyz)
    near = np.round(rgb)
    return np.where(np.abs(rgb - near) < 1e-9 * max(1.0, rgb.max()), near, rgb)


def _triple(rgb: Floats) -> tuple[float, float, float]:
    red, green, blue = rgb.tolist()
    return red, green, blue


def _recover(xyz: Floats) -> Spectrum | None:
    """Return a reflectance in [0, 1] of this colour under D65; None if there is none.

    A sigmoid of a parabola over wavelength, found by continuation from the grey of equal Y.
    """
    from scipy.optimize import least_squares

    eye = observer()
    weights = eye.rgb_to_xyz @ eye.matching * eye.d65  # zero at both ends, in steps of 1 nm
    at = (eye.wavelengths - 550.0) / 100.0
    sample_scales = np.stack([np.ones(len(at)), at, at * at])

    def reflect(coefficients: Floats) -> Floats:
        argument = coefficients @ sample_scales
        return 0.5 + 0.5 * argument / np.sqrt(1.0 + argument**2)

    grey = weights.sum(axis=1) * min(xyz[1], 0.99)
    coefficients = np.zeros(3)
    for step in np.linspace(0.0, 1.0, _STEPS + 1):
        aim = grey + step * (xyz - grey)

        def miss(coefficients: Floats, aim: Floats = aim) -> Floats:
            return (weights @ reflect(coefficients) - aim) / xyz.max()

        coefficients = least_squares(miss, coefficients, x_scale="jac").x
    if np.abs(miss(coefficients)).max() > _TOLERANCE:
        return None
    return Spectrum(eye.wavelengths, reflect(coefficients), extrapolate=True)


def _listed(xyz: XYZ) -> str:
    return ", ".join(f"{value:g}" for value in xyz)
