"""The metrics of the bench by name, and how an estimate is checked, scaled and measured by them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.evaluate.bench.images import Truth
from photonmap.evaluate.intervals import Statistic, mean
from photonmap.evaluate.methods.method import Estimate
from photonmap.evaluate.metrics import angular, reflectance, scaled
from photonmap.evaluate.metrics.arrays import Floats, least_squares_factor, paired, real, to_grey
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import shown, suggest

REFLECTANCE, SHADING, ILLUMINANT = "reflectance", "shading", "illuminant"
BOTH = (REFLECTANCE, SHADING)
LAYERS = (*BOTH, ILLUMINANT)
MEAN_LAYER = "mean"  # The mean over reflectance and shading, where a metric is measured on both
ORDER = (*BOTH, MEAN_LAYER, ILLUMINANT)  # The order in which scores of a metric are listed

Measure = Callable[[Truth, Floats, Floats], float]
"""From a ground truth, its layer that is meant, and an estimate of that layer, to an error."""


@dataclass(frozen=True)
class Metric:
    """A metric of the bench; less is better."""

    name: str  # on the command line and in tables
    meaning: str  # a few words, with the source
    layers: tuple[str, ...]  # that it is measured on
    measure: Measure  # measures it
    needs_rgb: bool = False  # it is defined for linear sRGB alone
    figures: tuple[str, ...] = ("mean",)  # by which it is summed up over images


@lru_cache(maxsize=2)
def _pairs(mask_bytes: bytes, shape: tuple[int, int]) -> reflectance.OrdinalPairs:
    """Return the pairs that WHDR compares in a mask."""
    return reflectance.ordinal_pairs(np.frombuffer(mask_bytes, bool).reshape(shape))


def _of_layers(error: Callable[..., float]) -> Measure:
    """Return the measure of an error of two images."""
    return lambda truth, true, made: error(true, made, truth.mask)


def _of_grey(error: Callable[..., float]) -> Measure:
    """Return the measure of an error of the means over bands of two images."""
    return lambda truth, true, made: error(to_grey(true), to_grey(made), truth.mask)


def _of_regions(error: Callable[..., float]) -> Measure:
    """Return the measure of an error over regions."""
    return lambda truth, true, made: error(true, made, truth.regions, truth.mask)


def _whdr(truth: Truth, true: Floats, made: Floats) -> float:
    pairs = _pairs(truth.mask.tobytes(), truth.mask.shape)
    return reflectance.whdr(true, made, truth.mask, pairs)


def _angle(truth: Truth, true: Floats, made: Floats) -> float:
    one = made if made.ndim == 1 else made[truth.mask].sum(axis=0)
    return angular.angular_error(true[truth.mask].sum(axis=0), one)


_ANGULAR = ("mean", "median", "trimean", "best", "worst")
_PAINT, _LIGHT = (REFLECTANCE,), (ILLUMINANT,)
_ROWS = (
    Metric("lmse", "LMSE of grey values, windows of 20 px; Grosse et al. 2009", BOTH,
           _of_grey(scaled.lmse)),
    Metric("lmse-color", "LMSE with one factor a window for all bands", BOTH,
           _of_layers(scaled.lmse)),
    Metric("lmse-mit",
           "LMSE of grey values as in the code of Grosse et al., which divides by less", BOTH,
           _of_grey(scaled.lmse_mit)),
    Metric("si-mse", "scale-invariant MSE; Chen and Koltun 2013", BOTH, _of_layers(scaled.si_mse)),
    Metric("si-lmse",
           "mean of si-MSE over windows of a tenth of the image; Chen and Koltun 2013", BOTH,
           _of_layers(scaled.si_lmse)),
    Metric("dssim", "(1 − SSIM) / 2; Chen and Koltun 2013", BOTH, _of_layers(scaled.dssim)),
    Metric("whdr", "WHDR for δ = 10%, pairs ordered by the truth; Bell et al. 2014", _PAINT,
           _whdr),
    Metric("albedo-intensity", "squared error of mean grey values of materials; Wu et al. 2023",
           _PAINT, _of_regions(reflectance.albedo_intensity)),
    Metric("albedo-chromaticity", "ΔE2000 of mean colours of materials; Wu et al. 2023", _PAINT,
           _of_regions(reflectance.albedo_chromaticity), needs_rgb=True),
    Metric("albedo-texture", "RMS difference of relative texture within materials", _PAINT,
           _of_regions(reflectance.albedo_texture)),
    Metric("delta-e", "mean ΔE2000 after one factor; Sharma et al. 2005", _PAINT,
           _of_layers(reflectance.delta_e), needs_rgb=True),
    Metric("angle", "angle between the illuminant and that of all light, degrees", _LIGHT,
           _angle, figures=_ANGULAR),
    Metric("angle-map", "mean angle to the illuminant of each pixel, degrees", _LIGHT,
           _of_layers(lambda *layers: mean(angular.angular_error_map(*layers))), figures=_ANGULAR),
)  # fmt: skip
METRICS = {metric.name: metric for metric in _ROWS}


def figure(name: str) -> Statistic:
    """Return what computes a figure of scores (K,) by its name."""
    if name == "mean":
        return mean
    return partial(angular.angular_figure, name)


def choose_metrics(names: str | Sequence[str] | None, space: str) -> list[Metric]:
    """Return metrics by name, or all that are defined in a space; `InputError` for any other."""
    if names is None:
        return [metric for metric in _ROWS if space == "rgb" or not metric.needs_rgb]
    names = read_list(names)
    for name in names:
        if name not in METRICS:
            raise InputError(f"there is no metric {name!r}; {suggest(name, METRICS)}")
        if space != "rgb" and METRICS[name].needs_rgb:
            raise InputError(f"{name} is defined in RGB only; leave it out or use the space rgb")
    return [METRICS[name] for name in dict.fromkeys(names)]


class Column(NamedTuple):
    """What a score is of."""

    metric: str
    layer: str  # one of `ORDER`


@dataclass
class Measured:
    """The scores of one estimate."""

    scores: dict[Column, float]  # by column
    undefined: dict[Column, str]  # reasons why a metric is not defined for this image, by column


def checked(estimate: Estimate, truth: Truth) -> dict[str, Floats]:
    """Return the layers of an estimate by name, scaled to the truth by least squares.

    An `InputError` says that it has no layer, or one of another size, with values that are not
    finite, or with negative ones on the whole, which a factor below 0 would turn round.
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
            raise InputError(f"{layer} is not a colour of light in {true.shape[2]} bands")
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
