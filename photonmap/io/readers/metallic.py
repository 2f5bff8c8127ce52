"""The metallic workflow of glTF, of MTL's PBR statements and of Blender."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.images import Image
from photonmap.scene.material import normal_reflectance
from photonmap.scene.textures import Paint, Texture, Triple, mean_number
from photonmap.spectra.curves import Color, Spectrum
from photonmap.spectra.observer import reflectance_to_rgb

USUAL_INDEX = 1.5
"""Index of refraction of a coat for which none is given"""
USUAL_COAT = normal_reflectance(USUAL_INDEX)
"""What such a coat reflects at normal incidence"""
_WHITE = Image(np.ones((1, 1, 3), np.float32), False)


class Gloss(NamedTuple):
    """A glossy lobe, and the base below it: attributes of `Material`."""

    reflectance: Paint
    glossy: Paint
    roughness: float | Texture


def metallic_fraction(base: NDArray[np.float64], lobe: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the metallic fraction m that gives a surface its base and its lobe.

    A colour a then makes a base of (1 - m) a and a lobe of m a + (1 - m) 0.04; a being unknown, m
    solves a quadratic (glTF's KHR_materials_pbrSpecularGlossiness, conversion to metallic).

    Parameters
    ----------
    base, lobe : diffuse reflectance, and reflectance at normal incidence; means over the bands
    """
    beyond = np.where(lobe > USUAL_COAT * (1.0 + 1e-6), lobe - USUAL_COAT, 0.0)
    half = 0.5 * (base + lobe) - USUAL_COAT
    fraction = (np.sqrt(half * half + USUAL_COAT * beyond) - half) / USUAL_COAT
    return np.where(beyond > 0.0, np.clip(fraction, 0.0, 1.0), 0.0)


def lie_alike(one: object, other: object) -> bool:
    """Return whether two textures lie alike on a surface; what is no texture lies as any does."""
    if not (isinstance(one, Texture) and isinstance(other, Texture)):
        return True
    return (one.scale, one.offset, one.clamp) == (other.scale, other.offset, other.clamp)


def metallic_gloss(
    base: Paint, metallic: float | Texture, coat: float, roughness: float | Texture
) -> Gloss:
    """Return a surface that is a metal in part, and for the rest a diffuse base below a coat.

    Parameters
    ----------
    base : colour of the metal, and of the base
    metallic : fraction that is metal; of a texture that lies otherwise than that of the base, the
        mean
    coat : reflectance of the coat at normal incidence
    roughness : of both
    """
    if isinstance(metallic, Texture) and (is_even(metallic) or not lie_alike(base, metallic)):
        metallic = mean_number(metallic)
    if isinstance(metallic, Texture):
        whole = base if isinstance(base, Texture) else _even(as_triple(base), metallic)
        return Gloss(*_part(whole, metallic, coat), roughness)
    if metallic == 0.0:
        return Gloss(base, coat, roughness)
    if not isinstance(base, Texture):
        glossy = _blend(base, metallic, (1.0 - metallic) * coat)
        return Gloss(_blend(base, 1.0 - metallic, 0.0), glossy, roughness)
    if metallic == 1.0:
        return Gloss(0.0, base, roughness)
    red, green, blue = ((1.0 - metallic) * part for part in base.factor)
    metal = _part(base, _even((metallic,) * 3, base), coat)[1]
    return Gloss(replace(base, factor=(red, green, blue)), metal, roughness)


def stretched(along: float, across: float) -> dict[str, float]:
    """Return roughness and anisotropy of a lobe of these α, within [0, 1], where u and v rise."""
    low, high = sorted((along, across))
    strength = ((high - low) / max(1.0 - low, 1e-30)) ** 0.5
    look = {"roughness": low**0.5, "anisotropy": strength}
    return look | {"anisotropy_rotation": 0.25} if along < across else look


def is_even(texture: Texture) -> bool:
    """Return whether a texture has the same value all over."""
    return not np.ptp(texture.image.texels, axis=(0, 1)).any()


def as_triple(color: Color) -> Triple:
    """Return the linear sRGB of a colour."""
    if isinstance(color, Spectrum):
        red, green, blue = np.clip(reflectance_to_rgb(color), 0.0, 1.0).tolist()
        return red, green, blue
    return color if isinstance(color, tuple) else (color,) * 3


def _even(color: Triple, like: Texture) -> Texture:
    """Return a texture of one colour, which lies like another."""
    return replace(like, image=_WHITE, factor=color)


def _part(base: Texture, metallic: Texture, coat: float) -> tuple[Texture, Texture]:
    """Return diffuse reflectance and reflectance at normal incidence of textures that lie alike.

    Of two images of different sizes, the texels are those of the larger one.
    """
    shape = np.maximum(base.image.texels.shape[:2], metallic.image.texels.shape[:2]).tolist()
    color = np.minimum(resized(base, shape), np.float32(1.0))
    share = np.minimum(resized(metallic, shape) @ np.array(LUMINANCE, np.float32), 1.0)[..., None]
    rest = np.float32(1.0) - share
    glossy = Texture.of(share * color + rest * np.float32(coat)).image
    plain = replace(base, factor=(1.0, 1.0, 1.0))
    return replace(plain, image=Texture.of(rest * color).image), replace(plain, image=glossy)


def resized(texture: Texture, shape: list[int]) -> NDArray[np.float32]:
    """Return linear RGB at the centres of as many texels as a shape says, (H, W, 3)."""
    values = texture.image.linear(slice(None), slice(None))
    for axis, count in enumerate(shape):
        size = values.shape[axis]
        if size == count:
            continue
        place = (np.arange(count) + 0.5) * size / count - 0.5
        low = np.floor(place)
        near = np.array((low, low + 1), np.int64)
        near = np.clip(near, 0, size - 1) if texture.clamp else near % size
        weight = (place - low).astype(np.float32).reshape(-1, *(1,) * (2 - axis))
        first, second = (np.take(values, rows, axis) for rows in near)
        values = first + weight * (second - first)
    return np.asarray(values * np.array(texture.factor, np.float32))


def _blend(color: Color, factor: float, more: float) -> Color:
    """Return factor · color + more."""
    if isinstance(color, Spectrum):
        values = factor * color.values + more
        return Spectrum(color.wavelengths, values, color.extrapolate)
    if isinstance(color, tuple):
        red, green, blue = (factor * value + more for value in color)
        return red, green, blue
    return factor * color + more
