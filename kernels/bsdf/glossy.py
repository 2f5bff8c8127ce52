"""Glossy surfaces: a GGX lobe over a diffuse base, which it covers like a coat.

The lobe is Trowbridge and Reitz' distribution with Smith's height-correlated masking, a Fresnel
reflectance (`core.fresnel`), and what is scattered several times between microfacets (C. Kulla and
A. Conty, "Revisiting physically based shading at Imageworks", SIGGRAPH 2017 course). The base gets
what the lobe does not reflect, each time light passes it, so that a white base reflects all light
whatever covers it. The BSDF is reciprocal.

Where a part of the surface is bare metal, the lobe is that of both parts, and the coat alone lies
over the base, whose albedo is less by the part that is bare.

`parameters` are α, the means over bands of the reflectance at normal incidence and of the base's
albedo, by which one of the two is chosen for a sample, the lobe's `curve`, and what is `over` the
base. Where textures give them, they are looked up for each point. Facets may differ along the
surface: see `facets`.
"""

import math
from typing import NamedTuple

import numpy as np

from photonmap.kernels.bsdf import facets
from photonmap.kernels.bsdf.cover import covered
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.bands import mix
from photonmap.kernels.core.fresnel import dip_of, dip_terms, rise
from photonmap.kernels.core.jit import jit
from photonmap.kernels.core.metals import DIP_MEANS
from photonmap.kernels.geometry.interaction import departure
from photonmap.kernels.geometry.texture import coordinates_at, look_up_number, reflectance_at

IS_NARROW = True  # See `models`
LOBE = 255
"""In place of a surface's model: what a glossy one has beside its base, for which the radiosity
cache has answered"""
_BY_LOBE = 0.9  # Least share of directions by the lobe where there is nothing else
TINY = 1e-12
NO_DIP = (0.0, 0.0, 0.0, 0.0)


class Lobe(NamedTuple):
    """A glossy lobe and its base at a point."""

    material: int
    alpha: float  # across the tangent, if there is one
    f0: float  # mean over bands of the reflectance at normal incidence
    base: float  # mean over bands of the albedo of the base
    row: int  # of `Scattering.albedos`
    between: float  # how far on the way to the next row
    is_textured: bool  # whether the normal reflectance is `color`, not the material's
    color: tuple  # linear RGB
    along: float  # α along the tangent
    tangent: tuple  # see `facets`
    azimuths: int  # row of `Scattering.albedos` where those of azimuths begin
    curve: tuple  # index of refraction, 0 for Schlick's formula, and the weighted mean of `rise`
    over: float  # reflectance at normal incidence of what covers the base; -1 for that of the lobe


class Reflection(NamedTuple):
    """What a lobe does between two directions: see `between`."""

    once: float  # what facets reflect once, per steradian, for a reflectance of 1
    rise: float  # `rise` at the facets
    dip: tuple  # `dip_terms` at the facets
    missing: float  # what is reflected several times, likewise
    incoming: tuple
    """albedos of light from wi, at Fresnel terms 1, `rise`, and a tuple of those at `dip_terms`"""
    outgoing: tuple  # likewise from wo
    mean: tuple  # cosine-weighted means of both


@jit
def lobe_at(geometry, scattering, hit):
    """Return the `Lobe` where a ray meets a surface."""
    maps, material = scattering.maps, geometry.material[hit.triangle]
    parameters = scattering.parameters[material]
    alpha, f0, base = parameters[0], parameters[1], parameters[2]
    curve, over = (parameters[3], parameters[4]), parameters[5]
    color, anisotropy = (0.0, 0.0, 0.0), scattering.anisotropy
    if maps is None:
        brush = facets.brush_of(anisotropy, material)
        tangent = facets.tangent_of(geometry, anisotropy, brush, hit)
        along = alpha + (1.0 - alpha) * brush.stretch
        row, azimuths = brush.mean, brush.azimuths
        between, is_textured = 0.0, False
        return Lobe(
            material, alpha, f0, base, row, between, is_textured, color, along, tangent, azimuths,
            curve, over,
        )  # fmt: skip
    s, t = coordinates_at(geometry, hit)
    brush = facets.brush_at(anisotropy, maps, material, s, t)
    row, between = brush.mean, brush.between
    if maps.roughness[material] >= 0:
        roughness = min(look_up_number(maps.maps, maps.roughness[material], s, t), 1.0)
        alpha = max(roughness * roughness, maps.least)
        level = roughness * (maps.steps - 1)
        step = min(int(level), maps.steps - 2)
        row, between = np.int64(maps.first[material] + step), level - step
    is_textured = maps.glossy[material] >= 0
    if is_textured:
        color = reflectance_at(maps.maps, maps.glossy[material], s, t)
        f0 = (color[0] + color[1] + color[2]) / 3.0
    if maps.base[material] >= 0:
        r, g, b = reflectance_at(maps.maps, maps.base[material], s, t)
        base = (r + g + b) / 3.0
    along, azimuths = alpha + (1.0 - alpha) * brush.stretch, brush.azimuths
    tangent = facets.tangent_of(geometry, anisotropy, brush, hit)
    return Lobe(
        material, alpha, f0, base, row, between, is_textured, color, along, tangent, azimuths,
        curve, over,
    )  # fmt: skip


@jit
def normal_reflectance(scattering, lobe, band):
    """Return the reflectance at normal incidence in one band."""
    if scattering.maps is not None and lobe.is_textured:
        return float(mix(lobe.color, scattering.maps.basis, band))
    return float(scattering.specular[lobe.material, band])


@jit
def interpolate(table, cosine):
    """Interpolate a row of `Scattering.albedos`, over the square root of the cosine."""
    level = math.sqrt(min(cosine, 1.0)) * (len(table) - 2)
    node = min(int(level), len(table) - 3)
    return table[node] + (level - node) * (table[node + 1] - table[node])


@jit
def interpolate_rows(tables, row, term, between, cosine):
    """Interpolate a term of tables, (R, terms, K), between a row and the next one."""
    value = interpolate(tables[row, term], cosine)
    return value + between * (interpolate(tables[row + 1, term], cosine) - value)


@jit
def look_up_albedo(scattering, lobe, term, cosine, azimuth):
    """Return the albedo of a Fresnel term of `Scattering.albedos`, of light from an angle."""
    albedos, anisotropy, row = scattering.albedos, scattering.anisotropy, lobe.row
    if anisotropy is None or lobe.along == lobe.alpha:
        if lobe.between == 0.0:
            return interpolate(albedos[row, term], cosine)
        return interpolate_rows(albedos, row, term, lobe.between, cosine)
    count = anisotropy.azimuths
    position = azimuth * (count - 1)
    step = min(int(position), count - 2)
    row = lobe.azimuths + step
    value = interpolate_rows(albedos, row, term, position - step, cosine)
    if lobe.between == 0.0:
        return value
    stronger = interpolate_rows(albedos, row + count, term, position - step, cosine)
    return value + lobe.between * (stronger - value)


@jit
def mean_albedo(scattering, lobe, term):
    """Return the cosine-weighted mean of `look_up_albedo`."""
    albedos = scattering.albedos
    value = albedos[lobe.row, term, -1]
    if lobe.between == 0.0:
        return value
    return value + lobe.between * (albedos[lobe.row + 1, term, -1] - value)


@jit
def _albedos(scattering, lobe, cosine, azimuth):
    """Return the albedos of light from an angle and azimuth, as `Reflection.incoming`."""
    # Those at `dip_terms` count where there is a base, which gets what the lobe does not reflect.
    single = look_up_albedo(scattering, lobe, 0, cosine, azimuth)
    grazing = look_up_albedo(scattering, lobe, 1, cosine, azimuth)
    if scattering.dip.shape[1] == 0 or lobe.base <= 0.0:
        return single, grazing, NO_DIP
    dip = (
        look_up_albedo(scattering, lobe, 2, cosine, azimuth),
        look_up_albedo(scattering, lobe, 3, cosine, azimuth),
        look_up_albedo(scattering, lobe, 4, cosine, azimuth),
        look_up_albedo(scattering, lobe, 5, cosine, azimuth),
    )
    return single, grazing, dip


@jit
def _mean_albedos(scattering, lobe):
    """Return the cosine-weighted means of `_albedos`."""
    single, grazing = mean_albedo(scattering, lobe, 0), mean_albedo(scattering, lobe, 1)
    if scattering.dip.shape[1] == 0 or lobe.base <= 0.0:
        return single, grazing, NO_DIP
    dip = (
        mean_albedo(scattering, lobe, 2),
        mean_albedo(scattering, lobe, 3),
        mean_albedo(scattering, lobe, 4),
        mean_albedo(scattering, lobe, 5),
    )
    return single, grazing, dip


@jit
def multiple_fresnel(lobe, f0, dip, mean):
    """Return the Fresnel term of multiple scattering; `dip` is its mean, `mean` that of term 1."""
    fresnel = f0 + (1.0 - f0) * lobe.curve[1] - dip
    return fresnel * fresnel * mean / (1.0 - fresnel * (1.0 - mean))


@jit
def lobe_albedo(terms, f0, dip, multiple):
    """Return the lobe's albedo, of those at Fresnel terms 1 and `rise`, less its `dip`."""
    single, grazing = terms[0], terms[1]
    return f0 * (single - grazing) + grazing - dip + (1.0 - single) * multiple


@jit
def _covered_part(lobe):
    """Return which part of the surface is base below its cover; the rest is bare metal."""
    if lobe.over < 0.0:
        return 1.0
    # (1 - m) a = base and m a + (1 - m) over = f0, of a colour a that both parts share
    whole = lobe.base + lobe.f0
    root = math.sqrt(max(whole * whole - 4.0 * lobe.over * lobe.base, 0.0))
    return max(2.0 * lobe.base / max(whole + root, TINY), lobe.base, TINY)


@jit
def _several(scattering, lobe, part, f0, mean, band):
    """Return the `multiple_fresnel` of a lobe of f0; of both parts where one is bare metal.

    `part` is the `_covered_part`.
    """
    dip = dip_of((scattering.dip, lobe.material), DIP_MEANS, band)
    if lobe.over < 0.0:
        return multiple_fresnel(lobe, f0, dip, mean)
    bare = min(max(f0 - part * lobe.over, 0.0) / max(1.0 - part, TINY), 1.0)
    metal = (1.0 - part) * multiple_fresnel(lobe, bare, dip, mean)
    return metal + part * multiple_fresnel(lobe, lobe.over, 0.0, mean)


@jit
def _albedo_over(scattering, lobe, f0, terms, mean, band):
    """Return the albedo of what lies over the base: of the lobe of f0, or of a coat."""
    if lobe.over >= 0.0:
        multiple = multiple_fresnel(lobe, lobe.over, 0.0, mean)
        return lobe_albedo(terms, lobe.over, 0.0, multiple)
    weights = scattering.dip, lobe.material
    multiple = multiple_fresnel(lobe, f0, dip_of(weights, DIP_MEANS, band), mean)
    return lobe_albedo(terms, f0, dip_of(weights, terms[2], band), multiple)


@jit
def between(scattering, lobe, wi, wo, n):
    """Return what a lobe does between two directions above the surface, whatever its colour."""
    cos_i, cos_o = vec.dot(wi, n), vec.dot(wo, n)
    h = vec.normalize(vec.add(wi, wo))
    at_i, at_o = facets.azimuth(lobe, wi, n), facets.azimuth(lobe, wo, n)
    masking = 1.0 + facets.masking(lobe, cos_i, at_i)
    masking += facets.masking(lobe, cos_o, at_o)
    once = facets.distribution(lobe, h, n) / (4.0 * cos_i * cos_o * masking)
    rising, dip = rise(vec.dot(wo, h), lobe.curve[0]), dip_terms(vec.dot(wo, h))
    incoming = _albedos(scattering, lobe, cos_i, at_i)
    outgoing = _albedos(scattering, lobe, cos_o, at_o)
    means = _mean_albedos(scattering, lobe)
    missing = (1.0 - incoming[0]) * (1.0 - outgoing[0])
    missing = missing / max(1.0 - means[0], TINY) * warp.INV_PI
    return Reflection(once, rising, dip, missing, incoming, outgoing, means)


@jit
def reflected(found, f0, dip, multiple):
    """Return what a lobe alone reflects (per steradian); `dip` is that at the facets."""
    once = f0 + (1.0 - f0) * found.rise - dip
    return once * found.once + multiple * found.missing


@jit
def evaluate(scattering, lobe, surface, wi, cover, values):
    """Turn the base's albedos in values, (N,), into the BSDF (per steradian), under a `Cover`."""
    wo, n = departure(surface), surface.ns
    if vec.dot(wi, n) <= 0.0 or vec.dot(wo, n) <= 0.0:
        values[:] = cover.own
        return
    found = between(scattering, lobe, wi, wo, n)
    at_i, at_o, means = found.incoming, found.outgoing, found.mean
    weights = scattering.dip, lobe.material
    covered_part = _covered_part(lobe)
    for band in range(len(values)):
        f0, rho = normal_reflectance(scattering, lobe, band), float(values[band])
        multiple = _several(scattering, lobe, covered_part, f0, means[0], band)
        through = 1.0 - _albedo_over(scattering, lobe, f0, at_i, means[0], band)
        through *= 1.0 - _albedo_over(scattering, lobe, f0, at_o, means[0], band)
        back = _albedo_over(scattering, lobe, f0, means, means[0], band)
        again = min(rho / covered_part, 1.0) * back
        base = rho * through * warp.INV_PI / max(1.0 - again, TINY)
        own = reflected(found, f0, dip_of(weights, found.dip, band), multiple)
        values[band] = covered(cover, f0, rho, own + base)


@jit
def lobe_probability(scattering, lobe, wo, n):
    """Return about which part of the light to wo the lobe reflects: its probability."""
    f0, rho, cosine = lobe.f0, lobe.base, vec.dot(wo, n)
    if cosine <= 0.0:
        return 0.0
    azimuth = facets.azimuth(lobe, wo, n)
    mean, mean_grazing = mean_albedo(scattering, lobe, 0), mean_albedo(scattering, lobe, 1)
    multiple = multiple_fresnel(lobe, f0, 0.0, mean)
    back = lobe_albedo((mean, mean_grazing), f0, 0.0, multiple)
    single = look_up_albedo(scattering, lobe, 0, cosine, azimuth)
    grazing = look_up_albedo(scattering, lobe, 1, cosine, azimuth)
    once = f0 * (single - grazing) + grazing
    whole = lobe_albedo((single, grazing), f0, 0.0, multiple)
    base = rho * (1.0 - whole) * (1.0 - back) / max(1.0 - rho * back, TINY)
    return once / max(whole + base, TINY)


@jit
def sample_visible(lobe, wo, n, u, v):
    """Return a direction by visible normals."""
    local = facets.to_local(lobe, wo, n)
    h = facets.visible_normal(lobe.along, lobe.alpha, local, u, v)
    wi = vec.sub(vec.scale(h, 2.0 * vec.dot(local, h)), local)
    return vec.normalize(facets.from_local(lobe, wi, n))


@jit
def _probability(scattering, lobe, surface, wo):
    """Return with which probability a sample is drawn by visible normals."""
    least = _BY_LOBE if surface.model == LOBE else 0.0
    return max(lobe_probability(scattering, lobe, wo, surface.ns), least)


@jit
def sample(scattering, lobe, surface, u, v):
    """Return a direction by visible normals, or by the cosine for base and multiple scattering."""
    wo, n = departure(surface), surface.ns
    if vec.dot(wo, n) <= 0.0:
        return vec.scale(n, -1.0)
    probability = _probability(scattering, lobe, surface, wo)
    if u >= probability:
        u = min((u - probability) / (1.0 - probability), warp.BELOW_ONE)
        return vec.from_frame(warp.cosine_hemisphere(u, v), n)
    return sample_visible(lobe, wo, n, u / probability, v)


@jit
def visible_pdf(lobe, wi, wo, n):
    """Return the density of sampling by visible normals (per steradian)."""
    cos_o = vec.dot(wo, n)
    h = vec.normalize(vec.add(wi, wo))
    visible = facets.distribution(lobe, h, n)
    return visible / (
        4.0 * cos_o * (1.0 + facets.masking(lobe, cos_o, facets.azimuth(lobe, wo, n)))
    )


@jit
def pdf(scattering, lobe, surface, wi):
    """Return the density of `sample` (per steradian)."""
    wo, n = departure(surface), surface.ns
    cos_i, cos_o = vec.dot(wi, n), vec.dot(wo, n)
    if cos_i <= 0.0 or cos_o <= 0.0:
        return 0.0
    probability = _probability(scattering, lobe, surface, wo)
    visible = visible_pdf(lobe, wi, wo, n)
    return probability * visible + (1.0 - probability) * warp.cosine_hemisphere_pdf(cos_i)


@jit
def multiply_transmitted(scattering, lobe, w, n, values):
    """Multiply values, (N,), by the part of light to or from w that passes the lobe."""
    cosine = vec.dot(w, n)
    if cosine <= 0.0:
        values[:] = 0.0
        return
    terms = _albedos(scattering, lobe, cosine, facets.azimuth(lobe, w, n))
    mean = mean_albedo(scattering, lobe, 0)
    for band in range(len(values)):
        f0 = normal_reflectance(scattering, lobe, band)
        over = _albedo_over(scattering, lobe, f0, terms, mean, band)
        values[band] *= np.float32(1.0 - over)


@jit
def return_to_base(scattering, lobe, values):
    """Turn the base's albedos in values, (N,), into what it sends in all, reflected back to it."""
    means, covered_part = _mean_albedos(scattering, lobe), _covered_part(lobe)
    for band in range(len(values)):
        f0, rho = normal_reflectance(scattering, lobe, band), float(values[band])
        back = _albedo_over(scattering, lobe, f0, means, means[0], band)
        again = min(rho / covered_part, 1.0) * back
        values[band] = np.float32(rho / max(1.0 - again, TINY))
