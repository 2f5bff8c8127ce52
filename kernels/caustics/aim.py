"""Photons aimed at spheres around specular surfaces: only those that hit one first make caustics.

A sphere is chosen by the solid angle it is seen under (by its area, from infinitely far) times its
importance, and a direction within its cone, or as the light would send it where that is narrower.
Spheres may overlap: a photon's density is the sum over all that it could have been aimed at.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.lights.dome import start_at
from photonmap.kernels.lights.emission import send
from photonmap.kernels.lights.kinds import DIRECTIONAL, DOME, emit, emitted
from photonmap.kernels.lights.portal import let_in, position_on
from photonmap.kernels.lights.samples import PhotonStart
from photonmap.kernels.lights.sun import emit_from_outside

MIDDLE = (0.5, 0.5)


@jit
def _cone(geometry, lights, emitter, start, sphere):
    """Return a sphere's cone: (axis, 1 - cosine, solid angle, whether the light is narrower)."""
    axis = vec.sub((sphere[0], sphere[1], sphere[2]), start.origin)
    squared, radius = vec.dot(axis, axis), sphere[3]
    if squared <= radius * radius:
        return axis, 2.0, 4.0 * math.pi, True
    axis = vec.scale(axis, 1.0 / math.sqrt(squared))
    sine = radius * radius / squared
    versine = sine / (1.0 + math.sqrt(1.0 - sine))
    solid = 2.0 * math.pi * versine
    _, pdf = emitted(geometry, lights, emitter, start, axis)
    return axis, versine, solid, solid * pdf >= 1.0


@jit
def _towards(geometry, lights, emitter, guide, sums, start, position, direction):
    """Aim a photon from a position; return (`PhotonStart`, sphere)."""
    for k in range(len(sums)):
        solid = _cone(geometry, lights, emitter, start, guide.spheres[k])[2]
        sums[k] = guide.importance[k] * solid + (sums[k - 1] if k > 0 else 0.0)
    total = sums[len(sums) - 1]
    chosen, u = warp.discrete(sums, direction[0] * total)
    axis, versine, _, narrow = _cone(geometry, lights, emitter, start, guide.spheres[chosen])
    if narrow:
        towards = emit(geometry, lights, emitter, position, (u, direction[1])).direction
    else:
        towards = vec.from_frame(warp.uniform_cone(u, direction[1], 1.0 - versine), axis)
    intensity, own = emitted(geometry, lights, emitter, start, towards)
    density = 0.0
    for k in range(len(sums)):
        axis, versine, solid, narrow = _cone(geometry, lights, emitter, start, guide.spheres[k])
        if narrow:
            density += guide.importance[k] * solid * own
        elif k == chosen or 1.0 - vec.dot(axis, towards) <= versine:
            density += guide.importance[k]
    weight = intensity * total / density if density > 0.0 else 0.0
    seen = position_on(lights, emitter, start.position, vec.scale(towards, -1.0))
    return PhotonStart(weight, seen, start.origin, towards), chosen


@jit
def _from_infinity(lights, guide, sums, start, point):
    """Aim a photon that starts on a disk across its direction; return (`PhotonStart`, sphere)."""
    first = vec.from_frame((1.0, 0.0, 0.0), start.direction)
    second = vec.from_frame((0.0, 1.0, 0.0), start.direction)
    for k in range(len(sums)):
        area = math.pi * guide.spheres[k, 3] * guide.spheres[k, 3]
        sums[k] = guide.importance[k] * area + (sums[k - 1] if k > 0 else 0.0)
    total = sums[len(sums) - 1]
    chosen, u = warp.discrete(sums, point[0] * total)
    x, y = warp.uniform_disk(u, point[1])
    centre, radius = vec.row(guide.spheres, chosen), guide.spheres[chosen, 3]
    x, y = radius * x + vec.dot(centre, first), radius * y + vec.dot(centre, second)
    density = 0.0
    for k in range(len(sums)):
        centre, radius = vec.row(guide.spheres, k), guide.spheres[k, 3]
        dx, dy = x - vec.dot(centre, first), y - vec.dot(centre, second)
        if k == chosen or dx * dx + dy * dy <= radius * radius:
            density += guide.importance[k]
    density *= math.pi * lights.radius * lights.radius / total
    origin = start_at(lights, start.direction, x, y)
    return PhotonStart(start.weight / density, start.position, origin, start.direction), chosen


@jit
def aim_photon(geometry, lights, guide, sums, point, direction, weight, flux):
    """Send a photon from an emitter to a specular surface, by two points of the unit square.

    Fills flux, (N,), which `weight` multiplies; `sums`, (K,), is used up. Returns (origin,
    direction, number of the sphere it is aimed at).
    """
    emitter, u = warp.discrete(lights.cdf, point[0])
    position = (u, point[1])
    if lights.kind[emitter] == DIRECTIONAL:
        start = emit_from_outside(lights, emitter, MIDDLE, position)
        start, chosen = _from_infinity(lights, guide, sums, start, direction)
        if lights.portals is not None:
            start = let_in(geometry, lights.portals, start)
    elif lights.kind[emitter] == DOME:
        start = emit(geometry, lights, emitter, MIDDLE, position)
        start, chosen = _from_infinity(lights, guide, sums, start, direction)
    else:
        start = emit(geometry, lights, emitter, position, MIDDLE)
        start, chosen = _towards(geometry, lights, emitter, guide, sums, start, position, direction)
    send(lights, emitter, start, weight, flux)
    return start.origin, start.direction, chosen
