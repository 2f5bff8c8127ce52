"""Sets of bands compared: those given, and the best Gaussians, by their widths and distances.

The error within the bands alone does not identify a good σ. It goes to 0 as σ does, since at a
single wavelength the product of values is the value of the product; but bands that narrow miss
most of the visible light. So σ and spacing are rated by the mean ΔE2000 after two bounces and a
projection to sRGB by regression.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.sensors.interreflection import (
    DARK,
    FINE,
    STEP,
    ErrorRow,
    band_values,
    check_sensitivities,
    interreflection_errors,
    trapezoid_weights,
)
from photonmap.spectra.bands import Bands
from photonmap.spectra.color_difference import lab_difference, lab_of_xyz
from photonmap.spectra.curves import VISIBLE, Spectrum, SpectrumSet, check_covers, resample
from photonmap.spectra.observer import observer
from photonmap.spectra.projection import direct_projection, fit_projection
from photonmap.spectra.sensitivities import spread_gaussians

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


@dataclass(frozen=True)
class Comparison:
    """Errors of sets of bands, in the order of the sets.

    Parameters
    ----------
    by_bounce : after each number of bounces
    direct_and_indirect : of both together, after 2 bounces; none of a study of one bounce
    colors : ΔE2000, after up to 2 bounces
    """

    by_bounce: list[ErrorRow] = field(default_factory=list)
    direct_and_indirect: list[ErrorRow] = field(default_factory=list)
    colors: list[ColorRow] = field(default_factory=list)


def compare_bands(
    bands: Mapping[str, Bands],
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    bounces: int,
    dark: float = DARK,
    step: float = STEP,
) -> Comparison:
    """Measure the errors of sets of bands.

    Parameters
    ----------
    bands : by the name under which results list them
    reflectances, illuminant : see `interreflection_errors`
    bounces : the largest number of them
    dark : fraction of the light below which a pair of reflectances is left out
    step : distance between samples of the curves, nm

    Raises
    ------
    InputError : a curve does not cover the bands
    """
    found = Comparison()
    for label, sensors in bands.items():
        errors_after = partial(
            interreflection_errors, reflectances, illuminant, sensors,
            dark=dark, label=label, step=step,
        )  # fmt: skip
        found.by_bounce.extend(errors_after(count) for count in range(1, bounces + 1))
        if bounces >= 2:
            found.direct_and_indirect.append(errors_after(2, direct_too=True))
        found.colors.extend(color_errors(reflectances, illuminant, sensors, label, bounces))
    return found


COUNTS = (*range(1, 13), 16, 24, 31)
WIDTHS = (0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0)
SPREADS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)

_TESTED = 60
"""Reflectances of which all pairs are tested."""
_REFINEMENTS = 3


@dataclass(frozen=True)
class BestRow:
    """The errors of N Gaussian bands.

    Parameters
    ----------
    count : N
    one, two : mean errors after 1 and 2 bounces where σ is a quarter of the bin, 1
    usual : mean ΔE2000 with this σ, after 2 bounces and regression
    width, width_delta : the best σ over the bin, and its ΔE2000
    spread, spread_delta : with that σ, the best distance of the centres from the middle of the
        range over their usual one, and its ΔE2000; a single band stays in the middle
    """

    count: int
    one: float
    two: float
    usual: float
    width: float
    width_delta: float
    spread: float
    spread_delta: float


def best_bands(
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    limits: tuple[float, float] = VISIBLE,
    dark: float = DARK,
    step: float = STEP,
    counts: Sequence[int] = COUNTS,
) -> Iterator[BestRow]:
    """Yield one row for each number of bands.

    Parameters
    ----------
    reflectances, illuminant : as for `interreflection_errors` and `color_errors`
    limits : the range that the bands divide, nm
    dark, step : as for `interreflection_errors`
    counts : numbers of bands
    """
    exact = exact_colors(reflectances, illuminant, _TESTED)
    for count in counts:
        usual = Bands.gaussian(count, *limits)
        one, two = (
            interreflection_errors(reflectances, illuminant, usual, bounces, dark, step=step).mean
            for bounces in (1, 2)
        )
        width, width_delta, spread, spread_delta = _search(exact, count, limits)
        yield BestRow(
            count, one, two, _delta(exact, usual), width, width_delta, spread, spread_delta
        )


def spread_bands(count: int, limits: tuple[float, float], width: float, spread: float) -> Bands:
    """Return the bands of `photonmap.spectra.sensitivities.spread_gaussians`."""
    return Bands.sensors(spread_gaussians(count, *limits, width, spread), limits=limits)


def _search(
    exact: Colors, count: int, limits: tuple[float, float]
) -> tuple[float, float, float, float]:
    """Return the best width and its ΔE2000, then the best spread and its ΔE2000."""
    size = (limits[1] - limits[0]) / count
    width, width_delta = _least(
        lambda width: _delta(exact, Bands.gaussian(count, *limits, width * size)), WIDTHS
    )
    if count == 1:
        return width, width_delta, 1.0, width_delta
    widest = count / (count - 1.0)  # the outer centres are the range's ends
    spread, spread_delta = _least(
        lambda spread: _delta(exact, spread_bands(count, limits, width, spread)),
        [*(spread for spread in SPREADS if spread < widest), widest],
    )
    return width, width_delta, spread, spread_delta


def _delta(exact: Colors, bands: Bands) -> float:
    """Return the mean ΔE2000 after 2 bounces and regression."""
    matrix = projection_matrix(exact, bands, "regression")
    return float(differences(exact, bands, matrix, 2).mean())


def _least(score: Callable[[float], float], grid: Sequence[float]) -> tuple[float, float]:
    """Return where the score is least, and that score: on a grid, then on finer ones around it."""
    known = {value: score(value) for value in grid}
    for _ in range(_REFINEMENTS):
        tried = sorted(known)
        best = tried.index(min(tried, key=known.__getitem__))
        ends = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
        for value in np.linspace(*ends, 5).tolist():
            if value not in known:
                known[value] = score(value)
    found = min(known, key=known.__getitem__)
    return found, known[found]
