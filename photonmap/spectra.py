"""Spectra and colours: curves over wavelength, and linear sRGB turned into such curves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A curve over wavelength: linear between its samples, constant beyond the outer ones.

    Equal by value; the arrays are read-only copies.

    Parameters
    ----------
    wavelengths : (M,) float64, nm, strictly increasing, M ≥ 2
    values : (M,) float64, in the unit of what is described: 1, or W·m⁻²·sr⁻¹

    Raises
    ------
    InputError
        if the two are not such arrays, or the wavelengths look like another unit
    """

    wavelengths: Floats
    values: Floats

    def __post_init__(self) -> None:
        """Copy the array-likes, check them and make them read-only."""
        for attribute in ("wavelengths", "values"):
            try:
                array = np.array(getattr(self, attribute), dtype=np.float64) + 0.0  # no -0.0
            except (TypeError, ValueError):
                raise InputError(f"a spectrum's {attribute} must be a row of numbers") from None
            object.__setattr__(self, attribute, array)
            array.setflags(write=False)
        _check_samples(self.wavelengths, self.values)
        _check_unit(self.wavelengths)

    def __call__(self, wavelengths: Floats) -> Floats:
        """Return the curve's values at `wavelengths` (nm), in their shape."""
        return np.interp(wavelengths, self.wavelengths, self.values)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Spectrum):
            return NotImplemented
        return np.array_equal(self.wavelengths, other.wavelengths) and np.array_equal(
            self.values, other.values
        )

    def __hash__(self) -> int:
        return hash((self.wavelengths.tobytes(), self.values.tobytes()))


Color = float | tuple[float, float, float] | Spectrum
"""A number is a constant spectrum, a triple is linear sRGB, a `Spectrum` is itself."""


def _check_samples(wavelengths: Floats, values: Floats) -> None:
    """Raise `InputError` unless the samples define a curve."""
    if wavelengths.ndim != 1 or wavelengths.shape != values.shape:
        raise InputError(
            "a spectrum needs one row of wavelengths and as many values; "
            f"got shapes {wavelengths.shape} and {values.shape}"
        )
    if len(wavelengths) < 2:
        raise InputError("a spectrum needs at least 2 samples; for a constant one give a number")
    if not (np.isfinite(wavelengths).all() and np.isfinite(values).all()):
        raise InputError("a spectrum's wavelengths and values must be finite")
    falls = np.flatnonzero(np.diff(wavelengths) <= 0)
    if falls.size:
        before, after = wavelengths[falls[0] : falls[0] + 2]
        raise InputError(
            f"wavelengths must increase, but {after:g} follows {before:g}; "
            "sort the samples and keep one for each wavelength"
        )


def _check_unit(wavelengths: Floats) -> None:
    """Raise `InputError` if wavelengths cannot be nanometres of light."""
    first, last = wavelengths[0], wavelengths[-1]
    units = (
        (last < 1e-3, "metres", "multiply by 1e9"),
        (last < 100.0, "micrometres", "multiply by 1000"),
        (first > 3000.0, "ångströms", "divide by 10"),
    )
    for found, unit, remedy in units:
        if found:
            raise InputError(
                f"wavelengths must be in nm; {first:g} to {last:g} look like {unit}: {remedy}"
            )


class Observer(NamedTuple):
    """What turns spectra into linear sRGB and back, in steps of 1 nm.

    Parameters
    ----------
    wavelengths : (M,) float64, nm
    matching : (3, M) float64, nm⁻¹; ∫ radiance × matching dλ = linear sRGB, where Y is
        normalised by ∫ȳ
    d65 : (M,) float64, the illuminant, scaled so that its linear sRGB is (1, 1, 1)
    basis : (3, M) float64 in [0, 1], the reflectances of red, green and blue; they add up to 1,
        and each returns to its own RGB under D65
    """

    wavelengths: Floats
    matching: Floats
    d65: Floats
    basis: Floats


# Chromaticities (x, y, 1 − x − y) of the red, green and blue primaries in columns, IEC 61966-2-1.
_PRIMARIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])


@cache
def observer() -> Observer:
    """Return the CIE 1931 2° observer, D65 and the basis, read once from `data/observer.csv`."""
    file = Path(__file__).with_name("data") / "observer.csv"
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
    xyz = xyz / np.trapezoid(xyz[1], wavelengths)
    white = integrate_products(wavelengths, xyz, wavelengths, d65[None])
    white, d65 = white / white[1], d65 / white[1]
    rgb_to_xyz = _PRIMARIES * np.linalg.solve(_PRIMARIES, white).T
    return Observer(wavelengths, np.linalg.solve(rgb_to_xyz, xyz), d65, basis)


def resample(at: Floats, wavelengths: Floats, curves: Floats) -> Floats:
    """Return piecewise-linear `curves` (C, K) over `wavelengths` (K,) at `at` (M,): (C, M)."""
    return np.array([np.interp(at, wavelengths, curve) for curve in curves])


def _merge(a: Floats, b: Floats) -> Floats:
    """Return the values of both, increasing; `np.union1d` takes 8 ms when first called."""
    both = np.sort(np.concatenate([a, b]))
    return both[np.append(True, np.diff(both) > 0.0)]


def integrate_products(
    wavelengths: Floats, weights: Floats, nodes: Floats, curves: Floats
) -> Floats:
    """Integrate each weight times each curve over the weights' range.

    Both are linear between their samples, the curves constant beyond the outer ones. On the
    merged grid their product is quadratic, and Simpson's rule is exact.

    Parameters
    ----------
    wavelengths : (M,) nm
    weights : (W, M)
    nodes : (K,) nm
    curves : (C, K)

    Returns
    -------
    (W, C) float64
    """
    inside = nodes[(nodes > wavelengths[0]) & (nodes < wavelengths[-1])]
    grid = _merge(wavelengths, inside)
    f = resample(grid, wavelengths, weights)
    g = resample(grid, nodes, curves)
    f0, f1 = f[:, :-1] * np.diff(grid) / 6.0, f[:, 1:] * np.diff(grid) / 6.0
    g0, g1 = g[:, :-1], g[:, 1:]
    return f0 @ (2.0 * g0 + g1).T + f1 @ (g0 + 2.0 * g1).T


def radiance_to_rgb(spectrum: Spectrum) -> Floats:
    """Project a radiance onto linear sRGB: (3,) float64, negative where out of gamut."""
    eye, curve = observer(), spectrum.values[None]
    return integrate_products(eye.wavelengths, eye.matching, spectrum.wavelengths, curve)[:, 0]


def reflectance_to_rgb(spectrum: Spectrum) -> Floats:
    """Return the linear sRGB of a reflectance under D65: (3,) float64, not clipped."""
    eye = observer()
    grid = _merge(eye.wavelengths, spectrum.wavelengths)
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
    return Spectrum(eye.wavelengths, np.asarray(rgb) @ eye.basis)


def upsample_emission(rgb: ArrayLike) -> Spectrum:
    """Return a smooth radiance of this colour: that of the surface `rgb` under D65.

    With c = max(rgb) it is c × `upsample_reflectance`(rgb / c) × D65; as the basis is linear,
    c cancels and `rgb` may exceed 1. Where all three are equal it is D65 itself.

    Parameters
    ----------
    rgb : (3,) linear sRGB, W·m⁻²·sr⁻¹
    """
    eye = observer()
    return Spectrum(eye.wavelengths, np.asarray(rgb) @ eye.basis * eye.d65)
