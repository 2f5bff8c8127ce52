"""The metallic workflow of glTF, of MTL's PBR statements and of Blender."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from photonmap.errors import InputError
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.images import Image
from photonmap.scene.parameters import Number
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import (
    Paint,
    Texture,
    Triple,
    lie_alike,
    mean_color,
    mean_number,
    resized,
)
from photonmap.spectra.curves import Color, Floats, Spectrum
from photonmap.spectra.observer import reflectance_to_rgb

USUAL_INDEX = 1.5  # Index of refraction of a coat for which none is given
USUAL_COAT = normal_reflectance(USUAL_INDEX)  # What such a coat reflects at normal incidence
FRACTION = Number("metallic fraction", textured=True, at_least=0.0, at_most=1.0)
"""Which part of a surface is metal"""
_WHITE = Image(np.ones((1, 1, 3), np.float32), False)


class Gloss(NamedTuple):
    """A glossy lobe, and the base below it: attributes of `Material`."""

    reflectance: Paint
    glossy: Paint
    roughness: float | Texture
    covering: float | None = None


def metallic_fraction(base: Floats, lobe: Floats, coat: Floats | float = USUAL_COAT) -> Floats:
    """Return the metallic fraction m that gives a surface its base and its lobe, in band means.

    A colour a then makes a base of (1 - m) a and a lobe of m a + (1 - m) coat; a being unknown, m
    solves a quadratic (glTF's KHR_materials_pbrSpecularGlossiness, conversion to metallic).
    """
    excess = np.where(lobe > coat * (1.0 + 1e-6), lobe - coat, 0.0)
    half = 0.5 * (base + lobe) - coat
    whole = np.sqrt(half * half + coat * excess) + half
    fraction = np.divide(excess, whole, out=np.zeros_like(excess), where=excess > 0.0)
    return np.minimum(fraction, 1.0)


def metallic_gloss(
    base: Paint, metallic: float | Texture, coat: Paint, roughness: float | Texture
) -> Gloss:
    """Return a surface that is a metal in part, and for the rest a diffuse base below a coat.

    The base is the colour of both. Of a texture of the fraction that lies otherwise than that of
    the base, the mean counts; one of the coat's reflectance at normal incidence lies like that of
    the base. A base with a spectrum in every texel is an `InputError`.
    """
    if isinstance(base, SpectralTexture):
        raise InputError("a reflectance of many spectra has none; give glossy in place of it")
    if isinstance(metallic, Texture) and (is_even(metallic) or not lie_alike(base, metallic)):
        metallic = mean_number(metallic)
    if metallic == 0.0:
        return Gloss(base, coat, roughness)
    covering = None if metallic == 1.0 else float(np.mean(as_triple(mean_color(coat))))
    like = next((each for each in (base, metallic, coat) if isinstance(each, Texture)), None)
    if like is None or isinstance(like, float):
        return Gloss(*_even_gloss(base, metallic, coat), roughness, covering)  # type: ignore[arg-type]
    if metallic == 1.0:
        return Gloss(0.0, base, roughness)
    whole, share, cover = (_as_texture(each, like) for each in (base, metallic, coat))
    if isinstance(metallic, Texture):
        return Gloss(*_part(whole, share, cover), roughness, covering)
    metal = _part(whole, share, cover)[1]
    if not isinstance(base, Texture):
        return Gloss(_blend(base, 1.0 - metallic, 0.0), metal, roughness, covering)
    red, green, blue = ((1.0 - metallic) * part for part in base.factor)
    return Gloss(replace(base, factor=(red, green, blue)), metal, roughness, covering)


def _even_gloss(base: Color, metallic: float, coat: Color) -> tuple[Color, Color]:
    """Return reflectance and reflectance at normal incidence of what is the same all over."""
    if isinstance(coat, float):
        glossy = _blend(base, metallic, (1.0 - metallic) * coat)
    else:
        pairs = zip(as_triple(base), as_triple(coat), strict=True)
        red, green, blue = (metallic * a + (1.0 - metallic) * b for a, b in pairs)
        glossy = red, green, blue
    return _blend(base, 1.0 - metallic, 0.0), glossy


def is_even(texture: Texture) -> bool:
    """Return whether a texture has the same value all over."""
    return not np.ptp(texture.image.texels, axis=(0, 1)).any()


def multiplied(textures: Sequence[Texture], factor: Triple) -> Texture:
    """Return the product of textures that lie alike, times a factor, 1 at most."""
    shape = np.max([each.image.texels.shape[:2] for each in textures], axis=0).tolist()
    texels = np.array(factor, np.float32)
    for each in textures:
        texels = texels * resized(each, shape)
    image = Texture.of(np.minimum(texels, np.float32(1.0))).image
    return replace(textures[0], image=image, factor=(1.0, 1.0, 1.0))


def as_triple(color: Color) -> Triple:
    """Return the linear sRGB of a colour."""
    if isinstance(color, Spectrum):
        red, green, blue = np.clip(reflectance_to_rgb(color), 0.0, 1.0).tolist()
        return red, green, blue
    return color if isinstance(color, tuple) else (color,) * 3


def _as_texture(paint: Paint, like: Texture) -> Texture:
    """Return a texture, of one colour where the paint is one, which lies like another."""
    if isinstance(paint, Texture):
        return paint
    return replace(like, image=_WHITE, factor=as_triple(paint))


def _part(base: Texture, metallic: Texture, coat: Texture) -> tuple[Texture, Texture]:
    """Return diffuse and glossy reflectance of textures that lie alike, as fine as the finest."""
    sizes = [each.image.texels.shape[:2] for each in (base, metallic, coat)]
    shape = np.max(sizes, axis=0).tolist()
    color = np.minimum(resized(base, shape), np.float32(1.0))
    share = np.minimum(resized(metallic, shape) @ np.array(LUMINANCE, np.float32), 1.0)[..., None]
    rest = np.float32(1.0) - share
    glossy = Texture.of(share * color + rest * np.minimum(resized(coat, shape), 1.0)).image
    plain = replace(base, factor=(1.0, 1.0, 1.0))
    return replace(plain, image=Texture.of(rest * color).image), replace(plain, image=glossy)


def _blend(color: Color, factor: float, more: float) -> Color:
    """Return factor · color + more."""
    if isinstance(color, Spectrum):
        values = factor * color.values + more
        return Spectrum(color.wavelengths, values, color.extrapolate)
    if isinstance(color, tuple):
        red, green, blue = (factor * value + more for value in color)
        return red, green, blue
    return factor * color + more
