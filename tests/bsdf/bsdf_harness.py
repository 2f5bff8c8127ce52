"""What every BSDF is tested by: its cases, surfaces that scatter by it, and the hemisphere.

A new model needs a line of `CASES`, for each set of parameters that differs in kind.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

import photonmap as pm
from photonmap.compile.surfaces.coats import with_coats
from photonmap.compile.surfaces.glossy import NODES, TERMS, lobe_albedos
from photonmap.compile.surfaces.relief import Reliefs
from photonmap.compile.surfaces.sheens import with_sheens
from photonmap.compile.textures import compile_textures
from photonmap.kernels.bsdf import models
from photonmap.kernels.core import records, rng, vec
from photonmap.kernels.core.jit import kernel
from photonmap.kernels.core.passes import Hit, SurfaceInteraction
from photonmap.kernels.core.record_types import with_absent
from photonmap.scene.surfaces.conductors import fit_dip
from photonmap.scene.surfaces.fresnel import mean_rise
from photonmap.spectra.bands import Bands

ALBEDOS = (0.2, 0.7, 1.0)
COSINES = (1.0, 0.5, 0.08)
"""Of the angles between normal and wo."""
SAMPLES = 20_000
ORIGIN = (0.0, 0.0, 0.0)


class Case(NamedTuple):
    """A BSDF: the name of its model, its parameters, and the diffuse albedo in each band."""

    model: str
    parameters: tuple = ()
    albedo: tuple = ALBEDOS
    specular: tuple = (0.0, 0.0, 0.0)
    is_textured: bool = False
    """whether textures give roughness, reflectance and albedo, which are the same all over"""
    anisotropy: tuple = (0.0, 0.0)
    """of the material, and its rotation; the tangent is `FRAME`'s x without one"""
    is_brushed: bool = False
    """whether an image gives directions, here none, and strengths, of which 1 occurs elsewhere"""
    coat: tuple = (0.0, 0.0, 1.5)
    """weight, roughness and index of refraction of a clear coat over it"""
    is_coat_textured: bool = False
    """whether an image gives its roughness, the same all over"""
    coat_lean: tuple = ()
    """its own normal, by `FRAME`'s x and y and the surface's; none where it is the surface's"""
    sheen: tuple = (0.0, 0.5)
    """colour and roughness of a sheen over it"""
    edge: tuple = ()
    """reflectance at 82°; none where Schlick's formula gives it"""
    index: float = 0.0
    """of refraction of its lobe, 0 for Schlick's formula"""
    covering: float = -1.0
    """reflectance at normal incidence of what lies over the base of a metal in part"""


LAMBERTIAN = Case("Lambertian")
CASES = [
    LAMBERTIAN,
    *(Case("rough diffuse", (roughness,)) for roughness in (0.0, 0.25, 1.0)),
    *(Case("glossy", (alpha,), specular=(0.04,) * 3, index=1.5) for alpha in (0.2, 0.5, 1.0)),
    Case("glossy", (0.4,), specular=(0.04, 0.2, 0.5)),
    Case("glossy", (0.3,), (0.0,) * 3, (0.5, 0.8, 1.0)),
    Case("glossy", (0.3,), (0.1, 0.2, 0.4), (0.12, 0.22, 0.42), covering=0.04),
    Case("glossy", (0.3,), (0.0,) * 3, (0.56, 0.8, 1.0), edge=(0.55, 0.7, 0.9)),
    Case("glossy", (0.2,), specular=(0.04, 0.5, 0.9), anisotropy=(0.6, 0.1)),
    Case("glossy", (0.2,), (0.0,) * 3, (0.5, 0.7, 0.9), anisotropy=(0.5, 0.1), edge=(0.4,) * 3),
    Case("glossy", (0.35,), (0.2, 0.5, 0.8), (0.04, 0.3, 0.5), is_textured=True),
    Case("Lambertian", coat=(1.0, 0.5, 1.5)),
    Case("glossy", (0.5,), specular=(0.04,) * 3, index=1.5, coat=(0.8, 0.45, 1.5)),
    Case("glossy", (0.3,), specular=(0.16,) * 3, index=7 / 3, anisotropy=(0.5, 0.2)),
    Case("glossy", (0.3,), specular=(0.04,) * 3, coat=(0.9, 0.53, 1.5), is_coat_textured=True),
    Case("glossy", (0.3,), (0.0,) * 3, (0.5, 0.8, 1.0), coat=(1.0, 0.5, 2.0)),
    Case("glossy", (0.35,), (0.2, 0.5, 0.8), (0.04, 0.3, 0.5), True, coat=(0.4, 0.7, 1.5)),
    *(Case("Lambertian", sheen=(0.9, roughness)) for roughness in (0.2, 0.5, 1.0)),
    Case("rough diffuse", (0.8,), sheen=(0.3, 0.4)),
    Case("glossy", (0.5,), specular=(0.04,) * 3, sheen=(0.6, 0.3)),
    Case("glossy", (0.3,), (0.0,) * 3, (0.5, 0.8, 1.0), sheen=(0.5, 0.7)),
]

_N = np.array([0.48, -0.6, 0.64])
_X = np.cross(_N, (0.0, 1.0, 0.0))
_X /= np.linalg.norm(_X)
FRAME = np.stack([_X, np.cross(_N, _X), _N])
"""Rows are x, y and the normal of a surface in general position."""
NORMAL = tuple(_N)


@cache
def make_scene(case):
    """Return the arrays of one triangle that scatters as the case says."""
    geometry = records.Geometry(
        scene=0,
        vertices=np.eye(3, dtype=np.float32),
        triangles=np.arange(3, dtype=np.int32)[None],
        normals=_N[None].astype(np.float32),
        shading_normals=np.zeros((0, 3), np.float32),
        material=np.zeros(1, np.int32),
        emitter=np.full(1, -1, np.int32),
        uv=np.ascontiguousarray(np.eye(3) @ FRAME[:2].T, np.float32),
        alpha=None,
        relief=None,
        corners=np.zeros((0, 3)),
        corner_normals=np.zeros((0, 3)),
    )
    scattering = _bare(case)
    look = _material(case)
    if case.is_brushed:
        look = replace(look, anisotropy=1.0, anisotropy_map=brushed(case.anisotropy[0]))
    table = compile_textures([look], np.ones(1))
    if case.is_brushed:
        _IMAGES.extend(table.images)
        scattering = table.lobes(scattering, Bands.rgb())
    reliefs = Reliefs(geometry, table, 1.0, np.zeros((3, 4)))
    scattering = reliefs.with_anisotropy(scattering, [look])
    materials = records.Materials(np.array([case.albedo], np.float32))
    textures = None
    if case.is_textured:
        textures, scattering = texture(case, scattering)
    scattering = _coated(scattering, look, geometry) if case.coat[0] else scattering
    table = compile_textures([look], np.ones(1))
    scattering = with_sheens(scattering, [look], table, Bands.rgb())
    return with_absent(
        records.SceneArrays(geometry, materials, None, None, textures, scattering),
        {"specular", "fluorescence"},
    )


def _bare(case):
    """Return the scattering of a case, without textures, covers and anisotropy."""
    parameters, albedos = np.zeros((1, 6)), np.zeros((TERMS, NODES + 1))
    parameters[0, : len(case.parameters)] = case.parameters
    parameters[0, 1:3] = np.mean(case.specular), np.mean(case.albedo)
    if case.model == "glossy":
        albedos = lobe_albedos(parameters[0, 0], case.index)
        parameters[0, 3:] = case.index, mean_rise(case.index), case.covering
    specular = np.array([case.specular], np.float32)
    model = np.array([models.MODELS.get(case.model, models.LAMBERTIAN)], np.uint8)
    return records.Scattering(
        model,
        parameters,
        specular,
        np.ascontiguousarray(albedos)[None],
        *(None, None, None),
        _dip(case),
        None,
        model,
        None,
    )


def _coated(scattering, look, geometry):
    """Return a scattering below the coat of a material."""
    table = compile_textures([look], np.ones(1))
    _IMAGES.extend(table.images)
    if look.has_textured_coat:
        scattering = table.lobes(scattering, Bands.rgb())
    return with_coats(scattering, [look], Reliefs(geometry, table, 1.0, np.zeros((3, 4))))


def _dip(case):
    """Return the weights of the dip, (1, 4, N); (1, 0, 0) where Schlick's formula holds."""
    if not case.edge:
        return np.zeros((1, 0, 0), np.float32)
    return fit_dip(np.array(case.specular), np.array(case.edge))[None].astype(np.float32)


def _material(case):
    """Return a material as the case says, but for its colours."""
    is_glossy = case.model == "glossy"
    roughness = np.sqrt(case.parameters[0]) if is_glossy else 0.0
    strength, turns = case.anisotropy
    weight, coat_roughness, coat_ior = case.coat
    own = [[0.5 + 0.5 * np.array(case.coat_lean)]]
    return pm.Material(
        "m",
        glossy=0.5 if is_glossy else 0.0,
        roughness=_even(roughness) if case.is_textured else roughness,
        anisotropy=strength,
        anisotropy_rotation=turns,
        coat=weight,
        coat_roughness=_even(coat_roughness) if case.is_coat_textured else coat_roughness,
        coat_ior=coat_ior,
        coat_relief=pm.NormalMap(_even(own)) if case.coat_lean else None,
        diffuse_roughness=case.parameters[0] if case.model == "rough diffuse" else 0.0,
        sheen=case.sheen[0],
        sheen_roughness=case.sheen[1],
    )


def texture(case, scattering):
    """Return the textures of a glossy case, and its scattering with them in place of numbers."""
    material = pm.Material(
        "textured",
        _even(case.albedo),
        glossy=_even(case.specular),
        roughness=_even(np.sqrt(case.parameters[0])),
        coat=_even(case.coat[0]) if case.coat[0] else 0.0,
    )
    table, bands = compile_textures([material], np.ones(1)), Bands.rgb()
    _IMAGES.extend(table.images)
    wrong = scattering._replace(specular=np.full((1, 3), 0.9, np.float32))
    return table.textures(bands), table.lobes(wrong, bands)


def brushed(strength):
    """Return an image that has a strength where the harness looks, and another one far away."""
    texels = np.full((64, 64, 3), [1.0, 0.5, strength], np.float32)
    texels[0] = texels[:, 0] = 1.0, 0.5, 1.0
    texels[32] = texels[:, 32] = 1.0, 0.5, strength
    return pm.AnisotropyMap(pm.Texture.of(texels))


_IMAGES = []
"""Texels, of which kernels have the addresses."""


def _even(value):
    return pm.Texture.of(np.full((2, 2, 3), value, np.float32))


def number_of(case):
    """Return the number of a case's model."""
    if case.coat[0]:
        return models.COATED
    if case.sheen[0]:
        return models.SHEEN
    return models.MODELS.get(case.model, models.LAMBERTIAN)


@kernel
def _evaluate_all(scene, model, n, wi, wo, values, densities):
    hit = Hit(0, 0.3, 0.3, 1.0)
    for i in range(len(wi)):
        arrival = vec.scale(vec.row(wo, i), -3.0)
        surface = SurfaceInteraction(ORIGIN, ORIGIN, n, n, 0, hit, arrival, model)
        direction = vec.row(wi, i)
        models.evaluate(scene, surface, direction, values[i])
        densities[i] = models.pdf(scene, surface, direction)


@kernel
def _sample_all(scene, model, n, wo, key, wi):
    hit, arrival = Hit(0, 0.3, 0.3, 1.0), vec.scale(wo, -3.0)
    surface = SurfaceInteraction(ORIGIN, ORIGIN, n, n, 0, hit, arrival, model)
    state = rng.stream(key, 0, 0)
    for i in range(len(wi)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        wi[i, 0], wi[i, 1], wi[i, 2] = models.sample(scene, surface, u, v)


@kernel
def _scatter_all(scene, model, n, wo, key, response, flux):
    hit, arrival = Hit(0, 0.3, 0.3, 1.0), vec.scale(wo, -3.0)
    surface = SurfaceInteraction(ORIGIN, ORIGIN, n, n, 0, hit, arrival, model)
    state = rng.stream(key, 0, 0)
    for i in range(len(flux)):
        u, state = rng.draw(state)
        v, state = rng.draw(state)
        models.scatter_flux(scene, surface, (u, v), 1.0, flux[i], response[0], response[1])


def to_world(local):
    """Turn directions about +z, (n, 3), into those about the surface's normal."""
    return np.ascontiguousarray(np.asarray(local, float) @ FRAME)


def departure(cosine, azimuth=0.0):
    """Return the unit vector wo, in the world, at an angle to the normal."""
    sine = np.sqrt(1.0 - cosine * cosine)
    return to_world([[sine * np.cos(azimuth), sine * np.sin(azimuth), cosine]])[0]


def evaluate(case, wi, wo, model=None):
    """Return the BSDF, (n, N), and the density of wi, (n,), for pairs of directions.

    By default by the model of the case.
    """
    wi = np.ascontiguousarray(wi)
    wo = np.ascontiguousarray(np.broadcast_to(wo, wi.shape))
    values, densities = np.empty((len(wi), len(case.albedo)), np.float32), np.empty(len(wi))
    model = number_of(case) if model is None else model
    _evaluate_all(make_scene(case), model, NORMAL, wi, wo, values, densities)
    return values.astype(float), densities


def sample(case, wo, key=1, count=SAMPLES, model=None):
    """Return directions wi, (n, 3), in the world."""
    wi = np.empty((count, 3))
    model = number_of(case) if model is None else model
    _sample_all(make_scene(case), model, NORMAL, tuple(wo), np.uint64(key), wi)
    return wi


def scatter(case, wo, key=2, count=SAMPLES):
    """Return what is left of a flux of 1 that photons bring from wo, (n, N)."""
    flux = np.ones((count, len(case.albedo)), np.float32)
    response = np.empty((2, len(case.albedo)), np.float32)
    scene, model = make_scene(case), number_of(case)
    _scatter_all(scene, model, NORMAL, tuple(wo), np.uint64(key), response, flux)
    return flux.astype(float)


def hemisphere(cosine=0.5, heights=48, turns=256):
    """Return a quadrature: directions about the normal, (n, 3), and their solid angles.

    Gauss-Legendre in the cosine, in two parts that meet at that of wo, where BSDFs have a kink.
    """
    nodes, weights = np.polynomial.legendre.leggauss(heights)
    parts = [(0.0, cosine), (cosine, 1.0)] if cosine < 1.0 else [(0.0, 1.0)]
    z = np.concatenate([low + (high - low) * 0.5 * (nodes + 1.0) for low, high in parts])
    share = np.concatenate([(high - low) * 0.5 * weights for low, high in parts])
    phi = (np.arange(turns) + 0.5) * 2.0 * np.pi / turns
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1.0 - z * z)
    local = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    return to_world(local), np.repeat(share, turns) * 2.0 * np.pi / turns


def furnace(case, cosine, count=10_000):
    """Return what is reflected of even light, in the first band, and the error of that."""
    wo = departure(cosine)
    wi = sample(case, wo, count=count)
    values, density = evaluate(case, wi, wo)
    used = density > 0.0
    weights = np.where(used, values[:, 0] * (wi @ _N) / np.where(used, density, 1.0), 0.0)
    return weights.mean(), weights.std() / np.sqrt(len(weights))


def directional_albedo(case, cosine):
    """Return the part of the light from an angle that is reflected, in each band, by quadrature."""
    wi, solid_angles = hemisphere(cosine)
    values, _ = evaluate(case, wi, departure(cosine))
    return values.T @ ((wi @ _N) * solid_angles)
