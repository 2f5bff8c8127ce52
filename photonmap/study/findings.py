"""What follows from the points of a study: laws, corrections, the front, what effects cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from photonmap.study.fit import Power, fit_power
from photonmap.study.point import Point
from photonmap.study.recommend import (
    BUFFER,
    PATH,
    Correction,
    Law,
    laws,
    pareto_front,
    spectral_errors,
    total_error,
)
from photonmap.study.sweeps import called

Indexed = list[tuple[int, Point]]

_HIDDEN = 0.5  # of the noise, below which a change is not told from it


@dataclass(frozen=True, eq=False)
class Findings:
    """The points in the order measured, and what the reference is off by itself.

    Parameters
    ----------
    points : all of them; their index is what they are known by
    base : the bands from which sweeps start
    own_errors : of the reference, by buffer
    """

    points: Sequence[Point]
    base: str
    own_errors: dict[str, float]

    def of(self, sweep: str) -> Indexed:
        """Return the points of a sweep with their indices."""
        return [(i, point) for i, point in enumerate(self.points) if point.sweep == sweep]

    def most_passes(self, sweep: str) -> Indexed:
        """Return the points of a sweep that have the most passes, from few to many bands."""
        points = self.of(sweep)
        most = max((point.settings.passes for _, point in points), default=0)
        return [pair for pair in points if pair[1].settings.passes == most]

    @cached_property
    def correction(self) -> Correction:
        """How stated errors become true ones."""
        points = [point for _, point in self.of("passes")]
        return Correction.measure(points, self.own_errors[BUFFER])

    def is_told(self, point: Point, buffer: str) -> bool:
        """Tell whether a true error stands out of the reference's own."""
        return point.true.get(buffer, 0.0) > self.own_errors[buffer]

    def slope(self, sweep: str, buffer: str) -> Power | None:
        """Fit true errors of a sweep against seconds; None from too few points."""
        told = [point for _, point in self.of(sweep) if self.is_told(point, buffer)]
        return fit_power([p.seconds for p in told], [p.true[buffer] for p in told])

    def slope_by_passes(self, sweep: str, buffer: str) -> Power | None:
        """Fit true errors of a sweep against passes, which no other program disturbs."""
        told = [point for _, point in self.of(sweep) if self.is_told(point, buffer)]
        return fit_power([p.settings.passes for p in told], [p.true[buffer] for p in told])

    @cached_property
    def spectral(self) -> dict[str, tuple[float, float]]:
        """Errors of shading and indirect light by bands."""
        return spectral_errors(self.points)

    @cached_property
    def laws(self) -> list[Law]:
        """What noise takes, by bands; the path tracer's is the last."""
        return laws(self.points, self.base, self.correction)

    @property
    def laws_of_bands(self) -> list[Law]:
        """Those of photon mapping."""
        return [law for law in self.laws if law.label != PATH]

    @property
    def candidates(self) -> Indexed:
        """Points that may stand on the front: photon mapping, the whole image, known colours."""
        return self.of("passes") + self.of("bands")

    @cached_property
    def front(self) -> Indexed:
        """The candidates that none beats in seconds and error."""
        points = self.candidates
        seconds = [point.seconds for _, point in points]
        errors = [total_error(point, self.correction, self.spectral) for _, point in points]
        return [points[place] for place in pareto_front(seconds, errors)]

    def label_of(self, point: Point) -> str:
        """Return what the law of a point's bands is called."""
        return called(point.settings.bands)

    @property
    def bias(self) -> Point | None:
        """The path tracer's longest run, which tells what photon mapping's mean is off by."""
        points = [point for _, point in self.of("path")]
        return max(points, key=lambda point: point.settings.passes, default=None)


def beyond_noise(point: Point, buffer: str = "radiance") -> float | None:
    """Return what a choice changes: the true error without the noise; None where noise hides it."""
    noise = point.stated[buffer]
    square = point.true[buffer] ** 2 - noise**2
    return math.sqrt(square) if square > (_HIDDEN * noise) ** 2 else None
