"""Lines of sight: what rays hit first, and whether anything lies between two points."""

from __future__ import annotations

from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.ray import any_hit, closest_hit


@jit
def first_hits(scene, origins, directions, triangles, distances):
    """Write the triangle that each ray hits first, -1 for none, and the distance to it."""
    for i in range(len(origins)):
        o, d = origins[i], directions[i]
        hit = closest_hit(scene, (o[0], o[1], o[2]), (d[0], d[1], d[2]))
        triangles[i] = hit.triangle
        distances[i] = hit.distance


@jit
def find_clear(scene, starts, ends, clear):
    """Write whether nothing lies between starts (P, 3) and ends (M, 3), as (P, M)."""
    for i in range(len(starts)):
        s = starts[i]
        origin = (s[0], s[1], s[2])
        for k in range(len(ends)):
            e = ends[k]
            way = (e[0] - s[0], e[1] - s[1], e[2] - s[2])
            clear[i, k] = not any_hit(scene, origin, way, 0.999)
