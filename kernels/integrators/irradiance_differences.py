"""Differences of indirect irradiance between neighbouring pixels, without bias.

What a gather ray of one pixel finds at its end y is what its neighbour would find there too, if y
is Lambertian and both see it: only how densely each casts rays onto y differs. With p the density
of a pixel's gather rays per unit of area at y, 0 where y is hidden from it, and q that of its
neighbour's, a ray that brings irradiance E to the pixel says of the neighbour's irradiance minus
the pixel's

    E (q − p) / (q + p),

and the rays of the neighbour say the rest: both together have the difference as their mean, by
multiple importance sampling with the balance heuristic, as in gradient-domain path tracing
(Kettunen et al. 2015). Each says little where the two pixels see alike, however noisy E is.
"""

from typing import NamedTuple

import numpy as np

from photonmap.kernels.camera.cameras import first_hit, generate_lens_ray
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.passes import CAMERA, INDIRECT, SHADOW
from photonmap.kernels.film.linked_pixels import NEIGHBOURS, neighbour, step_to
from photonmap.kernels.geometry.interaction import surface_interaction
from photonmap.kernels.geometry.opacity import occluded

EXISTS, SEES = 9, 10
"""Columns of `Scratch.shifted`, after point and both normals: whether the neighbour is in the
image, and whether the camera sample would see a surface there"""


class Shifts(NamedTuple):
    """Where the rays of a camera sample add what they say of its pixel's neighbours."""

    differences: np.ndarray  # (5, P, N), of `Estimate`
    pixel: int
    weight: float  # of the sample in its pixel


@jit
def _shift(job, position, index, pixel, number, scratch):
    """Look at what the camera sample would see a pixel further, and keep it in the scratch."""
    geometry, kept = job.scene.geometry, scratch.shifted[number]
    width = job.eye.film.width
    x, y = step_to(number)
    ray = generate_lens_ray(
        job.eye.camera, pixel % width + x + position[0], pixel // width + y + position[1],
        index, job.key,
    )  # fmt: skip
    hit = first_hit(geometry, ray)
    scratch.rays[CAMERA] += 1
    kept[SEES] = 0.0
    if hit.triangle < 0:
        return
    surface = surface_interaction(geometry, hit, ray.direction)
    kept[SEES] = 1.0
    for axis in range(3):
        kept[axis] = surface.point[axis]
        kept[3 + axis] = surface.ng[axis]
        kept[6 + axis] = surface.ns[axis]


@jit
def begin_shifts(job, differences, position, index, pixel, weight, scratch):
    """Look at what a camera sample would see in each neighbour; return `Shifts`, or None."""
    if differences is None:
        return None
    for number in range(NEIGHBOURS):
        exists = neighbour(job.eye.film, pixel, number) >= 0
        scratch.shifted[number, EXISTS] = exists
        if exists:
            _shift(job, position, index, pixel, number, scratch)
    return Shifts(differences, pixel, weight)


@jit
def _density(point, ng, ns, end):
    """Return with which density gather rays from a point reach `end` if it is seen, times π."""
    way = vec.sub(end.point, point)
    square = vec.dot(way, way)
    cosine, there = vec.dot(way, ns), -vec.dot(way, end.ng)
    if cosine <= 0.0 or there <= 0.0 or vec.dot(way, ng) <= 0.0:
        return 0.0
    return cosine * there / (square * square)


@jit
def _neighbour_density(geometry, kept, end, rays):
    """Return `_density` from a neighbour, 0 if `end` is hidden from it."""
    if kept[SEES] == 0.0:
        return 0.0
    point, ng, ns = (
        (kept[0], kept[1], kept[2]), (kept[3], kept[4], kept[5]), (kept[6], kept[7], kept[8]),
    )  # fmt: skip
    density = _density(point, ng, ns, end)
    if density == 0.0:
        return 0.0
    rays[SHADOW] += 1
    return 0.0 if occluded(geometry, point, vec.sub(end.point, point), 1.0) else density


@jit
def add_differences(scene, shifts, surface, hit, direction, light, scratch):
    """Add what a gather ray that brings `light`, (rows, N), from a Lambertian `hit` says."""
    if shifts is None:
        return
    if hit.triangle < 0:
        return
    end = surface_interaction(scene.geometry, hit, direction)
    own = _density(surface.point, surface.ng, surface.ns, end)
    _add(shifts, 0, 1.0, light)
    for number in range(NEIGHBOURS):
        if scratch.shifted[number, EXISTS] != 0.0:
            other = _neighbour_density(scene.geometry, scratch.shifted[number], end, scratch.rays)
            _add(shifts, 1 + number, (other - own) / max(other + own, 1e-30), light)


@jit
def _add(shifts, row, factor, light):
    factor = np.float32(factor * shifts.weight)
    for band in range(light.shape[1]):
        shifts.differences[row, shifts.pixel, band] += factor * light[INDIRECT, band]
