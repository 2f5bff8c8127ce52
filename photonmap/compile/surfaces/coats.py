"""Clear coats, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from photonmap.compile.surfaces.glossy import STEPS as COATS
from photonmap.compile.surfaces.glossy import append_stepped, lobe_albedos
from photonmap.compile.surfaces.relief import Reliefs
from photonmap.compile.surfaces.white_bases import WHITE_BASES, through, whole_albedos
from photonmap.kernels.bsdf.models import COATED
from photonmap.kernels.core import records
from photonmap.scene.material import LEAST_ALPHA, Material
from photonmap.scene.surfaces.fresnel import mean_rise, normal_reflectance
from photonmap.scene.textures import Texture, mean_number
from photonmap.spectra.curves import Floats

STEPS = 9  # Values of the roughness of a base for which D is tabulated, evenly from 0 to 1


def with_coats(
    scattering: records.Scattering | None, materials: Sequence[Material], reliefs: Reliefs
) -> records.Scattering | None:
    """Return BSDFs of M materials below clear coats, where any material has one."""
    chosen = [index for index, material in enumerate(materials) if material.is_coated]
    if scattering is None or not chosen:
        return scattering
    numbers = _numbers(scattering, materials, chosen)
    row, first, steps = np.full((3, len(materials)), -1, np.int32)
    model, albedos = scattering.model.copy(), [scattering.albedos]
    passing: list[Floats] = []
    for place, index in enumerate(chosen):
        _, alpha, refraction, dielectric = numbers[:, index].tolist()
        row[index] = len(scattering.albedos) + place
        first[index] = sum(len(rows) for rows in passing)
        albedos.append(lobe_albedos(alpha, refraction)[None])
        is_image = isinstance(materials[index].coat_roughness, Texture)
        steps_of_image = np.linspace(0.0, 1.0, COATS).tolist() if is_image else []
        alphas = [alpha, *(max(step * step, LEAST_ALPHA) for step in steps_of_image)]
        base = dielectric, float(scattering.parameters[index, 3])
        rows = [_through((refraction, each), materials[index], base) for each in alphas]
        passing += rows
        steps[index] = len(rows[0])
    varies = np.array([material.has_textured_coat for material in materials])
    weight, alpha, refraction, dielectric = numbers
    whole, stepped = append_stepped(np.concatenate(albedos), refraction, varies)
    coats = records.Coats(
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
        np.concatenate(passing),
        scattering.maps if varies.any() else None,
        np.array([material.own_coat_relief is not None for material in materials], np.uint8),
        reliefs.of_coats(materials),
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
        f0, base = scattering.parameters[index, 1:3].tolist()
        varies = isinstance(material.glossy, Texture) or base == 0.0
        numbers[:, index] = (
            mean_number(material.coat),
            max(mean_number(material.coat_roughness) ** 2, LEAST_ALPHA),
            material.coat_ior,
            normal_reflectance(1.5) if varies else f0,
        )
    return numbers


def _through(coat: tuple[float, float], material: Material, base: tuple[float, float]) -> Floats:
    """Return rows of `Coats.through` for one material.

    The coat is its index and α; the base F₀ and index of its lobe, where that is no metal.
    """
    steps = np.linspace(0.0, 1.0, STEPS).tolist()
    if not isinstance(material.roughness, Texture):
        steps = [material.roughness if material.is_glossy else 1.0] * 2
    rows = []
    for alpha in (max(step * step, LEAST_ALPHA) for step in steps):
        metal = through_coat(*coat, "glossy", alpha, 1.0, 0.0)
        below = ("glossy", alpha, *base) if material.is_glossy else ("Lambertian",)
        rows.append([through_coat(*coat, *below), metal])
    return np.array(rows)


@cache
def through_coat(index: float, alpha: float, base: str, *numbers: float) -> Floats:
    """Return D(θ) of a coat, by index and α, over a white base, see `white_bases.through`.

    The base is a model, and the numbers that `WHITE_BASES` has of it.
    """
    passed = np.maximum(1.0 - whole_albedos(alpha, normal_reflectance(index), index), 1e-9)
    return through(passed, WHITE_BASES[base](*numbers))
