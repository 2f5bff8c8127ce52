"""What the page shows of estimates: the best and the worst, and where metrics disagree."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from photonmap.evaluate.bench.measure import Column, Measured, true_layer
from photonmap.evaluate.bench.truth import Truth
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.evaluate.report.disagreements import Disagreements, Rated
from photonmap.evaluate.report.pictures import layer_picture, picture


class Case(NamedTuple):
    """An image on which a method does best, or worst."""

    image: str
    column: Column
    score: float
    radiance: str
    """as a data URI, as are all pictures"""
    layers: list[tuple[str, ...]]
    """name, picture of the truth, picture of the estimate"""


@dataclass
class Gallery:
    """Keeps the best and the worst case of each method, and where metrics disagree on two.

    Cases go by the first metric's mean over layers, or its only layer.

    Parameters
    ----------
    cases : by method, then "best" and "worst"
    disagreements : of LMSE and DSSIM
    """

    cases: dict[str, dict[str, Case]] = field(default_factory=dict)
    disagreements: Disagreements = field(default_factory=Disagreements)

    def keep(
        self, truth: Truth, method: str, layers: Mapping[str, Floats], measured: Measured
    ) -> None:
        """Keep an estimate if it is the best or the worst of its method so far."""
        if not measured.scores:
            return
        self.disagreements.keep(truth, Rated(method, layers, measured.scores))
        kept = self.cases.setdefault(method, {})
        column = kept["best"].column if kept else _headline(measured)
        if column not in measured.scores:
            return
        score = measured.scores[column]
        for title, beats in (("best", operator.lt), ("worst", operator.gt)):
            if title not in kept or beats(score, kept[title].score):
                kept[title] = _case(truth, layers, column, score)


def _headline(measured: Measured) -> Column:
    """Return the last column of the first metric: the mean over layers if there is one."""
    first = next(iter(measured.scores)).metric
    return [column for column in measured.scores if column.metric == first][-1]


def _case(truth: Truth, layers: Mapping[str, Floats], column: Column, score: float) -> Case:
    """Draw the pictures of an estimate."""
    pictures = [
        (layer, *(layer_picture(truth, layer, v) for v in (true_layer(truth, layer), values)))
        for layer, values in layers.items()
    ]
    return Case(truth.name, column, score, picture(truth, truth.radiance), pictures)
