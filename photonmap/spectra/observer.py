"""The CIE 1931 observer: spectra to linear sRGB and back, XYZ to colours, adaptation to a white."""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from photonmap.errors import InputError
from photonmap.spectra.curves import (
    VISIBLE,
    Color,
    Floats,
    Spectrum,
    integrate_products,
    merge_grids,
    product_weights,
    resample,
)

XYZ = tuple[float, float, float]

_TOLERANCE = 1e-6  # of the largest of XYZ
_STEPS = 8  # from grey to the colour
_DIMMER = (0.5, 0.2, 0.05, 0.01, 0.002)
_CAT16 = np.array(
    [
        [0.401288, 0.650173, -0.051461],
        [-0.250268, 1.204414, 0.045854],
        [-0.002079, 0.048952, 0.953127],
    ]
)
"""From XYZ to the responses of cones."""
_MOST = 5.0
"""Ratio of the responses of two cones, relative to those to D65, above which a light is too
saturated to be anybody's white: of a black body of 2856 K it is 3.1, of a candle 7, of the
primaries of sRGB 5.6 to 13."""


class Observer(NamedTuple):
    """What turns spectra into linear sRGB and back, in steps of 1 nm.

    Parameters
    ----------
    wavelengths : (M,) float64, nm
    matching : (3, M) float64, nm⁻¹; ∫ radiance × matching dλ = linear sRGB, where Y is
        normalised by ∫ȳ
    rgb_to_xyz : (3, 3) float64; its first column is the XYZ of red
    d65 : (M,) float64, the illuminant, scaled so that its linear sRGB is (1, 1, 1)
    efficiency : ∫ȳ dλ, nm; ȳ is V(λ), the luminous efficiency, which is 1 at its peak
    basis : (3, M) float64 in [0, 1], the reflectances of red, green and blue; they add up to 1,
        and each returns to its own RGB under D65
    """

    wavelengths: Floats
    matching: Floats
    rgb_to_xyz: Floats
    d65: Floats
    efficiency: float
    basis: Floats


# Chromaticities (x, y, 1 − x − y) of the red, green and blue primaries in columns, IEC 61966-2-1.
_PRIMARIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])


@cache
def observer() -> Observer:
    """Return the CIE 1931 2° observer, D65 and the basis, read once from `data/observer.csv`."""
    file = Path(__file__).parents[1] / "data" / "observer.csv"
    return observer_from_table(np.loadtxt(file, delimiter=","))


def observer_from_table(table: Floats) -> Observer:
    """Build an `Observer` from columns λ (nm), x̄, ȳ, z̄, D65 and any number of basis curves.

    The table is (K, 5 + B), of whole wavelengths, increasing. The white of the primaries is D65 as
    tabulated, not its rounded chromaticity, so that a reflectance of 1 is (1, 1, 1) to the last
    digit.
    """
    wavelengths = np.arange(table[0, 0], table[-1, 0] + 1.0)
    columns = resample(wavelengths, table[:, 0], table[:, 1:].T)
    xyz, d65, basis = columns[:3], columns[3], columns[4:]
    efficiency = float(np.trapezoid(xyz[1], wavelengths))
    xyz = xyz / efficiency
    white = integrate_products(wavelengths, xyz, wavelengths, d65[None])
    white, d65 = white / white[1], d65 / white[1]
    rgb_to_xyz = _PRIMARIES * np.linalg.solve(_PRIMARIES, white).T
    return Observer(
        wavelengths, np.linalg.solve(rgb_to_xyz, xyz), rgb_to_xyz, d65, efficiency, basis
    )


def radiance_to_rgb(spectrum: Spectrum) -> Floats:
    """Project a radiance onto linear sRGB: (3,) float64, negative where out of gamut.

    Outside of 400 to 700 nm, where the eye sees little, the curve keeps its outer values; one that
    covers less is an `InputError`.
    """
    spectrum.check_covers(*VISIBLE)
    eye, curve = observer(), spectrum.values[None]
    return integrate_products(eye.wavelengths, eye.matching, spectrum.wavelengths, curve)[:, 0]


def reflectance_to_rgb(spectrum: Spectrum) -> Floats:
    """Return the linear sRGB of a reflectance under D65: (3,) float64, not clipped.

    As `radiance_to_rgb` otherwise.
    """
    spectrum.check_covers(*VISIBLE)
    grid, light, merged, before, after = _under_d65(spectrum.wavelengths.tobytes())
    g = np.interp(merged, grid, light * spectrum(grid))
    return before @ (2.0 * g[:-1] + g[1:]) + after @ (g[:-1] + 2.0 * g[1:])


@lru_cache(maxsize=16)
def _under_d65(wavelengths: bytes) -> tuple[Floats, ...]:
    """Return what reflectances at the same wavelengths, of which scenes have many, share.

    The grid on which light is reflected, D65 there, and `product_weights` of the eye on it.
    """
    eye = observer()
    grid = merge_grids(eye.wavelengths, np.frombuffer(wavelengths))
    light = np.interp(grid, eye.wavelengths, eye.d65)
    return grid, light, *product_weights(eye.wavelengths, eye.matching, grid)


def upsample_reflectance(rgb: ArrayLike) -> Spectrum:
    """Return a smooth reflectance that has this colour, (3,) linear sRGB, under D65.

    A sum of three basis curves, within [0, 1] for `rgb` within [0, 1]: I. Mallett and C. Yuksel,
    "Spectral Primary Decomposition for Rendering with sRGB Reflectance", EGSR 2019.
    """
    eye = observer()
    return Spectrum(eye.wavelengths, np.asarray(rgb) @ eye.basis, extrapolate=True)


def upsample_emission(rgb: ArrayLike) -> Spectrum:
    """Return a smooth radiance of a colour, (3,) linear sRGB: that of the surface `rgb` under D65.

    With c = max(rgb) it is c × `upsample_reflectance`(rgb / c) × D65; as the basis is linear, c
    cancels and `rgb` may exceed 1. Where all three are equal it is D65 itself.
    """
    eye = observer()
    return Spectrum(eye.wavelengths, np.asarray(rgb) @ eye.basis * eye.d65, extrapolate=True)


def emission_spectrum(color: Color) -> Spectrum:
    """Return the spectrum of a radiance given as any colour; a number is a constant spectrum."""
    if isinstance(color, Spectrum):
        return color
    if np.ndim(color):
        return upsample_emission(color)
    return Spectrum(observer().wavelengths[[0, -1]], np.full(2, color), extrapolate=True)


def luminance(color: Color) -> float:
    """Return the luminance ∫ L ȳ dλ / ∫ ȳ dλ of a radiance L; 1 for the constant 1."""
    return float(observer().rgb_to_xyz[1] @ radiance_to_rgb(emission_spectrum(color)))


def normalise_luminance(spectrum: Spectrum) -> Spectrum:
    """Return a light scaled to a luminance of 1, that of the constant 1."""
    return spectrum * (1.0 / luminance(spectrum))


def adapt_to_d65(white: Floats) -> Floats:
    """Return the matrix, (3, 3), that turns a white into D65 of its luminance, for linear sRGB.

    Full adaptation by von Kries' rule, in the cone responses of CAT16: C. Li et al., "Comprehensive
    color solutions: CAM16, CAT16, and CAM16-UCS", Color Research and Application 42(6), 2017. It is
    the identity if the white, (3,), is black, or too saturated to be taken for white.
    """
    to_xyz = observer().rgb_to_xyz
    to_cones = _CAT16 @ to_xyz
    luminance = to_xyz[1] @ white
    relative = to_cones @ white / to_cones.sum(axis=1)
    if not 0.0 < relative.max() <= _MOST * relative.min():
        return np.eye(3)
    return np.linalg.solve(to_cones, (luminance / relative)[:, None] * to_cones)


def reflectance_of_xyz(xyz: XYZ) -> Color:
    """Return a reflectance that has this colour (Y = 1 for a perfect diffuser) under D65.

    Within the gamut of sRGB it is linear sRGB; outside it is a smooth curve by W. Jakob and J.
    Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", Computer Graphics
    Forum 38(2), 2019. An `InputError` says that no reflectance has it.
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
    """Return a light of this colour, like `reflectance_of_xyz` without an upper bound."""
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
        raise InputError(f"no colour has the XYZ {_listed(xyz)}; give three values of 0 or more")
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
