"""BSDFs that are neither Lambertian nor specular: the list of models, and the calls to each.

Where `scene.scattering` is None, every surface is Lambertian or specular, and no code of any model
is compiled. A base is a module of functions beside each other, about unit vectors that leave
the surface, wi towards the light and wo towards the eye:

- `lobe_at(geometry, scattering, hit)` returns what it is at a point, a `glossy.Lobe`;
- `evaluate(scattering, base, surface, wi, cover, values)` turns the diffuse albedos in values,
  (N,), into the BSDF (per steradian), without the cosine, with the `Cover` that lies over it;
- `sample(scattering, base, surface, u, v)` returns wi; one below the horizon is lost;
- `pdf(scattering, base, surface, wi)` returns the density of `sample` (per steradian).
"""

import numpy as np

from photonmap.kernels.bsdf import coated, glossy, lambert, rough_diffuse, sheen
from photonmap.kernels.bsdf.cover import UNCOVERED
from photonmap.kernels.bsdf.fluorescence import (
    FLUORESCING,
    add_reradiated,
    divide_by_taken,
    fill_whole_albedo,
    fluoresces,
    fluorophore_at,
)
from photonmap.kernels.bsdf.glass import glass_fraction
from photonmap.kernels.bsdf.material import albedo, look_up_material
from photonmap.kernels.core import vec, warp
from photonmap.kernels.core.bands import copy, divide
from photonmap.kernels.core.jit import by_number, jit, outlined
from photonmap.kernels.core.passes import SurfaceInteraction
from photonmap.kernels.geometry.interaction import departure

BASES = {"Lambertian": lambert, "rough diffuse": rough_diffuse, "glossy": glossy}
"""Models that may lie below a clear coat or a sheen, by the names that materials give them"""
MODELS = {name: number for number, name in enumerate(BASES)}
"""Values of `Scattering.below`, and of `Scattering.model` but for what a cover lies over"""
LAMBERTIAN, GLOSSY = MODELS["Lambertian"], MODELS["glossy"]
COATED, SHEEN = len(BASES), len(BASES) + 1
"""Values of `Scattering.model` of what lies below a clear coat, and below a sheen"""
NARROW = (*(MODELS[name] for name, base in BASES.items() if base.IS_NARROW), COATED, SHEEN)
"""Those with lobes that cosine-distributed rays and light samples may miss, or that may cover some
of them"""

_modules = BASES.values()
_lobe_at = by_number(_modules, "lobe_at", "geometry, scattering, hit")
_evaluate_base = by_number(_modules, "evaluate", "scattering, base, surface, wi, cover, values")
_sample_base = by_number(_modules, "sample", "scattering, base, surface, u, v")
_base_pdf = by_number(_modules, "pdf", "scattering, base, surface, wi")


@jit
def model_at(scene, triangle):
    """Return the model of what a surface scatters beside its specular lobe."""
    if scene.scattering is None:
        return LAMBERTIAN
    return np.int64(scene.scattering.model[scene.geometry.material[triangle]])


@jit
def with_number(surface, model):
    """Return a surface whose directions are drawn by a model."""
    point, site, ng, ns, side, hit, arrival, _ = surface
    return SurfaceInteraction(point, site, ng, ns, side, hit, arrival, np.int64(model))


@jit
def with_model(scene, surface):
    """Return a surface whose directions are drawn by its own model, not by Lambert's law."""
    return with_number(surface, model_at(scene, surface.hit.triangle))


@jit
def model_below(scene, triangle):
    """Return the model of a surface, or of what lies below its coat or sheen."""
    return np.int64(scene.scattering.below[scene.geometry.material[triangle]])


@jit
def _evaluate(scene, surface, wi, values):
    """Turn the diffuse albedos in values into the BSDF."""
    geometry, scattering, sheens = scene.geometry, scene.scattering, scene.scattering.sheens
    hit, wo, n, cover = surface.hit, departure(surface), surface.ns, UNCOVERED
    model, below = model_at(scene, hit.triangle), model_below(scene, hit.triangle)
    base = _lobe_at(below, geometry, scattering, hit)
    if scattering.coats is not None and model == COATED:
        coat = coated.coat_at(geometry, scattering, surface)
        cover = coated.cover_at(scattering, base, coat, wi, wo, n)
    _evaluate_base(below, scattering, base, surface, wi, cover, values)
    if sheens is not None and model == SHEEN:
        sheen.cover(sheens, sheen.sheen_at(geometry, sheens, hit), (wi, wo), n, values)


@outlined
def _evaluate_rest(scene, surface, wi, values):
    """Turn diffuse albedos of a whole surface into the BSDF of the part that is no glass."""
    if scene.scattering.glass is None:
        _evaluate(scene, surface, wi, values)
        return
    rest = 1.0 - glass_fraction(scene.geometry, scene.scattering.glass, surface.hit)
    if rest <= 0.0:
        values[:] = 0.0
        return
    divide(values, rest)
    _evaluate(scene, surface, wi, values)
    divide(values, 1.0 / rest)


@jit
def fill_albedo(scene, surface, values):
    """Fill values, (N,), with the diffuse albedos of a surface."""
    color = look_up_material(scene, surface.hit)
    for band in range(len(values)):
        values[band] = albedo(scene, color, band)


@jit
def evaluate(scene, surface, wi, values):
    """Fill values, (N,), with the BSDF (per steradian) from wi to where a ray came from."""
    if surface.model == glossy.LOBE:
        values[:] = 0.0
    else:
        fill_albedo(scene, surface, values)
    _evaluate_rest(scene, surface, wi, values)


@jit
def evaluate_lobe(scene, surface, wi, values):
    """Fill values, (N,), with what the BSDF has beside its diffuse base."""
    values[:] = 0.0
    _evaluate_rest(scene, surface, wi, values)


@outlined
def fill_excitation(scene, surface, wi, response, values):
    """Fill values, (N,), with how much of the light from wi excites fluorescence, per steradian.

    `response` is what `evaluate` fills for the same directions, of a surface that fluoresces.
    """
    fill_whole_albedo(scene, surface.hit, values)
    _evaluate_rest(scene, surface, wi, values)
    divide_by_taken(scene, surface.hit, response, values)


@jit
def evaluate_sought(scene, surface, wi, response, scratch):
    """Fill response as `evaluate`, or as `fill_excitation` where that is what paths look for."""
    evaluate(scene, surface, wi, response)
    if scene.fluorescence is not None and surface.model == FLUORESCING:
        fill_excitation(scene, surface, wi, response, scratch)
        copy(scratch, response)


@jit
def _rescaled(u, probability):
    """Return a uniform number that is not below the probability, as one in [0, 1)."""
    return min((u - probability) / (1.0 - probability), warp.BELOW_ONE)


@outlined
def _sample(scene, surface, u, v):
    geometry, scattering, sheens = scene.geometry, scene.scattering, scene.scattering.sheens
    if scene.fluorescence is not None and surface.model == FLUORESCING:
        return lambert.sample_cosine(surface, u, v)
    below = model_below(scene, surface.hit.triangle)
    base, wo = _lobe_at(below, geometry, scattering, surface.hit), departure(surface)
    if scattering.coats is not None and surface.model == COATED:
        coat = coated.coat_at(geometry, scattering, surface)
        probability = coated.probability(scattering, base, coat, wo)
        if u < probability:
            return coated.sample(coat, wo, u / probability, v)
        u = _rescaled(u, probability)
    if sheens is not None and surface.model == SHEEN:
        over = sheen.sheen_at(geometry, sheens, surface.hit)
        probability = sheen.probability(sheens, over, base, vec.dot(wo, surface.ns))
        if u < probability:
            return sheen.sample(surface.ns, u / probability, v)
        u = _rescaled(u, probability)
    return _sample_base(below, scattering, base, surface, u, v)


@jit
def sample(scene, surface, u, v):
    """Return a unit vector wi of density `pdf`; `surface.model` says by which BSDF."""
    if scene.scattering is None or surface.model == LAMBERTIAN:
        return lambert.sample_cosine(surface, u, v)
    return _sample(scene, surface, u, v)


@outlined
def _pdf(scene, surface, wi):
    geometry, scattering, sheens = scene.geometry, scene.scattering, scene.scattering.sheens
    if scene.fluorescence is not None and surface.model == FLUORESCING:
        return lambert.cosine_pdf(surface, wi)
    below = model_below(scene, surface.hit.triangle)
    base, wo = _lobe_at(below, geometry, scattering, surface.hit), departure(surface)
    density = _base_pdf(below, scattering, base, surface, wi)
    if scattering.coats is not None and surface.model == COATED:
        coat = coated.coat_at(geometry, scattering, surface)
        probability = coated.probability(scattering, base, coat, wo)
        own = coated.pdf(coat, wi, wo, surface.ns)
        return probability * own + (1.0 - probability) * density
    if sheens is not None and surface.model == SHEEN:
        over = sheen.sheen_at(geometry, sheens, surface.hit)
        probability = sheen.probability(sheens, over, base, vec.dot(wo, surface.ns))
        return probability * sheen.pdf(wi, surface.ns) + (1.0 - probability) * density
    return density


@jit
def pdf(scene, surface, wi):
    """Return the density of `sample` (per steradian) for the unit vector wi."""
    if scene.scattering is None or surface.model == LAMBERTIAN:
        return lambert.cosine_pdf(surface, wi)
    return _pdf(scene, surface, wi)


@jit
def _toward_light(coats, surface, direction):
    """Return the surface as light meets it, and wi: turned for coats with normals of their own."""
    if coats is None or coats.relief is None:
        return surface, direction
    point, site, ng, ns, side, hit, _, model = surface
    arrival = vec.scale(direction, -1.0)
    turned = SurfaceInteraction(point, site, ng, ns, side, hit, arrival, model)
    return turned, departure(surface)


@outlined
def scatter_flux(scene, surface, point, factor, flux, response, excited):
    """Scatter a photon, by a point of the unit square; return the direction in which it leaves.

    `flux`, (N,), is multiplied by factor · BSDF · cosine / pdf, where `factor` is that of Veach's
    adjoint BSDF at the arrival, and gains what it makes a fluorescent surface re-emit there.
    `response` and `excited`, (N,), are scratch.
    """
    direction = sample(scene, surface, point[0], point[1])
    density = pdf(scene, surface, direction)
    cosine = vec.dot(surface.ng, direction)
    if density <= 0.0 or cosine <= 0.0:
        flux[:] = 0.0
        return direction
    surface, toward = _toward_light(scene.scattering.coats, surface, direction)
    evaluate(scene, surface, toward, response)
    is_fluorescent, scale = fluoresces(scene, surface.hit.triangle), factor * cosine / density
    if scene.fluorescence is not None and is_fluorescent:
        fill_excitation(scene, surface, toward, response, excited)
        for band in range(len(flux)):
            excited[band] *= flux[band]
    for band in range(len(flux)):
        flux[band] *= response[band] * (factor * cosine / density)
    if scene.fluorescence is not None and is_fluorescent:
        row, concentration = fluorophore_at(scene.geometry, scene.fluorescence, surface.hit)
        add_reradiated(scene.fluorescence, row, scale * concentration, excited, flux)
    return direction
