"""Clear coats: a smooth or rough layer of a colourless dielectric over any base that is no glass.

A coat covers a fraction of the surface, its weight. It reflects by a GGX lobe of its own, and what
it does not reflect meets the base; what the base returns passes it, or is reflected back again:

    f = weight · (f_coat + D(i) D(o) · f_base · (1 - b) / (1 - A b)) + (1 - weight) · f_base.

A is the base's albedo, and b the part of its light that the coat returns. D(θ) is tabulated such
that a white base reflects all light (`photonmap.compile.surfaces.coats`). Over a Lambertian base b
is the coat's mean albedo, and D = (1 - E) / √(1 - b), where E(θ) is its albedo for light from an
angle; over a mirror b = E, and D = √(1 - E). Metals send light near the mirror direction: b² =
E(i) E(o) for them, and what is metallic in part lies between. The BSDF is reciprocal.

Scenes without coats have None for `Scattering.coats`: no code of theirs is compiled.
"""

import math

import numpy as np

from photonmap.kernels.bsdf import glossy
from photonmap.kernels.bsdf.cover import UNCOVERED, Cover
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit
from photonmap.kernels.geometry.texture import coordinates, look_up_number


@jit
def weight_at(geometry, scattering, maps, hit):
    """Return the fraction of the surface that a coat covers, where a ray meets it."""
    material = geometry.material[hit.triangle]
    weight = scattering.coats.weight[material]
    if maps is None:
        return weight
    if maps.coat[material] < 0:
        return weight
    s, t = coordinates(geometry.uv, geometry.triangles, hit.triangle, hit.u, hit.v)
    return min(look_up_number(maps.maps, maps.coat[material], s, t), 1.0)


@jit
def _lobe_of(coats, material):
    """Return the lobe of a coat."""
    alpha, nothing = coats.alpha[material], (0.0, 0.0, 0.0)
    row, f0 = np.int64(coats.row[material]), coats.f0[material]
    return glossy.Lobe(material, alpha, f0, 0.0, row, 0.0, False, nothing, alpha, nothing, 0)


@jit
def _albedo(lobe, multiple, terms):
    """Return what a coat reflects, of its albedos of three Fresnel terms."""
    return glossy.lobe_albedo(terms, lobe.f0, 0.0, multiple)


@jit
def _step(coats, base, kind, cosine):
    """Return D over a white base as rough as this one: 0 what is no metal, 1 metal."""
    last = coats.steps[base.material] - 1
    place = math.sqrt(math.sqrt(base.alpha * base.along)) * last
    step = min(int(place), last - 1)
    row = coats.first[base.material] + step
    low = glossy.interpolate(coats.through[row, kind], cosine)
    return low + (place - step) * (glossy.interpolate(coats.through[row + 1, kind], cosine) - low)


@jit
def _through(coats, base, share, cosine):
    """Return D, of a base of which a share is metal."""
    if share == 0.0 or share == 1.0:
        return _step(coats, base, int(share), cosine)
    dielectric = _step(coats, base, 0, cosine)
    return dielectric + share * (_step(coats, base, 1, cosine) - dielectric)


@jit
def _metallic_share(coats, base):
    """Return which part of the base is metal: what its lobe reflects above a dielectric's."""
    excess = max(base.f0 - coats.dielectric[base.material], 0.0)
    return excess / (excess + base.base) if excess > 0.0 else 0.0


@jit
def cover_at(scattering, base, weight, wi, wo, n):
    """Return the `Cover` of a surface, given its base as a `Lobe`, and the weight of its coat."""
    if weight <= 0.0 or vec.dot(wi, n) <= 0.0 or vec.dot(wo, n) <= 0.0:
        return UNCOVERED
    coats = scattering.coats
    lobe = _lobe_of(coats, base.material)
    found = glossy.between(scattering, None, None, None, lobe, wi, wo, n)
    multiple = glossy.multiple_fresnel(lobe.f0, 0.0, found.mean[0])
    own = glossy.reflected(found, lobe.f0, 0.0, multiple)
    at_i, at_o = _albedo(lobe, multiple, found.incoming), _albedo(lobe, multiple, found.outgoing)
    mean, share = _albedo(lobe, multiple, found.mean), _metallic_share(coats, base)
    back = mean + share * (math.sqrt(at_i * at_o) - mean)
    through = weight * (1.0 - back) * _through(coats, base, share, vec.dot(wi, n))
    through *= _through(coats, base, share, vec.dot(wo, n))
    return Cover(weight * own, 1.0 - weight, through, back)


@jit
def probability(scattering, base, weight, cosine):
    """Return with which probability a sample is drawn by the coat's lobe, for wo of this cosine."""
    if weight <= 0.0 or cosine <= 0.0:
        return 0.0
    lobe, albedos = _lobe_of(scattering.coats, base.material), scattering.albedos
    single = glossy.look_up_albedo(albedos, None, None, lobe, 0, cosine, 0.0)
    grazing = glossy.look_up_albedo(albedos, None, None, lobe, 1, cosine, 0.0)
    once = weight * (lobe.f0 * (single - grazing) + grazing)
    beneath = (1.0 - once) * min(base.f0 + base.base, 1.0)
    return once / max(once + beneath, glossy.TINY)


@jit
def sample(scattering, material, wo, n, u, v):
    """Return a direction by visible normals of the coat."""
    return glossy.sample_visible(None, _lobe_of(scattering.coats, material), wo, n, u, v)


@jit
def pdf(scattering, material, wi, wo, n):
    """Return the density of `sample` (per steradian)."""
    if vec.dot(wi, n) <= 0.0 or vec.dot(wo, n) <= 0.0:
        return 0.0
    return glossy.visible_pdf(None, _lobe_of(scattering.coats, material), wi, wo, n, 0.0)
