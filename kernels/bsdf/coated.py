"""Clear coats: a smooth or rough layer of a colourless dielectric over any base that is no glass.

A coat covers a fraction of the surface, its weight. It reflects by a GGX lobe of its own, and what
it does not reflect meets the base; what the base returns passes it, or is reflected back again:

    f = weight · (f_coat + D(i) D(o) · f_base · (1 - b) / (1 - A b)) + (1 - weight) · f_base.

A is the base's albedo, and b the part of its light that the coat returns. D(θ) is tabulated such
that a white base reflects all light (`photonmap.compile.surfaces.coats`). Over a Lambertian base b
is the coat's mean albedo, and D = (1 - E) / √(1 - b), where E(θ) is its albedo for light from an
angle; over a mirror b = E, and D = √(1 - E). Metals send light near the mirror direction: b² =
E(i) E(o) for them, and what is metallic in part lies between. The BSDF is reciprocal.

A coat may have a normal of its own, about which all angles above are. Its light then falls by its
own cosine, for which the caller's is changed: so it is like shading normals, of which light that is
traced backwards knows which side is the light's. Where the coat leans away from one of the two
directions, it reflects nothing, and light passes it as at normal incidence.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import glossy
from photonmap.kernels.bsdf.cover import UNCOVERED, Cover
from photonmap.kernels.core import vec
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.geometry.interaction import interpolated_normal
from photonmap.kernels.geometry.relief import turned_normal
from photonmap.kernels.geometry.texture import fraction_at


class Coat(NamedTuple):
    """A clear coat at a point."""

    weight: float  # fraction of the surface that it covers
    lobe: glossy.Lobe
    through: int  # row of `Coats.through`, of the least rough base
    normal: tuple


@jit
def weight_at(geometry, scattering, hit):
    """Return the fraction of the surface that a coat covers, where a ray meets it."""
    maps, material = scattering.maps, geometry.material[hit.triangle]
    if maps is None or maps.coat[material] < 0:
        return scattering.coats.weight[material]
    return fraction_at(geometry, maps.maps, maps.coat[material], hit)


@outlined
def coat_at(geometry, scattering, surface):
    """Return the `Coat` of a surface."""
    hit, coats, normal = surface.hit, scattering.coats, surface.ns
    weight = weight_at(geometry, scattering, hit)
    lobe, through = lobe_at(geometry, coats, hit)
    if coats.relief is not None and coats.own[geometry.material[hit.triangle]] != 0:
        normal = interpolated_normal(
            geometry.shading_normals, geometry.triangles, hit, surface.ng, surface.side
        )
        normal = turned_normal(geometry, coats.relief, hit, normal, surface.side)
    return Coat(weight, lobe, through, normal)


@jit
def lobe_at(geometry, coats, hit):
    """Return the lobe of a coat where a ray meets it, and its row of `Coats.through`."""
    maps, material = coats.maps, geometry.material[hit.triangle]
    alpha, row, first = coats.alpha[material], np.int64(coats.row[material]), coats.first[material]
    if maps is None or maps.coat_roughness[material] < 0:
        return _lobe(coats, material, alpha, row, 0.0), np.int64(first)
    roughness = fraction_at(geometry, maps.maps, maps.coat_roughness[material], hit)
    alpha, position = max(roughness * roughness, maps.least), roughness * (maps.steps - 1)
    step = min(int(position), maps.steps - 2)
    lobe = _lobe(coats, material, alpha, np.int64(coats.stepped[material] + step), position - step)
    return lobe, np.int64(first + (1 + step) * coats.steps[material])


@jit
def _lobe(coats, material, alpha, row, between):
    f0, nothing = coats.f0[material], (0.0, 0.0, 0.0)
    curve = coats.refraction[material], coats.mean_rise[material]
    return glossy.Lobe(
        material, alpha, f0, 0.0, row, between, False, nothing, alpha, nothing, 0, curve, -1.0
    )


@jit
def _albedo(lobe, multiple, terms):
    """Return what a coat reflects, of its albedos of three Fresnel terms."""
    return glossy.lobe_albedo(terms, lobe.f0, 0.0, multiple)


@jit
def _step(coats, coat, base, kind, cosine):
    """Return D over a white base as rough as this one: 0 what is no metal, 1 metal."""
    last = coats.steps[base.material] - 1
    position = math.sqrt(math.sqrt(base.alpha * base.along)) * last
    step = min(int(position), last - 1)
    row, between = coat.through + step, position - step
    low = glossy.interpolate_rows(coats.through, row, kind, between, cosine)
    if coats.maps is None or coat.lobe.between == 0.0:
        return low
    row += coats.steps[coat.lobe.material]
    high = glossy.interpolate_rows(coats.through, row, kind, between, cosine)
    return low + coat.lobe.between * (high - low)


@jit
def _through(coats, coat, base, metallic, cosine):
    """Return D, of a base that is metal in part."""
    if metallic == 0.0 or metallic == 1.0:
        return _step(coats, coat, base, int(metallic), cosine)
    dielectric = _step(coats, coat, base, 0, cosine)
    return dielectric + metallic * (_step(coats, coat, base, 1, cosine) - dielectric)


@jit
def _metallic_part(coats, base):
    """Return which part of the base is metal: what its lobe reflects above a dielectric's."""
    excess = max(base.f0 - coats.dielectric[base.material], 0.0)
    return excess / (excess + base.base) if excess > 0.0 else 0.0


@jit
def _above(w, normal):
    """Return a direction; the normal in place of one that a coat leans away from."""
    return w if vec.dot(w, normal) > 0.0 else normal


@jit
def _tilt(relief, normal, wi, wo, n):
    """Return by what a coat's light is multiplied for its own cosine in place of the base's."""
    # It reflects none to or from where it leans away.
    cosine, beside = vec.dot(wi, normal), vec.dot(wi, n)
    if cosine <= 0.0 or vec.dot(wo, normal) <= 0.0:
        return 0.0
    if relief is None:
        return 1.0
    return cosine / beside if beside > 0.0 else 0.0


@outlined
def cover_at(scattering, base, coat, wi, wo, n):
    """Return the `Cover` of a surface of normal n, given its base as a `Lobe`, and its coat."""
    if coat.weight <= 0.0:
        return UNCOVERED
    coats, weight, lobe, normal = scattering.coats, coat.weight, coat.lobe, coat.normal
    tilt = _tilt(coats.relief, normal, wi, wo, n)
    wi, wo = _above(wi, normal), _above(wo, normal)
    cos_i, cos_o = vec.dot(wi, normal), vec.dot(wo, normal)
    found = glossy.between(scattering, lobe, wi, wo, normal)
    multiple = glossy.multiple_fresnel(lobe, lobe.f0, 0.0, found.mean[0])
    own = glossy.reflected(found, lobe.f0, 0.0, multiple) * tilt
    at_i, at_o = _albedo(lobe, multiple, found.incoming), _albedo(lobe, multiple, found.outgoing)
    mean, metallic = _albedo(lobe, multiple, found.mean), _metallic_part(coats, base)
    back = mean + metallic * (math.sqrt(at_i * at_o) - mean)
    through = weight * (1.0 - back) * _through(coats, coat, base, metallic, cos_i)
    through *= _through(coats, coat, base, metallic, cos_o)
    return Cover(weight * own, 1.0 - weight, through, back)


@outlined
def probability(scattering, base, coat, wo):
    """Return with which probability a sample is drawn by the coat's lobe."""
    cosine = vec.dot(wo, coat.normal)
    if coat.weight <= 0.0 or cosine <= 0.0:
        return 0.0
    lobe = coat.lobe
    single = glossy.look_up_albedo(scattering, lobe, 0, cosine, 0.0)
    grazing = glossy.look_up_albedo(scattering, lobe, 1, cosine, 0.0)
    once = coat.weight * (lobe.f0 * (single - grazing) + grazing)
    beneath = (1.0 - once) * min(base.f0 + base.base, 1.0)
    return once / max(once + beneath, glossy.TINY)


@jit
def sample(coat, wo, u, v):
    """Return a direction by visible normals of the coat."""
    return glossy.sample_visible(coat.lobe, wo, coat.normal, u, v)


@jit
def pdf(coat, wi, wo, n):
    """Return the density of `sample` (per steradian) above n: some go below the coat's horizon."""
    if vec.dot(wi, n) <= 0.0 or vec.dot(wo, coat.normal) <= 0.0:
        return 0.0
    if vec.dot(vec.add(wi, wo), coat.normal) <= 0.0:
        return 0.0
    return glossy.visible_pdf(coat.lobe, wi, wo, coat.normal)
