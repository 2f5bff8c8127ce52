"""A glTF file under construction: JSON, buffer, textures (sRGB in PNG) and materials."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, warn
from photonmap.io.png import encode_png
from photonmap.io.readers.decoding import plain
from photonmap.io.readers.gltf.materials import CLAMP, METALLIC_TEXTURE, NEAREST, REPEAT
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import listed
from photonmap.scene.images import Image
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, parameters_of
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import USUAL_COAT, as_triple, metallic_fraction
from photonmap.scene.surfaces.relief import NormalMap
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import (
    Texture,
    Triple,
    is_black,
    lie_alike,
    mean_color,
    mean_number,
    resized,
)
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Color, Floats
from photonmap.spectra.fluorophores import describe_fluorophores
from photonmap.spectra.rgb_spaces import encode_srgb

Json = dict[str, Any]
_TYPES = {"<f4": 5126, "<u2": 5123, "<u4": 5125}
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_LARGEST = (1 << 32) - 1
_VERTICES, _INDICES = 34962, 34963  # What buffer views are for


@dataclass
class Draft:
    """What has been written so far."""

    tree: Json = field(default_factory=dict)  # the JSON
    blocks: list[bytes] = field(default_factory=list)  # of the buffer, each a multiple of 4 bytes
    rounded: dict[str, list[str]] = field(default_factory=dict)  # what is changed, and whose
    _size: int = 0

    def add(self, kind: str, item: Json) -> int:
        """Append an item to a top-level array; return its index."""
        items = self.tree.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def use(self, extension: str, content: Json) -> Json:
        """Return the JSON of an extension, which is listed as used."""
        used = self.tree.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)
        return {extension: content}

    def add_view(self, data: bytes, **more: int) -> int:
        """Append bytes to the buffer; return the index of their view, which may say more."""
        view = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data), **more}
        self.blocks.append(data + b"\0" * (-len(data) % 4))
        self._size += len(self.blocks[-1])
        return self.add("bufferViews", view)

    def add_rows(self, rows: NDArray[Any], kind: str, limits: bool = False) -> int:
        """Append an array of one or two dimensions; return the index of its accessor.

        limits : whether the least and largest values are named too
        """
        table, is_float = rows.reshape(len(rows), -1).astype(kind), kind == "<f4"
        item = {
            "bufferView": self.add_view(
                table.tobytes(), target=_VERTICES if is_float else _INDICES
            ),
            "componentType": _TYPES[kind],
            "type": _SHAPES[table.shape[1]],
            "count": len(table),
        }
        if limits:
            item |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self.add("accessors", item)

    def note(self, what: str, owner: str) -> None:
        """Note what is written differently, and whose it is."""
        self.rounded.setdefault(what, []).append(owner)

    def warn(self) -> None:
        """Warn of what is written differently."""
        for what, owners in self.rounded.items():
            warn(f"{what}, in {len(owners)} material{'s' * (len(owners) > 1)}: {listed(owners)}")

    def finish(self, uri: str | None) -> tuple[Json, bytes]:
        """Return the JSON and the buffer, which lies in the file of a name or in the same one."""
        data = b"".join(self.blocks)
        named = {} if uri is None else {"uri": uri}
        buffer = {**named, "byteLength": len(data)}
        asset = {"version": "2.0", "generator": "photonmap"}
        return {"asset": asset, **self.tree, "buffers": [buffer]}, data


def pack_glb(tree: Json, data: bytes) -> bytes:
    """Return a GLB file."""
    text = json.dumps(tree, ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    size = 28 + len(text) + len(data)
    if size > _LARGEST:
        raise InputError(f"a GLB file of {size} bytes is too large; write .gltf")
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(data), b"BIN\0"),
            data,
        ]
    )


_ROUNDED = "textures of floating-point numbers are rounded to 16 bits in sRGB"
_NUMBERS_ROUNDED = "textures of opacity, roughness, normals and the like are rounded to 16 bits"
_SPECTRA = "the spectra of textures become their colours under D65"
_OPACITY_APART = "opacities that lie otherwise than the colour become their mean"
_RESIZED = "textures are enlarged to the size of another one in the same image"
_WHOLE = slice(None), slice(None)
_WHITE = Image(np.full((1, 1, 3), 255, np.uint8), True)


@dataclass
class TextureWriter:
    """Adds textures to a file, each image once."""

    draft: Draft  # the file
    _images: dict[Any, tuple[int, Triple]] = field(default_factory=dict)
    _textures: dict[Any, int] = field(default_factory=dict)
    _kept: list[Image] = field(default_factory=list)

    def color(self, texture: Texture, owner: str, most: float = 1.0) -> tuple[Json, Triple]:
        """Add a colour texture; return the JSON that names it, and a factor up to `most`."""
        if isinstance(texture, SpectralTexture):
            self.draft.note(_SPECTRA, owner)
        image, factor = self._image(texture, None, owner, most)
        return self._use(image, texture), factor

    def masked(
        self, color: Texture | None, mask: Texture, owner: str
    ) -> tuple[Json, Triple, float]:
        """Add a texture of a colour, or of white, and of opacity.

        Returns The JSON that names it, and the factors of colour and opacity
        """
        if color is None:
            color = replace(mask, image=_WHITE, factor=(1.0, 1.0, 1.0))
        elif not lie_alike(color, mask):
            self.draft.note(_OPACITY_APART, owner)
            return *self.color(color, owner), mean_number(mask)
        image, factor = self._image(color, mask, owner)
        return self._use(image, color), factor, 1.0

    def data(self, texture: Texture, owner: str) -> Json:
        """Add a texture of numbers in linear RGB, in 8 bits if they hold it, or else in 16."""
        values = texture.image.linear(*_WHOLE).astype(np.float64)
        texels: NDArray[Any] = np.rint(255.0 * values).astype(np.uint8)
        if not np.allclose(texels / 255.0, values, rtol=0.0, atol=1e-6):
            texels = np.rint(65535.0 * values).astype(np.uint16)
            self._note_rounding(values, owner)
        item = {"bufferView": self.draft.add_view(encode_png(texels)), "mimeType": "image/png"}
        return self._use(self.draft.add("images", item), texture)

    def _image(
        self, color: Texture, mask: Texture | None, owner: str, most: float = 1.0
    ) -> tuple[int, Triple]:
        """Add an image, unless it is there; return its index, and the factor of its colour."""
        plain = color.image.texels.dtype == np.uint8 and color.image.srgb
        plain = plain and max(color.factor) <= most
        key = (
            id(color.image),
            None if plain else color.factor,
            mask and (id(mask.image), mask.factor),
        )
        if color.image.texels.dtype != np.uint8:
            self.draft.note(_ROUNDED, owner)
        if key not in self._images:
            self._kept += [each.image for each in (color, mask) if each]  # so that ids stay
            texels, scale = (_rgb(color.image.texels), 1.0) if plain else _encode(color)
            if mask is not None:
                texels = self._with_alpha(texels, mask, owner)
            view = self.draft.add_view(encode_png(texels))
            item = {"bufferView": view, "mimeType": "image/png"}
            self._images[key] = self.draft.add("images", item), (scale, scale, scale)
        index, scales = self._images[key]
        return index, color.factor if plain else scales

    def _with_alpha(self, texels: NDArray[Any], mask: Texture, owner: str) -> NDArray[Any]:
        """Return (H, W, 4) texels; with a mask that 8 bits cannot hold, uint16."""
        linear = _rgb(mask.image.linear(*_WHOLE)) * np.array(mask.factor)
        alpha = np.minimum(linear @ np.array(LUMINANCE), 1.0)
        if texels.shape[:2] != alpha.shape:
            shape = tuple(np.maximum(texels.shape[:2], alpha.shape))
            if texels.shape[:2] not in ((1, 1), shape) or alpha.shape != shape:
                self.draft.note(_RESIZED, owner)
            texels, alpha = _enlarge(texels, shape), _enlarge(alpha, shape)
        levels = np.rint(255.0 * alpha)
        if texels.dtype == np.uint8 and np.allclose(levels / 255.0, alpha, rtol=0.0, atol=1e-6):
            return np.dstack([texels, levels.astype(np.uint8)])
        if texels.dtype == np.uint8:
            texels = 257 * texels.astype(np.uint16)
        self._note_rounding(alpha, owner)
        return np.dstack([texels, np.rint(65535.0 * alpha).astype(np.uint16)])

    def _note_rounding(self, values: NDArray[Any], owner: str) -> None:
        """Note numbers, which are not encoded in sRGB, that 16 bits cannot hold."""
        if not np.allclose(np.rint(65535.0 * values) / 65535.0, values, rtol=0.0, atol=1e-7):
            self.draft.note(_NUMBERS_ROUNDED, owner)

    def _use(self, image: int, texture: Texture) -> Json:
        key = image, texture.clamp, texture.nearest
        if key not in self._textures:
            item: Json = {"source": image}
            if texture.clamp or texture.nearest:
                wraps = (CLAMP if clamp else REPEAT for clamp in texture.clamps)
                sampler = dict(zip(("wrapS", "wrapT"), wraps, strict=True))
                sampler |= {"magFilter": NEAREST, "minFilter": NEAREST} if texture.nearest else {}
                item["sampler"] = self.draft.add("samplers", sampler)
            self._textures[key] = self.draft.add("textures", item)
        use: Json = {"index": self._textures[key]}
        (s, t), (u, v) = texture.scale, texture.offset
        if (s, t, u, v) != (1.0, 1.0, 0.0, 0.0):
            transform = {"scale": [s, t], "offset": [u, 1.0 - t - v]}
            use["extensions"] = self.draft.use("KHR_texture_transform", transform)
        return use


def _rgb(texels: NDArray[Any]) -> NDArray[Any]:
    return np.repeat(texels, 3, axis=2) if texels.shape[2] == 1 else texels


def _encode(texture: Texture) -> tuple[NDArray[np.uint16], float]:
    """Return texels of 16 bits in sRGB, and the factor by which they are to be multiplied."""
    linear = _rgb(texture.image.linear(*_WHOLE)).astype(np.float64) * np.array(texture.factor)
    scale = float(linear.max()) or 1.0
    return np.rint(65535.0 * encode_srgb(linear / scale)).astype(np.uint16), scale


def _enlarge(texels: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    rows, columns = (
        np.arange(wanted) * there // wanted
        for wanted, there in zip(shape, texels.shape, strict=False)
    )
    return texels[rows[:, None], columns]


_GLOSS_APART = "textures of gloss that lie otherwise than another one become their mean"
_COATS = "textures of glossy reflectances take the coat of a usual dielectric"
_RGB = Bands.rgb()
_LARGEST_COAT = normal_reflectance(1e3)  # Of the largest index that the reader takes
_EXTENSIONS = {
    "coat": ("clearcoat", {"coat": "clearcoat", "coat_roughness": "clearcoatRoughness"}),
    "sheen": ("sheen", {"sheen": "sheenColor", "sheen_roughness": "sheenRoughness"}),
}
"""Of lobes over others: the extension, and how its keys of a factor and a texture begin, by
attribute; other lobes are left to TOML"""
_ONE_COLOR = "what is glass in part takes the colour of the rest"


@dataclass
class MaterialWriter:
    """Describes a material by the one of glTF that comes nearest.

    Spectra become linear sRGB, mirrors metals of roughness 0, and rough diffuse surfaces smooth.
    """

    material: Material
    name: str  # in the file
    textures: TextureWriter
    extensions: Json = field(default_factory=dict)  # what they hold

    def use(self, extension: str, content: Json) -> None:
        """Add an extension."""
        self.extensions |= self.textures.draft.use(f"KHR_materials_{extension}", content)

    def note(self, what: str) -> None:
        """Note what is written differently."""
        self.textures.draft.note(what, self.name)

    def write(self) -> Json:
        """Return the JSON of the material."""
        material = self.material
        item = self.opaque() if material.ior is None else self.glass()
        if isinstance(material.relief, NormalMap):
            item["normalTexture"] = self.normal_map(material.relief)
        coat = self.extensions.get("KHR_materials_clearcoat", {})
        if isinstance(material.own_coat_relief, NormalMap):
            coat["clearcoatNormalTexture"] = self.normal_map(material.own_coat_relief)
        elif material.own_coat_relief is None and "normalTexture" in item:
            coat["clearcoatNormalTexture"] = item["normalTexture"]
        item |= self.emission()
        if material.fluorescence is not None:
            described = {"fluorescence": describe_fluorophores(material.fluorescence)}
            amount = material.fluorescence_concentration
            described |= self.scalar(amount, "concentration", "concentrationTexture")
            item["extras"] = {"photonmap": described}
        extensions = {"extensions": self.extensions} if self.extensions else {}
        return {"name": self.name, **item, **extensions}

    def normal_map(self, relief: NormalMap) -> Json:
        """Return the JSON that names a map of normals."""
        return self.textures.data(_multiplied(relief.texture), self.name) | {
            "scale": relief.strength
        }

    def glass(self) -> Json:
        """Return the JSON of glass; where only a part is glass, its colour is that of the rest."""
        material = self.material
        color = material.tint
        if not material.is_all_glass:
            color = material.reflectance
            if color != material.tint:
                self.note(_ONE_COLOR)
        texture = color if isinstance(color, Texture) else None
        surface, mode = self.base_color(texture, _RGB.reflectance(mean_color(color)).tolist())
        surface["metallicFactor"] = 0.0
        surface |= self.scalar(material.roughness, "roughnessFactor", METALLIC_TEXTURE)
        share = self.scalar(material.transmission, "transmissionFactor", "transmissionTexture")
        self.use("transmission", share)
        self.use("ior", {"ior": material.ior})
        if not material.thin:
            volume: Json = {"thicknessFactor": 1.0}
            if material.attenuation_distance is not None:
                volume["attenuationColor"] = _RGB.reflectance(material.attenuation_color).tolist()
                volume["attenuationDistance"] = material.attenuation_distance
            self.use("volume", volume)
            if (abbe := material.nearest_abbe) is not None:
                self.use("dispersion", {"dispersion": 20.0 / abbe})
        self.add_stretch()
        return {"pbrMetallicRoughness": surface, **mode}

    def scalar(self, value: float | Texture, factor: str, use: str) -> Json:
        """Return a number as a factor, or a texture of numbers beside a factor of 1.

        factor, use : keys of the factor and of the texture
        """
        if not isinstance(value, Texture):
            return {factor: value}
        return {factor: 1.0, use: self.textures.data(_multiplied(value), self.name)}

    def base_color(
        self, texture: Texture | None, factor: list[float], rest: float = 1.0
    ) -> tuple[Json, dict[str, str]]:
        """Return the JSON of a base colour and its opacity, and the mode in which that is used.

        texture, factor : its texture, or the colour where it has none
        rest : divides the colour of a texture
        """
        surface: Json = {}
        alpha, scale = self.material.alpha, (1.0, 1.0, 1.0)
        opacity = alpha
        if isinstance(alpha, Texture):
            masked = self.textures.masked(texture, alpha, self.name)
            surface["baseColorTexture"], scale, opacity = masked
        elif texture is not None:
            surface["baseColorTexture"], scale = self.textures.color(texture, self.name)
        if texture is not None:
            factor = [min(part / rest, 1.0) for part in scale]
        surface["baseColorFactor"] = [*factor, opacity]
        return surface, ({} if alpha == 1.0 else {"alphaMode": "BLEND"})

    def opaque(self) -> Json:
        """Return the JSON of what is not glass."""
        material, textured = self.material, self.split_lobe()
        gloss, roughness = _lobe(material)
        base = _RGB.reflectance(mean_color(material.reflectance))
        whole, metallic, coat = split_metal(base, gloss, material.covering)
        painted = material.reflectance
        if textured is not None:
            roughness = 1.0
            if textured.color is not None:
                whole, metallic, coat = np.ones(3), 1.0, np.full(3, self.coat_beside_metal)
                painted = textured.color
        surface: Json = {"metallicFactor": metallic, "roughnessFactor": roughness}
        if textured is not None:
            surface[METALLIC_TEXTURE] = self.textures.data(textured.data, self.name)
        if metallic != 1.0 or textured is not None:
            self.add_coat(coat)
        self.add_stretch()
        self.add_covers()
        color = painted if isinstance(painted, Texture) else None
        color = color if base.any() or textured is not None else None
        rest = 1.0 if textured and textured.color else 1.0 - metallic
        colored, mode = self.base_color(color, whole.tolist(), rest)
        # surfaces emit from their front alone
        sides = {"doubleSided": is_black(material.emission)}
        return {"pbrMetallicRoughness": surface | colored, **sides, **mode}

    def add_stretch(self) -> None:
        """Say how a material differs along the surface, if it does."""
        material = self.material
        if not material.is_anisotropic:
            return
        stretch: Json = {
            "anisotropyStrength": material.anisotropy,
            "anisotropyRotation": 2.0 * np.pi * material.anisotropy_rotation,
        }
        if material.anisotropy_map is not None:
            stretch["anisotropyTexture"] = self.textures.data(
                material.anisotropy_map.texture, self.name
            )
        self.use("anisotropy", stretch)

    def add_covers(self) -> None:
        """Add the lobes that a material has over others, as glTF knows them."""
        for lobe, (extension, keys) in _EXTENSIONS.items():
            if not self.material.has(lobe):
                continue
            content: Json = {}
            for attribute, key in keys.items():
                value = getattr(self.material, attribute)
                factor, use = f"{key}Factor", f"{key}Texture"
                if not isinstance(parameters_of(Material)[attribute], Colored):
                    content |= self.scalar(value, factor, use)
                elif isinstance(value, Texture):
                    content[use], scale = self.textures.color(value, f"{self.name} {attribute}")
                    content[factor] = list(scale)
                else:
                    content[factor] = _RGB.reflectance(value).tolist()
            self.use(extension, content)

    @property
    def coat_beside_metal(self) -> float:
        """Return what the coat beside the metallic part of a texture reflects."""
        covering = self.material.covering
        return USUAL_COAT if covering is None else covering

    def add_coat(self, coat: Floats) -> None:
        """Say that a coat, (3,), reflects so much at normal incidence."""
        most, specular = float(coat.max()), Json()
        if most == 0.0:
            specular = {"specularFactor": 0.0}
        elif most > _LARGEST_COAT:
            self.use("ior", {"ior": 0.0})
            specular = {"specularFactor": most}
        elif not math.isclose(most, USUAL_COAT, rel_tol=1e-12):
            root = math.sqrt(most)
            self.use("ior", {"ior": (1.0 + root) / (1.0 - root)})
        if coat.min() < most:
            specular["specularColorFactor"] = (coat / most).tolist()
        if specular:
            self.use("specular", specular)

    def emission(self) -> Json:
        """Return the JSON of the emission."""
        emission = self.material.emission
        item: Json = {}
        if isinstance(emission, Texture):
            item["emissiveTexture"], factor = self.textures.color(emission, self.name, math.inf)
        else:
            factor = rgb_emission(emission)
        if any(factor):
            item["emissiveFactor"], strength = split_exactly(factor)
            if strength != 1.0:
                self.use("emissive_strength", {"emissiveStrength": strength})
        return item

    def split_lobe(self) -> Lobe | None:
        """Return what textures of a glossy lobe become; None where it has none.

        The metallic part of each texel is that of a surface of `coat_beside_metal`.
        """
        material = self.aligned()
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
        if material.covering is None:
            self.note(_COATS)
        base, glossy = _texels(material.reflectance, shape), _texels(material.glossy, shape)
        coat = self.coat_beside_metal
        data[..., 2] = metallic_fraction(base.mean(axis=2), glossy.mean(axis=2), coat)
        color = base + glossy - (1.0 - data[..., 2:]) * np.float32(coat)
        image = Texture.of(np.clip(color, 0.0, 1.0)).image
        return Lobe(replace(lying, image=image), replace(lying, image=Texture.of(data).image))

    def aligned(self) -> Material:
        """Return a material whose textures of the lobe lie alike; others become their mean."""
        material = self.material
        paints = (material.reflectance, material.glossy, material.roughness)
        first = next((paint for paint in paints if isinstance(paint, Texture)), None)
        if not lie_alike(first, material.glossy):
            self.note(_GLOSS_APART)
            material = replace(material, glossy=mean_color(material.glossy))
        if not lie_alike(first, material.roughness):
            self.note(_GLOSS_APART)
            material = replace(material, roughness=mean_number(material.roughness))
        return material


def _multiplied(texture: Texture) -> Texture:
    if texture.factor == (1.0, 1.0, 1.0):
        return texture
    texels = texture.image.linear(*_WHOLE) * np.array(texture.factor)
    return replace(texture, image=Texture.of(texels).image, factor=(1.0, 1.0, 1.0))


def _lobe(material: Material) -> tuple[Floats, float]:
    """Return what reflects besides the diffuse base, (3,), and its roughness; 1 where none does."""
    if material.is_glossy:
        return _RGB.reflectance(mean_color(material.glossy)), mean_number(material.roughness)
    mirror = _RGB.reflectance(material.mirror)
    return mirror, 0.0 if mirror.any() else 1.0


def split_metal(
    base: Floats, gloss: Floats, covering: float | None
) -> tuple[Floats, float, Floats]:
    """Return colour, metallic fraction and coat of which the reader makes a base and a gloss.

    With a colour c, a metallic fraction m and a coat k, the base is (1 - m) c and the gloss
    m c + (1 - m) k, which is linear in the base: of the slope m / (1 - m). All of a gloss that
    covers the base is coat.

    base, gloss : (3,) diffuse reflectance, and reflectance at normal incidence
    covering : of the coat beside metal; None where there is none
    """
    if not base.any() and gloss.any():
        return gloss, 1.0, np.zeros(3)
    if covering is None:
        return base, 0.0, gloss
    most, least = int(base.argmax()), int(base.argmin())
    if base[least] < base[most]:
        slope = max((gloss[most] - gloss[least]) / (base[most] - base[least]), 0.0)
        fraction = float(slope / (1.0 + slope))
    else:
        fraction = float(metallic_fraction(base.mean(), gloss.mean(), covering))
    whole = np.minimum(base / max(1.0 - fraction, 1e-9), 1.0)
    return whole, fraction, np.full(3, covering)


def rgb_emission(color: Color) -> tuple[float, float, float]:
    """Return the linear sRGB of an amount of light."""
    return plain(_RGB.emission(color))


def split_exactly(color: tuple[float, float, float]) -> tuple[list[float], float]:
    """Return three factors within [0, 1] and a power of two, whose products are the colour."""
    mantissa, exponent = math.frexp(max(color))
    strength = 2.0 ** max(exponent - (mantissa == 0.5), 0)
    return [part / strength for part in color], strength


class Lobe(NamedTuple):
    """A glossy lobe as glTF has it."""

    color: Texture | None  # base colour, where a texture gives the reflectance of the lobe
    data: Texture  # what the texture of the metallic part and of roughness holds, in blue and green


def _texels(paint: object, shape: list[int]) -> NDArray[np.float32]:
    if isinstance(paint, Texture):
        return np.broadcast_to(resized(paint, shape), (*shape, 3))
    color = np.array(as_triple(paint), np.float32)  # type: ignore[arg-type]
    return np.broadcast_to(color, (*shape, 3))
