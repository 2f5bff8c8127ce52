"""The scores of methods on a data set, and what they come to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np

from photonmap.evaluate import intervals
from photonmap.evaluate.bench.images import Kind
from photonmap.evaluate.bench.measure import MEAN_LAYER, METRICS, ORDER, Column, Measured, figure
from photonmap.evaluate.metrics.arrays import Floats


@dataclass
class MethodScores:
    """The scores of one method."""

    name: str  # of the method
    measured: dict[str, Measured] = field(default_factory=dict)  # by image
    draws: dict[str, list[dict[Column, float]]] = field(default_factory=dict)
    """scores against a truth with noise added, by image"""
    failures: dict[str, str] = field(default_factory=dict)
    """reasons why images have no estimate, by image"""
    settings: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # by scene
    seconds: dict[str, float] = field(default_factory=dict)  # that the method took, by image

    @property
    def columns(self) -> list[Column]:
        """What at least one image has a score of, in the order of metrics."""
        found = {column for measured in self.measured.values() for column in measured.scores}
        order = list(METRICS)
        return sorted(found, key=lambda c: (order.index(c.metric), ORDER.index(c.layer)))

    def values(self, column: Column, images: list[str]) -> Floats:
        """Return the scores of images, nan where there is none."""
        missing = Measured({}, {})
        scores = [self.measured.get(name, missing).scores.get(column, np.nan) for name in images]
        return np.array(scores, np.float64)

    def drawn(self, column: Column) -> Floats:
        """Return the scores against each draw, (D, K); none unless all images have all of them."""
        images = [name for name, found in self.measured.items() if column in found.scores]
        rows = [[draw.get(column, np.nan) for draw in self.draws.get(name, [])] for name in images]
        complete = all(row and np.isfinite(row).all() for row in rows)
        return np.array(rows).T if complete else np.empty((0, len(images)))


class Summary(NamedTuple):
    """A figure of a method's scores over the images that have one."""

    method: str
    column: Column
    figure: str
    value: float
    over_scenes: intervals.Interval | None  # bootstrap over scenes
    over_truth: intervals.Interval | None  # that the standard errors of the truth leave
    scored: int  # images that have a score
    failed: int
    """images on which the method failed; others have no score as the metric is not defined there"""


class Failure(NamedTuple):
    """An image of which a method has no estimate."""

    method: str
    image: str
    reason: str


class Comparison(NamedTuple):
    """Two methods by the same images."""

    column: Column
    first: str
    second: str
    difference: float  # mean score of the first minus that of the second, over scenes
    p_value: float


@dataclass(repr=False)
class Evaluation:
    """What a run of the bench found.

    Parameters
    ----------
    dataset : name of the data set
    space : in which images were compared
    images, scenes, kinds : names of the images, and the scene and the kind of each
    methods : their scores
    """

    dataset: str
    space: str
    images: list[str]
    scenes: list[str]
    kinds: list[Kind]
    methods: list[MethodScores]

    def __repr__(self) -> str:
        methods = ", ".join(method.name for method in self.methods)
        count = f"{len(self.images)} image{'s' * (len(self.images) != 1)}"
        failed = f"; {len(self.failures)} failed" if self.failed else ""
        return f"<Evaluation of {self.dataset}, {count} in {self.space}: {methods}{failed}>"

    @property
    def failed(self) -> bool:
        """Whether a method failed on an image."""
        return bool(self.failures)

    @property
    def failures(self) -> list[Failure]:
        """The images of which a method has no estimate, and why."""
        return [
            Failure(method.name, image, reason)
            for method in self.methods
            for image, reason in method.failures.items()
        ]

    def summaries(self) -> list[Summary]:
        """Return the figures of all methods and columns; none of methods that failed everywhere."""
        return [
            self._summary(method, column, name)
            for method in self.methods
            for column in method.columns
            for name in METRICS[column.metric].figures
        ]

    def _summary(self, method: MethodScores, column: Column, name: str) -> Summary:
        statistic = figure(name)
        values = method.values(column, self.images)
        known = np.isfinite(values)
        value = statistic(values[known])
        return Summary(
            method.name,
            column,
            name,
            value,
            intervals.scene_interval(intervals.group_by_scene(values, self.scenes), statistic),
            intervals.truth_interval(value, [statistic(draw) for draw in method.drawn(column)]),
            int(known.sum()),
            len(method.failures),
        )

    def comparisons(self) -> list[Comparison]:
        """Compare every two methods by the first metric that both have, by its mean if any."""
        found = []
        for first, second in combinations(self.methods, 2):
            shared = [column for column in first.columns if column in second.columns]
            means = [column for column in shared if column.layer == MEAN_LAYER]
            for column in (means or shared)[:1]:
                one, two = (method.values(column, self.images) for method in (first, second))
                groups = intervals.group_by_scene(one - two, self.scenes)
                if groups:
                    difference = float(np.mean([group.mean() for group in groups]))
                    p_value = intervals.paired_test(one, two, self.scenes)
                    found.append(Comparison(column, first.name, second.name, difference, p_value))
        return found
