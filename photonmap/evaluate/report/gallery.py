"""The pictures of the page: small, in sRGB, and part of it."""

from __future__ import annotations

import base64
import operator
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from photonmap.evaluate.bench.measure import Column, Measured, true_layer
from photonmap.evaluate.bench.metric_list import ILLUMINANT
from photonmap.evaluate.bench.truth import Truth
from photonmap.evaluate.metrics.arrays import Floats, to_grey
from photonmap.io.png import encode_png
from photonmap.results.preview import as_bytes

_WIDTH = 160
"""Largest width of a picture, pixels."""
_SHOWN_AS = 0.8
"""Linear value that pictures give to a shading or radiance of 1."""
_PATCH = 24
"""Side of the patch that shows one illuminant, pixels."""


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
    """Keeps the best and the worst case of each method.

    They go by the first metric's mean over layers, or its only layer.

    Parameters
    ----------
    cases : by method, then "best" and "worst"
    """

    cases: dict[str, dict[str, Case]] = field(default_factory=dict)

    def keep(
        self, truth: Truth, method: str, layers: Mapping[str, Floats], measured: Measured
    ) -> None:
        """Keep an estimate if it is the best or the worst of its method so far."""
        if not measured.scores:
            return
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
        (layer, *(_layer_picture(truth, layer, v) for v in (true_layer(truth, layer), values)))
        for layer, values in layers.items()
    ]
    return Case(truth.name, column, score, _picture(truth, truth.radiance), pictures)


def _layer_picture(truth: Truth, layer: str, values: Floats) -> str:
    """Return the picture of a layer; of an illuminant, its colour."""
    if layer != ILLUMINANT:
        return _picture(truth, values, 1.0 if layer == "reflectance" else _SHOWN_AS)
    light = values if values.ndim == 1 else values[truth.mask].sum(axis=0)
    color = np.broadcast_to(light / np.abs(light).max(), (_PATCH, _PATCH, len(light)))
    return _as_uri(color, 1.0)


def _picture(truth: Truth, values: Floats, exposure: float = _SHOWN_AS) -> str:
    """Return the valid pixels of an image, made smaller by leaving out lines and columns."""
    step = -(-truth.mask.shape[1] // _WIDTH)
    shown = np.where(truth.mask[..., None], values, 0.0)[::step, ::step]
    return _as_uri(shown, exposure)


def _as_uri(values: Floats, exposure: float) -> str:
    """Return linear RGB as a PNG in a data URI; other numbers of bands are shown in grey."""
    if values.shape[-1] != 3:
        values = np.repeat(to_grey(values)[..., None], 3, axis=-1)
    png = encode_png(as_bytes(values, exposure))
    return "data:image/png;base64," + base64.b64encode(png).decode()
