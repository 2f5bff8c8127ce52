"""Colour differences after interreflection in N bands and projection to sRGB: CIE ΔE2000.

Exact colours are ∫ matching · e r₁ r₂ dλ over 380 to 780 nm, where curves that cover less keep
their outer values; estimates are E R₁ R₂ in the bands, times a 3 × N matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.sensors.interreflection import (
    FINE,
    band_values,
    check_sensitivities,
    trapezoid_weights,
)
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_difference import lab_difference, lab_of_xyz
from photonmap.spectra.curves import VISIBLE, Spectrum, SpectrumSet, check_covers, resample
from photonmap.spectra.observer import observer
from photonmap.spectra.projection import direct_projection, fit_projection

Floats = NDArray[np.float64]

METHODS = ("direct", "regression")
MOST = 200
"""Largest number of reflectances tested in all ordered pairs: 40 000 of them."""


@dataclass(frozen=True)
class ColorRow:
    """Colour differences after some bounces and a projection, over a set of reflectances.

    Parameters
    ----------
    bands : as the user specified them: "6", "box:6"
    count : N
    bounces : 1 or 2
    method : of projection to sRGB, one of `METHODS`
    mean, p95, worst : ΔE2000; p95 is the 95th percentile
    """

    bands: str
    count: int
    bounces: int
    method: str
    mean: float
    p95: float
    worst: float


class Colors(NamedTuple):
    """Exact colours to compare with.

    Parameters
    ----------
    taught : reflectances that a regression is fitted to
    tested : C others
    illuminant : e
    white : (3,) XYZ of the illuminant
    labs : for 1 bounce (C, 3) and for 2 bounces (C · C, 3) CIE Lab relative to that white
    """

    taught: SpectrumSet
    tested: SpectrumSet
    illuminant: Spectrum
    white: Floats
    labs: tuple[Floats, Floats]


def color_errors(
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    bands: Bands,
    label: str | None = None,
    most_bounces: int = 2,
) -> list[ColorRow]:
    """Measure ΔE2000 after 1 and 2 bounces, for both methods of projection.

    The regression is fitted to reflectances 1, 3, 5 …; up to 200 of the others are tested, in all
    ordered pairs.

    Parameters
    ----------
    reflectances : curves; a single one is both fitted to and tested
    illuminant : e, any unit
    bands : N sensitivities
    label : name of the bands in the result; N if None
    most_bounces : 1, for one bounce alone, or more

    Raises
    ------
    InputError : a curve covers less than the bands or 400 to 700 nm
    """
    exact = exact_colors(reflectances, illuminant)
    rows = []
    for method in METHODS:
        matrix = projection_matrix(exact, bands, method)
        for bounces in range(1, min(most_bounces, 2) + 1):
            off = differences(exact, bands, matrix, bounces)
            summary = float(off.mean()), float(np.percentile(off, 95.0)), float(off.max())
            rows.append(ColorRow(label or str(bands.count), bands.count, bounces, method, *summary))
    return rows


def exact_colors(reflectances: SpectrumSet, illuminant: Spectrum, most: int = MOST) -> Colors:
    """Split the reflectances into taught and tested, and return exact colours of the latter.

    Parameters
    ----------
    most : largest number of tested reflectances
    """
    check_covers(reflectances.wavelengths, *VISIBLE)
    illuminant.check_covers(*VISIBLE)
    every = np.arange(len(reflectances))
    odd = every[1::2] if len(every) > 1 else every
    odd = odd[np.linspace(0, len(odd) - 1, min(most, len(odd))).astype(int)]
    taught, tested = _subset(reflectances, every[::2]), _subset(reflectances, odd)
    eye = observer()
    weights = trapezoid_weights(eye.wavelengths) * illuminant(eye.wavelengths)
    matching = eye.rgb_to_xyz @ eye.matching * weights
    curves = resample(eye.wavelengths, tested.wavelengths, tested.values)
    one = curves @ matching.T
    two = np.stack([curves * row @ curves.T for row in matching], axis=-1).reshape(-1, 3)
    white = matching.sum(axis=1)
    return Colors(
        taught, tested, illuminant, white, (lab_of_xyz(one, white), lab_of_xyz(two, white))
    )


def projection_matrix(exact: Colors, bands: Bands, method: str) -> Floats:
    """Return the matrix, (3, N), from band radiances to linear sRGB, by one of `METHODS`."""
    check_sensitivities(bands)
    if method == "direct":
        return direct_projection(bands, "rgb").matrix
    return fit_projection(bands, "rgb", exact.taught, [exact.illuminant]).matrix


def differences(exact: Colors, bands: Bands, matrix: Floats, bounces: int) -> Floats:
    """Return ΔE2000 between the estimates and the exact colours: (C,) for 1 bounce, else (C · C,).

    Parameters
    ----------
    exact : C reflectances and their colours
    bands : N sensitivities
    matrix : (3, N), linear sRGB from band radiances
    bounces : 1 or 2
    """
    reflected, light = band_values(bands, exact.tested, exact.illuminant, FINE)
    estimate = reflected * light
    if bounces == 2:
        estimate = (estimate[:, None] * reflected).reshape(-1, len(light))
    lab = lab_of_xyz(estimate @ (observer().rgb_to_xyz @ matrix).T, exact.white)
    return lab_difference(exact.labs[bounces - 1], lab)


def _subset(curves: SpectrumSet, chosen: NDArray[np.int64]) -> SpectrumSet:
    """Return some curves of a set."""
    names = tuple(curves.names[index] for index in chosen)
    return SpectrumSet(curves.wavelengths, curves.values[chosen], names)
