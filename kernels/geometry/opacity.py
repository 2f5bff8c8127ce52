"""Rays through surfaces whose opacity is below 1.

A surface of opacity a stops a ray with probability a; that of a pane depends on the angle. A hash
of where the ray meets it, and from which direction, decides: no random numbers are spent, and one
ray always meets the same surface.
"""

import math

import numpy as np

from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import Hit
from photonmap.kernels.core.rng import draw, stream
from photonmap.kernels.geometry.interaction import offset, point_at, side_of
from photonmap.kernels.geometry.pane import pane_opacity
from photonmap.kernels.geometry.ray import any_hit, closest_hit
from photonmap.kernels.geometry.texture import coordinates, look_up_number

MOST_LAYERS = 256  # Surfaces that a ray passes through at most; the last one stops it
STEPS = float(1 << 40)  # Of the unit interval, to which coordinates are rounded before hashing


@jit
def opacity_at(geometry, triangle, u, v):
    """Return the opacity of a surface at barycentrics (u, v)."""
    alpha = geometry.alpha
    if alpha is None:
        return 1.0
    material = geometry.material[triangle]
    image = alpha.image[material]
    if image < 0:
        return alpha.value[material]
    s, t = coordinates(geometry.uv, geometry.triangles, triangle, u, v)
    return look_up_number(alpha.maps, image, s, t)


@jit
def opacity_along(geometry, hit, direction):
    """Return with which probability a surface stops a ray."""
    if geometry.alpha is None:
        return 1.0
    opacity = opacity_at(geometry, hit.triangle, hit.u, hit.v)
    return opacity * pane_opacity(geometry, hit, direction)


@jit
def divide_by_opacity(geometry, hit, flux):
    """Divide flux that a surface stopped by its opacity: what an opaque surface would get."""
    if geometry.alpha is None:
        return
    divide(flux, opacity_at(geometry, hit.triangle, hit.u, hit.v))


@jit
def _bits(x):
    return np.uint64(np.int64(x * STEPS))


@jit
def _stops(geometry, hit, direction):
    """Return whether a surface stops a ray."""
    opacity = opacity_along(geometry, hit, direction)
    if opacity >= 1.0:
        return True
    if opacity <= 0.0:
        return False
    state = stream(hit.triangle, _bits(hit.u), _bits(hit.v))
    state = stream(state, _bits(direction[0]) ^ (_bits(direction[1]) << np.uint64(20)),
                   _bits(direction[2]))  # fmt: skip
    return draw(state)[0] < opacity


@jit
def behind(geometry, hit, direction):
    """Return the point where a ray leaves a surface that it passed through."""
    point, size = point_at(geometry, hit.triangle, hit.u, hit.v)
    side = side_of(geometry, hit.triangle, direction)
    normal = vec.row(geometry.normals, hit.triangle)
    return offset(point, size, vec.scale(normal, 2.0 * side - 1.0))


@outlined
def _intersect_layers(geometry, origin, direction):
    distance = 0.0
    for _ in range(MOST_LAYERS):
        hit = closest_hit(geometry.scene, origin, direction)
        distance += hit.distance
        if hit.triangle < 0 or _stops(geometry, hit, direction):
            break
        origin = behind(geometry, hit, direction)
    return Hit(hit.triangle, hit.u, hit.v, distance)


@outlined
def _occluded_by_layers(geometry, origin, direction, length):
    if not any_hit(geometry.scene, origin, direction, length):
        return False
    start, rest = origin, direction
    for _ in range(MOST_LAYERS):
        hit = closest_hit(geometry.scene, start, rest)
        # A segment that ends is shortened to what is left of it, and has length 1.
        if hit.triangle < 0 or hit.distance >= length:
            return False
        if _stops(geometry, hit, direction):
            return True
        start = behind(geometry, hit, direction)
        if length < math.inf:
            end = vec.add(origin, vec.scale(direction, length))
            rest = vec.scale(vec.sub(end, start), 1.0 / length)
            if vec.dot(rest, direction) <= 0.0:
                return False
    return True


@jit
def intersect(geometry, origin, direction):
    """Return the first `Hit` that stops a ray; its triangle is -1 if none does."""
    if geometry.alpha is None:
        return closest_hit(geometry.scene, origin, direction)
    return _intersect_layers(geometry, origin, direction)


@jit
def occluded(geometry, origin, direction, length):
    """Return whether anything stops a ray within origin + t direction, 0 < t < length."""
    if geometry.alpha is None:
        return any_hit(geometry.scene, origin, direction, length)
    return _occluded_by_layers(geometry, origin, direction, length)
