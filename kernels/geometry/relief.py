"""Relief: shading normals that images turn, as normal maps or by heights.

A normal map holds directions in the frame of tangent, bitangent and normal, each coordinate from -1
to 1; the tangent points to where u rises, the bitangent to where v does. A map of heights holds
their derivatives by u and v (J. F. Blinn, "Simulation of wrinkled surfaces", SIGGRAPH 1978). The
surface itself stays as it is, and so do its edges and its shadows.
"""

import math

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.texture import coordinates_at, look_up

TINY = 1e-30
NONE = (0.0, 0.0, 0.0)
LEAST_COSINE = 1e-3  # Between a normal and the turned one: one that leans further stays


@jit
def derivatives(geometry, triangle):
    """Return derivatives of points by u and v, and twice the signed area in (u, v), 0 for none."""
    triangles, uv = geometry.triangles, geometry.uv
    a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
    p = vec.row(geometry.vertices, a)
    first = vec.sub(vec.row(geometry.vertices, b), p)
    second = vec.sub(vec.row(geometry.vertices, c), p)
    along = float(uv[b, 0]) - uv[a, 0], float(uv[b, 1]) - uv[a, 1]
    across = float(uv[c, 0]) - uv[a, 0], float(uv[c, 1]) - uv[a, 1]
    area = along[0] * across[1] - across[0] * along[1]
    if abs(area) < TINY:
        return first, second, 0.0
    by_u = vec.sub(vec.scale(first, across[1] / area), vec.scale(second, along[1] / area))
    by_v = vec.sub(vec.scale(second, along[0] / area), vec.scale(first, across[0] / area))
    return by_u, by_v, area


@jit
def tangent_at(geometry, tangents, hit, by_u):
    """Return the tangent that is interpolated between vertices; that of the triangle if flat."""
    t = vec.interpolated(tangents, geometry.triangles, hit)
    return t if vec.dot(t, t) > 1e-6 else by_u


@jit
def handedness(tangents, triangle, geometry):
    """Return the sign of the tangents that a mesh gives, as in MikkTSpace; 0 where it has none."""
    return float(tangents[geometry.triangles[triangle, 0], 3])


@jit
def _given_frame(geometry, relief, hit, n, sign):
    """Return tangent, bitangent and normal as they are interpolated: the frame of MikkTSpace."""
    mean = vec.interpolated(geometry.shading_normals, geometry.triangles, hit)
    n = vec.scale(n, math.sqrt(vec.dot(mean, mean)))
    tangent = tangent_at(geometry, relief.tangents, hit, (0.0, 0.0, 0.0))
    return tangent, vec.scale(vec.cross(n, tangent), sign), n


@jit
def _own_frame(geometry, relief, hit, n):
    """Return tangent, bitangent and normal of length 1 by texture coordinates; 0 without."""
    by_u, _, area = derivatives(geometry, hit.triangle)
    tangent = tangent_at(geometry, relief.tangents, hit, by_u)
    tangent = vec.sub(tangent, vec.scale(n, vec.dot(n, tangent)))
    length = math.sqrt(vec.dot(tangent, tangent))
    if area == 0.0 or length < TINY:
        return NONE, NONE, n
    tangent = vec.scale(tangent, 1.0 / length)
    return tangent, vec.scale(vec.cross(n, tangent), math.copysign(1.0, area)), n


@jit
def _from_directions(geometry, relief, hit, n, texel):
    """Return the direction that a normal map gives."""
    strength = relief.strength[geometry.material[hit.triangle]]
    sign = handedness(relief.tangents, hit.triangle, geometry)
    if sign != 0.0:
        tangent, bitangent, n = _given_frame(geometry, relief, hit, n, sign)
    else:
        tangent, bitangent, n = _own_frame(geometry, relief, hit, n)
    if tangent == NONE:
        return n
    x, y = strength * (2.0 * texel[0] - 1.0), strength * (2.0 * texel[1] - 1.0)
    turned = vec.add(vec.scale(tangent, x), vec.scale(bitangent, y))
    return vec.add(turned, vec.scale(n, 2.0 * texel[2] - 1.0))


@jit
def _from_slopes(geometry, relief, hit, n, texel):
    """Return the normal of the surface that heights of these derivatives by u and v would raise."""
    height = relief.strength[geometry.material[hit.triangle]]
    by_u, by_v, area = derivatives(geometry, hit.triangle)
    volume = vec.dot(n, vec.cross(by_u, by_v))
    if area == 0.0 or abs(volume) < TINY:
        return n
    gradient = vec.add(
        vec.scale(vec.cross(by_v, n), height * texel[0] / volume),
        vec.scale(vec.cross(n, by_u), height * texel[1] / volume),
    )
    return vec.sub(n, gradient)


@jit
def _turn(geometry, relief, hit, n):
    """Return the unit normal on the front that the relief makes of one."""
    s, t = coordinates_at(geometry, hit)
    material = geometry.material[hit.triangle]
    texel = look_up(relief.maps, relief.image[material], s, t)
    if relief.is_height[material]:
        turned = _from_slopes(geometry, relief, hit, n, texel)
    else:
        turned = _from_directions(geometry, relief, hit, n, texel)
    length = math.sqrt(vec.dot(turned, turned))
    if vec.dot(turned, n) < LEAST_COSINE * length or length < TINY:
        return n
    return vec.scale(turned, 1.0 / length)


@jit
def turned_normal(geometry, relief, hit, n, side):
    """Return the shading normal on a side, of a hit whose interpolated normal there is `n`."""
    return n if relief is None else _turned(geometry, relief, hit, n, side)


@outlined
def _turned(geometry, relief, hit, n, side):
    if relief.image[geometry.material[hit.triangle]] < 0:
        return n
    sign = 1.0 - 2.0 * side
    return vec.scale(_turn(geometry, relief, hit, vec.scale(n, sign)), sign)
