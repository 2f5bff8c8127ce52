"""Vectors of three, as tuples of float64, and orthonormal frames."""

import math

from photonmap.kernels.core.jit import jit


@jit
def add(a, b):
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@jit
def sub(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@jit
def scale(a, s):
    """Return a times the number s."""
    return a[0] * s, a[1] * s, a[2] * s


@jit
def dot(a, b):
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def cross(a, b):
    """Return the cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@jit
def normalize(a):
    """Return a at length 1."""
    return scale(a, 1.0 / math.sqrt(dot(a, a)))


@jit
def row(array, i):
    """Return row i of an (n, 3) array as a vector."""
    return float(array[i, 0]), float(array[i, 1]), float(array[i, 2])


@jit
def interpolated(rows, triangles, hit):
    """Return what lies at a hit between rows, (V, 3) or more, of the corners of its triangle."""
    a = row(rows, triangles[hit.triangle, 0])
    b = row(rows, triangles[hit.triangle, 1])
    c = row(rows, triangles[hit.triangle, 2])
    return add(scale(a, 1.0 - hit.u - hit.v), add(scale(b, hit.u), scale(c, hit.v)))


@jit
def from_frame(local, n):
    """Turn a vector from the frame whose third axis is n into the world (Duff et al. 2017)."""
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    x, y, z = local
    return (
        x * (1.0 + sign * n[0] * n[0] * a) + y * b + z * n[0],
        x * sign * b + y * (sign + n[1] * n[1] * a) + z * n[1],
        -x * sign * n[0] - y * n[1] + z * n[2],
    )


@jit
def to_frame(vector, n):
    """Turn a vector of the world into the frame of `from_frame`: its inverse."""
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    x = (1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0])
    return dot(vector, x), dot(vector, (b, sign + n[1] * n[1] * a, -n[1])), dot(vector, n)
