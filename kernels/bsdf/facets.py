"""Facets of a glossy surface: Trowbridge and Reitz' distribution, with Smith's masking.

Their roughness may differ along the surface: `along` a tangent, and `alpha` across it. What tells
where it does, is an argument of its own, None in a scene where all surfaces are alike in all
directions: then none of its code is compiled.
"""

import math

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.relief import derivatives, tangent_at

TINY = 1e-12
LEAST_LENGTH = 1e-9
"""Of a tangent: it is shorter where there are no texture coordinates."""


@jit
def along_of(anisotropy, material, alpha):
    """Return α along the tangent, of what it is across."""
    if anisotropy is None:
        return alpha
    return alpha + (1.0 - alpha) * anisotropy.stretch[material]


@jit
def tangent_of(geometry, anisotropy, hit):
    """Return the direction along which α is `along`, of any length and not quite on the surface."""
    if anisotropy is None:
        return 0.0, 0.0, 0.0
    material = geometry.material[hit.triangle]
    if anisotropy.stretch[material] == 0.0:
        return 0.0, 0.0, 0.0
    normal = vec.row(geometry.normals, hit.triangle)
    tangent, sign = vec.cross((0.0, 1.0, 0.0), normal), 1.0
    if len(geometry.uv) > 0:
        by_u, _, area = derivatives(geometry, hit.triangle)
        if area != 0.0:
            tangent = tangent_at(geometry, anisotropy.tangents, hit, by_u)
            sign = math.copysign(1.0, area)
    tangent = vec.sub(tangent, vec.scale(normal, vec.dot(normal, tangent)))
    across = vec.scale(vec.cross(normal, tangent), sign)
    tangent = vec.scale(tangent, anisotropy.turn[material, 0])
    return vec.add(tangent, vec.scale(across, anisotropy.turn[material, 1]))


@jit
def _frame(lobe, n):
    """Return unit vectors on the surface of normal n, along the lobe's tangent and across it."""
    tangent = vec.sub(lobe.tangent, vec.scale(n, vec.dot(n, lobe.tangent)))
    length = math.sqrt(vec.dot(tangent, tangent))
    if length < LEAST_LENGTH:
        tangent = vec.from_frame((1.0, 0.0, 0.0), n)
    else:
        tangent = vec.scale(tangent, 1.0 / length)
    return tangent, vec.cross(n, tangent)


@jit
def to_local(anisotropy, lobe, w, n):
    """Return a vector in the frame of the normal, whose first axis is the tangent, if any."""
    if anisotropy is None:
        return vec.to_frame(w, n)
    if lobe.along == lobe.alpha:
        return vec.to_frame(w, n)
    tangent, across = _frame(lobe, n)
    return vec.dot(w, tangent), vec.dot(w, across), vec.dot(w, n)


@jit
def from_local(anisotropy, lobe, w, n):
    """Undo `to_local`."""
    if anisotropy is None:
        return vec.from_frame(w, n)
    if lobe.along == lobe.alpha:
        return vec.from_frame(w, n)
    tangent, across = _frame(lobe, n)
    return vec.add(vec.scale(n, w[2]), vec.add(vec.scale(tangent, w[0]), vec.scale(across, w[1])))


@jit
def azimuth(anisotropy, lobe, w, n):
    """Return the share of w² along the surface that lies across the tangent, in [0, 1]."""
    if anisotropy is None:
        return 0.0
    if lobe.along == lobe.alpha:
        return 0.0
    x, y, _ = to_local(anisotropy, lobe, w, n)
    return y * y / max(x * x + y * y, TINY)


@jit
def _smith(alpha, cosine):
    return 0.5 * (math.sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0)


@jit
def masking(anisotropy, lobe, cosine, share):
    """Return Smith's Λ in a direction of this cosine and `azimuth`."""
    if anisotropy is None:
        return _smith(lobe.alpha, cosine)
    along, across = lobe.along, lobe.alpha
    if along == across:
        return _smith(across, cosine)
    return _smith(math.sqrt(along * along * (1.0 - share) + across * across * share), cosine)


@jit
def distribution(anisotropy, lobe, h, n):
    """Return the density of facet normals (per steradian)."""
    if anisotropy is None:
        return _even_distribution(lobe.alpha, h, n)
    along, across = lobe.along, lobe.alpha
    if along == across:
        return _even_distribution(across, h, n)
    x, y, z = to_local(anisotropy, lobe, h, n)
    x, y = x / along, y / across
    spread = x * x + y * y + z * z
    return warp.INV_PI / (along * across * spread * spread)


@jit
def _even_distribution(alpha, h, n):
    cosine, across = vec.dot(h, n), vec.cross(h, n)
    spread = alpha * alpha * cosine * cosine + vec.dot(across, across)
    return alpha * alpha * warp.INV_PI / (spread * spread)


@jit
def visible_normal(along, across, wo, u, v):
    """Return a facet's normal that wo sees, about +z; α is `along` x and `across` it.

    J. Dupuy and A. Benyoub, "Sampling visible GGX normals with spherical caps", 2023.
    """
    x, y, z = vec.normalize((along * wo[0], across * wo[1], wo[2]))
    height = (1.0 - v) * (1.0 + z) - z
    r = math.sqrt(max(1.0 - height * height, 0.0))
    cosine, sine = warp.cos_sin_2pi(u)
    return vec.normalize((along * (r * cosine + x), across * (r * sine + y), max(height + z, TINY)))
