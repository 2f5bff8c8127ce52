"""The priors of SIRFS, as `learn` finds them.

Differences are Gaussian scale mixtures: many are small, and some large.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np

from photonmap.evaluate.metrics.arrays import Floats, Mask

SCALES = np.logspace(-2.0, 1.5, 16)
"""Standard deviations of the Gaussians; only their weights are learnt. Rendered reflectances are
exactly equal on a surface: without a least scale, the cost would have a cusp there that no descent
gets past."""
_NEAR = 1e-8
"""Added to squared lengths, whose logarithm is taken."""
_LEAST, _MOST, _STEPS = float(np.log(_NEAR)), float(np.log(1e4)), 16384
_STEP = (_MOST - _LEAST) / (_STEPS - 1)
_ROUNDS = 200
_NEGLIGIBLE = 1e-6


def cost_table(weights: Floats, dimensions: int) -> Floats:
    """Return the cost −log Σ_k a_k σ_k^−d exp(−q / 2σ_k²) of squared lengths q of d numbers.

    It is 0 for no difference, and tabulated over log q, between whose entries it is linear.

    Parameters
    ----------
    weights : (16,) a_k
    dimensions : d
    """
    table = -_log_density(np.exp(np.linspace(_LEAST, _MOST, _STEPS)), weights, dimensions)
    return np.asarray(table - table[0])


def learn_mixture(squared: Floats, dimensions: int) -> Floats:
    """Return the weights (16,) of a mixture for a sample of squared lengths, by EM."""
    weights = np.full(len(SCALES), 1.0 / len(SCALES))
    logs = _log_parts(np.maximum(squared, _NEAR), dimensions)
    logs -= logs.max(axis=1, keepdims=True)
    parts = np.exp(logs)
    for _ in range(_ROUNDS):
        joint = parts * weights
        weights = (joint / joint.sum(axis=1, keepdims=True)).mean(axis=0)
    return np.where(weights > _NEGLIGIBLE, weights, 0.0)


def _log_parts(squared: Floats, dimensions: int) -> Floats:
    """Return log σ_k^−d exp(−q / 2σ_k²): (Q, 16)."""
    return np.asarray(
        -dimensions * np.log(SCALES) - squared[:, None] / (2.0 * SCALES**2), np.float64
    )


def _log_density(squared: Floats, weights: Floats, dimensions: int) -> Floats:
    logs = _log_parts(squared, dimensions) + np.log(np.maximum(weights, 1e-300))
    largest = logs.max(axis=1)
    return np.asarray(largest + np.log(np.exp(logs - largest[:, None]).sum(axis=1)), np.float64)


def windows(mask: Mask, reach: int = 2) -> Iterator[tuple[tuple[slice, slice], ...]]:
    """Yield the places of all pairs of pixels in windows of 2 reach + 1, each pair once.

    For an image, `image[one]` and `image[other]` are the members of pairs that are a shift apart.
    """
    height, width = mask.shape
    for y in range(reach + 1):
        for x in range(-reach, reach + 1):
            if (y, x) > (0, 0) and y < height and abs(x) < width:
                rows = slice(0, height - y), slice(y, height)
                left, right = (
                    slice(max(-x, 0), width - max(x, 0)),
                    slice(max(x, 0), width + min(x, 0)),
                )
                yield (rows[0], left), (rows[1], right)


def difference_cost(image: Floats, mask: Mask, table: Floats) -> tuple[float, Floats]:
    """Return the mean cost of differences of (H, W, C) in windows of 5×5, and its gradient.

    Parameters
    ----------
    table : as `cost_table` returns it
    """
    total, count = 0.0, 0
    gradient = np.zeros_like(image)
    for one, other in windows(mask):
        cost, pairs = _compiled()(
            (image[one], image[other]),
            (mask[one], mask[other]),
            table,
            (gradient[one], gradient[other]),
        )
        total += cost
        count += pairs
    count = max(count, 1)
    return total / count, gradient / count


@lru_cache(maxsize=1)
def _compiled() -> Any:
    """Return `_add_pairs`, compiled when it is first needed."""
    from numba import njit

    return njit(_add_pairs)


def _add_pairs(images: Any, masks: Any, table: Floats, gradients: Any) -> tuple[float, int]:
    """Return the cost and number of pairs of pixels a shift apart, and add to their gradients."""
    total, count = 0.0, 0
    for y in range(masks[0].shape[0]):
        for x in range(masks[0].shape[1]):
            if not (masks[0][y, x] and masks[1][y, x]):
                continue
            squared = 0.0
            for band in range(images[0].shape[2]):
                squared += (images[1][y, x, band] - images[0][y, x, band]) ** 2
            kept = squared + _NEAR
            position = min(max((np.log(kept) - _LEAST) / _STEP, 0.0), _STEPS - 1.001)
            index = int(position)
            rise = table[index + 1] - table[index]
            total += table[index] + rise * (position - index)
            count += 1
            pull = 2.0 * rise / (_STEP * kept)
            for band in range(images[0].shape[2]):
                change = pull * (images[1][y, x, band] - images[0][y, x, band])
                gradients[1][y, x, band] += change
                gradients[0][y, x, band] -= change
    return total, count


FILE = "sirfs_priors.json"


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
    text = files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return Priors(**json.loads(text))


def as_json(priors: Priors) -> str:
    """Return priors as text, a line each."""
    rows = (f" {json.dumps(name)}: {json.dumps(_rounded(v))}" for name, v in asdict(priors).items())
    return "{\n" + ",\n".join(rows) + "\n}"


def _rounded(value: Any) -> Any:
    return [_rounded(v) for v in value] if isinstance(value, list) else float(f"{value:.6g}")


def whitened(colors: Floats, spread: Any) -> Floats:
    """Return (…, C) with brightness over one standard deviation and deviations over another.

    The map is linear and its own transpose.
    """
    mean = colors.mean(axis=-1, keepdims=True)
    return np.asarray(mean / spread[0] + (colors - mean) / spread[1])
