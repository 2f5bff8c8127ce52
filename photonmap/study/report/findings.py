"""What follows from the points of a study: laws, correction, Pareto front, bias."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from photonmap.study.fit import Power, fit_power
from photonmap.study.point import Point
from photonmap.study.report.convergence import (
    BUFFER,
    PATH,
    Correction,
    Law,
    laws,
    pareto_front,
    spectral_errors,
    total_error,
)
from photonmap.study.sweeps import bands_label

Indexed = list[tuple[int, Point]]

_HIDDEN = 0.5  # fraction of the noise below which a change is not significant


@dataclass(frozen=True, eq=False)
class Findings:
    """The points in the order of measurement, and what follows from them.

    Parameters
    ----------
    points : all measured points; they are identified by their index
    base : bands that the sweeps start from
    own_errors : errors of the reference itself, by buffer
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

    def slope(self, sweep: str, buffer: str) -> Power | None:
        """Fit true errors of a sweep against seconds; None for too few points."""
        points = [point for _, point in self.of(sweep) if self.is_significant(point, buffer)]
        return fit_power([p.seconds for p in points], [p.true[buffer] for p in points])

    def slope_by_passes(self, sweep: str, buffer: str) -> Power | None:
        """Fit true errors of a sweep against passes, which other programs do not affect."""
        points = [point for _, point in self.of(sweep) if self.is_significant(point, buffer)]
        return fit_power([p.settings.passes for p in points], [p.true[buffer] for p in points])

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

    @cached_property
    def front(self) -> Indexed:
        """The candidates that no other dominates in seconds and error."""
        points = self.candidates
        seconds = [point.seconds for _, point in points]
        errors = [total_error(point, self.correction, self.spectral) for _, point in points]
        return [points[place] for place in pareto_front(seconds, errors)]

    def label_of(self, point: Point) -> str:
        """Return the label of the law of a point's bands."""
        return bands_label(point.settings.bands)

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
