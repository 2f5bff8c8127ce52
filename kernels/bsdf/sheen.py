"""Sheen: fibres that stand off a cloth, or dust, which shine where they are seen at grazing angles.

A. Conty Estevez and C. Kulla, "Production friendly microfacet sheen BRDF", SIGGRAPH 2017 course,
which glTF's KHR_materials_sheen takes over: facets of the distribution

    D(h) = (2 + 1/α) sin(θ)^(1/α) / 2π

lean away from the normal, and mask each other by their fit of Smith's Λ, in correlation. Their
softer terminator is left out, as in glTF: with it the BSDF would not be reciprocal. So it reflects

    s · K(i) K(o) · D(h) / (4 cos(i) cos(o) (1 + Λ(i) + Λ(o)))

of light from i to o, s being its colour. Without K it would reflect more light than arrives beyond
87° where α is below 0.08; K(θ), up to 1, forbids it. What the sheen lets pass reaches the base,
whose BSDF is multiplied by T(i) T(o), tabulated such that a white base reflects all light whatever
the colour of the sheen (`photonmap.compile.surfaces.sheens`): over a Lambertian base,
T = (1 - s E) / √(1 - s Ē), where E(θ) is what the sheen reflects of light from an angle for s = 1,
and Ē the mean of that. All of it is reciprocal.
"""

import math
from typing import NamedTuple

from photonmap.kernels.bsdf.glossy import TINY, interpolate
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.bands import mix
from photonmap.kernels.core.jit import jit, kernel
from photonmap.kernels.geometry.texture import coordinates_at, reflectance_at

ROUGHEST = (21.5473, 3.82987, 0.19823, -1.97760, -4.32054)
SMOOTHEST = (25.3245, 3.32435, 0.16801, -1.27393, -4.85967)
"""Terms a, b, c, d and e of the fit of Λ, at α 1 and 0 (table 1 there)"""


class Sheen(NamedTuple):
    """A sheen at a point."""

    material: int
    row: int  # of the tables of `Sheens`
    is_textured: bool  # whether its colour is `color` rather than the material's
    color: tuple  # linear RGB
    mean: float  # mean of its colour over the bands


@jit
def sheen_at(geometry, sheens, hit):
    """Return the `Sheen` where a ray meets a surface that has one."""
    material = geometry.material[hit.triangle]
    row, mean, nothing = sheens.row[material], sheens.mean[material], (0.0, 0.0, 0.0)
    if sheens.maps is None or sheens.image[material] < 0:
        return Sheen(material, row, False, nothing, mean)
    s, t = coordinates_at(geometry, hit)
    color = reflectance_at(sheens.maps, sheens.image[material], s, t)
    return Sheen(material, row, True, color, (color[0] + color[1] + color[2]) / 3.0)


@jit
def color_of(sheens, sheen, band):
    """Return the colour of a sheen in one band."""
    if sheen.is_textured:
        return min(max(float(mix(sheen.color, sheens.basis, band)), 0.0), 1.0)
    return float(sheens.color[sheen.material, band])


@jit
def _fit(term, alpha):
    """Return a term of the fit at α."""
    smooth = (1.0 - alpha) * (1.0 - alpha)
    return ROUGHEST[term] + smooth * (SMOOTHEST[term] - ROUGHEST[term])


@jit
def _exponent(cosine, alpha):
    falling = 1.0 + _fit(1, alpha) * cosine ** _fit(2, alpha)
    return _fit(0, alpha) / falling + _fit(3, alpha) * cosine + _fit(4, alpha)


@jit
def masking(cosine, alpha):
    """Return Λ of a direction above the surface."""
    if cosine < 0.5:
        return math.exp(_exponent(cosine, alpha))
    return math.exp(2.0 * _exponent(0.5, alpha) - _exponent(max(1.0 - cosine, 0.0), alpha))


@jit
def fibres(alpha, cos_i, cos_o, together):
    """Return what fibres reflect (per steradian), without K; `together` is wi · wo."""
    height = (cos_i + cos_o) ** 2 / max(2.0 + 2.0 * together, TINY)
    density = (2.0 + 1.0 / alpha) * max(1.0 - height, 0.0) ** (0.5 / alpha) * (0.5 * warp.INV_PI)
    hidden = 1.0 + masking(cos_i, alpha) + masking(cos_o, alpha)
    return density / (4.0 * cos_i * cos_o * hidden)


@kernel
def tabulate(alpha, leaving, arriving, azimuths, table):
    """Fill table (O, I) with the mean of `fibres` over azimuths (A,), by cosines (O,) and (I,)."""
    for o in range(len(leaving)):
        for i in range(len(arriving)):
            cos_o, cos_i = leaving[o], arriving[i]
            across = math.sqrt((1.0 - cos_o * cos_o) * (1.0 - cos_i * cos_i))
            total = 0.0
            for azimuth in azimuths:
                together = across * math.cos(azimuth) + cos_o * cos_i
                total += fibres(alpha, cos_i, cos_o, together)
            table[o, i] = total / len(azimuths)


@jit
def _through(table, color, cosine):
    """Return T of a sheen of a colour, between steps of colours."""
    position = color * (len(table) - 1)
    step = min(int(position), len(table) - 2)
    low = interpolate(table[step], cosine)
    return low + (position - step) * (interpolate(table[step + 1], cosine) - low)


@jit
def cover(sheens, sheen, directions, n, values):
    """Turn a base's BSDF in values, (N,), into that below a sheen; `directions` are wi and wo."""
    wi, wo = directions
    cos_i, cos_o = vec.dot(wi, n), vec.dot(wo, n)
    if cos_i <= 0.0 or cos_o <= 0.0:
        values[:] = 0.0
        return
    own = fibres(sheens.alpha[sheen.material], cos_i, cos_o, vec.dot(wi, wo))
    own *= interpolate(sheens.kept[sheen.row], cos_i) * interpolate(sheens.kept[sheen.row], cos_o)
    table = sheens.through[sheen.row]
    for band in range(len(values)):
        color = color_of(sheens, sheen, band)
        passed = _through(table, color, cos_i) * _through(table, color, cos_o)
        values[band] = color * own + passed * values[band]


@jit
def probability(sheens, sheen, base, cosine):
    """Return with which probability a sample is drawn for the sheen: wo has this cosine."""
    if cosine <= 0.0:
        return 0.0
    own = sheen.mean * interpolate(sheens.albedo[sheen.row], cosine)
    beneath = (1.0 - own) * min(base.f0 + base.base, 1.0)
    return own / max(own + beneath, TINY)


@jit
def sample(n, u, v):
    """Return a direction about n, even by solid angle: the lobe is wide."""
    return vec.from_frame(warp.uniform_cone(u, v, 0.0), n)


@jit
def pdf(wi, n):
    """Return the density of `sample` (per steradian)."""
    return warp.uniform_cone_pdf(0.0) if vec.dot(wi, n) > 0.0 else 0.0
