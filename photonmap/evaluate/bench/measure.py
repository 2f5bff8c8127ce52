"""Check an estimate, bring it to the scale of the truth, and measure it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.evaluate.bench.metric_list import BOTH, LAYERS, MEAN_LAYER, REFLECTANCE, Metric
from photonmap.evaluate.bench.truth import Truth
from photonmap.evaluate.methods.method import Estimate
from photonmap.evaluate.metrics.arrays import Floats, least_squares_factor, paired, real
from photonmap.runtime.wording import shown


class Column(NamedTuple):
    """What a score is of."""

    metric: str
    layer: str
    """one of `photonmap.evaluate.bench.metric_list.ORDER`"""


@dataclass
class Measured:
    """The scores of one estimate.

    Parameters
    ----------
    scores : by column
    undefined : reasons why a metric is not defined for this image, by column
    """

    scores: dict[Column, float]
    undefined: dict[Column, str]


def checked(estimate: Estimate, truth: Truth) -> dict[str, Floats]:
    """Return the layers of an estimate by name, scaled to the truth by least squares.

    Raises
    ------
    InputError : it has no layer, or one of another size, with values that are not finite, or with
        negative ones on the whole, which a factor below 0 would turn round
    """
    if not isinstance(estimate, Estimate):
        raise InputError(
            f"the method returns {shown(estimate)}; return a photonmap.evaluate.Estimate"
        )
    layers = {}
    for name in LAYERS:
        layer = getattr(estimate, name)
        if layer is None:
            continue
        with naming(name):
            layers[name] = _checked_layer(real(layer, "the estimate"), truth, name)
    if not layers:
        raise InputError("the estimate has neither reflectance nor shading nor illuminant")
    return layers


def _checked_layer(layer: Floats, truth: Truth, name: str) -> Floats:
    true = true_layer(truth, name)
    if name in BOTH:
        pair = paired(true, layer, truth.mask)
        factor = least_squares_factor(pair.truth, pair.estimate)
        if factor < 0.0:
            raise InputError(
                "the estimate is negative where the truth is brightest; give linear values, not "
                "logarithms"
            )
        return pair.estimate * factor
    if layer.ndim == 1:
        if layer.shape != true.shape[2:] or not np.isfinite(layer).all() or not layer.any():
            raise InputError(f"{layer} is no colour of light in {true.shape[2]} bands")
        return layer
    return paired(true, layer, truth.mask).estimate


def true_layer(truth: Truth, name: str) -> Floats:
    """Return a layer of the truth; the illuminant is the shading, whatever its brightness."""
    return truth.reflectance if name == REFLECTANCE else truth.shading


def measure(layers: dict[str, Floats], truth: Truth, metrics: Sequence[Metric]) -> Measured:
    """Measure the layers of an estimate, as `checked` returns them, by all metrics that apply."""
    found = Measured({}, {})
    for metric in metrics:
        columns = [Column(metric.name, layer) for layer in metric.layers if layer in layers]
        for column in columns:
            true, made = true_layer(truth, column.layer), layers[column.layer]
            try:
                found.scores[column] = metric.measure(truth, true, made)
            except InputError as error:
                found.undefined[column] = str(error)
        scores = [found.scores[column] for column in columns if column in found.scores]
        if metric.layers == BOTH and len(scores) == len(BOTH):
            found.scores[Column(metric.name, MEAN_LAYER)] = sum(scores) / len(BOTH)
    return found
