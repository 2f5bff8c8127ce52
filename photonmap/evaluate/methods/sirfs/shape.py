"""Depth as a surface: slopes, curvature, normals and their harmonics, and the gradients of these.

Real spherical harmonics up to order 2, without their constants, are the polynomials of R.
Ramamoorthi and P. Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH
2001. The constants would only scale the coefficients of light, whose prior is learnt.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from photonmap.evaluate.metrics.arrays import Floats

_SMOOTH, _SLOPE, _BEND = (1.0, 2.0, 1.0), (-1.0, 0.0, 1.0), (1.0, -2.0, 1.0)


class Filters(NamedTuple):
    """Derivatives of (P,) depths of all pixels of an image as sparse matrices."""

    x: Any
    y: Any
    xx: Any
    xy: Any
    yy: Any


@lru_cache(maxsize=4)
def filters(height: int, width: int) -> Filters:
    """Return the derivatives of 3×3 pixels; beyond the border, depths repeat."""
    from scipy.sparse import csr_array, diags_array, kron

    def along(count: int, weights: tuple[float, ...], scale: float) -> Any:
        rows = [
            np.full(count - abs(k), w * scale) for k, w in zip((-1, 0, 1), weights, strict=True)
        ]
        matrix = diags_array(rows, offsets=(-1, 0, 1), shape=(count, count)).tolil()
        matrix[0, 0] += weights[0] * scale
        matrix[-1, -1] += weights[2] * scale
        return matrix

    def both(down: tuple[float, ...], right: tuple[float, ...], scales: tuple[float, float]) -> Any:
        return csr_array(kron(along(height, down, scales[0]), along(width, right, scales[1])))

    return Filters(
        both(_SMOOTH, _SLOPE, (0.25, 0.5)),
        both(_SLOPE, _SMOOTH, (0.5, 0.25)),
        both(_SMOOTH, _BEND, (0.25, 1.0)),
        both(_SLOPE, _SLOPE, (0.5, 0.5)),
        both(_BEND, _SMOOTH, (1.0, 0.25)),
    )


class Surface:
    """Slopes and normals of a depth map.

    Parameters
    ----------
    depth : (H, W) towards the camera, pixels
    """

    def __init__(self, depth: Floats) -> None:
        self.shape = depth.shape
        flat = depth.ravel()
        self._filters = filters(*depth.shape)
        self.p, self.q = self._filters.x @ flat, self._filters.y @ flat
        self._bends = tuple(matrix @ flat for matrix in self._filters[2:])
        self.squared = 1.0 + self.p**2 + self.q**2
        self._length = np.sqrt(self.squared)

    def normals(self) -> Floats:
        """Return (P, 3) unit normals: right, down, towards the camera."""
        return np.stack([-self.p, -self.q, np.ones_like(self.p)], axis=1) / self._length[:, None]

    def curvature(self) -> Floats:
        """Return the mean curvature of each pixel: (P,)."""
        xx, xy, yy = self._bends
        p, q = self.p, self.q
        bent = (1.0 + p**2) * yy - 2.0 * p * q * xy + (1.0 + q**2) * xx
        return np.asarray(bent / (2.0 * self.squared * self._length))

    def of_normals(self, by_normal: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by normals (P, 3)."""
        normals = self.normals()
        tangent = by_normal - (by_normal * normals).sum(axis=1, keepdims=True) * normals
        tangent /= self._length[:, None]
        return self.of_slopes(-tangent[:, 0], -tangent[:, 1])

    def of_slopes(self, by_p: Floats, by_q: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by slopes."""
        return np.asarray(self._filters.x.T @ by_p + self._filters.y.T @ by_q).reshape(self.shape)

    def of_curvature(self, by_curvature: Floats) -> Floats:
        """Return the gradient by depth (H, W) of what has a gradient by mean curvature (P,)."""
        xx, xy, yy = self._bends
        p, q = self.p, self.q
        scale = by_curvature / (self.squared * self._length)
        curvature = by_curvature * self.curvature()
        by_p = scale * (p * yy - q * xy) - 3.0 * curvature * p / self.squared
        by_q = scale * (q * xx - p * xy) - 3.0 * curvature * q / self.squared
        bends = (
            self._filters.xx.T @ (0.5 * scale * (1.0 + q**2))
            - self._filters.xy.T @ (scale * p * q)
            + self._filters.yy.T @ (0.5 * scale * (1.0 + p**2))
        )
        return self.of_slopes(by_p, by_q) + bends.reshape(self.shape)


HARMONICS = 9


def harmonics(normals: Floats) -> Floats:
    """Return (P, 9) for normals (P, 3)."""
    x, y, z = normals.T
    rows = [np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3.0 * z * z - 1.0]
    return np.stack(rows, axis=1)


def by_normals(normals: Floats, by_harmonics: Floats) -> Floats:
    """Return the gradient by normals (P, 3) of what has a gradient by harmonics (P, 9)."""
    x, y, z = normals.T
    g = by_harmonics.T
    return np.stack(
        [
            g[1] + y * g[4] + z * g[5] + 2.0 * x * g[7],
            g[2] + x * g[4] + z * g[6] - 2.0 * y * g[7],
            g[3] + x * g[5] + y * g[6] + 6.0 * z * g[8],
        ],
        axis=1,
    )
