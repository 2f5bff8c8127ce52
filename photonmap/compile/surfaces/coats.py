"""Clear coats, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from photonmap.compile.surfaces.glossy import (
    GRID,
    NODES,
    SMALLEST_COSINE,
    append_stepped,
    lobe_albedo,
    lobe_albedos,
    multiple_fresnel,
    reflections,
)
from photonmap.compile.surfaces.glossy import STEPS as COATS
from photonmap.compile.surfaces.relief import Reliefs
from photonmap.compile.table_cache import Floats, kept_on_disk
from photonmap.kernels.bsdf.models import COATED
from photonmap.kernels.core import records
from photonmap.kernels.core.lobe_records import Coats
from photonmap.scene.material import LEAST_ALPHA, Material
from photonmap.scene.surfaces.fresnel import mean_rise, normal_reflectance, rise
from photonmap.scene.textures import Texture, mean_number

STEPS = 9
"""Values of the roughness of a base for which D is tabulated, evenly from 0 to 1."""
ROUNDS = 60
"""of the iteration, which gains a digit in about six"""


def with_coats(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    reliefs: Reliefs | None = None,
) -> records.Scattering | None:
    """Return BSDFs below clear coats, where any material has one.

    Parameters
    ----------
    scattering : of M materials
    materials : (M,)
    reliefs : of the scene; None where no coat has normals of its own
    """
    chosen = [index for index, material in enumerate(materials) if material.is_coated]
    if scattering is None or not chosen:
        return scattering
    numbers = _numbers(scattering, materials, chosen)
    row, first, steps = np.full((3, len(materials)), -1, np.int32)
    model, albedos = scattering.model.copy(), [scattering.albedos]
    through: list[Floats] = []
    for place, index in enumerate(chosen):
        _, alpha, refraction, dielectric = numbers[:, index].tolist()
        row[index] = len(scattering.albedos) + place
        first[index] = sum(len(rows) for rows in through)
        albedos.append(lobe_albedos(alpha, refraction)[None])
        alphas = [alpha, *_stepped_alphas(materials[index].coat_roughness)]
        base = dielectric, float(scattering.parameters[index, 3])
        rows = [_through((refraction, each), materials[index], base) for each in alphas]
        through += rows
        steps[index] = len(rows[0])
    varies = np.array([material.has_textured_coat for material in materials])
    weight, alpha, refraction, dielectric = numbers
    whole, stepped = append_stepped(np.concatenate(albedos), refraction, varies)
    coats = Coats(
        weight,
        np.array([normal_reflectance(each) for each in refraction.tolist()]),
        refraction,
        np.array([mean_rise(each) for each in refraction.tolist()]),
        alpha,
        row,
        stepped,
        dielectric,
        first,
        steps,
        np.concatenate(through),
        scattering.maps if varies.any() else None,
        np.array([material.own_coat_relief is not None for material in materials], np.uint8),
        reliefs and reliefs.of_coats(materials),
    )
    model[chosen] = COATED
    return scattering._replace(model=model, albedos=whole, coats=coats)


def _numbers(
    scattering: records.Scattering, materials: Sequence[Material], chosen: Sequence[int]
) -> Floats:
    """Return weight, α and index of the coats of chosen materials, and F₀ of their bases, (4, M).

    Of others weight and α are 0, and the index is 1.
    """
    numbers = np.zeros((4, len(materials)))
    numbers[2] = 1.0
    for index in chosen:
        material = materials[index]
        numbers[:, index] = (
            mean_number(material.coat),
            max(mean_number(material.coat_roughness) ** 2, LEAST_ALPHA),
            material.coat_ior,
            _dielectric(material, scattering.parameters[index, 1:3].tolist()),
        )
    return numbers


def _stepped_alphas(roughness: float | Texture) -> list[float]:
    """Return α of even steps of roughness, if an image gives it; else nothing."""
    steps = _evenly_from_0_to_1(COATS) if isinstance(roughness, Texture) else []
    return [max(step * step, LEAST_ALPHA) for step in steps]


def _evenly_from_0_to_1(count: int) -> list[float]:
    return list(np.linspace(0.0, 1.0, count).tolist())


def _dielectric(material: Material, means: list[float]) -> float:
    """Return what the lobe of a base reflects at normal incidence where it is no metal."""
    f0, base = means
    varies = isinstance(material.glossy, Texture) or base == 0.0
    return normal_reflectance(1.5) if varies else f0


def _through(coat: tuple[float, float], material: Material, base: tuple[float, float]) -> Floats:
    """Return rows of `Coats.through` for one material.

    The coat is its index and α; the base F₀ and index of its lobe, where that is no metal.
    """
    dielectric = base if material.is_glossy else (None, 0.0)
    steps = _evenly_from_0_to_1(STEPS)
    if not isinstance(material.roughness, Texture):
        steps = [material.roughness if material.is_glossy else 1.0] * 2
    alphas = [max(step * step, LEAST_ALPHA) for step in steps]
    bases = dielectric, (1.0, 0.0)
    rows = [[through_coat(*coat, alpha, *below) for below in bases] for alpha in alphas]
    return np.array(rows)


@cache
def through_coat(
    index: float, alpha: float, below: float, base_f0: float | None, base_index: float
) -> Floats:
    """Return D(θ) of a coat over a white base, (NODES + 1,).

    It solves D · ∫ f D cos dω = 1 - E for the BSDF f of the base and the coat's albedo E(θ), by the
    symmetric scaling of Sinkhorn and Knopp. The last column is unused.

    Parameters
    ----------
    index, alpha : of the coat
    below, base_f0, base_index : α, reflectance at normal incidence and index (0 for Schlick's
        formula) of the base's lobe, which lies over a white diffuse one; F₀ is None where it has
        no lobe
    """
    passed = np.maximum(1.0 - _whole_albedos(alpha, normal_reflectance(index), index), 1e-9)
    base, through = white_base(below, base_f0, base_index), np.sqrt(passed)
    for _ in range(ROUNDS):
        through = np.sqrt(through * passed / (base @ through))
    return np.append(through, 0.0)


def _whole_albedos(alpha: float, f0: float, index: float) -> Floats:
    """Return what a lobe reflects of light from each node's angle, (NODES,)."""
    single, grazing = lobe_albedos(alpha, index)[:2]
    several = multiple_fresnel(f0, single[-1], mean_rise(index))
    whole = lobe_albedo(single, grazing, f0, several)
    return np.asarray(whole[:-1])


@kept_on_disk
def white_base(alpha: float, f0: float | None, index: float) -> Floats:
    """Return where a white base sends light from each node's angle: rows add up to 1."""
    if f0 is None:
        return evenly(np.ones(NODES))
    single, grazing = lobe_albedos(alpha, index)[:2]
    cosines = np.maximum(np.linspace(0.0, 1.0, NODES) ** 2, SMALLEST_COSINE).tolist()
    once = np.array([_once((alpha, index), f0, cosine) for cosine in cosines])
    once *= ((f0 * (single - grazing) + grazing)[:-1] / once.sum(axis=1))[:, None]
    several = multiple_fresnel(f0, single[-1], mean_rise(index)) * evenly(1.0 - single[:-1])
    diffuse = 0.0 if f0 == 1.0 else evenly(1.0 - _whole_albedos(alpha, f0, index))
    return np.asarray(once + several + diffuse)


def evenly(missing: Floats) -> Floats:
    """Return where light goes that leaves by missing(i) · missing(o), of which so much goes."""
    nodes = np.linspace(0.0, 1.0, NODES)
    spread = missing * nodes**3  # of 2 μ dμ = 4 t³ dt, for μ = t²
    spread[-1] *= 0.5
    return np.asarray(missing[:, None] * (spread / max(spread.sum(), 1e-300)))


def _once(lobe: tuple[float, float], f0: float, cosine: float) -> Floats:
    """Return what a lobe reflects once of light of this cosine, by that of leaving, (NODES,)."""
    alpha, index = lobe
    weight, beside, out = reflections(alpha, alpha, 0.0, cosine, GRID)
    weight = weight * (f0 + (1.0 - f0) * rise(beside, index))
    places = np.sqrt(np.clip(out, 0.0, 1.0)).ravel() * (NODES - 1)
    lower = np.minimum(places.astype(int), NODES - 2)
    share = places - lower
    low = np.bincount(lower, weight.ravel() * (1.0 - share), NODES)
    return np.asarray(low + np.bincount(lower + 1, weight.ravel() * share, NODES)) / weight.size
