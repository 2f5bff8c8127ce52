"""The metallic workflow of glTF, of MTL's PBR statements and of Blender."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from photonmap.scene.textures import Paint, Texture, mean_color
from photonmap.spectra.curves import Color, Spectrum

USUAL_INDEX = 1.5
"""Index of refraction of a coat for which none is given"""


class Gloss(NamedTuple):
    """A glossy lobe, and the base below it: attributes of `Material`."""

    reflectance: Paint
    glossy: Color
    roughness: float


def coat_of(index: float) -> float:
    """Return the reflectance at normal incidence of a coat of this index of refraction."""
    return ((index - 1.0) / (index + 1.0)) ** 2


def metallic_gloss(base: Paint, metallic: float, coat: float, roughness: float) -> Gloss:
    """Return a surface that is a metal in part, and for the rest a diffuse base below a coat.

    Parameters
    ----------
    base : colour of the metal, and of the base; of a texture, the metal has the mean
    metallic : fraction that is metal
    coat : reflectance of the coat at normal incidence
    roughness : of both
    """
    if metallic == 0.0:
        return Gloss(base, coat, roughness)
    glossy = _blend(mean_color(base), metallic, (1.0 - metallic) * coat)
    if not isinstance(base, Texture):
        return Gloss(_blend(base, 1.0 - metallic, 0.0), glossy, roughness)
    if metallic == 1.0:
        return Gloss(0.0, glossy, roughness)
    red, green, blue = ((1.0 - metallic) * part for part in base.factor)
    return Gloss(replace(base, factor=(red, green, blue)), glossy, roughness)


def _blend(color: Color, factor: float, more: float) -> Color:
    """Return factor · color + more."""
    if isinstance(color, Spectrum):
        values = factor * color.values + more
        return Spectrum(color.wavelengths, values, color.extrapolate)
    if isinstance(color, tuple):
        red, green, blue = (factor * value + more for value in color)
        return red, green, blue
    return factor * color + more
