"""What MTL's statements about gloss stand for."""

from __future__ import annotations

import math

import numpy as np

from photonmap.io.readers.metallic import USUAL_INDEX, Gloss, coat_of, metallic_gloss
from photonmap.io.readers.wavefront.draft import Draft, matters
from photonmap.scene.parameters import Number
from photonmap.scene.textures import Paint, Texture
from photonmap.spectra.curves import Spectrum

NUMBERS = {
    "Ns": Number("exponent", at_least=0.0),
    "Pr": Number("roughness", at_least=0.0, at_most=1.0),
    "Pm": Number("metallic fraction", at_least=0.0, at_most=1.0),
}
"""What statements of these keywords hold."""
BLENDER_RANGE = 0.08
"""Reflectance at normal incidence at which Blender's specular is 1."""


def gloss_of(draft: Draft, albedo: Paint) -> Gloss | None:
    """Return the glossy lobe that a draft describes, over a base of this albedo; None if none.

    - With `Pr`, the metallic workflow: `Pm` of the surface is a metal of this colour, and the rest
      has a coat of index `Ni`.
    - From Blender's exporter, likewise: `Ks` is its specular, `Ns` stands for its roughness, and
      under `illum 3` `Ka` for its metallic.
    - Else, under `illum 2`, or none, with `Ks` and `Ns`: a coat that reflects `Ks` at normal
      incidence, whose lobe is about as wide as Phong's of this exponent: α² = 2 / (Ns + 2), as in
      Walter et al. 2007, "Microfacet models for refraction through rough surfaces".

    Statements about gloss that have no effect are noted as ignored.
    """
    numbers, model = draft.numbers, draft.numbers.get("illum", 2.0)
    if "Pr" in numbers:
        index = numbers.get("Ni", 1.0)  # 1 is what exporters write that know of no index
        coat = coat_of(index if index > 1.0 else USUAL_INDEX)
        return _metallic(draft, albedo, numbers.get("Pm", 0.0), coat, numbers["Pr"])
    if numbers.get("Pm", 0.0) != 0.0:
        draft.ignored.append("Pm")
    if draft.blender and model >= 2.0 and "Ns" in numbers:
        roughness = 1.0 - math.sqrt(min(numbers["Ns"] / draft.blender, 1.0))
        metallic = numbers.get("Ka", 0.0) if model == 3.0 else 0.0
        specular = draft.colors.get("Ks", 0.0)
        mean = float(np.mean(specular)) if not isinstance(specular, Spectrum) else 0.5
        return _metallic(draft, albedo, metallic, BLENDER_RANGE * mean, roughness)
    glossy = draft.colors.get("Ks")
    if model == 2.0 and glossy is not None and "Ns" in numbers:
        alpha = math.sqrt(2.0 / (numbers["Ns"] + 2.0))
        return Gloss(albedo, glossy, math.sqrt(alpha)) if matters(glossy) else None
    if "Ns" in numbers and matters(draft.colors.get("Ks", 1.0)):
        draft.ignored.append("Ns")
    return None


def _metallic(
    draft: Draft, albedo: Paint, metallic: float, coat: float, roughness: float
) -> Gloss | None:
    """Return a surface that is a metal in part; None if it reflects diffusely alone."""
    draft.averaged = isinstance(albedo, Texture) and metallic > 0.0
    gloss = metallic_gloss(albedo, metallic, coat, roughness)
    return gloss if matters(gloss.glossy) else None
