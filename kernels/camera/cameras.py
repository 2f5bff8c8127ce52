"""The kinds of cameras: the ray through a film point, and the film point of a point in space.

Rays through a thin lens leave points of its opening, and meet where it is focused. Nothing else
asks where the eye is.
"""

import math

import numpy as np

from photonmap.kernels.camera.projections import (
    UNSEEN,
    distorted_point,
    distorted_ray,
    fisheye_point,
    fisheye_ray,
    mapped_ray,
    panorama_point,
    panorama_ray,
)
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, kernel, outlined
from photonmap.kernels.core.passes import FilmPoint, Hit, Ray
from photonmap.kernels.core.rng import sobol_2d
from photonmap.kernels.core.streams import LENS, split
from photonmap.kernels.geometry.opacity import intersect

PINHOLE, ORTHOGRAPHIC, DISTORTED, FISHEYE, PANORAMA, RAY_MAP = range(6)  # Values of `Camera.kind`
WITHOUT_FILM_POINTS = (RAY_MAP,)  # Those for which `film_point` finds none


@outlined
def _curved_ray(camera, x, y):
    """Return the ray of a camera that bends straight lines."""
    if camera.kind == FISHEYE:
        return fisheye_ray(camera, x, y)
    if camera.kind == PANORAMA:
        return panorama_ray(camera, x, y)
    if camera.kind == RAY_MAP:
        return mapped_ray(camera, x, y)
    return distorted_ray(camera, x, y)


@jit
def generate_ray(camera, x, y):
    """Return the `Ray` through film point (x, y) in pixels and the centre of the lens.

    Its direction is of any length; (0, 0, 0) where no light reaches the film. A pinhole's rays
    leave its origin in the directions of the image; those of an orthographic camera leave the
    points of the image in the direction that its origin holds.
    """
    if camera.optics is not None and camera.kind > ORTHOGRAPHIC:
        return _curved_ray(camera, x, y)
    pixels = vec.add(vec.scale(camera.across, x), vec.scale(camera.down, y))
    on_image = vec.add(camera.corner, pixels)
    return Ray(camera.origin, on_image) if camera.kind == PINHOLE else Ray(on_image, camera.origin)


@jit
def _straight_point(camera, point):
    """Return the `FilmPoint` of a camera that maps straight lines to straight lines."""
    across, down = camera.across, camera.down
    normal = vec.cross(across, down)
    if camera.kind == PINHOLE:
        step, height = vec.sub(point, camera.origin), vec.dot(camera.corner, normal)
        advance = vec.dot(step, normal) / height
        if advance <= 0.0:
            return UNSEEN
        step = vec.scale(step, 1.0 / advance)
        density = math.sqrt(vec.dot(step, step)) / (advance * advance * abs(height))
        step = vec.sub(step, camera.corner)
    else:
        step, height = vec.sub(point, camera.corner), vec.dot(camera.origin, normal)
        if vec.dot(step, normal) / height <= 0.0:
            return UNSEEN
        density = math.sqrt(vec.dot(camera.origin, camera.origin)) / abs(height)
    x = vec.dot(step, across) / vec.dot(across, across)
    y = vec.dot(step, down) / vec.dot(down, down)
    return FilmPoint(x, y, density)


@outlined
def _curved_point(camera, point):
    """Return the `FilmPoint` of a camera that bends straight lines."""
    if camera.kind in WITHOUT_FILM_POINTS:
        return UNSEEN
    if camera.kind == FISHEYE:
        return fisheye_point(camera, point)
    if camera.kind == PANORAMA:
        return panorama_point(camera, point)
    return distorted_point(camera, point)


@jit
def film_point(camera, point):
    """Return the `FilmPoint` of a point in space: the inverse of `generate_ray`."""
    if camera.optics is not None and camera.kind > ORTHOGRAPHIC:
        return _curved_point(camera, point)
    return _straight_point(camera, point)


@jit
def has_open_lens(optics):
    """Return whether rays through one film point differ."""
    return optics is not None and optics.lens.is_open


@jit
def generate_lens_ray(camera, x, y, index, key):
    """Return a `Ray` through film point (x, y) and point number `index` of the lens."""
    ray = generate_ray(camera, x, y)
    if camera.optics is None or not camera.optics.lens.is_open:
        return ray
    return _through_lens(camera.optics.lens, ray, index, key)


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


@jit
def _in_polygon(blades, u, v):
    """Return a point of the regular polygon in the unit circle, uniform by area."""
    blade = min(int(u * blades), blades - 1)
    s, t = warp.uniform_triangle(u * blades - blade, v)
    low, high = 2.0 * math.pi * blade / blades, 2.0 * math.pi * (blade + 1) / blades
    return s * math.cos(low) + t * math.cos(high), s * math.sin(low) + t * math.sin(high)


@outlined
def _through_lens(lens, ray, index, key):
    """Return the ray from a point of the lens to the focus of `ray`, which advances by 1."""
    u, v = sobol_2d(index, split(key, LENS))
    x, y = _in_polygon(lens.blades, u, v) if lens.blades > 0 else warp.uniform_disk(u, v)
    shift = vec.add(vec.scale(lens.right, x), vec.scale(lens.up, y))
    direction = vec.sub(ray.direction, vec.scale(shift, lens.nearness))
    return Ray(vec.add(ray.origin, shift), direction)


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
