"""What lies at each pixel's centre: distance, depth, normal and identity of the first hit."""

import math

from photonmap.kernels.camera.cameras import first_hit, generate_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.geometry.interaction import point_at, surface_interaction


@kernel
def first_hits(geometry, view, span, triangles, distance, depth, normal):
    """Fill the first hits of the pixels of a span, by rays through the centre of the lens.

    Triangles (P,) int32 (-1: none), distance and depth (P,), normal (P, 3). Depth is measured along
    the camera's axis; where it has none, it is the distance.
    """
    film, ahead = view.film, view.camera.axis
    has_axis = vec.dot(ahead, ahead) > 0.0
    for pixel in range(span.first, span.last):
        column, row = pixel % film.width, pixel // film.width
        ray = generate_ray(view.camera, column + 0.5, row + 0.5)
        hit = first_hit(geometry, ray)
        triangles[pixel] = hit.triangle
        distance[pixel] = 0.0
        depth[pixel] = 0.0
        normal[pixel] = 0.0
        if hit.triangle < 0:
            continue
        step = vec.sub(point_at(geometry, hit.triangle, hit.u, hit.v)[0], ray.origin)
        ns = surface_interaction(geometry, hit, ray.direction).ns
        distance[pixel] = math.sqrt(vec.dot(step, step))
        depth[pixel] = vec.dot(step, ahead) if has_axis else distance[pixel]
        for axis in range(3):
            normal[pixel, axis] = ns[axis]
