"""What the page shows of estimates: the best and the worst, and where LMSE and DSSIM disagree.

Beigpour et al. 2013 close with the complaint that estimates that look worse may have a lower LMSE.
Which one looks worse is for the reader to see; but of degraded truths it is known which is worse.
"""

from __future__ import annotations

import heapq
import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from photonmap.evaluate.bench.images import Truth
from photonmap.evaluate.bench.measure import (
    BOTH,
    ILLUMINANT,
    MEAN_LAYER,
    Column,
    Measured,
    true_layer,
)
from photonmap.evaluate.metrics.arrays import Floats, to_grey
from photonmap.report.pages import png_uri
from photonmap.results.preview import as_bytes

_WIDTH = 160  # Largest width of a picture, pixels
_SHOWN_AS = 0.8  # Linear value that pictures give to a shading or radiance of 1
_PATCH = 24  # Side of the patch that shows one illuminant, pixels


def layer_picture(truth: Truth, layer: str, values: Floats) -> str:
    """Return the picture of a layer; of an illuminant, its colour."""
    if layer != ILLUMINANT:
        return picture(truth, values, 1.0 if layer == "reflectance" else _SHOWN_AS)
    light = values if values.ndim == 1 else values[truth.mask].sum(axis=0)
    color = np.broadcast_to(light / np.abs(light).max(), (_PATCH, _PATCH, len(light)))
    return _as_uri(color, 1.0)


def picture(truth: Truth, values: Floats, exposure: float = _SHOWN_AS) -> str:
    """Return the valid pixels of an image, made smaller by leaving out lines and columns."""
    step = -(-truth.mask.shape[1] // _WIDTH)
    shown = np.where(truth.mask[..., None], values, 0.0)[::step, ::step]
    return _as_uri(shown, exposure)


def _as_uri(values: Floats, exposure: float) -> str:
    """Return linear RGB as a PNG in a data URI; other numbers of bands are shown in grey."""
    if values.shape[-1] != 3:
        values = np.repeat(to_grey(values)[..., None], 3, axis=-1)
    return png_uri(as_bytes(values, exposure))


LMSE, DSSIM = Column("lmse-color", MEAN_LAYER), Column("dssim", MEAN_LAYER)
_SHOWN = 4  # Cases on the page, of each kind


class Rated(NamedTuple):
    """An estimate and its scores."""

    name: str
    layers: Mapping[str, Floats]
    scores: Mapping[Column, float]

    @property
    def both(self) -> tuple[float, float] | None:
        """LMSE and DSSIM, if both are positive."""
        found = (self.scores.get(LMSE, 0.0), self.scores.get(DSSIM, 0.0))
        return found if min(found) > 0.0 else None


class Side(NamedTuple):
    """One of two estimates as it is shown."""

    name: str
    lmse: float
    dssim: float
    layers: list[tuple[str, str]]  # name and picture as a data URI


class Disagreement(NamedTuple):
    """Two estimates of an image that two metrics rank differently."""

    strength: float  # product of the logarithms of both ratios of scores
    image: str
    radiance: str  # as a data URI
    layers: list[tuple[str, str]]  # of the truth
    by_lmse: Side  # what LMSE prefers
    by_dssim: Side


@dataclass
class Cases:
    """Pairs of estimates, and where metrics disagree on them most."""

    ordered: bool  # the second of a pair is known to be worse
    pairs: int = 0  # that were compared
    differing: int = 0
    """those of them that LMSE and DSSIM rank differently; if ordered, LMSE wrongly"""
    opposite: int = 0  # if ordered, those that DSSIM ranks wrongly and LMSE rightly
    shown: list[Disagreement] = field(default_factory=list)
    """the strongest, at most one of an image"""

    def percent(self, count: int) -> str:
        """Return a share of the pairs."""
        return f"{100.0 * count / self.pairs:.3g}%"

    def add(self, truth: Truth, first: Rated, second: Rated) -> None:
        """Compare two estimates of an image."""
        if first.both is None or second.both is None:
            return
        self.pairs += 1
        lmse, dssim = (math.log(b / a) for a, b in zip(first.both, second.both, strict=True))
        strength = -lmse * dssim
        if strength <= 0.0:
            return
        if self.ordered and dssim < 0.0:
            self.opposite += 1
            return
        self.differing += 1
        if strength > self._bar(truth.name):
            others = [each for each in self.shown if each.image != truth.name]
            others.append(_drawn(truth, first, second, strength))
            self.shown = heapq.nlargest(_SHOWN, others, key=lambda each: each.strength)

    def _bar(self, image: str) -> float:
        """Return the strength that a case of an image must exceed to be shown."""
        held = [each.strength for each in self.shown if each.image == image]
        full = len(self.shown) == _SHOWN
        return held[0] if held else min(each.strength for each in self.shown) if full else 0.0


@dataclass
class Disagreements:
    """Collects them among methods, and among degradations of which the worse one is known."""

    methods: Cases = field(default_factory=lambda: Cases(ordered=False))
    """any two methods on the same image"""
    known: Cases = field(default_factory=lambda: Cases(ordered=True))
    """of two estimates, one is known to be worse"""
    _truth: Truth | None = None
    _rated: list[Rated] = field(default_factory=list)

    def keep(self, truth: Truth, rated: Rated) -> None:
        """Compare an estimate with those of the same image that were kept before."""
        if self._truth is not truth:
            self._truth, self._rated = truth, []
        for before in self._rated:
            self.methods.add(truth, before, rated)
        self._rated.append(rated)

    def keep_known(self, truth: Truth, worse: Sequence[Rated]) -> None:
        """Compare estimates that are known to get worse, each with the next."""
        for first, second in pairwise(worse):
            self.known.add(truth, first, second)


def _drawn(truth: Truth, first: Rated, second: Rated, strength: float) -> Disagreement:
    """Draw two estimates."""
    by_lmse, by_dssim = sorted((first, second), key=lambda each: each.scores[LMSE])
    true = {layer: true_layer(truth, layer) for layer in BOTH}
    return Disagreement(
        strength,
        truth.name,
        picture(truth, truth.radiance),
        _pictures(truth, true),
        _side(truth, by_lmse),
        _side(truth, by_dssim),
    )


def _side(truth: Truth, rated: Rated) -> Side:
    pictures = _pictures(truth, rated.layers)
    return Side(rated.name, rated.scores[LMSE], rated.scores[DSSIM], pictures)


def _pictures(truth: Truth, layers: Mapping[str, Floats]) -> list[tuple[str, str]]:
    return [(layer, layer_picture(truth, layer, layers[layer])) for layer in BOTH]


class Case(NamedTuple):
    """An image on which a method does best, or worst."""

    image: str
    column: Column
    score: float
    radiance: str  # as a data URI, as are all pictures
    layers: list[tuple[str, ...]]  # name, picture of the truth, picture of the estimate


@dataclass
class Gallery:
    """Keeps the best and the worst case of each method, and where metrics disagree on two.

    Cases go by the first metric's mean over layers, or its only layer.
    """

    cases: dict[str, dict[str, Case]] = field(default_factory=dict)
    """by method, then "best" and "worst" """
    disagreements: Disagreements = field(default_factory=Disagreements)  # of LMSE and DSSIM

    def keep(
        self, truth: Truth, method: str, layers: Mapping[str, Floats], measured: Measured
    ) -> None:
        """Keep an estimate if it is the best or the worst of its method so far."""
        if not measured.scores:
            return
        self.disagreements.keep(truth, Rated(method, layers, measured.scores))
        kept = self.cases.setdefault(method, {})
        first = next(iter(measured.scores)).metric
        of_first = [column for column in measured.scores if column.metric == first]
        column = kept["best"].column if kept else of_first[-1]  # the mean over layers comes last
        if column not in measured.scores:
            return
        score = measured.scores[column]
        for title, beats in (("best", operator.lt), ("worst", operator.gt)):
            if title not in kept or beats(score, kept[title].score):
                pictures = [
                    (
                        name,
                        *(layer_picture(truth, name, v) for v in (true_layer(truth, name), made)),
                    )
                    for name, made in layers.items()
                ]
                seen = picture(truth, truth.radiance)
                kept[title] = Case(truth.name, column, score, seen, pictures)
