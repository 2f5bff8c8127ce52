"""What to choose: seconds to a target by laws fitted to what was measured, and the Pareto front."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace

from photonmap.budget import LEAST_PASSES
from photonmap.study.fit import Cost, Power, fit_cost, fit_power
from photonmap.study.point import Point
from photonmap.study.sweeps import called

BUFFER = "shading"
"""Whose error is aimed at."""

PATH = "path tracing"

_UNKNOWN = (0.0, math.nan)


@dataclass(frozen=True)
class Law:
    """What a method in some bands takes to an error of shading.

    Parameters
    ----------
    label : as in "6 bands" or "path tracing"
    noise : error against passes
    cost : seconds against passes
    most : the most passes measured
    spectral : part of the error that no pass takes away: too few bands; 0 where it is not known
    indirect : relative error of the colour of indirect light, too few bands again; nan likewise
    """

    label: str
    noise: Power
    cost: Cost
    most: int
    spectral: float = 0.0
    indirect: float = math.nan

    def seconds_to(self, target: float) -> Estimate:
        """Return what it takes until noise is down to a target.

        Never less than the passes that a render which aims at an error takes anyway.
        """
        passes = max(math.ceil(self.noise.inverse(target)), LEAST_PASSES)
        return Estimate(self.cost.seconds(passes), passes, passes > self.most)

    def total_after(self, seconds: float) -> float:
        """Return noise and spectral error together after so much time."""
        passes = max((seconds - self.cost.setup) / self.cost.each, 1.0)
        return math.hypot(self.noise.at(passes), self.spectral)


@dataclass(frozen=True)
class Estimate:
    """Seconds and passes to a target; `extrapolated` beyond what was measured."""

    seconds: float
    passes: int
    extrapolated: bool


@dataclass(frozen=True)
class Correction:
    """How stated errors become true ones.

    Parameters
    ----------
    ratio : true over stated
    own_error : of the reference, below which a true error says little
    """

    ratio: float = 1.0
    own_error: float = math.inf

    @classmethod
    def measure(cls, points: Sequence[Point], own_error: float) -> Correction:
        """Take the median ratio of points above the reference's own error; 1 without any."""
        told = cls(1.0, own_error)
        ratios = [
            point.true[BUFFER] / point.stated[BUFFER] for point in points if told.is_told(point)
        ]
        return cls(statistics.median(ratios), own_error) if ratios else told

    def is_told(self, point: Point) -> bool:
        """Tell whether a point's true error is above the reference's own."""
        return point.true.get(BUFFER, 0.0) > self.own_error and point.stated[BUFFER] > 0.0

    def error(self, point: Point) -> float:
        """Return the true error of a point's noise where it is told, or else the corrected one."""
        return point.true[BUFFER] if self.is_told(point) else self.ratio * point.stated[BUFFER]


def laws(points: Sequence[Point], base: str, correction: Correction) -> list[Law]:
    """Return a law for each number of bands, and one for the path tracer.

    That of the base is fitted to all numbers of passes; others are the same law times what their
    processor seconds and errors were of the base's in the sweep of bands.

    Parameters
    ----------
    points : all of them
    base : the bands of the sweeps of passes
    correction : of stated errors, where true ones are not told
    """
    spectral = spectral_errors(points)
    swept = {
        (point.settings.bands, point.settings.passes): point
        for point in points
        if point.sweep == "bands"
    }
    passes = [point for point in points if point.sweep == "passes"]
    equal = [point for (label, _), point in swept.items() if label == base]
    whole = _fit(called(base), passes + equal, correction, spectral.get(base, _UNKNOWN))
    if whole is None:
        return []
    found = []
    for label in sorted({base, *(label for label, _ in swept)}, key=_by_number):
        pairs = [(swept[label, of], swept[base, of]) for of in _common(swept, label, base)]
        found.append(_scaled(whole, called(label), pairs, spectral.get(label, _UNKNOWN)))
    path = [point for point in points if point.sweep == "path"]
    slow = _fit(PATH, path, correction, spectral.get(base, _UNKNOWN))
    return found if slow is None else [*found, slow]


def _common(swept: dict[tuple[str, int], Point], label: str, base: str) -> list[int]:
    """Return the numbers of passes that were measured with both."""
    return [passes for name, passes in swept if name == label and (base, passes) in swept]


def _fit(
    label: str, points: Sequence[Point], correction: Correction, off: tuple[float, float]
) -> Law | None:
    """Fit what points of one kind tell; None from fewer than two numbers of passes."""
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
    """Return the law of other bands from points of equal passes, theirs and the base's."""
    longer, noisier = 1.0, 1.0
    if pairs:
        longer = sum(own.processor for own, _ in pairs) / sum(base.processor for _, base in pairs)
        noisier = statistics.mean(own.stated[BUFFER] / base.stated[BUFFER] for own, base in pairs)
    noise = replace(law.noise, factor=law.noise.factor * noisier)
    cost = Cost(law.cost.setup * longer, law.cost.each * longer)
    return Law(label, noise, cost, law.most, *off)


def spectral_errors(points: Sequence[Point]) -> dict[str, tuple[float, float]]:
    """Return errors of shading and of indirect light by bands, at the most passes measured."""
    found: dict[str, tuple[int, tuple[float, float]]] = {}
    for point in points:
        label, passes = point.settings.bands, point.settings.passes
        if point.color is not None and passes >= found.get(label, (0,))[0]:
            found[label] = passes, (point.color.shading, point.color.indirect)
    return {label: errors for label, (_, errors) in found.items()}


def total_error(
    point: Point, correction: Correction, spectral: dict[str, tuple[float, float]]
) -> float:
    """Return a point's error of shading: noise, and that of its bands."""
    return math.hypot(correction.error(point), spectral.get(point.settings.bands, _UNKNOWN)[0])


def pareto_front(costs: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return the indices of the points that none beats in both, from cheap to exact."""
    order = sorted(range(len(costs)), key=lambda index: (costs[index], errors[index]))
    front: list[int] = []
    for index in order:
        if not front or errors[index] < errors[front[-1]]:
            front.append(index)
    return front


def _by_number(label: str) -> tuple[int, str]:
    return (int(label), "") if label.isdecimal() else (0, label)
