"""The CIE 1931 observer: spectra to linear sRGB, and linear sRGB to smooth spectra."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.spectra.curves import VISIBLE, Color, Spectrum
from photonmap.spectra.integrals import integrate_products, merge_grids, resample

Floats = NDArray[np.float64]


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

    The white of the primaries is D65 as tabulated, not its rounded chromaticity, so that a
    reflectance of 1 is (1, 1, 1) to the last digit.

    Parameters
    ----------
    table : (K, 5 + B) float64, whole wavelengths, increasing
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

    Outside of 400 to 700 nm, where the eye sees little, the curve keeps its outer values.

    Raises
    ------
    InputError
        if the spectrum covers less
    """
    spectrum.check_covers(*VISIBLE)
    eye, curve = observer(), spectrum.values[None]
    return integrate_products(eye.wavelengths, eye.matching, spectrum.wavelengths, curve)[:, 0]


def reflectance_to_rgb(spectrum: Spectrum) -> Floats:
    """Return the linear sRGB of a reflectance under D65: (3,) float64, not clipped.

    As `radiance_to_rgb` otherwise.
    """
    spectrum.check_covers(*VISIBLE)
    eye = observer()
    grid = merge_grids(eye.wavelengths, spectrum.wavelengths)
    light = np.interp(grid, eye.wavelengths, eye.d65)
    return radiance_to_rgb(Spectrum(grid, light * spectrum(grid)))


def upsample_reflectance(rgb: ArrayLike) -> Spectrum:
    """Return a smooth reflectance that has this colour under D65.

    A sum of three basis curves, within [0, 1] for `rgb` within [0, 1]: I. Mallett and C. Yuksel,
    "Spectral Primary Decomposition for Rendering with sRGB Reflectance", EGSR 2019.

    Parameters
    ----------
    rgb : (3,) linear sRGB
    """
    eye = observer()
    return Spectrum(eye.wavelengths, np.asarray(rgb) @ eye.basis, extrapolate=True)


def upsample_emission(rgb: ArrayLike) -> Spectrum:
    """Return a smooth radiance of this colour: that of the surface `rgb` under D65.

    With c = max(rgb) it is c × `upsample_reflectance`(rgb / c) × D65; as the basis is linear,
    c cancels and `rgb` may exceed 1. Where all three are equal it is D65 itself.

    Parameters
    ----------
    rgb : (3,) linear sRGB, W·m⁻²·sr⁻¹
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
