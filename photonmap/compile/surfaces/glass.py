"""Glass that varies over its surface, and surfaces that are glass in part, as kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from photonmap.compile.textures import TextureTable
from photonmap.errors import InputError
from photonmap.kernels.core import records
from photonmap.scene.images import Image
from photonmap.scene.material import LEAST_ALPHA, Material
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture, lie_alike, mean_number, resized
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.observer import reflectance_to_rgb

STRIP = 256  # Rows of an image that are looked at together


def opaque_part(material: Material) -> Material:
    """Return a material whose reflectance is that of the part that is no glass, times how much.

    Where the transmission is a number, `compile_materials` multiplies by it. Textures of both that
    lie differently are an `InputError`.
    """
    share, base = material.transmission, material.reflectance
    if material.ior is None or not isinstance(share, Texture):
        return material
    if isinstance(base, SpectralTexture) or not lie_alike(base, share):
        raise InputError(
            f"material {material.name!r}: textures of transmission and reflectance must both be "
            "Textures of one scale, offset and clamp; give one of them as a number"
        )
    shape = share.image.texels.shape[:2]
    if isinstance(base, Texture):
        shape = tuple(np.maximum(shape, base.image.texels.shape[:2]).tolist())
    rest = np.float32(1.0) - np.minimum(resized(share, shape)[..., :1], np.float32(1.0))
    if isinstance(base, Texture):
        color = resized(base, shape)
    else:
        rgb = reflectance_to_rgb(base) if isinstance(base, Spectrum) else base
        color = np.clip(np.asarray(rgb, np.float32), 0.0, 1.0)
    texels = np.broadcast_to(rest * color, (*shape, 3))
    image = Image(np.ascontiguousarray(texels, np.float32), False)
    return replace(material, reflectance=replace(share, image=image, factor=(1.0, 1.0, 1.0)))


def clear_textures(materials: Sequence[Material], bands: Bands) -> dict[int, Texture]:
    """Return what panes of textured tint let pass in every band: the least of the tint's bands."""
    return {
        index: _least(material.tint, bands)
        for index, material in enumerate(materials)
        if material.is_pane and material.is_all_glass and isinstance(material.tint, Texture)
    }


def _least(tint: Texture, bands: Bands) -> Texture:
    """Return the least over bands of each texel, a texture of one channel."""
    rows = tint.image.texels.shape[0]
    parts = []
    for start in range(0, rows, STRIP):
        rgb = tint.image.linear(slice(start, start + STRIP), slice(None)) * np.ones(3, np.float32)
        rgb = np.minimum(rgb * np.array(tint.factor, np.float32), np.float32(1.0))
        parts.append((rgb @ bands.reflectance_basis).min(axis=2, keepdims=True))
    texels = np.clip(np.concatenate(parts), 0.0, 1.0)
    image = Image(np.ascontiguousarray(texels, np.float32), False)
    return replace(tint, image=image, factor=(1.0, 1.0, 1.0))


def with_glass(
    specular: records.Specular | None,
    materials: Sequence[Material],
    table: TextureTable,
    bands: Bands,
) -> records.Specular | None:
    """Return specular lobes with what varies over glass, and which part of a surface it is."""
    if specular is None:
        return None
    is_glass = np.array([material.ior is not None for material in materials])
    none = np.int32(-1)
    images = (
        table.rows["tint"],
        np.where(is_glass, table.rows["roughness"], none),
        np.where(is_glass, table.rows["anisotropy_map"], none),
    )
    maps = None
    if np.greater_equal(images, 0).any():
        basis = bands.reflectance_basis.astype(np.float32, order="C")
        maps = records.GlassMaps(table.maps, *images, basis, LEAST_ALPHA)
    fraction = None
    if not all(material.is_all_glass for material in materials if material.ior is not None):
        parts = np.array([mean_number(material.transmission) for material in materials])
        rows = table.rows["transmission"]
        fraction = records.GlassFraction(
            np.where(is_glass, parts, 1.0), rows, table.maps if (rows >= 0).any() else None
        )
    return specular._replace(maps=maps, glass=fraction)


def beside_glass(
    scattering: records.Scattering | None,
    materials: Sequence[Material],
    specular: records.Specular | None,
) -> records.Scattering | None:
    """Return BSDFs that know which fraction of each material is glass, 0 of what is none."""
    fraction = None if specular is None else specular.glass
    if scattering is None or fraction is None:
        return scattering
    is_glass = np.array([material.ior is not None for material in materials])
    return scattering._replace(
        glass=fraction._replace(value=np.where(is_glass, fraction.value, 0.0))
    )
