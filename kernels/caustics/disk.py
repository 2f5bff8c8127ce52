"""Disks over which caustic photons count: their weights, and how much of a disk is surface."""

import math
from typing import NamedTuple

from photonmap.kernels.bsdf.specular import specular_probability
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.records import GLASS, THIN
from photonmap.kernels.core.rng import draw
from photonmap.kernels.geometry.interaction import point_at, side_of
from photonmap.kernels.geometry.opacity import behind, opacity_at
from photonmap.kernels.geometry.ray import closest_hit

ALIGNED = 0.7  # Cosine between normals above which photons count for each other's surface
FLATNESS = 0.3  # Height above the surface, in radii, within which photons count
LEVEL = 0.02  # The same beside what lets light pass, in whose light another surface may lie
ENOUGH = 4  # Rays that find surface in a disk
MOST_LOOKS = 64  # Rays of a disk
FARTHEST = 3.0  # Length of such a ray, in radii
LEAST_SLOPE = 1e-3  # Cosine between it and a surface
MOST_PASSED = 16  # Surfaces that such a ray passes


class Place(NamedTuple):
    """A point of a surface."""

    point: tuple[float, float, float]
    ng: tuple[float, float, float]  # on the side that is looked at
    triangle: int


@jit
def _lets_pass(scene, triangle):
    """Return whether a surface that photons reach lets light pass, too."""
    alpha, material = scene.geometry.alpha, scene.geometry.material[triangle]
    if alpha is not None and (alpha.image[material] >= 0 or alpha.value[material] < 1.0):
        return True
    if scene.specular is None or scene.specular.glass is None:
        return False
    return scene.specular.kind[material] == GLASS or scene.specular.kind[material] == THIN


@jit
def _is_level(photon, step, ng, radius):
    """Return whether a photon lies on the surface of a point, `step` apart, and not on a layer.

    On a sphere, the chord is perpendicular to the mean of both normals; facets deviate from that by
    half their angle at most.
    """
    turn = vec.sub(photon.ng, ng)
    slack = LEVEL + 0.5 * math.sqrt(vec.dot(turn, turn))
    return abs(vec.dot(step, vec.add(ng, photon.ng))) < 2.0 * slack * radius


@jit
def disk_weight(scene, photon, at, radius):
    """Return the weight of a photon for a place, 0 if it does not count: both are a `Place`.

    Weights fall from 1 as a parabola (Silverman 1986, 4.2).
    """
    step = vec.sub(photon.point, at.point)
    near = 1.0 - vec.dot(step, step) / (radius * radius)
    if near <= 0.0 or vec.dot(photon.ng, at.ng) < ALIGNED:
        return 0.0
    if abs(vec.dot(step, at.ng)) > FLATNESS * radius:
        return 0.0
    if scene.geometry.alpha is None and scene.specular.glass is None:
        return near
    if _lets_pass(scene, at.triangle) or _lets_pass(scene, photon.triangle):
        of = scene.geometry.material
        if of[at.triangle] != of[photon.triangle] or not _is_level(photon, step, at.ng, radius):
            return 0.0
    return near


@jit
def _is_passed(scene, triangle):
    """Return whether surfaces behind another may be lit, and seen, via it."""
    return specular_probability(scene, triangle) > 0.0 or _lets_pass(scene, triangle)


@jit
def _weight_at(scene, photon, hit, direction, radius):
    """Return the weight of a photon where a ray meets a surface, and the cosine of the two."""
    geometry, triangle = scene.geometry, hit.triangle
    ng = vec.scale(
        vec.row(geometry.normals, triangle), 1.0 - 2.0 * side_of(geometry, triangle, direction)
    )
    cosine = -vec.dot(ng, direction)
    if specular_probability(scene, triangle) == 1.0:
        return 0.0, cosine
    if opacity_at(geometry, triangle, hit.u, hit.v) == 0.0:
        return 0.0, cosine
    point, _ = point_at(geometry, triangle, hit.u, hit.v)
    return disk_weight(scene, photon, Place(point, ng, triangle), radius), cosine


@jit
def _look(scene, photon, origin, direction, radius):
    """Return (weight, cosine, distance) where a ray finds what a photon counts for; or 0, 1, 0."""
    distance = 0.0
    for _ in range(MOST_PASSED):
        hit = closest_hit(scene.geometry.scene, origin, direction)
        distance += hit.distance
        if hit.triangle < 0 or distance > FARTHEST * radius:
            break
        weight, cosine = _weight_at(scene, photon, hit, direction, radius)
        if weight > 0.0:
            return weight, cosine, distance
        if not _is_passed(scene, hit.triangle):
            break
        origin = behind(scene.geometry, hit, direction)
    return 0.0, 1.0, 0.0


@jit
def _free_height(scene, photon, radius):
    """Return how far a photon's surface sees along its normal, up to the radius."""
    origin, height = photon.point, 0.0
    for _ in range(MOST_PASSED):
        hit = closest_hit(scene.geometry.scene, origin, photon.ng)
        if hit.triangle < 0 or height + hit.distance >= radius:
            break
        height += hit.distance
        if not _is_passed(scene, hit.triangle):
            return 0.9 * height
        origin = behind(scene.geometry, hit, photon.ng)
    return radius


@jit
def _part_at(scene, photon, height, radius, r, s):
    """Return what a point of a photon's disk, drawn by (r, s), says of the part that is surface.

    That is 1 where the surface is flat there, 0 where it ends.
    """
    squared = 1.0 - math.sqrt(1.0 - r)
    cosine, sine = warp.cos_sin_2pi(s)
    across = radius * math.sqrt(squared)
    way = vec.from_frame((across * cosine, across * sine, -height), photon.ng)
    length = math.sqrt(across * across + height * height)
    eye = vec.add(photon.point, vec.scale(photon.ng, height))
    weight, slope, distance = _look(scene, photon, eye, vec.scale(way, 1.0 / length), radius)
    stretch = height * distance * distance / (length * length * length * max(slope, LEAST_SLOPE))
    return weight / (1.0 - squared) * stretch


@jit
def edge_correction(scene, photon, radius, state):
    """Return 1 / the part of a photon's disk, by weight, that is surface it counts for; and rays.

    Rays from above find what lies open: what stands on a surface hides it from light, too. They are
    drawn until enough found surface: their number has the mean that is sought (negative binomial
    sampling; Haldane 1945, "On a method of estimating frequencies").
    """
    height, found, looks = _free_height(scene, photon, radius), 0.0, 0
    while found < ENOUGH - 0.5 and looks < MOST_LOOKS:
        r, state = draw(state)
        s, state = draw(state)
        found += _part_at(scene, photon, height, radius, r, s)
        looks += 1
    return looks / max(found, 1.0), looks + 1
