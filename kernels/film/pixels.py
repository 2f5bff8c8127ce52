"""Pixels: the order in which they take low-discrepancy points, and the plane that each shows."""

import numpy as np

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit

MIN_COSINE = 0.9
"""Cosine between normals above which two points may lie on one smooth surface."""
MAX_SLOPE = 0.1
"""Height of one over the tangent plane of the other, per distance, up to which they do."""
FLAT = 6
"""Column of a pixel's plane that holds its flatness; before it lie point and shading normal."""


@jit
def morton(x, y):
    """Interleave the bits of two 16-bit integers: neighbours in the plane get near numbers."""
    code = np.uint64(0)
    for bit in range(16):
        code |= np.uint64((x >> bit) & 1) << np.uint64(2 * bit)
        code |= np.uint64((y >> bit) & 1) << np.uint64(2 * bit + 1)
    return code


@jit
def is_same_surface(step, normal, other):
    """Return whether a point a `step` away, with normal `other`, lies on one smooth surface."""
    height = vec.dot(step, normal)
    return vec.dot(
        normal, other
    ) > MIN_COSINE and height * height <= MAX_SLOPE * MAX_SLOPE * vec.dot(step, step)


@jit
def plane_point(plane, pixel):
    """Return the point kept in row `pixel` of (P, 7)."""
    return float(plane[pixel, 0]), float(plane[pixel, 1]), float(plane[pixel, 2])


@jit
def plane_normal(plane, pixel):
    """Return the normal kept in row `pixel` of (P, 7)."""
    return float(plane[pixel, 3]), float(plane[pixel, 4]), float(plane[pixel, 5])


@jit
def update_plane(plane, pixel, first, point, normal):
    """Keep the plane of a pixel's first hit; it is not flat if a later one departs from it."""
    if first:
        for axis in range(3):
            plane[pixel, axis] = point[axis]
            plane[pixel, 3 + axis] = normal[axis]
        plane[pixel, FLAT] = 1.0
    elif not is_same_surface(
        vec.sub(point, plane_point(plane, pixel)), plane_normal(plane, pixel), normal
    ):
        plane[pixel, FLAT] = 0.0
