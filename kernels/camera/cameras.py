"""The kinds of cameras, and the ray of each; nothing else asks where the eye is."""

import numpy as np

from photonmap.kernels.camera.lens import through_lens
from photonmap.kernels.camera.projections import distorted_ray, fisheye_ray, panorama_ray
from photonmap.kernels.camera.ray_map import mapped_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import Hit, Ray
from photonmap.kernels.geometry.opacity import intersect

PINHOLE, ORTHOGRAPHIC, DISTORTED, FISHEYE, PANORAMA, RAY_MAP = range(6)
"""Values of `Camera.kind`."""


@jit
def _on_image(camera, x, y):
    """Return the point or direction of film point (x, y), in pixels from the upper left corner."""
    return vec.add(camera.corner, vec.add(vec.scale(camera.across, x), vec.scale(camera.down, y)))


@jit
def _straight_ray(camera, x, y):
    """Return the ray of a camera that maps straight lines to straight lines.

    A pinhole's rays leave its origin in the directions of the image; those of an orthographic
    camera leave the points of the image in the direction that its origin holds.
    """
    if camera.kind == PINHOLE:
        return Ray(camera.origin, _on_image(camera, x, y))
    return Ray(_on_image(camera, x, y), camera.origin)


@outlined
def _curved_ray(camera, x, y):
    """Return the ray of any other camera."""
    if camera.kind == FISHEYE:
        return fisheye_ray(camera, x, y)
    if camera.kind == PANORAMA:
        return panorama_ray(camera, x, y)
    if camera.kind == RAY_MAP:
        return mapped_ray(camera, x, y)
    return distorted_ray(camera, x, y)


@jit
def _ray(optics, camera, x, y):
    if optics is None or camera.kind <= ORTHOGRAPHIC:
        return _straight_ray(camera, x, y)
    return _curved_ray(camera, x, y)


@jit
def generate_ray(camera, x, y):
    """Return the `Ray` through film point (x, y) in pixels and the centre of the lens.

    Its direction is of any length; (0, 0, 0) where no light reaches the film.
    """
    return _ray(camera.optics, camera, x, y)


@jit
def has_open_lens(optics):
    """Return whether rays through one film point differ."""
    return optics is not None and optics.lens.is_open


@jit
def _lens_ray(optics, ray, index, key):
    if optics is None or not optics.lens.is_open:
        return ray
    return through_lens(optics.lens, ray, index, key)


@jit
def generate_lens_ray(camera, x, y, index, key):
    """Return a `Ray` through film point (x, y) and point number `index` of the lens."""
    return _lens_ray(camera.optics, generate_ray(camera, x, y), index, key)


@jit
def is_dark(ray):
    """Return whether no light reaches the film point of a ray, as beyond a fisheye's circle."""
    return vec.dot(ray.direction, ray.direction) == 0.0


@jit
def first_hit(geometry, ray):
    """Return the `Hit` of a camera's ray; its triangle is -1 where it meets nothing, or is dark."""
    if is_dark(ray):
        nothing = np.float64(0.0)
        return Hit(np.int64(-1), nothing, nothing, np.float64(np.inf))
    return intersect(geometry, ray.origin, ray.direction)
