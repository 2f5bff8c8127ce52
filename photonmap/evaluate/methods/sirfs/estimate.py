"""The cost of a shape and a light, and the descent in both, from coarse to fine at once."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View
from photonmap.evaluate.methods.sirfs.priors import (
    Priors,
    cost_table,
    difference_cost,
    load_priors,
    whitened,
)
from photonmap.evaluate.methods.sirfs.shape import HARMONICS, Surface, by_normals, harmonics
from photonmap.evaluate.metrics.arrays import Floats, Mask, to_grey

BEND = 10.0
"""Unit of curvature in its prior, pixels."""
_SAMPLED = 400
"""Number of pixels whose reflectances the entropy compares."""
_KERNEL = 1.0
"""Width σ of the entropy's kernel, in units of the spread of differences."""


class Objective:
    """The cost (1) of a log image, terms averaged over pixels.

    Parameters
    ----------
    log_image : (H, W, C)
    mask : (H, W)
    priors : what is likely
    weights : of "smooth", "entropy", "absolute", "curvature", "facing" and "light"
    """

    def __init__(
        self, log_image: Floats, mask: Mask, priors: Priors, weights: dict[str, float]
    ) -> None:
        self._image, self._mask, self._priors, self._weights = log_image, mask, priors, weights
        self._edges = cost_table(np.array(priors.edges), log_image.shape[2])
        self._bends = cost_table(np.array(priors.bends), 1)
        inside = np.flatnonzero(mask)
        self._sampled = inside[np.linspace(0, len(inside) - 1, _SAMPLED).astype(np.int64)]

    def shading(self, depth: Floats, light: Floats) -> Floats:
        """Return the log shading (H, W, C) of a depth map in a light (9, C)."""
        return (harmonics(Surface(depth).normals()) @ light).reshape(self._image.shape)

    def __call__(self, depth: Floats, light: Floats) -> tuple[float, Floats, Floats]:
        """Return the cost, and its gradients by depth (H, W) and light (9, C)."""
        surface = Surface(depth)
        normals = surface.normals()
        basis = harmonics(normals)
        reflectance = self._image - (basis @ light).reshape(self._image.shape)
        cost, by_reflectance = self._reflectance_cost(reflectance)
        by_shading = -by_reflectance.reshape(-1, light.shape[1])
        by_depth = surface.of_normals(by_normals(normals, by_shading @ light.T))
        shape_cost, by_shape = self._shape_cost(surface)
        light_cost, by_light = self._light_cost(light)
        return (
            cost + shape_cost + light_cost,
            by_depth + by_shape,
            basis.T @ by_shading + by_light,
        )

    def _reflectance_cost(self, reflectance: Floats) -> tuple[float, Floats]:
        """Return the cost of log reflectance (H, W, C), and its gradient."""
        spread = self._priors.edge_spread
        white = whitened(reflectance, spread)
        smooth, gradient = difference_cost(white, self._mask, self._edges)
        cost, gradient = self._weights["smooth"] * smooth, self._weights["smooth"] * gradient
        flat = white.reshape(-1, white.shape[2])
        entropy, by_sample = _entropy(flat[self._sampled])
        cost += self._weights["entropy"] * entropy
        by_flat = gradient.reshape(flat.shape)
        np.add.at(by_flat, self._sampled, self._weights["entropy"] * by_sample)
        gradient = whitened(by_flat.reshape(white.shape), spread)
        absolute, by_value = self._absolute(reflectance)
        return (
            cost + self._weights["absolute"] * absolute,
            gradient + self._weights["absolute"] * by_value,
        )

    def _absolute(self, reflectance: Floats) -> tuple[float, Floats]:
        """Return the cost of values: normal in brightness and in deviations from it."""
        mean, brightness, deviation = self._priors.reflectance
        white = whitened(reflectance - mean, (brightness, deviation))
        white = np.where(self._mask[..., None], white, 0.0)
        count = int(self._mask.sum())
        return 0.5 * float((white**2).sum()) / count, whitened(
            white, (brightness, deviation)
        ) / count

    def _shape_cost(self, surface: Surface) -> tuple[float, Floats]:
        curvature = BEND * surface.curvature().reshape(*surface.shape, 1)
        bent, by_curvature = difference_cost(curvature, self._mask, self._bends)
        count = surface.squared.size
        facing = 0.5 * float(np.log(surface.squared).sum()) / count
        slopes = (surface.p / surface.squared / count, surface.q / surface.squared / count)
        gradient = self._weights["curvature"] * surface.of_curvature(BEND * by_curvature.ravel())
        gradient += self._weights["facing"] * surface.of_slopes(*slopes)
        return self._weights["curvature"] * bent + self._weights["facing"] * facing, gradient

    def _light_cost(self, light: Floats) -> tuple[float, Floats]:
        mean = light.mean(axis=1)
        away = mean - np.array(self._priors.light)
        pulled = np.array(self._priors.light_precision) @ away
        deviations = (light - mean[:, None]) / np.array(self._priors.light_deviation)[:, None]
        weight, bands = self._weights["light"], light.shape[1]
        cost = 0.5 * weight * float(away @ pulled + (deviations**2).sum())
        scaled = deviations / np.array(self._priors.light_deviation)[:, None]
        centred = scaled - scaled.mean(axis=1, keepdims=True)
        return cost, weight * (pulled[:, None] / bands + centred)


def _entropy(colors: Floats) -> tuple[float, Floats]:
    """Return Rényi's quadratic entropy of colours (K, C) up to a constant, and its gradient."""
    squared = (colors**2).sum(axis=1)
    apart = np.maximum(squared[:, None] + squared[None] - 2.0 * colors @ colors.T, 0.0)
    near = np.exp(-apart / (4.0 * _KERNEL**2))
    whole = float(near.sum())
    pull = colors * near.sum(axis=1)[:, None] - near @ colors
    return -float(np.log(whole / near.size)), pull / (_KERNEL**2 * whole)


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
            depth_of(parts[:-1], levels, view.mask.shape), parts[-1].reshape(HARMONICS, -1)
        )
        gradients = [level.T @ by_depth.ravel() for level in levels]
        return total, np.concatenate([*gradients, by_light.ravel()])

    start = np.concatenate([np.zeros(sum(sizes)), light.ravel()])
    found = minimize(cost, start, method="L-BFGS-B", jac=True,
                     options={"maxiter": round(steps), "gtol": 1e-10, "ftol": 1e-8})  # fmt: skip
    parts = np.split(found.x, np.cumsum(sizes))
    depth = depth_of(parts[:-1], levels, view.mask.shape)
    shading = np.exp(objective.shading(depth, parts[-1].reshape(HARMONICS, -1)))
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


METHODS = (
    Method(
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
    ),
)
