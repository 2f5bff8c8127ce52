"""Area lights: emitting triangles, sampled roughly in proportion to what reaches a point.

What arrives from a triangle, cos θ cos θ' / r², is worked out at its corners. It is taken to be
linear along the lines from one corner, the apex, to the opposite side, and samples follow that;
parts below the point's horizon get none. The apex is the corner that lies alone on its side of the
horizon, if there is one.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.interaction import offset, point_at
from photonmap.kernels.geometry.opacity import opacity_at
from photonmap.kernels.lights.portal import position_on
from photonmap.kernels.lights.samples import LightSample, PhotonStart, no_sample
from photonmap.kernels.lights.samples import NoParameters as Parameters  # noqa: F401

TINY = 1e-30
BEFORE_LAMP = 1.0 - 2.0**-16
"""Where shadow rays end, as a fraction of the way. The rounding of an origin that lies far from the
middle of the scene is larger than the offset off an area light that lies near it."""


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
def corners_from(geometry, triangle, point, ns):
    """Return (apex, left, right, apex's number): each (height above the horizon, what it sends)."""
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
def mean_irradiance_factor(corners):
    """Return the mean of cos θ cos θ' / r² over a triangle, roughly; corners of `corners_from`."""
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
def sample_triangle_light(corners, u, v):
    """Return (b1, b2, density relative to an even one, 0 where nothing is above the horizon)."""
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


@jit
def importance(geometry, lights, emitter, at, ns):
    """Estimate the irradiance at a point from an area light of power 1, unless it is occluded."""
    return warp.INV_PI * mean_irradiance_factor(
        corners_from(geometry, lights.triangle[emitter], at, ns)
    )


@jit
def _emitting_point(geometry, triangle, position):
    """Return (point, ng, opacity) on the front of an emitting triangle, offset off it."""
    point, size = point_at(geometry, triangle, position[0], position[1])
    normal = vec.row(geometry.normals, triangle)
    opacity = opacity_at(geometry, triangle, position[0], position[1])
    return offset(point, size, normal), normal, opacity


@jit
def sample_towards(geometry, lights, emitter, surface, u, v):
    """Sample a point of the triangle; a `LightSample`.

    Its `pdf` is that of points spread evenly: multiple importance sampling stays unbiased by any
    density on which both strategies agree.
    """
    triangle = lights.triangle[emitter]
    b1, b2, density = sample_triangle_light(
        corners_from(geometry, triangle, surface.point, surface.ns), u, v
    )
    if density == 0.0:
        return no_sample(surface.ns)
    target, normal, opacity = _emitting_point(geometry, triangle, (b1, b2))
    segment = vec.sub(target, surface.point)
    squared = vec.dot(segment, segment)
    if squared == 0.0:
        return no_sample(surface.ns)
    direction = vec.scale(segment, 1.0 / math.sqrt(squared))
    facing = -vec.dot(normal, direction)
    if facing <= 0.0:
        return no_sample(direction)
    even = warp.uniform_triangle_pdf(lights.area[emitter]) * squared / facing
    weight = opacity / (even * density)
    position = position_on(lights, emitter, (b1, b2), direction)
    return LightSample(segment, BEFORE_LAMP, direction, weight, even, position)


@jit
def pdf(geometry, lights, emitter, segment, direction):
    """Return the even density (per steradian) of a ray; `segment` leads to its hit."""
    facing = -vec.dot(vec.row(geometry.normals, lights.triangle[emitter]), direction)
    return warp.uniform_triangle_pdf(lights.area[emitter]) * vec.dot(segment, segment) / facing


@jit
def emit(geometry, lights, emitter, position, direction):
    """Start a photon, by two points of the unit square; a `PhotonStart`."""
    spot = warp.uniform_triangle(position[0], position[1])
    origin, normal, opacity = _emitting_point(geometry, lights.triangle[emitter], spot)
    direction = vec.from_frame(warp.cosine_hemisphere(direction[0], direction[1]), normal)
    seen = position_on(lights, emitter, spot, vec.scale(direction, -1.0))
    return PhotonStart(math.pi * lights.area[emitter] * opacity, seen, origin, direction)


@jit
def emitted(geometry, lights, emitter, start, direction):
    """Return what a `PhotonStart` sends in another direction, per steradian, and its density."""
    cosine = vec.dot(vec.row(geometry.normals, lights.triangle[emitter]), direction)
    pdf = warp.cosine_hemisphere_pdf(cosine)
    return start.weight * pdf, pdf
