"""A thin lens: rays through points of its opening, which meet where it is focused."""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import Ray
from photonmap.kernels.core.rng import sobol_2d
from photonmap.kernels.core.streams import LENS, split


@jit
def _in_polygon(blades, u, v):
    """Return a point of the regular polygon in the unit circle, uniform by area."""
    blade = min(int(u * blades), blades - 1)
    s, t = warp.uniform_triangle(u * blades - blade, v)
    low, high = 2.0 * math.pi * blade / blades, 2.0 * math.pi * (blade + 1) / blades
    return s * math.cos(low) + t * math.cos(high), s * math.sin(low) + t * math.sin(high)


@outlined
def through_lens(lens, ray, index, key):
    """Return the ray that leaves a point of the lens to where `ray`, of its centre, is in focus.

    The direction of `ray` advances by 1 along the axis.
    """
    u, v = sobol_2d(index, split(key, LENS))
    x, y = _in_polygon(lens.blades, u, v) if lens.blades > 0 else warp.uniform_disk(u, v)
    shift = vec.add(vec.scale(lens.right, x), vec.scale(lens.up, y))
    direction = vec.sub(ray.direction, vec.scale(shift, lens.nearness))
    return Ray(vec.add(ray.origin, shift), direction)
