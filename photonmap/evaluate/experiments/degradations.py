"""Estimates that are known to get worse step by step, and which metrics notice.

The ground truth of an image is degraded in four ways, each by growing amounts, so that the order of
the results is known without asking anyone:

- blur: reflectance and shading are Gaussian means with σ = 1, 2, 4 and 8 pixels
- bleed: a share of the log shading is moved to reflectance, 10, 20, 40 and 80%
- tint: reflectance gets a colour cast and shading loses it, factors 1.1, 1.2, 1.4 and 1.8 between
  the first and the last band
- wrong scale: materials have wrong brightness, by random factors with a standard deviation of
  0.1, 0.2, 0.4 and 0.8 in logarithm, and shading is the image over that

and combined: one of them at amount 4 alone, then with 2 of another on top, then with 8 of it. An
estimate that has all the faults of another, and one more, is worse.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from photonmap.evaluate.bench.images import Truth
from photonmap.evaluate.bench.measure import (
    ILLUMINANT,
    MEAN_LAYER,
    Column,
    Metric,
    checked,
    measure,
)
from photonmap.evaluate.methods.method import FLOOR, Estimate
from photonmap.evaluate.metrics.arrays import Floats, blurred_within, to_grey
from photonmap.evaluate.report.gallery import Rated
from photonmap.evaluate.report.tables import Cell, Table

Layers = tuple[Floats, Floats]  # Reflectance and shading, (H, W, C) each

AMOUNTS = (1, 2, 4, 8)  # Relative amounts of each degradation
COMBINED = "combined"
_BELOW, _ON_TOP = 4, (2, 8)
"""Amounts of the first of two degradations, and of the second."""


def _blur(truth: Truth, layers: Layers, amount: float) -> Layers:
    reflectance, shading = (blurred_within(layer, truth.mask, amount) for layer in layers)
    return reflectance, shading


def _wrong_scale(truth: Truth, layers: Layers, amount: float) -> Layers:
    numbers, region = np.unique(truth.regions, return_inverse=True)
    logs = np.random.Generator(np.random.PCG64(0)).standard_normal(len(numbers))
    return _moved(layers, np.exp(0.1 * amount * logs)[region].reshape(*truth.regions.shape, 1))


def _moved(layers: Layers, factor: Floats) -> Layers:
    """Move a factor from shading to reflectance."""
    return layers[0] * factor, layers[1] / factor


DEGRADATIONS: dict[str, Callable[[Truth, Layers, float], Layers]] = {
    "blur": _blur,
    "bleed": lambda truth, layers, amount: _moved(
        layers, np.maximum(to_grey(truth.shading), FLOOR)[..., None] ** (0.1 * amount)
    ),
    "tint": lambda truth, layers, amount: _moved(
        layers, np.linspace(1.0 + 0.1 * amount, 1.0, truth.shading.shape[2])
    ),
    "wrong scale": _wrong_scale,
}
"""From a truth, layers and an amount to layers with that fault. The factors that it moves are those
of the truth, so that a fault on top of another takes nothing back."""


_COLUMNS = (*DEGRADATIONS, COMBINED)


class OrderTest:
    """Counts how often metrics of decompositions order degradations rightly.

    `watch` is called with estimates of a truth that are known to get worse, in this order.
    """

    def __init__(
        self,
        metrics: Sequence[Metric],
        watch: Callable[[Truth, Sequence[Rated]], None] = lambda truth, worse: None,
    ) -> None:
        self._watch = watch
        self._metrics = [metric for metric in metrics if metric.layers != (ILLUMINANT,)]
        self._right: dict[tuple[str, str], list[float]] = {}

    def add(self, truth: Truth) -> None:
        """Degrade an image and measure it by all metrics."""
        for name, degrade in DEGRADATIONS.items():
            perfect = truth.reflectance, truth.shading
            worse = {f"{name} {amount}": degrade(truth, perfect, amount) for amount in AMOUNTS}
            self._measure(name, truth, {"truth": perfect, **worse})
            below = degrade(truth, perfect, _BELOW)
            for other, again in DEGRADATIONS.items():
                if other != name:
                    first = f"{name} {_BELOW}"
                    both = {f"{first}, {other} {top}": again(truth, below, top) for top in _ON_TOP}
                    self._measure(COMBINED, truth, {first: below, **both})

    def _measure(self, name: str, truth: Truth, estimates: Mapping[str, Layers]) -> None:
        """Measure estimates that get worse by all metrics."""
        rated = []
        for what, estimate in estimates.items():
            layers = checked(Estimate(*estimate), truth)
            rated.append(Rated(what, layers, measure(layers, truth, self._metrics).scores))
        self._watch(truth, rated)
        found = [each.scores for each in rated]
        for metric in self._metrics:
            mean, only = Column(metric.name, MEAN_LAYER), Column(metric.name, metric.layers[0])
            values = [scores.get(mean, scores.get(only, np.nan)) for scores in found]
            if np.isfinite(values).all():
                self._right.setdefault((metric.name, name), []).append(rightly(values))

    def table(self) -> Table | None:
        """Return the share of orders that are right, by metric and degradation."""
        if not self._right:
            return None
        rows = []
        for metric in self._metrics:
            shares = [self._right.get((metric.name, name), []) for name in _COLUMNS]
            if all(shares):
                means = [float(np.mean(share)) for share in shares]
                rows.append((metric.name, [*map(Cell, means), Cell(min(means))]))
        return Table(
            "degradations",
            "Which metric orders degradations rightly",
            "The truth was degraded in four ways by growing amounts, and in every two of them, one "
            "on top of the other. Figures are shares of steps to a worse estimate for which the "
            "metric rises by more than 1e-6 of its value; the last is the least of them.",
            ["metric", *_COLUMNS, "least"],
            rows,
            _verdict(rows),
        )


def rightly(values: Sequence[float]) -> float:
    """Return the share of steps of rising values that do rise."""
    array = np.asarray(values, np.float64)
    steps: Floats = np.diff(array)
    return float((steps > np.maximum(1e-6 * np.abs(array[1:]), 1e-12)).mean())


def _verdict(rows: Sequence[tuple[str, Sequence[Cell]]]) -> list[str]:
    """Return which metrics miss a degradation, and which come out best."""
    said = []
    for column, name in enumerate(_COLUMNS):
        blind = [metric for metric, cells in rows if (cells[column].value or 0.0) < 0.5]
        if blind:
            said.append(
                f"{name.capitalize()} is missed more often than seen by {', '.join(blind)}."
            )
    best = max(cells[-1].value or 0.0 for _, cells in rows)
    winners = [metric for metric, cells in rows if cells[-1].value == best]
    said.append(f"Best in its worst case: {', '.join(winners)}, with {100 * best:.3g}% right.")
    return said
