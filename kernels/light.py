"""Emitters: samples towards a point for direct light, and photons that leave them."""

import math

from photonmap.kernels import surface, vec, warp
from photonmap.kernels.jit import jit
from photonmap.kernels.ray import occluded
from photonmap.kernels.records import DOME, POINT


@jit
def _point_of_emitter(geometry, triangle, u, v):
    """Return (point, ng) on the front of an emitting triangle, offset off it."""
    b1, b2 = warp.uniform_triangle(u, v)
    point, size = surface.point_at(geometry, triangle, b1, b2)
    normal = vec.row(geometry.normals, triangle)
    return surface.offset(point, size, normal), normal


@jit
def _lit(ng, ns, direction):
    """Return cos θ to the shading normal, 0 where the normals disagree about the side."""
    return max(vec.dot(ns, direction), 0.0) if vec.dot(ng, direction) > 0.0 else 0.0


@jit
def emitted(geometry, lights, triangle, side):
    """Return the row of spectra that a ray's end shows, -1 if it shows none."""
    emitter = lights.dome if triangle < 0 else geometry.emitter[triangle] if side == 0 else -1
    return lights.spectrum[emitter] if emitter >= 0 else -1


@jit
def sample_direct(geometry, lights, point, ng, ns, u, v, samples, gathers):
    """Sample one emitter for the irradiance at a point.

    Returns (emitter, weight): the sum of weight · lights.spectra[row of the emitter] over
    `samples` such samples and `gathers` cosine-distributed rays, weighed by the balance heuristic
    (Veach 1997, 9.2.4), estimates irradiance. A weight of 0 with emitter >= 0 is a light that is
    blocked; emitter -1 is one that is not in front.
    """
    emitter, u = warp.discrete(lights.cumulative, u)
    chance = warp.discrete_pdf(lights.cumulative, emitter)
    kind = lights.kind[emitter]
    if kind == DOME:
        direction = vec.from_frame(warp.cosine_hemisphere(u, v), ns)
        if _lit(ng, ns, direction) == 0.0:
            return -1, 0.0
        blocked = occluded(geometry.scene, point, direction, math.inf)
        return emitter, 0.0 if blocked else math.pi / (samples * chance + gathers)
    if kind == POINT:
        target = vec.row(lights.position, emitter)
        normal = ng
    else:
        target, normal = _point_of_emitter(geometry, lights.triangle[emitter], u, v)
    segment = vec.sub(target, point)
    squared = vec.dot(segment, segment)
    if squared == 0.0:
        return -1, 0.0
    direction = vec.scale(segment, 1.0 / math.sqrt(squared))
    cosine = _lit(ng, ns, direction)
    facing = 1.0 if kind == POINT else -vec.dot(normal, direction)
    if cosine == 0.0 or facing <= 0.0:
        return -1, 0.0
    if occluded(geometry.scene, point, segment, 1.0):
        return emitter, 0.0
    if kind == POINT:
        return emitter, cosine / (samples * squared * chance)
    pdf = chance * warp.uniform_triangle_pdf(lights.area[emitter]) * squared / facing
    return emitter, cosine / (samples * pdf + gathers * warp.cosine_hemisphere_pdf(cosine))


@jit
def weigh_hit(geometry, lights, emitter, point, hit, direction, cosine, samples, gathers):
    """Weight of an emitting triangle hit by a cosine-distributed ray, as in `sample_direct`."""
    segment = vec.sub(hit, point)
    facing = -vec.dot(vec.row(geometry.normals, lights.triangle[emitter]), direction)
    chance = warp.discrete_pdf(lights.cumulative, emitter)
    pdf = chance * warp.uniform_triangle_pdf(lights.area[emitter])
    pdf *= vec.dot(segment, segment) / facing
    return cosine / (samples * pdf + gathers * warp.cosine_hemisphere_pdf(cosine))


@jit
def weigh_miss(lights, samples, gathers):
    """Weight of the dome seen by a cosine-distributed ray, as in `sample_direct`."""
    return math.pi / (samples * warp.discrete_pdf(lights.cumulative, lights.dome) + gathers)


@jit
def emit(geometry, lights, place, aim):
    """Send a photon from an emitter: place and aim are points of the unit square.

    Returns (emitter, weight, origin, direction): its flux is weight · the emitter's spectrum.
    """
    emitter, u = warp.discrete(lights.cumulative, place[0])
    v = place[1]
    chance = warp.discrete_pdf(lights.cumulative, emitter)
    kind = lights.kind[emitter]
    if kind == POINT:
        weight = 1.0 / (warp.uniform_sphere_pdf() * chance)
        origin = vec.row(lights.position, emitter)
        return emitter, weight, origin, warp.uniform_sphere(aim[0], aim[1])
    if kind == DOME:
        direction = warp.uniform_sphere(aim[0], aim[1])
        x, y = warp.uniform_disk(u, v)
        local = (lights.radius * x, lights.radius * y, -2.0 * lights.radius)
        density = warp.uniform_sphere_pdf() * warp.uniform_disk_pdf()
        weight = lights.radius * lights.radius / (density * chance)
        return emitter, weight, vec.from_frame(local, direction), direction
    origin, normal = _point_of_emitter(geometry, lights.triangle[emitter], u, v)
    direction = vec.from_frame(warp.cosine_hemisphere(aim[0], aim[1]), normal)
    return emitter, math.pi * lights.area[emitter] / chance, origin, direction
