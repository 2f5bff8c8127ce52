"""What glossy lobes reflect in all, which their kernels look up."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.bsdf.glossy import SCHLICK_MEAN

NODES = 64
"""Angles, evenly in the square root of the cosine."""
GRID = 128
"""Samples per angle: its square."""
STEPS = 33
"""Values of roughness for which textured lobes have albedos; what lies between is interpolated."""
SMALLEST_COSINE = 1e-4


def lobe_albedos(alpha: float) -> NDArray[np.float64]:
    """Return what a GGX lobe reflects, (2, NODES + 1), with Fresnel terms 1 and (1 - cos)⁵.

    Of light from each angle, and last the cosine-weighted mean over all angles; by quadrature over
    visible normals (Dupuy and Benyoub 2023).
    """
    cosines = np.maximum(np.linspace(0.0, 1.0, NODES) ** 2, SMALLEST_COSINE)
    rows = np.array([_albedos(alpha, cosine) for cosine in cosines]).T
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    roots = 0.5 * (nodes + 1.0)  # mean over μ = t² of 2 μ dμ = 4 t³ dt
    means = [np.interp(roots, np.linspace(0.0, 1.0, NODES), row) for row in rows]
    return np.column_stack([rows, np.array(means) @ (2.0 * weights * roots**3)])


@cache
def stepped_albedos(least: float) -> NDArray[np.float64]:
    """Return `lobe_albedos` for even steps of roughness from 0 to 1, (STEPS, 2, NODES + 1).

    Parameters
    ----------
    least : smallest α
    """
    roughness = np.linspace(0.0, 1.0, STEPS)
    return np.array([lobe_albedos(max(value * value, least)) for value in roughness.tolist()])


def mean_albedo(f0: NDArray[np.floating], albedos: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what glossy surfaces reflect of light from all around, (M, N).

    Parameters
    ----------
    f0 : (M, N) reflectances at normal incidence
    albedos : (M, 2), what the lobe reflects with Fresnel terms 1 and (1 - cos)⁵, likewise
    """
    single, grazing = albedos[:, :1], albedos[:, 1:]
    fresnel = f0 + (1.0 - f0) * SCHLICK_MEAN
    multiple = fresnel**2 * single / (1.0 - fresnel * (1.0 - single))
    return np.asarray(f0 * (single - grazing) + grazing + (1.0 - single) * multiple)


def _albedos(alpha: float, cosine: float) -> tuple[float, float]:
    """Return the mean of G2 / G1 over visible normals, times each Fresnel term."""
    grid = (np.arange(GRID) + 0.5) / GRID
    u, v = np.meshgrid(grid, grid)
    wo = np.array([np.sqrt(1.0 - cosine * cosine), 0.0, cosine])
    stretched = wo * [alpha, alpha, 1.0]
    stretched /= np.linalg.norm(stretched)
    height = (1.0 - v) * (1.0 + stretched[2]) - stretched[2]
    r = np.sqrt(np.maximum(1.0 - height * height, 0.0))
    phi = 2.0 * np.pi * u
    h = np.stack(
        [alpha * (r * np.cos(phi) + stretched[0]), alpha * r * np.sin(phi), height + stretched[2]]
    )
    h /= np.linalg.norm(h, axis=0)
    along = np.tensordot(wo, h, 1)
    out = np.maximum(2.0 * along * h[2] - cosine, 0.0)
    shadowed = 1.0 + _smith(alpha, cosine) + _smith(alpha, np.maximum(out, 1e-9))
    weight = np.where(out > 0.0, (1.0 + _smith(alpha, cosine)) / shadowed, 0.0)
    return float(weight.mean()), float((weight * (1.0 - np.minimum(along, 1.0)) ** 5).mean())


def _smith(alpha: float, cosine: NDArray[np.float64] | float) -> NDArray[np.float64]:
    tangent = 1.0 / np.square(cosine) - 1.0
    return np.asarray(0.5 * (np.sqrt(1.0 + alpha * alpha * tangent) - 1.0))
