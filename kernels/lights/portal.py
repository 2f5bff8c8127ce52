"""Portals: area lights that show the environment, as openings to the outside do.

They are sampled as other area lights are. What they send follows from the direction alone, so a
position on a portal is the texel of the environment map that is seen through it.

Suns shine through portals, too, and through these alone: unless something outside is in the way. A
photon of a sun starts at the first portal that it comes to.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.interaction import offset, point_at
from photonmap.kernels.geometry.opacity import MOST_LAYERS, behind, intersect, occluded
from photonmap.kernels.lights.environment import texel_at
from photonmap.kernels.lights.samples import NOWHERE, PhotonStart


@jit
def position_on(lights, emitter, barycentrics, direction):
    """Return the position on an emitting triangle, as in `LightSample`, seen in a direction."""
    environment = lights.environment
    if environment is not None and lights.spectrum[emitter] == environment.row:
        return texel_at(environment, direction)
    return barycentrics


@outlined
def _pass_portals(geometry, portals, origin, direction):
    """Follow a ray through the portals that it meets before anything else."""
    # Returns (how many there are, a point behind the last one, the triangle that comes then or -1).
    for count in range(MOST_LAYERS):
        hit = intersect(geometry, origin, direction)
        if hit.triangle < 0 or not portals.is_portal[geometry.material[hit.triangle]]:
            return count, origin, hit.triangle
        origin = behind(geometry, hit, direction)
    return 0, origin, hit.triangle


@jit
def shines_in(geometry, portals, point, direction):
    """Return whether a sun that stands in a direction shines on a point, through portals."""
    count, _, triangle = _pass_portals(geometry, portals, point, direction)
    return count > 0 and triangle < 0


@jit
def let_in(geometry, portals, start):
    """Move the `PhotonStart` of a sun behind portals; its weight is 0 where it comes to none."""
    count, origin, _ = _pass_portals(geometry, portals, start.origin, start.direction)
    weight = start.weight if count > 0 else 0.0
    return PhotonStart(weight, NOWHERE, origin, start.direction)


@jit
def emit_through(geometry, portals, emitter, position, direction):
    """Start a photon of a sun at a portal; a `PhotonStart`, of weight 0 if the sun is hidden."""
    cdf = portals.cdf[portals.row[emitter]]
    index, u = warp.discrete(cdf, position[0])
    triangle = portals.triangle[index]
    b1, b2 = warp.uniform_triangle(u, position[1])
    point, size = point_at(geometry, triangle, b1, b2)
    normal = vec.row(geometry.normals, triangle)
    cosine = vec.dot(normal, direction)
    outside = offset(point, size, vec.scale(normal, -1.0 if cosine > 0.0 else 1.0))
    if occluded(geometry, outside, vec.scale(direction, -1.0), math.inf):
        return PhotonStart(0.0, NOWHERE, outside, direction)
    weight = portals.area[index] * abs(cosine) / warp.discrete_pdf(cdf, index)
    return let_in(geometry, portals, PhotonStart(weight, NOWHERE, outside, direction))
