"""The rays of a camera, as an array."""

from photonmap.kernels.camera.cameras import generate_ray
from photonmap.kernels.core.jit import kernel


@kernel
def fill_rays(camera, x, y, rays):
    """Fill rays, (n, 6), with origin and direction through film points x, y: (n,), in pixels."""
    for i in range(len(x)):
        ray = generate_ray(camera, x[i], y[i])
        for axis in range(3):
            rays[i, axis] = ray.origin[axis]
            rays[i, 3 + axis] = ray.direction[axis]
