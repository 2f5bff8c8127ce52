"""Materials of glTF files, as the reader of `io.readers.gltf_materials` takes them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.io.writers.gltf_draft import Draft, Json, TextureWriter
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, parameters_of
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import USUAL_COAT, USUAL_INDEX, as_triple, metallic_fraction
from photonmap.scene.surfaces.relief import NormalMap
from photonmap.scene.textures import Texture, is_black, lie_alike, mean_color, mean_number, resized
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Color, Floats

_APART = "textures of gloss that lie otherwise than another one become their mean"
_COATS = "textures of glossy reflectances take the coat of a usual dielectric"
_RGB = Bands.rgb()
_LARGEST_COAT = normal_reflectance(1e3)  # Of the largest index that the reader takes
_METALLIC_ROUGHNESS = "metallicRoughnessTexture"
_EXTENSIONS = {
    "coat": (
        "KHR_materials_clearcoat",
        {
            "coat": ("clearcoatFactor", "clearcoatTexture"),
            "coat_roughness": ("clearcoatRoughnessFactor", "clearcoatRoughnessTexture"),
        },
    ),
    "sheen": (
        "KHR_materials_sheen",
        {
            "sheen": ("sheenColorFactor", "sheenColorTexture"),
            "sheen_roughness": ("sheenRoughnessFactor", "sheenRoughnessTexture"),
        },
    ),
}
"""Of lobes over others: the extension, and its keys by attribute; other lobes are left to TOML"""
_ONE_COLOR = "what is glass in part takes the colour of the rest"


def write_material(material: Material, name: str, draft: Draft, textures: TextureWriter) -> Json:
    """Return the JSON of a material that comes nearest.

    Spectra become linear sRGB, mirrors metals of roughness 0, and rough diffuse surfaces smooth.
    """
    if material.ior is None:
        item = _opaque(material, name, draft, textures)
    else:
        item = _glass(material, name, draft, textures)
    if isinstance(material.relief, NormalMap):
        item["normalTexture"] = _normal_map(material.relief, textures)
    coat = item["extensions"].get("KHR_materials_clearcoat", {})
    if isinstance(material.own_coat_relief, NormalMap):
        coat["clearcoatNormalTexture"] = _normal_map(material.own_coat_relief, textures)
    elif material.own_coat_relief is None and "normalTexture" in item:
        coat["clearcoatNormalTexture"] = item["normalTexture"]
    extensions = item.pop("extensions") | _emission(material, name, draft, textures, item)
    return {"name": name, **item, **({"extensions": extensions} if extensions else {})}


def _normal_map(relief: NormalMap, textures: TextureWriter) -> Json:
    return textures.data(_multiplied(relief.texture)) | {"scale": relief.strength}


def _multiplied(texture: Texture) -> Texture:
    if texture.factor == (1.0, 1.0, 1.0):
        return texture
    texels = texture.image.linear(slice(None), slice(None)) * np.array(texture.factor)
    return replace(texture, image=Texture.of(texels).image, factor=(1.0, 1.0, 1.0))


def _glass(material: Material, name: str, draft: Draft, textures: TextureWriter) -> Json:
    """Return the JSON of glass; where only a part is glass, its colour is that of the rest."""
    assert material.ior is not None
    color = material.tint
    if not material.is_all_glass:
        color = material.reflectance
        if color != material.tint:
            draft.note(_ONE_COLOR, name)
    texture = color if isinstance(color, Texture) else None
    factor = _RGB.reflectance(mean_color(color)).tolist()
    surface, mode = _base_color(texture, factor, material.alpha, name, textures)
    surface["metallicFactor"] = 0.0
    surface |= _scalar(material.roughness, "roughnessFactor", _METALLIC_ROUGHNESS, textures)
    share = _scalar(material.transmission, "transmissionFactor", "transmissionTexture", textures)
    extensions = draft.use("KHR_materials_transmission", share)
    extensions |= draft.use("KHR_materials_ior", {"ior": material.ior})
    if not material.thin:
        extensions |= draft.use("KHR_materials_volume", _volume(material))
        if (abbe := material.nearest_abbe) is not None:
            extensions |= draft.use("KHR_materials_dispersion", {"dispersion": 20.0 / abbe})
    extensions |= _stretch(material, draft, textures)
    return {"pbrMetallicRoughness": surface, "extensions": extensions, **mode}


def _scalar(value: float | Texture, factor: str, use: str, textures: TextureWriter) -> Json:
    """Return a number as a factor, or a texture of numbers beside a factor of 1.

    factor, use : keys of the factor and of the texture
    """
    if not isinstance(value, Texture):
        return {factor: value}
    return {factor: 1.0, use: textures.data(_multiplied(value))}


def _base_color(
    texture: Texture | None,
    factor: list[float],
    alpha: float | Texture,
    name: str,
    textures: TextureWriter,
    rest: float = 1.0,
) -> tuple[Json, dict[str, str]]:
    """Return the JSON of a base colour and its opacity, and the mode in which that is used.

    texture, factor : its texture, or the colour where it has none
    rest : divides the colour of a texture
    """
    surface: Json = {}
    opacity, scale = alpha, (1.0, 1.0, 1.0)
    if isinstance(alpha, Texture):
        surface["baseColorTexture"], scale, opacity = textures.masked(texture, alpha, name)
    elif texture is not None:
        surface["baseColorTexture"], scale = textures.color(texture, name)
    if texture is not None:
        factor = [min(part / rest, 1.0) for part in scale]
    surface["baseColorFactor"] = [*factor, opacity]
    return surface, ({} if alpha == 1.0 else {"alphaMode": "BLEND"})


def _volume(material: Material) -> Json:
    volume: Json = {"thicknessFactor": 1.0}
    if material.attenuation_distance is not None:
        volume["attenuationColor"] = _RGB.reflectance(material.attenuation_color).tolist()
        volume["attenuationDistance"] = material.attenuation_distance
    return volume


def _opaque(material: Material, name: str, draft: Draft, textures: TextureWriter) -> Json:
    textured = split_lobe(material, name, draft)
    gloss, roughness = _lobe(material)
    base = _RGB.reflectance(mean_color(material.reflectance))
    whole, metallic, coat = split_metal(base, gloss)
    if textured is not None:
        roughness = 1.0
        if textured.color is not None:
            whole, metallic, coat = np.ones(3), 1.0, USUAL_COAT
            material = replace(material, reflectance=textured.color)
    surface: Json = {"metallicFactor": metallic, "roughnessFactor": roughness}
    if textured is not None:
        surface[_METALLIC_ROUGHNESS] = textures.data(textured.data)
    is_metal = metallic == 1.0 and textured is None
    item: Json = {
        "pbrMetallicRoughness": surface,
        "doubleSided": is_black(material.emission),  # surfaces emit from their front alone
        "extensions": {} if is_metal else _coat(coat, draft),
    }
    item["extensions"] |= _stretch(material, draft, textures)
    item["extensions"] |= _covers(material, name, draft, textures)
    color = material.reflectance if isinstance(material.reflectance, Texture) else None
    color = color if base.any() or textured is not None else None
    rest = 1.0 if textured and textured.color else 1.0 - metallic
    painted, mode = _base_color(color, whole.tolist(), material.alpha, name, textures, rest)
    surface |= painted
    return item | mode


def _stretch(material: Material, draft: Draft, textures: TextureWriter) -> Json:
    """Return the extension that says how a material differs along the surface, if it does."""
    if not material.is_anisotropic:
        return {}
    stretch: Json = {
        "anisotropyStrength": material.anisotropy,
        "anisotropyRotation": 2.0 * np.pi * material.anisotropy_rotation,
    }
    if material.anisotropy_map is not None:
        stretch["anisotropyTexture"] = textures.data(material.anisotropy_map.texture)
    return draft.use("KHR_materials_anisotropy", stretch)


def _covers(material: Material, name: str, draft: Draft, textures: TextureWriter) -> Json:
    """Return the extensions of the lobes that a material has over others, as glTF knows them."""
    found: Json = {}
    for lobe, (extension, keys) in _EXTENSIONS.items():
        content: Json = {}
        for attribute, (factor, use) in keys.items() if material.has(lobe) else ():
            value = getattr(material, attribute)
            if not isinstance(parameters_of(Material)[attribute], Colored):
                content |= _scalar(value, factor, use, textures)
            elif isinstance(value, Texture):
                content[use], scale = textures.color(value, f"{name} {attribute}")
                content[factor] = list(scale)
            else:
                content[factor] = _RGB.reflectance(value).tolist()
        found |= draft.use(extension, content) if content else {}
    return found


def _lobe(material: Material) -> tuple[Floats, float]:
    """Return what reflects besides the diffuse base, (3,), and its roughness; 1 where none does."""
    if material.is_glossy:
        return _RGB.reflectance(mean_color(material.glossy)), mean_number(material.roughness)
    mirror = _RGB.reflectance(material.mirror)
    return mirror, 0.0 if mirror.any() else 1.0


def split_metal(base: Floats, gloss: Floats) -> tuple[Floats, float, float]:
    """Return colour, metallic fraction and coat of which the reader makes a base and a gloss.

    With a colour c, a metallic fraction m and a coat k, the base is (1 - m) c and the gloss
    m c + (1 - m) k, which is linear in the base: of the slope m / (1 - m). What is not so gets a
    grey coat.

    base, gloss : (3,) diffuse reflectance, and reflectance at normal incidence
    """
    if not base.any() and gloss.any():
        return gloss, 1.0, 0.0
    most, least = int(base.argmax()), int(base.argmin())
    spread = base[most] - base[least]
    slope = float((gloss[most] - gloss[least]) / spread) if spread > 0.0 else 0.0
    level = float(gloss[least] - slope * base[least])
    whole, coat = (1.0 + slope) * base, (1.0 + slope) * level
    is_linear = np.allclose(slope * base + level, gloss, rtol=1e-9, atol=1e-12)
    if is_linear and slope >= 0.0 and whole.max() <= 1.0 + 1e-12 and -1e-12 <= coat <= 1.0:
        return np.minimum(whole, 1.0), slope / (1.0 + slope), max(coat, 0.0)
    return base, 0.0, float(gloss @ np.array(LUMINANCE))


def _coat(coat: float, draft: Draft) -> Json:
    """Return the extensions by which a coat reflects so much at normal incidence."""
    if coat == 0.0:
        return draft.use("KHR_materials_specular", {"specularFactor": 0.0})
    if coat > _LARGEST_COAT:
        return draft.use("KHR_materials_ior", {"ior": 0.0}) | draft.use(
            "KHR_materials_specular", {"specularFactor": coat}
        )
    if math.isclose(coat, normal_reflectance(USUAL_INDEX), rel_tol=1e-12):
        return {}
    root = math.sqrt(coat)
    return draft.use("KHR_materials_ior", {"ior": (1.0 + root) / (1.0 - root)})


def _emission(
    material: Material, name: str, draft: Draft, textures: TextureWriter, item: Json
) -> Json:
    """Add the emission to the JSON of a material; return its extensions."""
    emission = material.emission
    if isinstance(emission, Texture):
        item["emissiveTexture"], factor = textures.color(emission, name, math.inf)
    else:
        factor = rgb_emission(emission)
    if not any(factor):
        return {}
    item["emissiveFactor"], strength = split_exactly(factor)
    if strength == 1.0:
        return {}
    return draft.use("KHR_materials_emissive_strength", {"emissiveStrength": strength})


def rgb_emission(color: Color) -> tuple[float, float, float]:
    """Return the linear sRGB of an amount of light."""
    red, green, blue = _RGB.emission(color).tolist()
    return red, green, blue


def split_exactly(color: tuple[float, float, float]) -> tuple[list[float], float]:
    """Return three factors within [0, 1] and a power of two, whose products are the colour."""
    mantissa, exponent = math.frexp(max(color))
    strength = 2.0 ** max(exponent - (mantissa == 0.5), 0)
    return [part / strength for part in color], strength


class Lobe(NamedTuple):
    """A glossy lobe as glTF has it."""

    color: Texture | None  # base colour, where a texture gives the reflectance of the lobe
    data: Texture  # what the texture of the metallic part and of roughness holds, in blue and green


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
