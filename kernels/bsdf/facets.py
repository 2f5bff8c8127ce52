"""Facets of a glossy surface: Trowbridge and Reitz' distribution, with Smith's masking.

Their roughness may differ along the surface: `along` a tangent, and `alpha` across it. An
`Anisotropy` tells where it does; it is None in a scene whose surfaces are alike in all directions.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.relief import derivatives, handedness, tangent_at
from photonmap.kernels.geometry.texture import look_up

TINY = 1e-12
LEAST_LENGTH = 1e-9  # Of a tangent: it is shorter where there are no texture coordinates


class Brush(NamedTuple):
    """How a lobe differs along a surface at a point."""

    stretch: float  # how far α along the tangent is on the way from what it is across to 1
    cosine: float
    sine: float  # of the angle from where u rises to the tangent
    mean: int  # row of `Scattering.albedos` of the mean over azimuths
    azimuths: int  # row where those of azimuths begin
    between: float  # how far on the way to those of the next strength


@jit
def brush_of(anisotropy, material):
    """Return the `Brush` of a material, without its image."""
    row = np.int64(material)
    if anisotropy is None:
        return Brush(0.0, 1.0, 0.0, row, row, 0.0)
    turn, first = anisotropy.turn, np.int64(anisotropy.first[material])
    stretch = float(anisotropy.stretch[material])
    return Brush(stretch, turn[material, 0], turn[material, 1], row, first, 0.0)


@jit
def brush_at(anisotropy, maps, material, s, t):
    """Return the `Brush` at a point of the image, if the material has one.

    Red and green are a direction, from -1 to 1, and blue is a factor of the strength, as in glTF's
    KHR_materials_anisotropy.
    """
    brush = brush_of(anisotropy, material)
    if anisotropy is None or maps.anisotropy[material] < 0:
        return brush
    red, green, blue = look_up(maps.maps, maps.anisotropy[material], s, t)
    x, y = 2.0 * red - 1.0, 2.0 * green - 1.0
    length = math.sqrt(x * x + y * y)
    x, y = (x / length, y / length) if length > LEAST_LENGTH else (1.0, 0.0)
    largest, steps = math.sqrt(brush.stretch), anisotropy.strengths
    strength = min(blue, largest)
    level = (steps - 1) * strength / max(largest, TINY)
    step = min(int(level), steps - 2)
    before = steps - 1 - step
    azimuths = brush.azimuths - before * anisotropy.azimuths
    mean = brush.azimuths - (steps - 1) * (anisotropy.azimuths + 1) - 1 + step
    cosine, sine = brush.cosine * x - brush.sine * y, brush.sine * x + brush.cosine * y
    return Brush(strength * strength, cosine, sine, mean, azimuths, level - step)


@outlined
def tangent_of(geometry, anisotropy, brush, hit):
    """Return the direction along which α is `along`, of any length and not quite on the surface."""
    if anisotropy is None or brush.stretch == 0.0:
        return 0.0, 0.0, 0.0
    normal = vec.row(geometry.normals, hit.triangle)
    tangent, sign = vec.cross((0.0, 1.0, 0.0), normal), 1.0
    hand = handedness(anisotropy.tangents, hit.triangle, geometry)
    if hand != 0.0:
        tangent, sign = tangent_at(geometry, anisotropy.tangents, hit, tangent), hand
    elif len(geometry.uv) > 0:
        by_u, _, area = derivatives(geometry, hit.triangle)
        if area != 0.0:
            tangent = tangent_at(geometry, anisotropy.tangents, hit, by_u)
            sign = math.copysign(1.0, area)
    tangent = vec.sub(tangent, vec.scale(normal, vec.dot(normal, tangent)))
    across = vec.scale(vec.cross(normal, tangent), sign)
    return vec.add(vec.scale(tangent, brush.cosine), vec.scale(across, brush.sine))


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
def to_local(lobe, w, n):
    """Return a vector in the frame of the normal, whose first axis is the tangent, if any."""
    if lobe.along == lobe.alpha:
        return vec.to_frame(w, n)
    tangent, across = _frame(lobe, n)
    return vec.dot(w, tangent), vec.dot(w, across), vec.dot(w, n)


@jit
def from_local(lobe, w, n):
    """Undo `to_local`."""
    if lobe.along == lobe.alpha:
        return vec.from_frame(w, n)
    tangent, across = _frame(lobe, n)
    return vec.add(vec.scale(n, w[2]), vec.add(vec.scale(tangent, w[0]), vec.scale(across, w[1])))


@jit
def azimuth(lobe, w, n):
    """Return the share of w² along the surface that lies across the tangent, in [0, 1]."""
    if lobe.along == lobe.alpha:
        return 0.0
    x, y, _ = to_local(lobe, w, n)
    return y * y / max(x * x + y * y, TINY)


@jit
def _smith(alpha, cosine):
    return 0.5 * (math.sqrt(1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)) - 1.0)


@jit
def masking(lobe, cosine, azimuth):
    """Return Smith's Λ in a direction of this cosine and `azimuth`."""
    along, across = lobe.along, lobe.alpha
    if along == across:
        return _smith(across, cosine)
    alpha = math.sqrt(along * along * (1.0 - azimuth) + across * across * azimuth)
    return _smith(alpha, cosine)


@jit
def distribution(lobe, h, n):
    """Return the density of facet normals (per steradian)."""
    along, across = lobe.along, lobe.alpha
    if along == across:
        cosine, sine = vec.dot(h, n), vec.cross(h, n)
        spread = across * across * cosine * cosine + vec.dot(sine, sine)
        return across * across * warp.INV_PI / (spread * spread)
    x, y, z = to_local(lobe, h, n)
    x, y = x / along, y / across
    spread = x * x + y * y + z * z
    return warp.INV_PI / (along * across * spread * spread)


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
