"""Clear coats, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from photonmap.compile.surfaces.glossy import (
    GRID,
    NODES,
    SMALLEST_COSINE,
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
from photonmap.scene.material import LEAST_ALPHA, Material, normal_reflectance
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
        _, f0, alpha, dielectric = numbers[:, index].tolist()
        row[index] = len(scattering.albedos) + place
        first[index] = sum(len(rows) for rows in through)
        albedos.append(lobe_albedos(alpha)[None])
        alphas = [alpha, *_stepped_alphas(materials[index].coat_roughness)]
        rows = [_through((f0, each), materials[index], dielectric) for each in alphas]
        through += rows
        steps[index] = len(rows[0])
    varies = any(materials[index].has_textured_coat for index in chosen)
    albedos += [albedos[-1]] * varies  # a next row for all
    weight, f0, alpha, dielectric = numbers
    coats = Coats(
        weight,
        f0,
        alpha,
        row,
        dielectric,
        first,
        steps,
        np.concatenate(through),
        scattering.maps if varies else None,
        np.array([material.own_coat_relief is not None for material in materials], np.uint8),
        reliefs and reliefs.of_coats(materials),
    )
    model[chosen] = COATED
    return scattering._replace(model=model, albedos=np.concatenate(albedos), coats=coats)


def _numbers(
    scattering: records.Scattering, materials: Sequence[Material], chosen: Sequence[int]
) -> Floats:
    """Return weight, F₀ and α of the coats of chosen materials, and F₀ of their bases, (4, M)."""
    numbers = np.zeros((4, len(materials)))
    for index in chosen:
        material = materials[index]
        numbers[:, index] = (
            mean_number(material.coat),
            normal_reflectance(material.coat_ior),
            max(mean_number(material.coat_roughness) ** 2, LEAST_ALPHA),
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


def _through(coat: tuple[float, float], material: Material, dielectric: float) -> Floats:
    """Return rows of `Coats.through` for one material."""
    below = dielectric if material.is_glossy else None
    steps = _evenly_from_0_to_1(STEPS)
    if not isinstance(material.roughness, Texture):
        steps = [material.roughness if material.is_glossy else 1.0] * 2
    alphas = [max(step * step, LEAST_ALPHA) for step in steps]
    rows = [[through_coat(*coat, alpha, f0) for f0 in (below, 1.0)] for alpha in alphas]
    return np.array(rows)


@cache
def through_coat(f0: float, alpha: float, below: float, base_f0: float | None) -> Floats:
    """Return D(θ) of a coat over a white base, (NODES + 1,).

    It solves D · ∫ f D cos dω = 1 - E for the BSDF f of the base and the coat's albedo E(θ), by the
    symmetric scaling of Sinkhorn and Knopp. The last column is unused.

    Parameters
    ----------
    f0, alpha : of the coat
    below, base_f0 : α and reflectance at normal incidence of the base's lobe, which lies over a
        white diffuse one; None where it has no lobe
    """
    passed = np.maximum(1.0 - _whole_albedos(alpha, f0), 1e-9)
    base, through = white_base(below, base_f0), np.sqrt(passed)
    for _ in range(ROUNDS):
        through = np.sqrt(through * passed / (base @ through))
    return np.append(through, 0.0)


def _whole_albedos(alpha: float, f0: float) -> Floats:
    """Return what a lobe reflects of light from each node's angle, (NODES,)."""
    single, grazing, _ = lobe_albedos(alpha)
    whole = lobe_albedo(single, grazing, f0, multiple_fresnel(f0, single[-1]))
    return np.asarray(whole[:-1])


@kept_on_disk
def white_base(alpha: float, f0: float | None) -> Floats:
    """Return where a white base sends light from each node's angle: rows add up to 1."""
    if f0 is None:
        return evenly(np.ones(NODES))
    single, grazing, _ = lobe_albedos(alpha)
    cosines = np.maximum(np.linspace(0.0, 1.0, NODES) ** 2, SMALLEST_COSINE).tolist()
    once = np.array([_once(alpha, f0, cosine) for cosine in cosines])
    once *= ((f0 * (single - grazing) + grazing)[:-1] / once.sum(axis=1))[:, None]
    several = multiple_fresnel(f0, single[-1]) * evenly(1.0 - single[:-1])
    diffuse = 0.0 if f0 == 1.0 else evenly(1.0 - _whole_albedos(alpha, f0))
    return np.asarray(once + several + diffuse)


def evenly(missing: Floats) -> Floats:
    """Return where light goes that leaves by missing(i) · missing(o), of which so much goes."""
    nodes = np.linspace(0.0, 1.0, NODES)
    spread = missing * nodes**3  # of 2 μ dμ = 4 t³ dt, for μ = t²
    spread[-1] *= 0.5
    return np.asarray(missing[:, None] * (spread / max(spread.sum(), 1e-300)))


def _once(alpha: float, f0: float, cosine: float) -> Floats:
    """Return what a lobe reflects once of light of this cosine, by that of leaving, (NODES,)."""
    weight, beside, out = reflections(alpha, alpha, 0.0, cosine, GRID)
    weight = weight * (f0 + (1.0 - f0) * (1.0 - np.minimum(beside, 1.0)) ** 5)
    places = np.sqrt(np.clip(out, 0.0, 1.0)).ravel() * (NODES - 1)
    lower = np.minimum(places.astype(int), NODES - 2)
    share = places - lower
    low = np.bincount(lower, weight.ravel() * (1.0 - share), NODES)
    return np.asarray(low + np.bincount(lower + 1, weight.ravel() * share, NODES)) / weight.size
