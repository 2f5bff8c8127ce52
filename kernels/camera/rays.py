"""The rays and film points of a camera, as arrays."""

from photonmap.kernels.camera.cameras import film_point, generate_ray
from photonmap.kernels.core.jit import kernel


@kernel
def fill_rays(camera, x, y, rays):
    """Fill rays, (n, 6), with origin and direction through film points x, y: (n,), in pixels."""
    for i in range(len(x)):
        ray = generate_ray(camera, x[i], y[i])
        for axis in range(3):
            rays[i, axis] = ray.origin[axis]
            rays[i, 3 + axis] = ray.direction[axis]


@kernel
def fill_film_points(camera, points, seen):
    """Fill seen, (n, 3), with the film point, in pixels, and density of points, (n, 3)."""
    for i in range(len(points)):
        at = film_point(camera, (points[i, 0], points[i, 1], points[i, 2]))
        seen[i, 0], seen[i, 1], seen[i, 2] = at.x, at.y, at.density
