"""Least-squares fits: power laws, and seconds as a linear function of passes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Power:
    """y = factor · x^exponent.

    Parameters
    ----------
    factor, exponent : of the power law
    uncertainty : standard error of the exponent; nan for fewer than three points
    """

    factor: float
    exponent: float
    uncertainty: float = math.nan

    def at(self, x: float) -> float:
        """Return y at x."""
        return self.factor * x**self.exponent

    def inverse(self, y: float) -> float:
        """Return the x at which the law has the value y."""
        return (y / self.factor) ** (1.0 / self.exponent)


def fit_power(x: Sequence[float], y: Sequence[float]) -> Power | None:
    """Fit a power law by least squares of logarithms; None for fewer than two different x.

    Pairs with a value that is not positive and finite are ignored.
    """
    pairs = [(a, b) for a, b in zip(x, y, strict=True) if 0.0 < a < math.inf and 0.0 < b < math.inf]
    if len({a for a, _ in pairs}) < 2:
        return None
    logs = np.log(pairs)
    away = logs[:, 0] - logs[:, 0].mean()
    spread = float(away @ away)
    exponent = float(away @ logs[:, 1]) / spread
    offset = float(logs[:, 1].mean() - exponent * logs[:, 0].mean())
    rest = logs[:, 1] - offset - exponent * logs[:, 0]
    free = len(pairs) - 2
    uncertainty = math.sqrt(float(rest @ rest) / free / spread) if free else math.nan
    return Power(math.exp(offset), exponent, uncertainty)


@dataclass(frozen=True)
class Cost:
    """seconds = setup + each · passes."""

    setup: float
    each: float

    def seconds(self, passes: float) -> float:
        """Return the seconds of a number of passes."""
        return self.setup + self.each * passes


def fit_cost(passes: Sequence[float], seconds: Sequence[float]) -> Cost:
    """Fit seconds by least squares of relative deviations; neither coefficient is negative.

    Parameters
    ----------
    passes, seconds : positive, at least one pair
    """
    from scipy.optimize import nnls

    took = np.asarray(seconds, np.float64)
    if len(set(passes)) < 2:
        return Cost(0.0, float(np.mean(took / np.asarray(passes))))
    design = np.stack([np.ones(len(took)), np.asarray(passes, np.float64)], axis=1)
    setup, each = nnls(design / took[:, None], np.ones(len(took)))[0]
    return Cost(float(setup), float(each))
