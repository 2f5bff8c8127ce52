"""Convergence laws fitted to measured points, seconds to a target, and the Pareto front."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace

from photonmap.film.budget import LEAST_PASSES
from photonmap.study.fit import Cost, Power, fit_cost, fit_power
from photonmap.study.point import Point
from photonmap.study.sweeps import bands_label

BUFFER = "shading"
"""Buffer whose error is the target."""

PATH = "path tracing"

_UNKNOWN = (0.0, math.nan)
"""Spectral errors of shading and of indirect light where they are unknown."""


@dataclass(frozen=True)
class Law:
    """The convergence of a method in some bands, by the error of shading.

    Parameters
    ----------
    label : such as "6 bands" or "path tracing"
    noise : relative error against passes
    cost : seconds against passes
    most : largest number of passes measured
    spectral : relative error due to too few bands, which does not fall with passes; 0 if unknown
    indirect : relative colour error of indirect light due to too few bands; nan if unknown
    """

    label: str
    noise: Power
    cost: Cost
    most: int
    spectral: float = 0.0
    indirect: float = math.nan

    def seconds_to(self, target: float) -> Estimate:
        """Return the seconds and passes until noise has fallen to a target.

        At least the passes that a render to a given error takes in any case.
        """
        passes = max(math.ceil(self.noise.inverse(target)), LEAST_PASSES)
        return Estimate(self.cost.seconds(passes), passes, passes > self.most)

    def total_after(self, seconds: float) -> float:
        """Return the combined noise and spectral error after a number of seconds."""
        passes = max((seconds - self.cost.setup) / self.cost.each, 1.0)
        return math.hypot(self.noise.at(passes), self.spectral)


@dataclass(frozen=True)
class Estimate:
    """Seconds and passes to a target; `extrapolated` if these are more passes than measured."""

    seconds: float
    passes: int
    extrapolated: bool


@dataclass(frozen=True)
class Correction:
    """Correction of stated errors to true errors.

    Parameters
    ----------
    ratio : of true to stated error
    own_error : of the reference, below which a measured true error is not significant
    """

    ratio: float = 1.0
    own_error: float = math.inf

    @classmethod
    def measure(cls, points: Sequence[Point], own_error: float) -> Correction:
        """Take the median ratio over points with a significant true error; 1 if there are none."""
        identity = cls(1.0, own_error)
        ratios = [
            point.true[BUFFER] / point.stated[BUFFER]
            for point in points
            if identity.is_significant(point)
        ]
        return cls(statistics.median(ratios), own_error) if ratios else identity

    def is_significant(self, point: Point) -> bool:
        """Return whether the true error of a point is above the error of the reference."""
        return point.true.get(BUFFER, 0.0) > self.own_error and point.stated[BUFFER] > 0.0

    def error(self, point: Point) -> float:
        """Return the true error of a point if significant, else the corrected stated error."""
        return (
            point.true[BUFFER] if self.is_significant(point) else self.ratio * point.stated[BUFFER]
        )


def laws(points: Sequence[Point], base: str, correction: Correction) -> list[Law]:
    """Return a law for each number of bands, and one for path tracing.

    That of the base is fitted to all numbers of passes. The others are that law, scaled by the
    ratios of processor seconds and of errors to those of the base in the sweep of bands.

    Parameters
    ----------
    points : all measured points
    base : bands of the sweeps of passes
    correction : of stated errors where true errors are not significant
    """
    spectral = spectral_errors(points)
    swept = {
        (point.settings.bands, point.settings.passes): point
        for point in points
        if point.sweep == "bands"
    }
    passes = [point for point in points if point.sweep == "passes"]
    equal = [point for (label, _), point in swept.items() if label == base]
    whole = _fit(bands_label(base), passes + equal, correction, spectral.get(base, _UNKNOWN))
    if whole is None:
        return []
    found = []
    for label in sorted({base, *(label for label, _ in swept)}, key=_by_number):
        pairs = [(swept[label, of], swept[base, of]) for of in _common(swept, label, base)]
        found.append(_scaled(whole, bands_label(label), pairs, spectral.get(label, _UNKNOWN)))
    path = [point for point in points if point.sweep == "path"]
    slow = _fit(PATH, path, correction, spectral.get(base, _UNKNOWN))
    return found if slow is None else [*found, slow]


def _common(swept: dict[tuple[str, int], Point], label: str, base: str) -> list[int]:
    """Return the numbers of passes that were measured with both bands."""
    return [passes for name, passes in swept if name == label and (base, passes) in swept]


def _fit(
    label: str, points: Sequence[Point], correction: Correction, off: tuple[float, float]
) -> Law | None:
    """Fit a law to points of one kind; None for fewer than two numbers of passes."""
    passes = [point.settings.passes for point in points]
    errors = [correction.error(point) for point in points]
    noise = fit_power(passes, errors)
    if noise is None or noise.exponent >= 0.0:
        return None
    cost = fit_cost(passes, [point.seconds for point in points])
    return Law(label, noise, cost, max(passes), *off)


def _scaled(
    law: Law, label: str, pairs: Sequence[tuple[Point, Point]], off: tuple[float, float]
) -> Law:
    """Return the law of other bands, from pairs of points of equal passes: theirs, the base's."""
    longer, noisier = 1.0, 1.0
    if pairs:
        longer = sum(own.processor for own, _ in pairs) / sum(base.processor for _, base in pairs)
        noisier = statistics.mean(own.stated[BUFFER] / base.stated[BUFFER] for own, base in pairs)
    noise = replace(law.noise, factor=law.noise.factor * noisier)
    cost = Cost(law.cost.setup * longer, law.cost.each * longer)
    return Law(label, noise, cost, law.most, *off)


def spectral_errors(points: Sequence[Point]) -> dict[str, tuple[float, float]]:
    """Return spectral errors of shading and indirect light by bands, from the most passes."""
    found: dict[str, tuple[int, tuple[float, float]]] = {}
    for point in points:
        label, passes = point.settings.bands, point.settings.passes
        if point.color is not None and passes >= found.get(label, (0,))[0]:
            found[label] = passes, (point.color.shading, point.color.indirect)
    return {label: errors for label, (_, errors) in found.items()}


def total_error(
    point: Point, correction: Correction, spectral: dict[str, tuple[float, float]]
) -> float:
    """Return the error of shading of a point: noise and spectral error combined."""
    return math.hypot(correction.error(point), spectral.get(point.settings.bands, _UNKNOWN)[0])


def pareto_front(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return the indices of points that no other dominates, from cheap to accurate."""
    order = sorted(range(len(costs)), key=lambda index: (costs[index], errors[index]))
    front: list[int] = []
    for index in order:
        if not front or errors[index] < errors[front[-1]]:
            front.append(index)
    return front


def _by_number(label: str) -> tuple[int, str]:
    return (int(label), "") if label.isdecimal() else (0, label)
