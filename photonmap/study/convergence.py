"""What follows from the points of a study: convergence laws, the Pareto front, recommendations."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from photonmap.film.budget import LEAST_PASSES
from photonmap.study.measure import Point
from photonmap.study.sweeps import bands_label


@dataclass(frozen=True)
class Power:
    """y = factor · x^exponent; `uncertainty` of the exponent is nan for fewer than three points."""

    factor: float
    exponent: float
    uncertainty: float = math.nan

    def at(self, x: float) -> float:
        """Return y at x."""
        return self.factor * x**self.exponent

    def inverse(self, y: float) -> float:
        """Return the x at which the law has the value y."""
        return (y / self.factor) ** (1.0 / self.exponent)


def fit_power(x: Sequence[float], y: Sequence[float]) -> Power | None:
    """Fit a power law by least squares of logarithms; None for fewer than two different x.

    Pairs with a value that is not positive and finite are ignored.
    """
    pairs = [(a, b) for a, b in zip(x, y, strict=True) if 0.0 < a < math.inf and 0.0 < b < math.inf]
    if len({a for a, _ in pairs}) < 2:
        return None
    logs = np.log(pairs)
    away = logs[:, 0] - logs[:, 0].mean()
    spread = float(away @ away)
    exponent = float(away @ logs[:, 1]) / spread
    offset = float(logs[:, 1].mean() - exponent * logs[:, 0].mean())
    rest = logs[:, 1] - offset - exponent * logs[:, 0]
    free = len(pairs) - 2
    uncertainty = math.sqrt(float(rest @ rest) / free / spread) if free else math.nan
    return Power(math.exp(offset), exponent, uncertainty)


@dataclass(frozen=True)
class Cost:
    """seconds = setup + each · passes."""

    setup: float
    each: float

    def seconds(self, passes: float) -> float:
        """Return the seconds of a number of passes."""
        return self.setup + self.each * passes


def fit_cost(passes: Sequence[float], seconds: Sequence[float]) -> Cost:
    """Fit seconds by least squares of relative deviations; neither coefficient is negative."""
    from scipy.optimize import nnls

    took = np.asarray(seconds, np.float64)
    if len(set(passes)) < 2:
        return Cost(0.0, float(np.mean(took / np.asarray(passes))))
    design = np.stack([np.ones(len(took)), passes], axis=1)
    setup, each = nnls(design / took[:, None], np.ones(len(took)))[0]
    return Cost(float(setup), float(each))


BUFFER = "shading"
"""Buffer whose error is the target."""

PATH = "path tracing"

_UNKNOWN = (0.0, math.nan)
"""Spectral errors of shading and of indirect light where they are unknown."""


@dataclass(frozen=True)
class Law:
    """The convergence of a method in some bands, by the error of shading."""

    label: str  # such as "6 bands" or "path tracing"
    noise: Power  # relative error against passes
    cost: Cost  # seconds against passes
    most: int  # largest number of passes measured
    # relative error due to too few bands, which does not fall with passes; 0 if unknown
    spectral: float = 0.0
    # relative colour error of indirect light due to too few bands; nan if unknown
    indirect: float = math.nan

    def seconds_to(self, target: float) -> Estimate:
        """Return seconds and passes, at least `LEAST_PASSES`, until noise is down to a target."""
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

    `ratio` is of true to stated error; `own_error`, of the reference, is that below which a
    measured true error is not significant.
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
        if self.is_significant(point):
            return point.true[BUFFER]
        return self.ratio * point.stated[BUFFER]


def laws(points: Sequence[Point], base: str, correction: Correction) -> list[Law]:
    """Return a law for each number of bands, and one for path tracing.

    That of the base is fitted to all numbers of passes. The others are that law, scaled by the
    ratios of processor seconds and of errors to those of the base in the sweep of bands. `base` is
    the bands of the sweeps of passes.
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
    labels = sorted({base, *(label for label, _ in swept)})
    for label in sorted(labels, key=lambda label: int(label) if label.isdecimal() else 0):
        both = [passes for of, passes in swept if of == label and (base, passes) in swept]
        pairs = [(swept[label, passes], swept[base, passes]) for passes in both]
        found.append(_scaled(whole, bands_label(label), pairs, spectral.get(label, _UNKNOWN)))
    path = [point for point in points if point.sweep == "path"]
    slow = _fit(PATH, path, correction, spectral.get(base, _UNKNOWN))
    return found if slow is None else [*found, slow]


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


Indexed = list[tuple[int, Point]]

_HIDDEN = 0.5  # fraction of the noise below which a change is not significant


@dataclass(frozen=True, eq=False)
class Findings:
    """The points in the order of measurement, which their indices tell apart, and what follows.

    `base` is the bands that sweeps start from; `own_errors` are those of the reference, by buffer.
    """

    points: Sequence[Point]
    base: str
    own_errors: dict[str, float]

    def of(self, sweep: str) -> Indexed:
        """Return the points of a sweep with their indices."""
        return [(i, point) for i, point in enumerate(self.points) if point.sweep == sweep]

    def most_passes(self, sweep: str) -> Indexed:
        """Return the points of a sweep that have the most passes."""
        points = self.of(sweep)
        most = max((point.settings.passes for _, point in points), default=0)
        return [pair for pair in points if pair[1].settings.passes == most]

    @cached_property
    def correction(self) -> Correction:
        """Correction of stated errors to true errors, from the sweep of passes."""
        points = [point for _, point in self.of("passes")]
        return Correction.measure(points, self.own_errors[BUFFER])

    def is_significant(self, point: Point, buffer: str) -> bool:
        """Return whether a true error is above the error of the reference."""
        return point.true.get(buffer, 0.0) > self.own_errors[buffer]

    def slope(self, sweep: str, buffer: str, by_passes: bool = False) -> Power | None:
        """Fit true errors against seconds, or passes, which no program affects; None if few."""
        points = [point for _, point in self.of(sweep) if self.is_significant(point, buffer)]
        costs = [point.settings.passes if by_passes else point.seconds for point in points]
        return fit_power(costs, [point.true[buffer] for point in points])

    @cached_property
    def spectral(self) -> dict[str, tuple[float, float]]:
        """Spectral errors of shading and of indirect light, by bands."""
        return spectral_errors(self.points)

    @cached_property
    def laws(self) -> list[Law]:
        """Convergence laws by bands; that of path tracing is the last."""
        return laws(self.points, self.base, self.correction)

    @property
    def laws_of_bands(self) -> list[Law]:
        """Convergence laws of photon mapping."""
        return [law for law in self.laws if law.label != PATH]

    @property
    def candidates(self) -> Indexed:
        """Points that may be on the Pareto front: photon mapping at full size."""
        return self.of("passes") + self.of("bands")

    def total_error(self, point: Point) -> float:
        """Return the error of shading of a point: noise and spectral error combined."""
        return total_error(point, self.correction, self.spectral)

    @cached_property
    def front(self) -> Indexed:
        """The candidates that no other dominates in seconds and error."""
        points = self.candidates
        seconds = [point.seconds for _, point in points]
        errors = [self.total_error(point) for _, point in points]
        return [points[place] for place in pareto_front(seconds, errors)]

    @property
    def bias(self) -> Point | None:
        """The longest run of path tracing, whose mean shows the bias of photon mapping."""
        points = [point for _, point in self.of("path")]
        return max(points, key=lambda point: point.settings.passes, default=None)


def change_beyond_noise(point: Point, buffer: str = "radiance") -> float | None:
    """Return the true error of a choice beyond its noise; None if it is not significant."""
    noise = point.stated[buffer]
    square = point.true[buffer] ** 2 - noise**2
    return math.sqrt(square) if square > (_HIDDEN * noise) ** 2 else None


TARGETS = (0.05, 0.02, 0.01, 0.005)
HEADLINE = 0.01
"""Target error of shading that is described at length."""

_CHEAPER = 0.97  # largest fraction of the base's time at which fewer bands are worth mentioning
_FINER = 1 / 3
"""Largest fraction of the base's colour error at which more bands are worth mentioning."""
_STEPS = 400  # times, logarithmically spaced, at which the best number of bands is evaluated


def recommend(laws: Sequence[Law], base: str, targets: Sequence[float] = TARGETS) -> list[str]:
    """Return sentences on the time to each error: with the base's bands, others, path tracing."""
    found = {law.label: law for law in laws}
    if bands_label(base) not in found:
        return []
    first = _whole(found, bands_label(base), HEADLINE)
    rest = [_short(found, bands_label(base), target) for target in targets if target != HEADLINE]
    bands = [law for law in laws if law.label != PATH]
    return [first, *rest, *(text for text in (_limits(bands), _best(bands)) if text)]


def duration(seconds: float) -> str:
    """Return a time to two digits, in seconds, minutes or hours."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{two_digits(seconds / size)} {unit}"
    return f"{two_digits(seconds)} s"


def percent(part: float) -> str:
    """Return a fraction to two digits, as a percentage."""
    return f"{two_digits(100.0 * part)}%"


def two_digits(value: float) -> str:
    """Return a number to two significant digits, without an exponent."""
    if abs(value) >= 9.95 or value == 0.0 or not math.isfinite(value):
        return f"{value:.0f}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}"


def estimated_time(estimate: Estimate) -> str:
    """Return the time of an estimate, marked if it lies beyond the measured range."""
    return duration(estimate.seconds) + " (extrapolated)" * estimate.extrapolated


def _short(laws: dict[str, Law], base: str, target: float) -> str:
    """Return the time to a target with the base's bands, and by path tracing."""
    took = laws[base].seconds_to(target)
    path = f"; {_path_time(laws, target)}" if PATH in laws else ""
    return f"{100 * target:g}% error in {BUFFER}: {estimated_time(took)} with {base}{path}."


def _path_time(laws: dict[str, Law], target: float) -> str:
    return f"{PATH}: {estimated_time(laws[PATH].seconds_to(target))}"


def _whole(laws: dict[str, Law], base: str, target: float) -> str:
    """Return the same, and what fewer and more bands would change."""
    law, took = laws[base], laws[base].seconds_to(target)
    parts = [f"{100 * target:g}% error in {BUFFER}: {estimated_time(took)} with {base}{_off(law)}"]
    others = [other for name, other in laws.items() if name not in (base, PATH)]
    ratios = {other.label: other.seconds_to(target).seconds / took.seconds for other in others}
    cheaper = [other for other in others if ratios[other.label] < _CHEAPER]
    finer = [other for other in others if other.indirect < _FINER * law.indirect]
    if cheaper:
        least = min(cheaper, key=lambda other: ratios[other.label])
        parts.append(f"{ratios[least.label]:.0%} of that time with {least.label}{_off(least, law)}")
    if finer:
        best = min(finer, key=lambda other: ratios[other.label])
        if best not in cheaper:
            ratio = f"{ratios[best.label]:.2g} times the time"
            parts.append(f"{ratio} with {best.label}{_off(best, law)}")
    if PATH in laws:
        parts.append(_path_time(laws, target))
    return "; ".join(parts) + "."


def _off(law: Law, base: Law | None = None) -> str:
    """Return the colour error of indirect light, if it is known."""
    if math.isnan(law.indirect):
        return ""
    link = "but " if base and law.indirect > base.indirect else ""
    return f", {link}{percent(law.indirect)} colour error in indirect light"


def _limits(bands: Sequence[Law]) -> str:
    """Return the errors that more time does not reduce."""
    short = [f"{percent(law.spectral)} with {law.label}" for law in bands if law.spectral > 0.0]
    never = f"However long the render, the colour error of {BUFFER} never falls below "
    return f"{never}{', '.join(short)}." if short else ""


def _best(bands: Sequence[Law]) -> str:
    """Return which bands have the smallest error, noise and colour combined, for a given time."""
    if len(bands) < 2:
        return ""
    first = min(law.cost.seconds(LEAST_PASSES) for law in bands)
    last = max(law.seconds_to(TARGETS[-1]).seconds for law in bands)
    times = np.geomspace(first, last, _STEPS)
    best = [min(bands, key=lambda law: law.total_after(float(t))).label for t in times]
    turns = [0, *(i for i in range(1, len(best)) if best[i] != best[i - 1])]
    spans = [
        f"from {duration(float(times[turn]))} on with {best[turn]}" if turn else f"with {best[0]}"
        for turn in turns
    ]
    return f"Noise and colour error of {BUFFER} combined are smallest {', '.join(spans)}."
