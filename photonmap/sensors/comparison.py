"""Sets of bands compared: those given, and the best Gaussians, by their widths and distances.

The error within the bands alone does not identify a good σ. It goes to 0 as σ does, since at a
single wavelength the product of values is the value of the product; but bands that narrow miss
most of the visible light. So σ and spacing are rated by the mean ΔE2000 after two bounces and a
projection to sRGB by regression.

Exact colours are ∫ matching · e r₁ r₂ dλ over 380 to 780 nm, where curves that cover less keep
their outer values; estimates are E R₁ R₂ in the bands, times a 3 × N matrix.
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
    """Colour differences after some bounces and a projection, over a set of reflectances."""

    bands: str  # as the user specified them: "6", "box:6"
    count: int  # N
    bounces: int  # 1 or 2
    method: str  # of projection to sRGB, one of `METHODS`
    mean: float  # ΔE2000; p95 is the 95th percentile
    p95: float
    worst: float


class Colors(NamedTuple):
    """Exact colours to compare with."""

    taught: SpectrumSet  # reflectances that a regression is fitted to
    tested: SpectrumSet  # C others
    illuminant: Spectrum  # e
    white: Floats  # (3,) XYZ of the illuminant
    # for 1 bounce (C, 3) and for 2 bounces (C · C, 3) CIE Lab relative to that white
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
    ordered pairs. A single one is both fitted to and tested. `label` names the bands in the
    result, N if None; `most_bounces` of 1 is for one bounce alone.
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
    """Split reflectances into taught and tested, at `most`; return exact colours of the latter."""
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
    labs = lab_of_xyz(one, white), lab_of_xyz(two, white)
    return Colors(taught, tested, illuminant, white, labs)


def projection_matrix(exact: Colors, bands: Bands, method: str) -> Floats:
    """Return the matrix, (3, N), from band radiances to linear sRGB, by one of `METHODS`."""
    check_sensitivities(bands)
    if method == "direct":
        return direct_projection(bands, "rgb").matrix
    return fit_projection(bands, "rgb", exact.taught, [exact.illuminant]).matrix


def differences(exact: Colors, bands: Bands, matrix: Floats, bounces: int) -> Floats:
    """Return ΔE2000 of what a matrix (3, N) makes of bands and exact colours: (C,) or (C · C,)."""
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
    """Errors of sets of bands, in the order of the sets."""

    by_bounce: list[ErrorRow] = field(default_factory=list)  # after each number of bounces
    # of both together, after 2 bounces; none of a study of one bounce
    direct_and_indirect: list[ErrorRow] = field(default_factory=list)
    colors: list[ColorRow] = field(default_factory=list)  # ΔE2000, after up to 2 bounces


def compare_bands(
    bands: Mapping[str, Bands],
    reflectances: SpectrumSet,
    illuminant: Spectrum,
    bounces: int,
    dark: float = DARK,
    step: float = STEP,
) -> Comparison:
    """Measure the errors of sets of bands, by the names under which results list them.

    `bounces` is the largest number of them; the rest is as in `interreflection_errors`.
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

_TESTED = 60  # reflectances of which all pairs are tested
_REFINEMENTS = 3


@dataclass(frozen=True)
class BestRow:
    """The errors of N Gaussian bands."""

    count: int  # N
    one: float  # mean errors after 1 and 2 bounces where σ is a quarter of the bin, 1
    two: float
    usual: float  # mean ΔE2000 with this σ, after 2 bounces and regression
    width: float  # the best σ over the bin, and its ΔE2000
    width_delta: float
    # with that σ, the best distance of the centres from the middle of the range over their usual
    # one, and its ΔE2000; a single band stays in the middle
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
    """Yield a row for each number of bands that divide `limits`, nm; see `color_errors`."""
    exact = exact_colors(reflectances, illuminant, _TESTED)
    for count in counts:
        usual = Bands.gaussian(count, *limits)
        one, two = (
            interreflection_errors(reflectances, illuminant, usual, bounces, dark, step=step).mean
            for bounces in (1, 2)
        )
        yield BestRow(count, one, two, _delta(exact, usual), *_search(exact, count, limits))


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
