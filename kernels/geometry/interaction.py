"""Surface interactions: point, normals and side where a ray meets a triangle."""

import math

from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import Hit, SurfaceInteraction
from photonmap.kernels.geometry.relief import turned_normal

# How far a hit computed in float32 can be from its triangle, relative to the coordinates that
# enter it, and a distance that keeps a ray's origin off a plane through the scene's centre.
HIT_ERROR = 12.0 * 2.0**-24
LEAST_OFFSET = 2.0**-40
LEAST_BARYCENTRIC = 2.0**-20
MOST_ROUNDED = 2.0**-10  # By how much barycentrics in float32 may be wrong


@jit
def departure(surface):
    """Return wo: the unit vector to where a ray came from."""
    return vec.normalize(vec.scale(surface.arrival, -1.0))


@jit
def side_of(geometry, triangle, direction):
    """Return 0 where `direction` arrives at the front of a triangle, 1 at its back."""
    return 0 if vec.dot(vec.row(geometry.normals, triangle), direction) < 0.0 else 1


@jit
def point_at(geometry, triangle, u, v):
    """Return the point of barycentrics (u, v), and a bound on its coordinates' magnitude."""
    p0 = vec.row(geometry.vertices, geometry.triangles[triangle, 0])
    p1 = vec.row(geometry.vertices, geometry.triangles[triangle, 1])
    p2 = vec.row(geometry.vertices, geometry.triangles[triangle, 2])
    w = 1.0 - u - v
    point = (
        w * p0[0] + u * p1[0] + v * p2[0],
        w * p0[1] + u * p1[1] + v * p2[1],
        w * p0[2] + u * p1[2] + v * p2[2],
    )
    size = (
        w * abs(p0[0]) + u * abs(p1[0]) + v * abs(p2[0]),
        w * abs(p0[1]) + u * abs(p1[1]) + v * abs(p2[1]),
        w * abs(p0[2]) + u * abs(p1[2]) + v * abs(p2[2]),
    )
    return point, size


@jit
def offset(point, size, normal):
    """Move a point off its surface by more than its error (Pharr et al. 2023, PBRT, 6.8)."""
    across = abs(normal[0]) * size[0] + abs(normal[1]) * size[1] + abs(normal[2]) * size[2]
    distance = HIT_ERROR * across + LEAST_OFFSET
    return vec.add(point, vec.scale(normal, distance))


@jit
def interpolated_normal(normals, triangles, hit, ng, side):
    """Return one of normals, (V, 3), interpolated, on the side of ng; ng where the mesh is flat."""
    if normals.shape[0] == 0:
        return ng
    n = vec.interpolated(normals, triangles, hit)
    length = math.sqrt(vec.dot(n, n))
    if length < 1e-6:
        return ng
    return vec.scale(n, (1.0 - 2.0 * side) / length)


@jit
def shading_normal(geometry, hit, ng, side):
    """Return the normal on the side of ng that light is reflected by: interpolated, then turned."""
    n = interpolated_normal(geometry.shading_normals, geometry.triangles, hit, ng, side)
    return turned_normal(geometry, geometry.relief, hit, n, side)


@jit
def surface_interaction(geometry, hit, direction):
    """Return the `SurfaceInteraction` of a ray that hits a triangle: all on the side of arrival."""
    side = side_of(geometry, hit.triangle, direction)
    ng = vec.scale(vec.row(geometry.normals, hit.triangle), 1.0 - 2.0 * side)
    ns = shading_normal(geometry, hit, ng, side)
    # Off the edges, where a point could lie on either side of the next wall.
    u, v = max(hit.u, LEAST_BARYCENTRIC), max(hit.v, LEAST_BARYCENTRIC)
    excess = max(u + v - (1.0 - LEAST_BARYCENTRIC), 0.0)
    point, size = point_at(geometry, hit.triangle, u - 0.5 * excess, v - 0.5 * excess)
    return SurfaceInteraction(offset(point, size, ng), point, ng, ns, side, hit, direction, 0)


@jit
def _meet_exactly(geometry, hit, ray):
    """Return (hit, site, normal of any length) of a ray and a triangle's exact plane."""
    p0 = vec.row(geometry.corners, geometry.triangles[hit.triangle, 0])
    first = vec.sub(vec.row(geometry.corners, geometry.triangles[hit.triangle, 1]), p0)
    second = vec.sub(vec.row(geometry.corners, geometry.triangles[hit.triangle, 2]), p0)
    normal = vec.cross(first, second)
    advance = vec.dot(vec.sub(p0, ray.origin), normal) / vec.dot(ray.direction, normal)
    site = vec.add(ray.origin, vec.scale(ray.direction, advance))
    step, inverse = vec.sub(site, p0), 1.0 / vec.dot(normal, normal)
    u = vec.dot(vec.cross(step, second), normal) * inverse
    v = vec.dot(vec.cross(first, step), normal) * inverse
    return Hit(hit.triangle, u, v, advance), site, normal


@jit
def first_interaction(geometry, hit, ray):
    """Return the `SurfaceInteraction` of a camera's ray.

    Where lights have no area, no samples hide that hits and vertices are rounded to float32, which
    shows near them, at grazing angles and at the edges of cones. The ray meets the scene itself
    there; but relief turns rounded normals.
    """
    is_exact, site, normal = geometry.corners.shape[0] > 0, ray.origin, ray.direction
    if is_exact:
        exact, site, normal = _meet_exactly(geometry, hit, ray)
        is_exact = abs(exact.u - hit.u) + abs(exact.v - hit.v) < MOST_ROUNDED  # not edge-on
        if is_exact:
            hit = exact
    surface = surface_interaction(geometry, hit, ray.direction)
    if not is_exact:
        return surface
    point, side, ns = surface.point, surface.side, surface.ns
    ng = vec.scale(vec.normalize(normal), 1.0 - 2.0 * side)
    if geometry.relief is None:
        ns = interpolated_normal(geometry.corner_normals, geometry.triangles, hit, ng, side)
    return SurfaceInteraction(point, site, ng, ns, side, hit, ray.direction, surface.model)
