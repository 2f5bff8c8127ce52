"""Smooth surfaces: mirrors, diffuse surfaces with a mirror coat, and glass."""

import numpy as np

from photonmap.kernels import vec
from photonmap.kernels.fresnel import fresnel, mirrored, refracted
from photonmap.kernels.jit import jit, outlined
from photonmap.kernels.records import MIRROR
from photonmap.kernels.surface import offset, point_at, shading_normal, side_of


@jit
def _multiply(throughput, table, row, factor):
    for band in range(len(throughput)):
        throughput[band] *= table[row, band] * np.float32(factor)


@outlined
def leave(geometry, optics, triangle, u, v, direction, chance, carries_flux, throughput):
    """Send light on from a smooth surface; return (origin, unit direction).

    Glass reflects where the uniform number `chance` is below Fresnel's reflectance, else it
    transmits. `throughput`, (N,), takes up the mirror's reflectance or the glass's tint, and the
    square of the ratio of indices unless it is flux (Veach 1997, 5.2: radiance is compressed).
    """
    material = geometry.material[triangle]
    direction = vec.normalize(direction)
    side = side_of(geometry, triangle, direction)
    ng = vec.scale(vec.row(geometry.normals, triangle), 1.0 - 2.0 * side)
    n = shading_normal(geometry, triangle, u, v, ng, side)
    if vec.dot(n, direction) >= 0.0:
        n = ng
    point, size = point_at(geometry, triangle, u, v)
    if optics.kind[material] == MIRROR:
        _multiply(throughput, optics.mirror, material, 1.0)
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    eta = optics.ior[material] if side == 1 else 1.0 / optics.ior[material]
    if chance < fresnel(-vec.dot(n, direction), eta):
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    _multiply(throughput, optics.tint, material, 1.0 if carries_flux else eta * eta)
    beyond = refracted(direction, n, eta)
    if vec.dot(beyond, ng) >= 0.0:
        beyond = refracted(direction, ng, eta)
    return offset(point, size, vec.scale(ng, -1.0)), beyond


@jit
def _on_side(out, direction, ng):
    """Return a reflected direction, about the geometric normal if it would enter the surface."""
    return out if vec.dot(out, ng) > 0.0 else mirrored(direction, ng)
