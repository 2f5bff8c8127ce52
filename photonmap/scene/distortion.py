"""Lens distortion in NumPy: OpenCV's formulas, and whether they fold an image."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bounds = tuple[float, float, float, float]
"""Left, top, right and bottom of an image."""

STEPS = 24
"""Steps from the middle of the image to each point, whose solution begins at the one before."""
NEWTON = 6
ALONG_EDGE = 129
CLOSE = 1e-10


def distort(distortion: Sequence[float], points: Array) -> tuple[Array, Array]:
    """Return where OpenCV's k1, k2, p1, p2, k3 move points, (…, 2), and how that changes with them.

    The derivative, (…, 3), is symmetric: of x along x, of x along y, of y along y.
    """
    k1, k2, p1, p2, k3 = distortion
    x, y = points[..., 0], points[..., 1]
    z = x * x + y * y
    radial = 1.0 + z * (k1 + z * (k2 + z * k3))
    slope = 2.0 * (k1 + z * (2.0 * k2 + z * 3.0 * k3))
    moved = np.stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (z + 2.0 * x * x),
            y * radial + p1 * (z + 2.0 * y * y) + 2.0 * p2 * x * y,
        ],
        axis=-1,
    )
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    return moved, np.stack([xx, xy, yy], axis=-1)


def undistort(distortion: Sequence[float], targets: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the points, (n, 2), that are moved to targets, and whether the way there is unfolded.

    Points are followed from the middle of the image outwards, so that of several points that are
    moved to one, that is found which is reached without passing a fold.
    """
    points, sound = np.zeros_like(targets), np.ones(len(targets), bool)
    with np.errstate(all="ignore"):
        for step in range(1, STEPS + 1):
            goal = targets * (step / STEPS)
            for _ in range(NEWTON):
                moved, derivative = distort(distortion, points)
                sound &= _area(derivative) > 0.0
                points = np.where(sound[:, None], points - _step(derivative, moved - goal), 0.0)
            moved, derivative = distort(distortion, points)
            off = np.abs(moved - goal).max(axis=-1)
            sound &= off <= CLOSE * (1.0 + np.abs(goal).max(axis=-1))
            sound &= _area(derivative) > 0.0
    return points, sound


def _area(derivative: Array) -> Array:
    """Return the determinant: not above 0 where the image is folded."""
    area: Array = derivative[..., 0] * derivative[..., 2] - derivative[..., 1] ** 2
    return area


def _step(derivative: Array, error: Array) -> Array:
    """Return a step of Newton's method."""
    xx, xy, yy = np.moveaxis(derivative, -1, 0)
    right, down = np.moveaxis(error, -1, 0)
    steps = np.stack([yy * right - xy * down, xx * down - xy * right], axis=-1)
    return steps / _area(derivative)[..., None]


@lru_cache(maxsize=64)
def find_fold(distortion: tuple[float, ...], bounds: Bounds) -> bool:
    """Return whether distortion folds an image, as it does if a point of its edge has no origin."""
    left, top, right, bottom = bounds
    x, y = np.linspace(left, right, ALONG_EDGE), np.linspace(top, bottom, ALONG_EDGE)
    sides = [(x, np.full_like(x, edge)) for edge in (top, bottom)]
    sides += [(np.full_like(y, edge), y) for edge in (left, right)]
    edge = np.concatenate([np.stack(side, axis=-1) for side in sides])
    return not bool(undistort(distortion, edge)[1].all())


def undistorted_grid(distortion: Sequence[float], bounds: Bounds, nodes: int) -> Array:
    """Return the origins of a grid of points over an image, (nodes, nodes, 2)."""
    left, top, right, bottom = bounds
    x, y = np.meshgrid(np.linspace(left, right, nodes), np.linspace(top, bottom, nodes))
    grid = np.stack([x, y], axis=-1).reshape(-1, 2)
    return undistort(distortion, grid)[0].reshape(nodes, nodes, 2)


def fisheye_radius(distortion: Sequence[float], angle: float) -> float:
    """Return where OpenCV's fisheye model shows an angle, focal lengths from the middle."""
    k1, k2, k3, k4 = distortion
    z = angle * angle
    return angle * (1.0 + z * (k1 + z * (k2 + z * (k3 + z * k4))))


def widest_angle(distortion: Sequence[float]) -> tuple[float, float]:
    """Return the angle, up to π, to which a fisheye's radius increases, and the radius there."""
    k1, k2, k3, k4 = distortion
    roots = np.roots([9.0 * k4, 7.0 * k3, 5.0 * k2, 3.0 * k1, 1.0])
    turns = [float(root.real) for root in roots if abs(root.imag) < CLOSE and root.real > 0.0]
    angle = min([math.sqrt(turn) for turn in turns] + [math.pi])
    return angle, fisheye_radius(distortion, angle)
