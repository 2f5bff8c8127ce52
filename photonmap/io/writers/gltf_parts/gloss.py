"""Textures of glossy lobes as glTF has them: of base colour, metallic part and roughness."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.io.writers.gltf_parts.draft import Draft
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.material import Material
from photonmap.scene.surfaces.metallic import USUAL_COAT, as_triple, metallic_fraction
from photonmap.scene.textures import Texture, lie_alike, mean_color, mean_number, resized

_APART = "textures of gloss that lie otherwise than another one become their mean"
_COATS = "textures of glossy reflectances take the coat of a usual dielectric"


class Lobe(NamedTuple):
    """A glossy lobe as glTF has it.

    Parameters
    ----------
    color : its base colour where a texture gives the lobe's reflectance; None elsewhere
    data : what the texture of the metallic part and of roughness holds, in blue and green
    """

    color: Texture | None
    data: Texture


def split_lobe(material: Material, name: str, draft: Draft) -> Lobe | None:
    """Return what textures of a glossy lobe become; None where it has none.

    The metallic part of each texel is that of a surface whose coat reflects `USUAL_COAT`.
    """
    material = _aligned(material, name, draft)
    if not material.has_textured_lobe:
        return None
    paints = material.reflectance, material.glossy, material.roughness
    found = [paint for paint in paints if isinstance(paint, Texture)]
    shape = np.max([texture.image.texels.shape[:2] for texture in found], axis=0).tolist()
    lying = replace(found[-1], factor=(1.0, 1.0, 1.0))
    data = np.ones((*shape, 3), np.float32)
    data[..., 1] = _texels(material.roughness, shape) @ np.array(LUMINANCE, np.float32)
    if not isinstance(material.glossy, Texture):
        return Lobe(None, replace(lying, image=Texture.of(data).image))
    draft.note(_COATS, name)
    base, glossy = _texels(material.reflectance, shape), _texels(material.glossy, shape)
    data[..., 2] = metallic_fraction(base.mean(axis=2), glossy.mean(axis=2))
    color = base + glossy - (1.0 - data[..., 2:]) * np.float32(USUAL_COAT)
    image = Texture.of(np.clip(color, 0.0, 1.0)).image
    return Lobe(replace(lying, image=image), replace(lying, image=Texture.of(data).image))


def _texels(paint: object, shape: list[int]) -> NDArray[np.float32]:
    """Return a texture, a colour or a number as linear RGB, (H, W, 3)."""
    if isinstance(paint, Texture):
        return np.broadcast_to(resized(paint, shape), (*shape, 3))
    color = np.array(as_triple(paint), np.float32)  # type: ignore[arg-type]
    return np.broadcast_to(color, (*shape, 3))


def _aligned(material: Material, name: str, draft: Draft) -> Material:
    """Return a material whose textures of the lobe lie like its base; others become their mean."""
    first = next(
        (
            paint
            for paint in (material.reflectance, material.glossy, material.roughness)
            if isinstance(paint, Texture)
        ),
        None,
    )
    if not lie_alike(first, material.glossy):
        draft.note(_APART, name)
        material = replace(material, glossy=mean_color(material.glossy))
    if not lie_alike(first, material.roughness):
        draft.note(_APART, name)
        material = replace(material, roughness=mean_number(material.roughness))
    return material
