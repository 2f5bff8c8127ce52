"""Gehler's random field: an image has few reflectances, smooth shading, and edges as in Retinex.

P. V. Gehler, C. Rother, M. Kiefel, L. Zhang and B. Schölkopf, "Recovering intrinsic images with a
global sparsity prior on reflectance", NIPS 2011. Shading is grey, so that the reflectance of pixel
i is R_i = r_i I_i / |I_i| and its shading s_i = |I_i| / r_i. With sums over neighbours i ~ j,

    E = w_s E_s + w_r E_ret + w_cl E_cl                               (3)
    E_s = Σ (s_i − s_j)²
    E_ret = Σ (log r_i − log r_j − g_ij (log |I_i| − log |I_j|))²
    E_cl = Σ_i |R_i − R̃_{α_i}|²

where g_ij is 1 at the edges of colour Retinex (T^br = T^chr = 0.075), else 0, and R̃_1 … R̃_C are
reflectances of the whole image, C = 150. Coordinate descent (algorithm 1): r for given clusters,
by L-BFGS in log r instead of conjugate gradients; then assignments α; then means R̃. It starts from
colour Retinex, from constant shading and from constant reflectance, and the lowest energy wins.

The paper chooses its weights on training images and fixes no scale for r. Here they were chosen on
scenes with other seeds; |I| and r have a mean of 1. First clusters halve
the pixels again and again, where colours vary most.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.evaluate.methods.method import FLOOR, Estimate, Method, View, with_grey_shading
from photonmap.evaluate.methods.poisson import integrate, neighbours, steps_of
from photonmap.evaluate.methods.retinex import edge_steps
from photonmap.evaluate.metrics.arrays import Floats

_THRESHOLD = 0.075  # Of colour Retinex
_ROUNDS = 8  # Largest number of times that r, α and R̃ are solved for in turn
_STEPS = 15  # Largest number of steps of L-BFGS in a round
_SETTLED = 1e-4  # Relative decrease of the energy in a round below which the descent ends


class _Field(NamedTuple):
    """What stays the same during the descent, for the P pixels of a mask."""

    length: Floats  # (P,) |I|, with a mean of 1
    direction: Floats  # (P, C) I / |I|
    pairs: NDArray[np.int64]  # (2, E) neighbours, second first
    steps: Floats  # (E,) g_ij (log |I_i| − log |I_j|)


def estimate(view: View, smooth: float, retinex: float, cluster: float, count: float) -> Estimate:
    """Return the decomposition for weights w_s, w_r and w_cl and the number of clusters C."""
    image = np.maximum(view.image, FLOOR)
    length = np.linalg.norm(image, axis=-1)
    length /= length[view.mask].mean()
    down, right = edge_steps(image, np.log(length), _THRESHOLD, _THRESHOLD)
    colors = image[view.mask]
    field = _Field(
        length[view.mask],
        colors / np.linalg.norm(colors, axis=-1, keepdims=True),
        neighbours(view.mask),
        steps_of(down, right, view.mask),
    )
    weights = (smooth, retinex, cluster)
    by_retinex = integrate(down, right, view.mask)[view.mask]
    starts = by_retinex, np.log(field.length), np.zeros(len(field.length))
    found = [_descend(field, start, weights, round(count)) for start in starts]
    best = min(found, key=lambda each: each[0])[1]
    shading = np.ones(view.mask.shape)
    shading[view.mask] = field.length / np.exp(best)
    return with_grey_shading(view, shading)


def _descend(
    field: _Field, start: Floats, weights: tuple[float, float, float], count: int
) -> tuple[float, Floats]:
    """Return the energy and log r where coordinate descent from a start ends."""
    from scipy.optimize import minimize

    log_r = _rescaled(start)
    means = first_means(np.exp(log_r)[:, None] * field.direction, count)
    last = np.inf
    for _ in range(_ROUNDS):
        reflectance = np.exp(log_r)[:, None] * field.direction
        nearest = nearest_means(reflectance, means)
        means = means_of(reflectance, nearest, means)
        found = minimize(
            _energy, log_r, (field, means[nearest], weights), "L-BFGS-B", jac=True,
            options={"maxiter": _STEPS},
        )  # fmt: skip
        log_r = _rescaled(found.x)
        if last - found.fun < _SETTLED * abs(last):
            break
        last = found.fun
    reflectance = np.exp(log_r)[:, None] * field.direction
    nearest = nearest_means(reflectance, means)
    return _energy(log_r, field, means[nearest], weights)[0], log_r


def _rescaled(log_r: Floats) -> Floats:
    """Return log r with a mean of 1 for r, which is that of |I|."""
    return log_r - np.log(np.exp(log_r).mean())


def _energy(
    log_r: Floats, field: _Field, centres: Floats, weights: tuple[float, float, float]
) -> tuple[float, Floats]:
    """Return E for log r (P,) and the cluster means of the pixels (P, C), and its gradient."""
    smooth, retinex, cluster = weights
    second, first = field.pairs
    r = np.exp(log_r)
    shading = field.length / r
    jumps = shading[second] - shading[first]
    misses = log_r[second] - log_r[first] - field.steps
    away = r[:, None] * field.direction - centres
    energy = smooth * (jumps**2).sum() + retinex * (misses**2).sum() + cluster * (away**2).sum()
    gradient = -2.0 * smooth * shading * _gathered(field, jumps)
    gradient += 2.0 * retinex * _gathered(field, misses)
    gradient += 2.0 * cluster * r * (away * field.direction).sum(axis=-1)
    return float(energy), gradient


def _gathered(field: _Field, values: Floats) -> Floats:
    """Return for each pixel the sum over pairs where it is second minus that where it is first."""
    count = len(field.length)
    second, first = field.pairs
    sums = np.bincount(second, values, count) - np.bincount(first, values, count)
    return np.asarray(sums, np.float64)


METHODS = (
    Method("gehler", estimate, {"smooth": 0.01, "retinex": 1.0, "cluster": 0.1, "count": 150.0}),
)


def first_means(colors: Floats, count: int) -> Floats:
    """Split colours (P, C) at medians until there are `count` groups; return their means."""
    groups = [colors]
    spreads = [_spread(colors)]
    while len(groups) < count and max(spreads) > 0.0:
        widest = int(np.argmax(spreads))
        group = groups[widest]
        axis = int(np.argmax(group.var(axis=0)))
        order = np.argsort(group[:, axis], kind="stable")
        halves = [group[part] for part in np.array_split(order, 2)]
        groups[widest : widest + 1] = halves
        spreads[widest : widest + 1] = map(_spread, halves)
    return np.stack([group.mean(axis=0) for group in groups])


def _spread(colors: Floats) -> float:
    """Return the sum of squared distances of colours (P, C) to their mean."""
    return float(len(colors) * colors.var(axis=0).sum())


def nearest_means(colors: Floats, means: Floats) -> NDArray[Any]:
    """Return the nearest mean of each colour."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(means).query(colors)[1])


def means_of(colors: Floats, nearest: NDArray[Any], means: Floats) -> Floats:
    """Return the means of the colours of each cluster; clusters without any keep theirs."""
    counts = np.bincount(nearest, minlength=len(means))
    sums = np.stack([np.bincount(nearest, band, len(means)) for band in colors.T], axis=1)
    return np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], means)
