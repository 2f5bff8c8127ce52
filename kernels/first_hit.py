"""What lies at each pixel's centre: depth, normal and identity of the first hit."""

import math

from photonmap.kernels import vec
from photonmap.kernels.film import camera_ray
from photonmap.kernels.jit import kernel
from photonmap.kernels.opaque import hit
from photonmap.kernels.surface import meet, point_at


@kernel
def first_hits(geometry, camera, film, first, last, triangles, depth, normal):
    """Fill triangles (P,) int32 (-1: none), depth (P,), normal (P, 3) of pixels first..last."""
    for pixel in range(first, last):
        column, row = pixel % film.width, pixel // film.width
        direction = camera_ray(camera, column + 0.5, row + 0.5)
        triangle, u, v, _ = hit(geometry, camera.origin, direction)
        triangles[pixel] = triangle
        depth[pixel] = 0.0
        normal[pixel] = 0.0
        if triangle < 0:
            continue
        step = vec.sub(point_at(geometry, triangle, u, v)[0], camera.origin)
        ns = meet(geometry, triangle, u, v, direction)[2]
        depth[pixel] = math.sqrt(vec.dot(step, step))
        for axis in range(3):
            normal[pixel, axis] = ns[axis]
