"""BSDFs that are neither Lambertian nor specular: the list of models, and the calls to each.

All take `scattering` as an argument of its own: where it is None, every surface is Lambertian or
specular, and no code of any model is compiled. A model is a file of three functions beside each
other, about unit vectors that leave the surface, wi towards the light and wo towards the eye, and
the shading normal n:

- `evaluate(…, wi, wo, n, values)` turns the diffuse albedos in values, (N,), into the BSDF (per
  steradian), without the cosine; models that may lie below a coat take its `Cover` before `values`;
- `sample(…, wo, n, u, v)` returns wi; one below the horizon is lost;
- `pdf(…, wi, wo, n)` returns the density of `sample` (per steradian).

They begin with the material's parameters, or with all of `Scattering`, its textures, which are None
where there are none, and what the material is at the point.
"""

import numpy as np

from photonmap.kernels.bsdf import coated, glossy, lambert, rough_diffuse, sheen
from photonmap.kernels.bsdf.cover import UNCOVERED, covered
from photonmap.kernels.bsdf.glass import glass_share
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.bands import divide
from photonmap.kernels.core.jit import jit, outlined
from photonmap.kernels.core.passes import SurfaceInteraction
from photonmap.kernels.core.warp import INV_PI

LAMBERTIAN, ROUGH_DIFFUSE, GLOSSY, COATED, SHEEN = 0, 1, 2, 3, 4
"""Models; `Scattering.model` holds one for each material."""
LOBE = 5
"""Of a surface, not of a material: what a glossy one has beside its base; see `cached_base`."""
_BY_LOBE = 0.9
"""Least share of directions by the lobe where there is nothing else."""
MODELS = {"rough diffuse": ROUGH_DIFFUSE, "glossy": GLOSSY}
"""By the names that materials give them; those below a clear coat are `COATED`, those below sheen
`SHEEN`."""
NARROW = (GLOSSY, COATED, SHEEN)
"""Those with lobes that cosine-distributed rays and light samples may miss, or that may cover some
of them."""


@jit
def model_at(geometry, scattering, triangle):
    """Return the model of what a surface scatters beside its specular lobe."""
    if scattering is None:
        return LAMBERTIAN
    return np.int64(scattering.model[geometry.material[triangle]])


@jit
def with_model(geometry, scattering, surface):
    """Return a surface whose directions are drawn by its own model, not by Lambert's law."""
    point, ng, ns, side, hit, arrival, _ = surface
    model = model_at(geometry, scattering, hit.triangle)
    return SurfaceInteraction(point, ng, ns, side, hit, arrival, model)


@jit
def departure(surface):
    """Return wo: the unit vector to where a ray came from."""
    return vec.normalize(vec.scale(surface.arrival, -1.0))


@jit
def model_below(geometry, scattering, triangle):
    """Return the model of a surface, or of what lies below its coat or sheen."""
    return np.int64(scattering.below[geometry.material[triangle]])


@jit
def _base_at(geometry, scattering, model, hit):
    """Return what scatters below a cover, if there is one, as a `Lobe`: black where it has none."""
    if model == GLOSSY:
        return glossy.lobe_at(geometry, scattering, scattering.maps, hit)
    material = geometry.material[hit.triangle]
    albedo, nothing = scattering.parameters[material, 2], (0.0, 0.0, 0.0)
    row, curve = np.int64(material), (0.0, 0.0)
    return glossy.Lobe(material, 1.0, 0.0, albedo, row, 0.0, False, nothing, 1.0, nothing, 0, curve)


@jit
def _evaluate_base(scattering, model, base, cover, surface, wi, values):
    """Turn the diffuse albedos in values into the BSDF of what lies below a `Cover`."""
    wo, n = departure(surface), surface.ns
    if model == GLOSSY:
        glossy.evaluate(scattering, scattering.maps, base, wi, wo, n, cover, values)
    elif model == ROUGH_DIFFUSE:
        rough_diffuse.evaluate(scattering.parameters[base.material], wi, wo, n, values)
    elif model == LAMBERTIAN:
        for band in range(len(values)):
            rho = float(values[band])
            values[band] = covered(cover, 0.0, rho, rho * INV_PI)


@jit
def _cover_at(geometry, scattering, coats, base, surface, wi):
    """Return the `Cover` of a surface."""
    if coats is None:
        return UNCOVERED
    if model_at(geometry, scattering, surface.hit.triangle) != COATED:
        return UNCOVERED
    coat = coated.coat_at(geometry, scattering, surface)
    return coated.cover_at(scattering, base, coat, wi, departure(surface), surface.ns)


@jit
def _lay_sheen(geometry, scattering, sheens, surface, wi, values):
    """Turn the BSDF of a base in values into that with a sheen over it, if there is one."""
    if sheens is None:
        return
    if model_at(geometry, scattering, surface.hit.triangle) != SHEEN:
        return
    over = sheen.sheen_at(geometry, sheens, sheens.maps, surface.hit)
    sheen.cover(sheens, sheens.maps, over, (wi, departure(surface)), surface.ns, values)


@jit
def _evaluate(geometry, scattering, coats, surface, wi, values):
    """Turn the diffuse albedos in values into the BSDF."""
    hit = surface.hit
    below = model_below(geometry, scattering, hit.triangle)
    base = _base_at(geometry, scattering, below, hit)
    cover = _cover_at(geometry, scattering, coats, base, surface, wi)
    _evaluate_base(scattering, below, base, cover, surface, wi, values)
    _lay_sheen(geometry, scattering, scattering.sheens, surface, wi, values)


@outlined
def _evaluate_rest(geometry, scattering, share, surface, wi, values):
    """Turn the diffuse albedos in values into the BSDF, of the part of a surface that is no glass.

    The albedos are those of all of the surface.
    """
    if share is None:
        _evaluate(geometry, scattering, scattering.coats, surface, wi, values)
        return
    rest = 1.0 - glass_share(geometry, share, surface.hit)
    if rest <= 0.0:
        values[:] = 0.0
        return
    divide(values, rest)
    _evaluate(geometry, scattering, scattering.coats, surface, wi, values)
    divide(values, 1.0 / rest)


@jit
def fill_albedo(scene, surface, values):
    """Fill values, (N,), with the diffuse albedos of a surface."""
    color = look_up_material(scene.geometry, scene.textures, surface.hit)
    for band in range(len(values)):
        values[band] = albedo(scene.materials, scene.textures, color, band)


@jit
def evaluate(scene, scattering, surface, wi, values):
    """Fill values, (N,), with the BSDF (per steradian) from wi to where a ray came from."""
    if surface.model == LOBE:
        values[:] = 0.0
    else:
        fill_albedo(scene, surface, values)
    _evaluate_rest(scene.geometry, scattering, scattering.share, surface, wi, values)


@jit
def evaluate_lobe(scene, scattering, surface, wi, values):
    """Fill values, (N,), with what the BSDF has beside its diffuse base."""
    values[:] = 0.0
    _evaluate_rest(scene.geometry, scattering, scattering.share, surface, wi, values)


@jit
def _least(surface):
    """Return the least share of directions by the lobe."""
    return _BY_LOBE if surface.model == LOBE else 0.0


@jit
def _sample_base(scattering, model, base, surface, u, v):
    """Return a direction by what lies below a coat, if there is one."""
    if model == LAMBERTIAN:
        return lambert.sample(surface, u, v)
    wo, n = departure(surface), surface.ns
    if model == GLOSSY:
        return glossy.sample(scattering, scattering.maps, base, wo, n, u, v, _least(surface))
    if model == ROUGH_DIFFUSE:
        return rough_diffuse.sample(scattering.parameters[base.material], wo, n, u, v)
    return n  # of density 0: no model is left


@jit
def _left_of(u, share):
    """Return a uniform number that is not below the share, as one in [0, 1)."""
    return min((u - share) / (1.0 - share), warp.BELOW_ONE)


@outlined
def _sample(geometry, scattering, coats, sheens, surface, u, v):
    below = model_below(geometry, scattering, surface.hit.triangle)
    base, wo = _base_at(geometry, scattering, below, surface.hit), departure(surface)
    if coats is not None and surface.model == COATED:
        coat = coated.coat_at(geometry, scattering, surface)
        share = coated.probability(scattering, base, coat, wo)
        if u < share:
            return coated.sample(coat, wo, u / share, v)
        u = _left_of(u, share)
    if sheens is not None and surface.model == SHEEN:
        over = sheen.sheen_at(geometry, sheens, sheens.maps, surface.hit)
        share = sheen.probability(sheens, over, base, vec.dot(wo, surface.ns))
        if u < share:
            return sheen.sample(surface.ns, u / share, v)
        u = _left_of(u, share)
    return _sample_base(scattering, below, base, surface, u, v)


@jit
def sample(geometry, scattering, surface, u, v):
    """Return a unit vector wi of density `pdf`; `surface.model` says by which BSDF."""
    if scattering is None or surface.model == LAMBERTIAN:
        return lambert.sample(surface, u, v)
    coats, sheens = scattering.coats, scattering.sheens
    return _sample(geometry, scattering, coats, sheens, surface, u, v)


@jit
def _base_pdf(scattering, model, base, surface, wi):
    """Return the density of `_sample_base`."""
    if model == LAMBERTIAN:
        return lambert.pdf(surface, wi)
    wo, n = departure(surface), surface.ns
    if model == GLOSSY:
        return glossy.pdf(scattering, scattering.maps, base, wi, wo, n, _least(surface))
    if model == ROUGH_DIFFUSE:
        return rough_diffuse.pdf(scattering.parameters[base.material], wi, wo, n)
    return 0.0


@outlined
def _pdf(geometry, scattering, coats, sheens, surface, wi):
    below = model_below(geometry, scattering, surface.hit.triangle)
    base, wo = _base_at(geometry, scattering, below, surface.hit), departure(surface)
    density = _base_pdf(scattering, below, base, surface, wi)
    if coats is not None and surface.model == COATED:
        coat = coated.coat_at(geometry, scattering, surface)
        share = coated.probability(scattering, base, coat, wo)
        own = coated.pdf(coat, wi, wo, surface.ns)
        return share * own + (1.0 - share) * density
    if sheens is not None and surface.model == SHEEN:
        over = sheen.sheen_at(geometry, sheens, sheens.maps, surface.hit)
        share = sheen.probability(sheens, over, base, vec.dot(wo, surface.ns))
        return share * sheen.pdf(wi, surface.ns) + (1.0 - share) * density
    return density


@jit
def pdf(geometry, scattering, surface, wi):
    """Return the density of `sample` (per steradian) for the unit vector wi."""
    if scattering is None or surface.model == LAMBERTIAN:
        return lambert.pdf(surface, wi)
    return _pdf(geometry, scattering, scattering.coats, scattering.sheens, surface, wi)


@jit
def _toward_light(coats, surface, direction):
    """Return the surface that a photon leaves along a direction, as one that light meets, and wi.

    BSDFs are reciprocal, so it stays as it is, but for coats with normals of their own.
    """
    if coats is None:
        return surface, direction
    return _turned(coats.relief, surface, direction)


@jit
def _turned(relief, surface, direction):
    if relief is None:
        return surface, direction
    point, ng, ns, side, hit, _, model = surface
    turned = SurfaceInteraction(point, ng, ns, side, hit, vec.scale(direction, -1.0), model)
    return turned, departure(surface)


@outlined
def scatter_flux(scene, scattering, surface, point, factor, flux, response):
    """Scatter a photon, by a point of the unit square; return the direction in which it leaves.

    `flux`, (N,), is multiplied by factor · BSDF · cosine / pdf, where `factor` is that of Veach's
    adjoint BSDF at the arrival; `response`, (N,), is scratch.
    """
    direction = sample(scene.geometry, scattering, surface, point[0], point[1])
    density = pdf(scene.geometry, scattering, surface, direction)
    cosine = vec.dot(surface.ng, direction)
    if density <= 0.0 or cosine <= 0.0:
        flux[:] = 0.0
        return direction
    surface, toward = _toward_light(scattering.coats, surface, direction)
    evaluate(scene, scattering, surface, toward, response)
    for band in range(len(flux)):
        flux[band] *= response[band] * (factor * cosine / density)
    return direction
