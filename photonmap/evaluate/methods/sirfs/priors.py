"""The priors of SIRFS, as `learn` finds them, and colours in the units they are for."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from photonmap.evaluate.metrics.arrays import Floats

FILE = "priors.json"


@dataclass(frozen=True)
class Priors:
    """What is likely.

    Parameters
    ----------
    edges : (16,) weights of the mixture of differences of reflectance, in units of `edge_spread`
    bends : (16,) weights of the mixture of differences of mean curvature
    edge_spread : standard deviations of differences of log reflectance: brightness, deviations
    reflectance : mean and standard deviation of brightness, and standard deviation of deviations
    light : (9,) mean of coefficients, mean over bands
    light_precision : (9, 9) inverse of their covariance
    light_deviation : (9,) standard deviation of bands from their mean
    """

    edges: list[float]
    bends: list[float]
    edge_spread: list[float]
    reflectance: list[float]
    light: list[float]
    light_precision: list[list[float]]
    light_deviation: list[float]


def load_priors() -> Priors:
    """Return the priors that the package comes with."""
    text = files("photonmap.evaluate.methods.sirfs").joinpath(FILE).read_text(encoding="utf-8")
    return Priors(**json.loads(text))


def as_json(priors: Priors) -> str:
    """Return priors as text."""
    return json.dumps({name: _rounded(value) for name, value in asdict(priors).items()}, indent=1)


def _rounded(value: Any) -> Any:
    return [_rounded(v) for v in value] if isinstance(value, list) else float(f"{value:.6g}")


def whitened(colors: Floats, spread: Any) -> Floats:
    """Return (…, C) with brightness over one standard deviation and deviations over another.

    The map is linear and its own transpose.
    """
    mean = colors.mean(axis=-1, keepdims=True)
    return np.asarray(mean / spread[0] + (colors - mean) / spread[1])
