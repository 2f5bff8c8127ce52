"""Piecewise-linear curves: exact resampling, products and integrals."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def resample(at: Floats, wavelengths: Floats, curves: Floats) -> Floats:
    """Return piecewise-linear `curves` (C, K) over `wavelengths` (K,) at `at` (M,): (C, M)."""
    return np.array([np.interp(at, wavelengths, curve) for curve in curves])


def merge_grids(a: Floats, b: Floats) -> Floats:
    """Return the values of both, increasing; the first call of `np.union1d` takes 8 ms."""
    both = np.sort(np.concatenate([a, b]))
    return both[np.append(True, np.diff(both) > 0.0)]


def integrate_products(
    wavelengths: Floats, weights: Floats, nodes: Floats, curves: Floats
) -> Floats:
    """Integrate each weight times each curve over the weights' range.

    Both are linear between their samples; the curves are constant outside of theirs. On the
    merged grid their product is quadratic, and Simpson's rule is exact.

    Parameters
    ----------
    wavelengths : (M,) nm
    weights : (W, M)
    nodes : (K,) nm
    curves : (C, K)

    Returns
    -------
    (W, C) float64
    """
    inside = nodes[(nodes > wavelengths[0]) & (nodes < wavelengths[-1])]
    grid = merge_grids(wavelengths, inside)
    f = resample(grid, wavelengths, weights)
    g = resample(grid, nodes, curves)
    f0, f1 = f[:, :-1] * np.diff(grid) / 6.0, f[:, 1:] * np.diff(grid) / 6.0
    g0, g1 = g[:, :-1], g[:, 1:]
    return f0 @ (2.0 * g0 + g1).T + f1 @ (g0 + 2.0 * g1).T
