"""Specular surfaces: mirrors, diffuse surfaces with a mirror coat, and glass."""

import numpy as np

from photonmap.kernels.bsdf.fresnel import fresnel, mirrored, refracted
from photonmap.kernels.core import vec
from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.records import MIRROR
from photonmap.kernels.core.rng import draw
from photonmap.kernels.geometry.interaction import offset, point_at, shading_normal, side_of

LONGEST_CHAIN = 256
"""Specular scatterings in a row, after which a path is truncated."""


@jit
def specular_probability(geometry, specular, triangle):
    """Return the probability of the specular lobe; 1 for a surface that has no other."""
    return 0.0 if specular is None else specular.probability[geometry.material[triangle]]


@jit
def choose_lobe(probability, state, throughput):
    """Choose the specular lobe with a probability; return (whether it was chosen, state).

    `throughput`, (N,), is divided by the probability of the lobe that was chosen.
    """
    if probability >= 1.0:
        return True, state
    xi, state = draw(state)
    is_specular = xi < probability
    divide(throughput, probability if is_specular else 1.0 - probability)
    return is_specular, state


@jit
def _multiply(throughput, table, row, factor):
    for band in range(len(throughput)):
        throughput[band] *= table[row, band] * np.float32(factor)


@jit
def scatter_specular(geometry, specular, hit, direction, xi, carries_flux, throughput):
    """Scatter light that arrives along `direction` at a specular surface: a delta BSDF's `sample`.

    Glass reflects where the uniform number `xi` is below Fresnel's reflectance, and transmits
    elsewhere. `throughput`, (N,), is multiplied by the mirror's reflectance or the glass's tint,
    and by the square of the ratio of indices unless it is flux (Veach 1997, 5.2).

    Returns
    -------
    origin, unit direction
    """
    material = geometry.material[hit.triangle]
    direction = vec.normalize(direction)
    side = side_of(geometry, hit.triangle, direction)
    ng = vec.scale(vec.row(geometry.normals, hit.triangle), 1.0 - 2.0 * side)
    n = shading_normal(geometry, hit, ng, side)
    if vec.dot(n, direction) >= 0.0:
        n = ng
    point, size = point_at(geometry, hit.triangle, hit.u, hit.v)
    if specular.kind[material] == MIRROR:
        _multiply(throughput, specular.mirror, material, 1.0)
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    eta = specular.ior[material] if side == 1 else 1.0 / specular.ior[material]
    if xi < fresnel(-vec.dot(n, direction), eta):
        return offset(point, size, ng), _on_side(mirrored(direction, n), direction, ng)
    _multiply(throughput, specular.tint, material, 1.0 if carries_flux else eta * eta)
    transmitted = refracted(direction, n, eta)
    if vec.dot(transmitted, ng) >= 0.0:
        transmitted = refracted(direction, ng, eta)
    return offset(point, size, vec.scale(ng, -1.0)), transmitted


@jit
def _on_side(out, direction, ng):
    """Return a reflected direction, about the geometric normal if it would enter the surface."""
    return out if vec.dot(out, ng) > 0.0 else mirrored(direction, ng)
