"""What MTL's statements about gloss stand for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from photonmap.io.readers.wavefront.draft import Draft, matters
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.parameters import Number
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import (
    USUAL_INDEX,
    Gloss,
    as_triple,
    metallic_gloss,
)
from photonmap.scene.textures import Paint, Texture, is_black, lie_alike
from photonmap.spectra.curves import Spectrum

NUMBERS = {
    "Ns": Number("exponent", at_least=0.0),
    "Pr": Number("roughness", at_least=0.0, at_most=1.0),
    "Pm": Number("metallic fraction", at_least=0.0, at_most=1.0),
}
"""What statements of these keywords hold."""
USUAL_ROUGHNESS = 0.5
"""Of a metal that gives none: Blender's default."""
BLENDER_RANGE = 0.08
"""Reflectance at normal incidence at which Blender's specular is 1."""


def has_exponent(draft: Draft) -> bool:
    """Return whether a draft has a lobe of colour `Ks` and of the exponent `Ns`."""
    numbers = draft.numbers
    is_metallic = "Pr" in numbers or draft.blender > 0.0
    return numbers.get("illum", 2.0) == 2.0 and "Ns" in numbers and not is_metallic


def gloss_of(draft: Draft, albedo: Paint) -> Gloss | None:
    """Return the glossy lobe that a draft describes, over a base of this albedo; None if none.

    - With `Pr` or `Pm`, the metallic workflow: `Pm` of the surface is a metal of this colour, and
      the rest has a coat of index `Ni`.
    - From Blender's exporter, likewise: `Ks` is its specular, `Ns` stands for its roughness, and
      under `illum 3` and 6 `Ka` for its metallic.
    - Else, under `illum 2`, or none, with `Ks` and `Ns`, and their maps: a coat that reflects `Ks`
      at normal incidence, whose lobe is about as wide as Phong's of this exponent:
      α² = 2 / (Ns + 2), as in Walter et al. 2007, "Microfacet models for refraction through rough
      surfaces".

    Statements about gloss that have no effect are noted as ignored.
    """
    numbers, model = draft.numbers, draft.numbers.get("illum", 2.0)
    if draft.is_metallic:
        index = numbers.get("Ni", 1.0)  # 1 is what exporters write that know of no index
        if index < 1.0:
            draft.ignored.append("Ni")
        coat = normal_reflectance(index if index > 1.0 else USUAL_INDEX)
        metallic = draft.number("Pm") if "Pm" in numbers else 0.0
        return _metallic(draft, albedo, metallic, coat, _roughness(draft))
    if draft.blender and model >= 2.0 and "Ns" in numbers:
        roughness = 1.0 - math.sqrt(min(numbers["Ns"] / draft.blender, 1.0))
        metallic = numbers.get("Ka", 0.0) if model in (3.0, 6.0) else 0.0
        specular = draft.colors.get("Ks", 0.0)
        mean = float(np.mean(specular)) if not isinstance(specular, Spectrum) else 0.5
        return _metallic(draft, albedo, metallic, BLENDER_RANGE * mean, roughness)
    if has_exponent(draft):
        glossy = _textured(draft)
        if glossy is not None:
            return Gloss(albedo, glossy, _from_exponent(draft))
        if "Ks" in draft.colors:
            return None
    if "Ns" in numbers and matters(draft.colors.get("Ks", 1.0)):
        draft.ignored.append("Ns")
    return None


def _metallic(
    draft: Draft, albedo: Paint, metallic: float | Texture, coat: float, roughness: float | Texture
) -> Gloss | None:
    """Return a surface that is a metal in part; None if it reflects diffusely alone."""
    if not lie_alike(albedo, metallic):
        draft.averaged.append("map_Pm")
    gloss = metallic_gloss(albedo, metallic, coat, roughness)
    return None if is_black(gloss.glossy) else gloss


def _textured(draft: Draft) -> Paint | None:
    """Return `Ks` times its map; None where it is 0 or there is neither."""
    color, texture = draft.colors.get("Ks"), draft.maps.get("map_Ks")
    if texture is None:
        return color if color is not None and matters(color) else None
    factor = as_triple(1.0 if color is None else color)
    return replace(texture, factor=factor) if any(factor) else None


def _roughness(draft: Draft) -> float | Texture:
    """Return that of the metallic workflow."""
    if "Pr" in draft.numbers:
        return draft.number("Pr")
    return _from_exponent(draft) if "Ns" in draft.numbers else USUAL_ROUGHNESS


def _from_exponent(draft: Draft) -> float | Texture:
    """Return the roughness of a lobe as wide as Phong's of the exponent `Ns` times its map."""
    exponent, texture = draft.numbers["Ns"], draft.data.get("Ns")
    if texture is None:
        return (2.0 / (exponent + 2.0)) ** 0.25
    share = texture.image.linear(slice(None), slice(None)) @ np.array(LUMINANCE)
    roughness = (2.0 / (exponent * share + 2.0)) ** 0.25
    return replace(texture, image=Texture.of(roughness).image)
