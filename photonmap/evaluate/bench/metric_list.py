"""The metrics of the bench by name: what they are measured on, and by which figures they go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.bench.truth import Truth
from photonmap.evaluate.intervals import Statistic, mean
from photonmap.evaluate.metrics.albedo import (
    albedo_chromaticity,
    albedo_intensity,
    albedo_texture,
)
from photonmap.evaluate.metrics.angular import (
    angular_error,
    angular_error_map,
    summarise_angles,
)
from photonmap.evaluate.metrics.arrays import Floats, to_grey
from photonmap.evaluate.metrics.color import delta_e
from photonmap.evaluate.metrics.lmse import lmse, lmse_mit
from photonmap.evaluate.metrics.sintel import dssim, si_lmse, si_mse
from photonmap.evaluate.metrics.whdr import OrdinalPairs, ordinal_pairs, whdr
from photonmap.runtime.options import read_list
from photonmap.runtime.wording import suggest

REFLECTANCE, SHADING, ILLUMINANT = "reflectance", "shading", "illuminant"
BOTH = (REFLECTANCE, SHADING)
LAYERS = (*BOTH, ILLUMINANT)
MEAN_LAYER = "mean"
"""The mean over reflectance and shading, where a metric is measured on both."""
ORDER = (*BOTH, MEAN_LAYER, ILLUMINANT)
"""The order in which scores of a metric are listed."""

Measure = Callable[[Truth, Floats, Floats], float]
"""From a ground truth, its layer that is meant, and an estimate of that layer, to an error."""


@dataclass(frozen=True)
class Metric:
    """A metric of the bench; less is better.

    Parameters
    ----------
    name : on the command line and in tables
    meaning : a few words, with the source
    layers : that it is measured on
    measure : measures it
    needs_rgb : it is defined for linear sRGB alone
    figures : by which it is summed up over images
    """

    name: str
    meaning: str
    layers: tuple[str, ...]
    measure: Measure
    needs_rgb: bool = False
    figures: tuple[str, ...] = ("mean",)


@lru_cache(maxsize=2)
def _pairs(mask_bytes: bytes, shape: tuple[int, int]) -> OrdinalPairs:
    """Return the pairs that WHDR compares in a mask."""
    return ordinal_pairs(np.frombuffer(mask_bytes, bool).reshape(shape))


def _whdr(truth: Truth, true: Floats, made: Floats) -> float:
    pairs = _pairs(truth.mask.tobytes(), truth.mask.shape)
    return whdr(true, made, truth.mask, pairs)


def _angle(truth: Truth, true: Floats, made: Floats) -> float:
    one = made if made.ndim == 1 else made[truth.mask].sum(axis=0)
    return angular_error(true[truth.mask].sum(axis=0), one)


_ANGULAR = ("mean", "median", "trimean", "best", "worst")
_ROWS = (
    Metric(
        "lmse", "LMSE of grey values, windows of 20 px; Grosse et al. 2009", BOTH,
        lambda truth, true, made: lmse(to_grey(true), to_grey(made), truth.mask),
    ),
    Metric(
        "lmse-color", "LMSE with one factor a window for all bands", BOTH,
        lambda truth, true, made: lmse(true, made, truth.mask),
    ),
    Metric(
        "lmse-mit", "LMSE of grey values as in the code of Grosse et al., which divides by less",
        BOTH, lambda truth, true, made: lmse_mit(to_grey(true), to_grey(made), truth.mask),
    ),
    Metric(
        "si-mse", "scale-invariant MSE; Chen and Koltun 2013", BOTH,
        lambda truth, true, made: si_mse(true, made, truth.mask),
    ),
    Metric(
        "si-lmse", "mean of si-MSE over windows of a tenth of the image; Chen and Koltun 2013",
        BOTH, lambda truth, true, made: si_lmse(true, made, truth.mask),
    ),
    Metric(
        "dssim", "(1 − SSIM) / 2; Chen and Koltun 2013", BOTH,
        lambda truth, true, made: dssim(true, made, truth.mask),
    ),
    Metric("whdr", "WHDR for δ = 10%, pairs ordered by the truth; Bell et al. 2014",
           (REFLECTANCE,), _whdr),
    Metric(
        "albedo-intensity", "squared error of mean grey values of materials; Wu et al. 2023",
        (REFLECTANCE,),
        lambda truth, true, made: albedo_intensity(true, made, truth.regions, truth.mask),
    ),
    Metric(
        "albedo-chromaticity", "ΔE2000 of mean colours of materials; Wu et al. 2023",
        (REFLECTANCE,),
        lambda truth, true, made: albedo_chromaticity(true, made, truth.regions, truth.mask),
        needs_rgb=True,
    ),
    Metric(
        "albedo-texture", "RMS difference of relative texture within materials", (REFLECTANCE,),
        lambda truth, true, made: albedo_texture(true, made, truth.regions, truth.mask),
    ),
    Metric(
        "delta-e", "mean ΔE2000 after one factor; Sharma et al. 2005", (REFLECTANCE,),
        lambda truth, true, made: delta_e(true, made, truth.mask), needs_rgb=True,
    ),
    Metric("angle", "angle between the illuminant and that of all light, degrees",
           (ILLUMINANT,), _angle, figures=_ANGULAR),
    Metric(
        "angle-map", "mean angle to the illuminant of each pixel, degrees", (ILLUMINANT,),
        lambda truth, true, made: mean(angular_error_map(true, made, truth.mask)),
        figures=_ANGULAR,
    ),
)  # fmt: skip
METRICS = {metric.name: metric for metric in _ROWS}


def figure(name: str) -> Statistic:
    """Return what computes a figure of scores (K,) by its name."""
    if name == "mean":
        return mean
    return lambda scores: float(getattr(summarise_angles(scores), name))


def choose_metrics(names: str | Sequence[str] | None, space: str) -> list[Metric]:
    """Return metrics by name, or all that are defined in a space.

    Raises
    ------
    InputError : there is no such metric, or it is not defined in bands
    """
    if names is None:
        return [metric for metric in _ROWS if space == "rgb" or not metric.needs_rgb]
    names = read_list(names)
    for name in names:
        if name not in METRICS:
            raise InputError(f"there is no metric {name!r}; {suggest(name, METRICS)}")
        if space != "rgb" and METRICS[name].needs_rgb:
            raise InputError(f"{name} is defined in RGB alone; leave it out or take the space rgb")
    return [METRICS[name] for name in dict.fromkeys(names)]
