"""Rays that pass through the holes of surfaces whose opacity is below 1.

A surface of opacity a stops a ray with chance a. A hash of where and from where the ray comes
decides, so that no random numbers are spent and one ray always meets the same.
"""

import math

import numpy as np

from photonmap.kernels import vec
from photonmap.kernels.bands import divide
from photonmap.kernels.jit import jit, kernel, outlined
from photonmap.kernels.ray import intersect, occluded
from photonmap.kernels.rng import draw, stream
from photonmap.kernels.store import cell_at, place_in
from photonmap.kernels.surface import offset, point_at, side_of
from photonmap.kernels.texels import coordinates, look_up

MOST_LAYERS = 256
"""Surfaces that a ray passes through at most; the last one stops it."""
STEPS = float(1 << 40)
FINE = 8
"""Looks at a textured opacity along the side of a cell."""
LUMINANCE = (0.2126, 0.7152, 0.0722)


@jit
def opacity_at(geometry, alpha, triangle, u, v):
    """Return the opacity of a surface at barycentrics (u, v); alpha may be None."""
    if alpha is None:
        return 1.0
    material = geometry.material[triangle]
    image = alpha.image[material]
    if image < 0:
        return alpha.value[material]
    s, t = coordinates(geometry.uv, geometry.triangles, triangle, u, v)
    r, g, b = look_up(alpha.maps, image, s, t)
    # Of one grey exactly that.
    return g + LUMINANCE[0] * (r - g) + LUMINANCE[2] * (b - g)


@jit
def make_whole(geometry, alpha, triangle, u, v, flux):
    """Divide flux that a surface stopped by its opacity: what a whole surface would get."""
    if alpha is None:
        return
    divide(flux, opacity_at(geometry, alpha, triangle, u, v))


@kernel
def measure_cells(geometry, alpha, cells, areas, whole, there):
    """Add to `whole` and `there`, both (cells,), the area of each cell, and that of its surface."""
    for triangle in range(len(areas)):
        textured = alpha.image[geometry.material[triangle]] >= 0
        n = cells.divisions[triangle]
        for part in range(n * n):
            finer = 1
            for side in range(2):
                if n > 1 and cells.parts[cells.first[triangle, side] + part] >= 0:
                    finer = cells.finer
            steps = finer * (FINE if textured else 2)
            weight = areas[triangle] / (n * n * (steps * (steps + 1) // 2))
            for i in range(steps):
                for j in range(steps - i):
                    u, v = place_in(n, part, (i + 0.4) / steps, (j + 0.4) / steps)
                    opacity = opacity_at(geometry, alpha, triangle, u, v)
                    for side in range(2):
                        cell = cell_at(cells, triangle, side, u, v)
                        whole[cell] += weight
                        there[cell] += weight * opacity


@jit
def _bits(x):
    return np.uint64(np.int64(x * STEPS))


@jit
def _stops(geometry, alpha, triangle, u, v, direction):
    """Tell whether a surface stops a ray."""
    opacity = opacity_at(geometry, alpha, triangle, u, v)
    if opacity >= 1.0:
        return True
    if opacity <= 0.0:
        return False
    state = stream(triangle, _bits(u), _bits(v))
    state = stream(state, _bits(direction[0]) ^ (_bits(direction[1]) << np.uint64(20)),
                   _bits(direction[2]))  # fmt: skip
    return draw(state)[0] < opacity


@jit
def _beyond(geometry, triangle, u, v, direction):
    """Return the point where a ray leaves a surface that it passed through."""
    point, size = point_at(geometry, triangle, u, v)
    side = side_of(geometry, triangle, direction)
    normal = vec.row(geometry.normals, triangle)
    return offset(point, size, vec.scale(normal, 2.0 * side - 1.0))


@outlined
def _hit_opaque(geometry, alpha, origin, direction):
    passed = 0.0
    for _ in range(MOST_LAYERS):
        triangle, u, v, distance = intersect(geometry.scene, origin, direction)
        passed += distance
        if triangle < 0 or _stops(geometry, alpha, triangle, u, v, direction):
            break
        origin = _beyond(geometry, triangle, u, v, direction)
    return triangle, u, v, passed


@outlined
def _blocked_by_opaque(geometry, alpha, origin, direction, length):
    if not occluded(geometry.scene, origin, direction, length):
        return False
    start, rest = origin, direction
    for _ in range(MOST_LAYERS):
        triangle, u, v, distance = intersect(geometry.scene, start, rest)
        # A segment that ends is shortened to what is left of it, and has length 1.
        if triangle < 0 or distance >= length:
            return False
        if _stops(geometry, alpha, triangle, u, v, direction):
            return True
        start = _beyond(geometry, triangle, u, v, direction)
        if length < math.inf:
            end = vec.add(origin, vec.scale(direction, length))
            rest = vec.scale(vec.sub(end, start), 1.0 / length)
            if vec.dot(rest, direction) <= 0.0:
                return False
    return True


@jit
def _hit(geometry, alpha, origin, direction):
    if alpha is None:
        return intersect(geometry.scene, origin, direction)
    return _hit_opaque(geometry, alpha, origin, direction)


@jit
def _blocked(geometry, alpha, origin, direction, length):
    if alpha is None:
        return occluded(geometry.scene, origin, direction, length)
    return _blocked_by_opaque(geometry, alpha, origin, direction, length)


@jit
def hit(geometry, origin, direction):
    """Return (triangle, u, v, t) of the first hit that stops a ray; triangle -1 if none does."""
    return _hit(geometry, geometry.alpha, origin, direction)


@jit
def blocked(geometry, origin, direction, length):
    """Return whether anything stops a ray within origin + t direction, 0 < t < length."""
    return _blocked(geometry, geometry.alpha, origin, direction, length)
