"""Emitting triangles as a point sees them: what they send there, and where samples go.

What a triangle sends, cos θ cos θ' / r², is worked out at its corners. Between them it is taken
for linear along the ways from one corner, the apex, to the opposite side, and samples follow
that; parts below the point's horizon get none. The apex is a corner that lies alone on its side
of the horizon, if there is one.
"""

import math

from photonmap.kernels import vec, warp
from photonmap.kernels.jit import jit

TINY = 1e-30


@jit
def _corner(step, ns, height):
    """Return r cos θ and what comes from a corner, both negative below the horizon."""
    squared = max(vec.dot(step, step), TINY)
    rise = vec.dot(ns, step)
    return rise, rise * height / (squared * squared)


@jit
def _turn_to_apex(first, second, third):
    """Return the corners, turned such that the apex comes first, and its number."""
    if (second[0] > 0.0) == (third[0] > 0.0):
        return first, second, third, 0
    if (first[0] > 0.0) == (third[0] > 0.0):
        return second, third, first, 1
    return third, first, second, 2


@jit
def look_at(geometry, triangle, point, ns):
    """Return (apex, left, right, number) of a triangle seen from a point about a normal.

    Each corner is (height above the horizon, what comes from there); `number` is the apex's.
    """
    s0 = vec.sub(vec.row(geometry.vertices, geometry.triangles[triangle, 0]), point)
    s1 = vec.sub(vec.row(geometry.vertices, geometry.triangles[triangle, 1]), point)
    s2 = vec.sub(vec.row(geometry.vertices, geometry.triangles[triangle, 2]), point)
    height = max(-vec.dot(vec.row(geometry.normals, triangle), s0), 0.0)
    return _turn_to_apex(_corner(s0, ns, height), _corner(s1, ns, height), _corner(s2, ns, height))


@jit
def _crossing(apex, end):
    """Return where on the way from the apex to `end` the horizon is, as a fraction."""
    return apex[0] / (apex[0] - end[0])


@jit
def _sent_along(apex, end):
    """Return what comes from the way from the apex to `end`, in proportion to its width."""
    if apex[0] > 0.0 and end[0] > 0.0:
        return apex[1] + 2.0 * end[1]
    if apex[0] <= 0.0 and end[0] <= 0.0:
        return 0.0
    t = _crossing(apex, end)
    if apex[0] > 0.0:
        return t * t * apex[1]
    return (1.0 - t) * (2.0 + t) * end[1]


@jit
def sent_by(corners):
    """Return the mean of cos θ cos θ' / r² over a triangle, roughly; corners of `look_at`."""
    apex, left, right, _ = corners
    return (_sent_along(apex, left) + _sent_along(apex, right)) / 6.0


@jit
def _along(apex, end, u):
    """Sample the way from the apex to `end`: (fraction of it, density to its square)."""
    q0, q1, f0, f1 = 0.0, 1.0, apex[1], end[1]
    if end[0] <= 0.0:
        t = _crossing(apex, end)
        q1, f1 = t * t, 0.0
    elif apex[0] <= 0.0:
        t = _crossing(apex, end)
        q0, f0 = t * t, 0.0
    # Of √q the line 4/15 + 12/15 q is the best fit.
    a, b = f0 + (f1 - f0) * (4.0 / 15.0), max(f0 + (f1 - f0) * (16.0 / 15.0), f1)
    x = warp.linear(u, a, b)
    return math.sqrt(q0 + x * (q1 - q0)), warp.linear_pdf(x, a, b) / (q1 - q0)


@jit
def sample_lamp(corners, u, v):
    """Return (b1, b2, density) of a place on a triangle, relative to places spread evenly.

    density is 0 where nothing is above the horizon.
    """
    apex, left, right, number = corners
    from_left, from_right = _sent_along(apex, left), _sent_along(apex, right)
    if from_left + from_right <= 0.0:
        return 0.0, 0.0, 0.0
    y = warp.linear(v, from_left, from_right)
    end = (left[0] + y * (right[0] - left[0]), left[1] + y * (right[1] - left[1]))
    r, density = _along(apex, end, u)
    density *= warp.linear_pdf(y, from_left, from_right)
    if number == 0:
        return r * (1.0 - y), r * y, density
    if number == 1:
        return 1.0 - r, r * (1.0 - y), density
    return r * y, 1.0 - r, density
