"""The descent in shape and light, from coarse to fine at once."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View
from photonmap.evaluate.methods.sirfs.harmonics import COUNT
from photonmap.evaluate.methods.sirfs.objective import Objective
from photonmap.evaluate.methods.sirfs.priors import load_priors
from photonmap.evaluate.metrics.arrays import Floats, to_grey

_COARSEST = 4
"""Side of the smallest level of the pyramid, about, pixels."""


def estimate(view: View, steps: float, **weights: float) -> Estimate:
    """Return the decomposition after at most some steps of L-BFGS.

    Parameters
    ----------
    steps : largest number of steps
    weights : of the terms, see `Objective`
    """
    from scipy.optimize import minimize

    white = float(np.percentile(to_grey(view.image)[view.mask], 99.0))
    log_image = np.log(np.maximum(view.image / white, FLOOR))
    priors = load_priors()
    objective = Objective(log_image, view.mask, priors, weights)
    levels = pyramid(*view.mask.shape)
    sizes = [level.shape[1] for level in levels]
    light = np.repeat(np.array(priors.light)[:, None], log_image.shape[2], axis=1)

    def cost(values: Floats) -> tuple[float, Floats]:
        parts = np.split(values, np.cumsum(sizes))
        total, by_depth, by_light = objective(
            depth_of(parts[:-1], levels, view.mask.shape), parts[-1].reshape(COUNT, -1)
        )
        gradients = [level.T @ by_depth.ravel() for level in levels]
        return total, np.concatenate([*gradients, by_light.ravel()])

    start = np.concatenate([np.zeros(sum(sizes)), light.ravel()])
    found = minimize(cost, start, method="L-BFGS-B", jac=True,
                     options={"maxiter": round(steps), "gtol": 1e-10, "ftol": 1e-8})  # fmt: skip
    parts = np.split(found.x, np.cumsum(sizes))
    depth = depth_of(parts[:-1], levels, view.mask.shape)
    shading = np.exp(objective.shading(depth, parts[-1].reshape(COUNT, -1)))
    return Estimate(np.exp(log_image) / shading, shading, shading)


def depth_of(parts: list[Floats], levels: tuple[Any, ...], shape: tuple[int, ...]) -> Floats:
    """Return the depth (H, W) that a pyramid adds up to."""
    return np.asarray(
        sum(level @ part for level, part in zip(levels, parts, strict=True)), np.float64
    ).reshape(shape)


@lru_cache(maxsize=2)
def pyramid(height: int, width: int) -> tuple[Any, ...]:
    """Return matrices that bring levels of halved size to the image's, by linear interpolation.

    Each level counts √2 times as much as the one below, so that L-BFGS bends large surfaces first.
    """
    from scipy.sparse import csr_array, kron

    levels, step = [], 1
    while step == 1 or min(height, width) // step >= _COARSEST:
        matrix = kron(_interpolation(height, step), _interpolation(width, step))
        levels.append(csr_array(matrix * float(np.sqrt(2.0 * step))))
        step *= 2
    return tuple(levels)


def _interpolation(count: int, step: int) -> Any:
    """Return the matrix from knots `step` apart to `count` pixels."""
    from scipy.sparse import csr_array

    knots = -(-(count - 1) // step) + 1
    place = np.arange(count) / step
    left = np.minimum(place.astype(np.int64), max(knots - 2, 0))
    share = place - left
    rows = np.tile(np.arange(count), 2)
    columns = np.concatenate([left, np.minimum(left + 1, knots - 1)])
    return csr_array((np.concatenate([1.0 - share, share]), (rows, columns)), shape=(count, knots))


METHOD = Method(
    "sirfs",
    estimate,
    {
        "steps": 300.0,
        "smooth": 4.0,
        "entropy": 1.0,
        "absolute": 0.1,
        "curvature": 1.0,
        "facing": 0.1,
        "light": 0.1,
    },
)
