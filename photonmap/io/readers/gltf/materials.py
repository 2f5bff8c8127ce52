"""Read the materials of glTF files, and their textures: in files, in buffers and data URIs."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar
from urllib.parse import unquote

import numpy as np

from photonmap.errors import InputError, naming
from photonmap.io.readers.decoding import SHEEN, Losses, Note, note_loss, plain, read_embedded
from photonmap.io.readers.registry import GREY, OR_WITHOUT, MissingTextures, extended
from photonmap.runtime.files import named_image
from photonmap.runtime.wording import listed, shown
from photonmap.scene.images import Channels, Image, read_channels
from photonmap.scene.material import Material
from photonmap.scene.surfaces.fresnel import normal_reflectance
from photonmap.scene.surfaces.metallic import (
    USUAL_INDEX,
    Gloss,
    is_even,
    metallic_gloss,
    multiplied,
)
from photonmap.scene.surfaces.relief import STEEPEST, AnisotropyMap, NoRelief, NormalMap
from photonmap.scene.textures import Paint, Texture, Triple, lie_alike, mean_number
from photonmap.spectra.curves import LARGEST_REFLECTANCE, Floats
from photonmap.spectra.fluorophores import read_fluorophores

METALLIC_TEXTURE = "metallicRoughnessTexture"
Channel = Callable[[Channels], Image]
Tint = tuple[float, float, float, float]
WHITE = (1.0, 1.0, 1.0, 1.0)
_READ = (
    "ior", "specular", "emissive_strength", "transmission", "volume", "dispersion",
    "anisotropy", "clearcoat", "sheen", "pbrSpecularGlossiness",
)  # fmt: skip
"""Extensions that are simulated, `KHR_materials_…`"""
_TEXTURES = ("baseColorTexture", METALLIC_TEXTURE, "emissiveTexture")
_NORMALS, _COAT_NORMALS = "normalTexture", "clearcoatNormalTexture"
_HARMLESS = "occlusionTexture"  # It stands for what is simulated anyway
_OPAQUE = ("KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit")  # They transmit nothing
METAL_COLORS = "variation of a metal's colour"
LOBES = "variation of roughness and metallic"


def read_material(
    index: int, item: Json, textures: Textures, losses: Losses, tint: Tint | None = None
) -> Material:
    """Read a material.

    Of the base colour, the metallic fraction is the reflectance of a rough metal, and the rest a
    diffuse base below a coat (glTF 2.0, appendix B); with transmission through a volume it is
    glass.

    index : of the material in the file; it names what has no name
    tint : linear RGBA that multiplies the base colour, such as that of vertices
    """
    name = str(item.get("name") or f"material_{index}")
    source = Source(textures.path, name, item, losses, textures, tint)
    for key in (*item, *source.surface):
        if key.endswith("Texture") and key not in (*_TEXTURES, _NORMALS, _HARMLESS):
            source.lose(key)
    for extension in item.get("extensions", ()):
        if extension.removeprefix("KHR_materials_") not in _READ:
            source.lose(extension)
    look = _glass(source) or _opaque(source)
    if "coat" not in look and source.extension("clearcoat").get("clearcoatFactor", 0.0):
        source.lose("KHR_materials_clearcoat")
    if "sheen" not in look and _sheen(source):
        source.lose(SHEEN)
    if (relief := _normal_map(source, source.item, _NORMALS)) is not None:
        look["relief"] = relief
    if (emission := _emission(source)) is not None:
        look["emission"] = emission
    return Material(source.name, **look, **_fluorescence(source))


def _fluorescence(source: Source) -> dict[str, Any]:
    """Return what glTF has no extension for, as the writer keeps it in extras."""
    extras = source.item.get("extras")
    held = extras.get("photonmap") if isinstance(extras, dict) else None
    if not isinstance(held, dict) or "fluorescence" not in held:
        return {}
    with naming(f"material {shown(source.name)}: fluorescence", source.path):
        fluorescence = read_fluorophores(held["fluorescence"], source.path.parent)
    factor = source.number(held, "concentration", 1.0)
    amount = source.times(
        factor, held.get("concentrationTexture"), partial(Channels.image, linear=True)
    )
    return {"fluorescence": fluorescence, "fluorescence_concentration": amount}


def _opaque(source: Source) -> dict[str, Any]:
    if (older := _specular_gloss(source)) is not None:
        return older
    if "KHR_materials_unlit" in source.item.get("extensions", {}):
        return {"reflectance": _base(source)} | _alpha(source)
    if "pbrMetallicRoughness" not in source.item:
        tint: dict[str, Any] = {"reflectance": source.tint[:3]} if source.tint else {}
        return tint | _sheen(source)
    metallic = source.data("metallicFactor", Channels.blue)
    look = _gloss(source, _base(source), metallic)._asdict() | _alpha(source)
    coat = _clear_coat(source)
    return look | _anisotropy(source) | (coat or _sheen(source))


def _index(source: Source) -> float:
    """Return the index of refraction; 0 stands for an infinite one."""
    return source.number(source.extension("ior"), "ior", USUAL_INDEX, 1e3)


def _coat(source: Source, base: object) -> Paint:
    """Return what is reflected at normal incidence where there is no metal."""
    specular, index = source.extension("specular"), _index(source)
    once = normal_reflectance(max(index, 1.0)) if index > 0.0 else 1.0
    amount = source.number(specular, "specularFactor", 1.0)
    tint = source.color(specular, "specularColorFactor", 1e30)
    even = plain(min(once * part, 1.0) * amount for part in tint)
    images = {
        "specularColorTexture": source.texture(specular.get("specularColorTexture")),
        "specularTexture": source.times(1.0, specular.get("specularTexture"), Channels.opacity),
    }
    kept = []
    for name, image in images.items():
        if isinstance(image, Texture) and lie_alike(base, image):
            kept.append(image)
        elif isinstance(image, Texture):
            source.lose(name)
    if kept and lie_alike(kept[0], kept[-1]):
        return multiplied(kept, even)
    return even if len(set(even)) > 1 else even[0]


def _specular_gloss(source: Source) -> dict[str, Any] | None:
    """Return attributes of the older model of a base below a specular coat, if it is used."""
    model = source.extension("pbrSpecularGlossiness")
    if not model:
        return None
    if "specularGlossinessTexture" in model:
        source.lose("specularGlossinessTexture")
    names = {"diffuseFactor": "baseColorFactor", "diffuseTexture": "baseColorTexture"}
    renamed = {new: model[old] for old, new in names.items() if old in model}
    older = replace(source, item={**source.item, "pbrMetallicRoughness": renamed})
    glossy = source.color(model, "specularFactor")
    roughness = 1.0 - source.number(model, "glossinessFactor", 1.0)
    look = {"reflectance": _base(older), "glossy": glossy, "roughness": roughness}
    return look | _alpha(older)


def _anisotropy(source: Source) -> dict[str, Any]:
    extension = source.extension("anisotropy")
    strength = source.number(extension, "anisotropyStrength", 0.0)
    if strength == 0.0:
        return {}
    angle = extension.get("anisotropyRotation", 0.0)
    if type(angle) not in (int, float) or not math.isfinite(angle):
        raise source.wrong("anisotropyRotation", angle, "a finite number")
    turns = math.remainder(angle / (2.0 * math.pi), 1.0)
    stretch: dict[str, Any] = {"anisotropy": strength, "anisotropy_rotation": turns}
    image = source.texture(extension.get("anisotropyTexture"), Channels.data)
    return stretch if image is None else stretch | {"anisotropy_map": AnisotropyMap(image)}


def _base(source: Source) -> Triple | Texture:
    factor = source.base_color()
    if "baseColorTexture" not in source.surface:
        return factor
    texture = source.texture(source.surface["baseColorTexture"])
    if texture is None:
        return plain(part * GREY for part in factor)
    return replace(texture, factor=factor)


def _gloss(source: Source, base: Triple | Texture, metallic: float | Texture) -> Gloss:
    roughness = source.data("roughnessFactor", Channels.green)
    if not lie_alike(base, metallic):
        source.lose("variation of metallic")
    coat = _coat(source, base if isinstance(base, Texture) else metallic)
    return metallic_gloss(base, metallic, coat, roughness)


def _clear_coat(source: Source) -> dict[str, Any]:
    """Return the clear coat of a surface, if it has one, with normals of its own."""
    extension = source.extension("clearcoat")
    amount = source.number(extension, "clearcoatFactor", 0.0)
    roughness = source.number(extension, "clearcoatRoughnessFactor", 0.0)
    if amount == 0.0:
        return {}
    weight = source.times(amount, extension.get("clearcoatTexture"), Channels.red)
    rough = source.times(roughness, extension.get("clearcoatRoughnessTexture"), Channels.green)
    look: dict[str, Any] = {"coat": weight, "coat_roughness": rough}
    if extension.get(_COAT_NORMALS) == source.item.get(_NORMALS):
        return look
    return look | {"coat_relief": _normal_map(source, extension, _COAT_NORMALS) or NoRelief()}


def _sheen(source: Source) -> dict[str, Any]:
    extension = source.extension("sheen")
    roughness = source.number(extension, "sheenRoughnessFactor", 0.0)
    if not any(extension.get("sheenColorFactor", ())):
        return {}
    factor = source.color(extension, "sheenColorFactor")
    texture = source.texture(extension.get("sheenColorTexture"))
    color = factor if texture is None else replace(texture, factor=factor)
    if "sheenRoughnessTexture" in extension:
        source.lose("sheenRoughnessTexture")
    return {"sheen": color, "sheen_roughness": roughness}


def _glass(source: Source) -> dict[str, Any] | None:
    """Return attributes of what is glass, at least in part; None for what transmits nothing.

    It is thin without a volume. Metal transmits nothing; of the rest, what is not transmitted is
    reflected diffusely, below the same surface.
    """
    extension = source.extension("transmission")
    amount = source.number(extension, "transmissionFactor", 0.0)
    share = source.times(amount, extension.get("transmissionTexture"), Channels.red)
    metallic = source.data("metallicFactor", Channels.blue)
    if share == 0.0 or metallic == 1.0 or {*_OPAQUE} & {*source.item.get("extensions", ())}:
        return None
    if isinstance(metallic, Texture):
        source.lose("variation of metallic beside transmission")
        metallic = mean_number(metallic)
    base, index = _base(source), _index(source)
    if index == 0.0:
        raise source.wrong("ior", index, "an index of refraction above 0, which glass needs")
    if isinstance(share, Texture) and not lie_alike(base, share):
        source.lose("variation of transmission")
        share = mean_number(share)
    if isinstance(share, Texture):
        share = replace(share, factor=plain((1.0 - metallic) * part for part in share.factor))
    else:
        share *= 1.0 - metallic
    look: dict[str, Any] = {"reflectance": 0.0, "ior": index, "tint": base}
    look["roughness"] = source.data("roughnessFactor", Channels.green)
    if share != 1.0:
        rest = max(1.0 - mean_number(share), 1e-9)
        gloss = _gloss(source, base, min(metallic / rest, 1.0))
        look |= gloss._asdict() | {"transmission": share}
    look |= _anisotropy(source) | _alpha(source)
    if source.number(source.extension("volume"), "thicknessFactor", 0.0, 1e30) == 0.0:
        return look | {"thin": True}
    dispersion = source.number(source.extension("dispersion"), "dispersion", 0.0, 1e30)
    abbe = {"abbe": 20.0 / dispersion} if dispersion > 0.0 else {}
    return look | _attenuation(source) | abbe


def _attenuation(source: Source) -> dict[str, Any]:
    """Return what a volume absorbs; nothing along an infinite distance, the default."""
    volume = source.extension("volume")
    color = source.color(volume, "attenuationColor")
    if color == (1.0, 1.0, 1.0) or "attenuationDistance" not in volume:
        return {}
    distance = source.number(volume, "attenuationDistance", math.inf, 1e30)
    if distance == 0.0:
        raise source.wrong("attenuationDistance", 0, "a number above 0")
    return {"attenuation_color": color, "attenuation_distance": distance}


def _normal_map(source: Source, holder: Json, key: str) -> NormalMap | None:
    use = holder.get(key)
    if use is None:
        return None
    directions = source.texture(use, Channels.data)
    scale = use.get("scale", 1.0)
    if type(scale) not in (int, float) or not abs(scale) <= STEEPEST:
        raise source.wrong(f"scale of {key}", scale, f"a number up to {STEEPEST:g}")
    return None if directions is None or scale == 0.0 else NormalMap(directions, float(scale))


def _alpha(source: Source) -> dict[str, float | Texture]:
    """Return the opacity where the material has one: blended, or cut off."""
    mode = source.item.get("alphaMode", "OPAQUE")
    if mode == "OPAQUE":
        return {}
    factors = source.surface.get("baseColorFactor", ())
    alpha = source.number({"alpha": factors[3]} if len(factors) > 3 else {}, "alpha", 1.0)
    alpha *= (source.tint or WHITE)[3]
    cutoff = source.number(source.item, "alphaCutoff", 0.5, 1e30) if mode == "MASK" else None
    if "baseColorTexture" in source.surface:
        return {"alpha": source.textures.opacity(source.surface["baseColorTexture"], alpha, cutoff)}
    return {"alpha": alpha if cutoff is None else float(alpha >= cutoff)}


def _emission(source: Source) -> Paint | None:
    """Return the radiance; None for a surface that does not emit."""
    item = source.item
    if not any(item.get("emissiveFactor", ())):
        return None
    color = source.color(item, "emissiveFactor")
    strength = source.number(source.extension("emissive_strength"), "emissiveStrength", 1.0, 1e30)
    factor = plain(part * strength for part in color)
    if "emissiveTexture" not in item:
        return factor
    texture = source.texture(item["emissiveTexture"])
    return None if texture is None else replace(texture, factor=factor)


@dataclass(frozen=True)
class Described:
    """What JSON describes, and where what is wrong or not simulated is said."""

    kind: ClassVar[str]
    largest: ClassVar[float] = float(np.finfo(np.float64).max)  # Of numbers without other limits
    path: Path  # the file, for messages
    name: str  # its own in the scene
    item: Json  # its JSON
    losses: Losses  # takes what is not simulated

    def lose(self, what: str) -> None:
        """Note what is not simulated."""
        note_loss(self.losses, what, self.name)

    def number(
        self, values: Json, key: str, default: float | None, largest: float | None = None
    ) -> float:
        """Return a number from 0 to `largest`; `default` where it is not given."""
        value, most = values.get(key, default), self.largest if largest is None else largest
        if type(value) not in (int, float) or not 0.0 <= value <= most:
            limits = "of at least 0" if most == Described.largest else f"from 0 to {most:g}"
            raise self.wrong(key, value, f"a number {limits}")
        return float(value)

    def wrong(self, key: str, value: Any, wanted: str) -> InputError:
        """Return the error that a value is not what is wanted."""
        return self.error(f"{key} {shown(value)} is not {wanted}; correct it")

    def error(self, message: str) -> InputError:
        """Return an error about it."""
        return InputError(f"{self.kind} {shown(self.name)}: {message}", self.path)


@dataclass(frozen=True)
class Source(Described):
    """A material."""

    kind, largest = "material", 1.0
    textures: Textures  # those of the file
    tint: Tint | None = None  # RGBA that multiplies the base colour; None for none

    @property
    def surface(self) -> Json:
        """The metallic-roughness model."""
        return self.item.get("pbrMetallicRoughness") or {}

    def extension(self, name: str) -> Json:
        """Return the content of an extension, empty if there is none."""
        found: Json = self.item.get("extensions", {}).get(f"KHR_materials_{name}") or {}
        return found

    def color(self, values: Json, key: str, largest: float = 1.0) -> tuple[float, float, float]:
        """Return three factors, each from 0 to `largest`."""
        value = values.get(key, [1, 1, 1])[:3]
        most = max(largest, LARGEST_REFLECTANCE)
        if len(value) < 3 or not all(
            type(part) in (int, float) and 0 <= part <= most for part in value
        ):
            raise self.wrong(key, value, f"three numbers within [0, {largest:g}]")
        return plain(min(float(part), largest) for part in value)

    def texture(self, use: Json | None, channel: Channel = Channels.image) -> Texture | None:
        """Return a texture, of colours by default; None if it is missing, or there is none."""
        if use is None:
            return None
        return self.textures.texture(use, channel, find_placement(self.item), self.lose)

    def data(self, factor: str, channel: Channel) -> float | Texture:
        """Return a factor of the surface times a channel of the texture beside it, if any."""
        number = self.number(self.surface, factor, 1.0)
        return self.times(number, self.surface.get(METALLIC_TEXTURE), channel)

    def times(self, number: float, use: Json | None, channel: Channel) -> float | Texture:
        """Return a number times a channel of a texture, if there is one."""
        texture = None if number == 0.0 else self.texture(use, channel)
        if texture is None:
            return number
        texture = replace(texture, factor=(number,) * 3)
        return mean_number(texture) if is_even(texture) else texture

    def base_color(self) -> Triple:
        """Return the factor of the base colour, tinted."""
        red, green, blue = self.color(self.surface, "baseColorFactor")
        r, g, b, _ = self.tint or WHITE
        return r * red, g * green, b * blue


CLAMP, MIRROR, REPEAT = 33071, 33648, 10497  # Values of a sampler's wrapS and wrapT
NEAREST = 9728  # Value of a sampler's magFilter; others interpolate
_TRANSFORM = "KHR_texture_transform"
_EMBEDDED = "photonmap_image_"  # How the names of files begin that embedded images are decoded from
Json = Mapping[str, Any]


@dataclass(frozen=True)
class Placement:
    """How a texture lies on a surface: the set of coordinates, and what becomes of them.

    They are scaled, rotated about the origin, and moved, v counting downwards; the rotation, in
    radians, turns u towards -v.
    """

    coordinates: int = 0
    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, use: Json) -> Placement:
        """Return the placement of a texture by the JSON that names it."""
        transform = use.get("extensions", {}).get(_TRANSFORM, {})
        s, t = transform.get("scale", (1.0, 1.0))
        u, v = transform.get("offset", (0.0, 0.0))
        coordinates = transform.get("texCoord", use.get("texCoord", 0))
        return cls(coordinates, (s, t), transform.get("rotation", 0.0), (u, v))

    @property
    def matrix(self) -> Floats:
        """The same of coordinates whose v counts upwards, (2, 3)."""
        (s, t), (u, v) = self.scale, self.offset
        cosine, sine = math.cos(self.rotation), math.sin(self.rotation)
        return np.array(
            [[s * cosine, -t * sine, u + t * sine], [s * sine, t * cosine, 1.0 - v - t * cosine]]
        )

    def turn(self, uv: Floats) -> Floats:
        """Return coordinates of vertices, (V, 2), v upwards, as the textures of a mesh use them.

        Textures themselves scale and move, but do not rotate.
        """
        return uv @ self.matrix[:, :2].T + self.matrix[:, 2] if self.rotation else uv


def find_placement(material: Json) -> Placement:
    """Return the placement of a material: of the texture of its colour, light or gloss."""
    surface = material.get("pbrMetallicRoughness") or {}
    older = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness") or {}
    found = older.get("diffuseTexture") or surface.get("baseColorTexture")
    found = found or material.get("emissiveTexture")
    found = found or surface.get("metallicRoughnessTexture") or material.get("normalTexture")
    return Placement.of(found or {})


@dataclass
class Textures:
    """The textures of a file."""

    path: Path  # the file
    item: Callable[
        [str, int], dict[str, Any]
    ]  # returns an item of a top-level array, by its name and index
    view: Callable[[int], bytes | memoryview]  # returns the bytes of a buffer view
    missing: MissingTextures  # what becomes of an image that cannot be read
    lost: list[str] = field(default_factory=list)  # images that could not be read
    _known: dict[tuple[int, Callable[[Channels], Any]], Any] = field(default_factory=dict)
    _last: tuple[int, Channels] | None = None

    def texture(
        self, use: Json, channel: Channel, placement: Placement, lose: Note
    ) -> Texture | None:
        """Return a texture; None if it is missing, which is noted.

        channel : a method of `Channels` that returns its colours, or the numbers that it holds
        """
        image = self._read(use, channel)
        return None if image is None else self._place(Texture(image), use, placement, lose)

    def opacity(self, use: Json, factor: float, cutoff: float | None) -> Texture | float:
        """Return a texture's alpha times a factor, or 0 and 1 below and above a cutoff."""
        mask = self._read(use, Channels.alpha)
        values = np.float32(factor) * (np.ones((1, 1), np.float32) if mask is None else mask)
        if cutoff is not None:
            values = (values >= cutoff).astype(np.float32)
        if (values == values[0, 0]).all():
            return float(values[0, 0])
        texture = Texture.of(values[..., None])
        return self._place(texture, use, Placement.of(use), lambda _: None)

    def _read(self, use: Json, make: Callable[[Channels], Any]) -> Any:
        """Return what a function makes of the image, once; None if the image is missing."""
        texture = self.item("textures", use["index"])
        index = texture.get("source")
        if index is None:
            problem = f"texture {use['index']} is neither PNG nor JPEG; export it as one of them"
            if self.missing == "error":
                raise InputError(f"{problem}{OR_WITHOUT}", self.path)
            self.lost.append(f"texture {use['index']}")
            return None
        if (index, make) not in self._known:
            try:
                made = make(self._channels(index))
            except InputError as error:
                if self.missing == "error":
                    raise self._name(index, error) from None
                self.lost.append(self.item("images", index).get("uri", f"image {index}")[:80])
                made = None
            self._known[index, make] = made
        return self._known[index, make]

    def _channels(self, index: int) -> Channels:
        """Read an image, unless it was the last one that was read."""
        if self._last is None or self._last[0] != index:
            self._last = index, self._read_image(index, self.item("images", index))
        return self._last[1]

    def _read_image(self, index: int, image: dict[str, Any]) -> Channels:
        """Read an image as it is stored, as the specification demands, whatever it states."""
        if not _is_embedded(image):
            return read_channels(named_image(self.path.parent, unquote(image["uri"])), True)
        data: bytes | memoryview
        if "uri" in image:
            data = base64.b64decode(image["uri"].partition(",")[2], validate=True)
        else:
            data = self.view(image["bufferView"])
        kind = image.get("mimeType", "image/png")[6:]
        return read_embedded(data, f"{_EMBEDDED}{index}.{kind}", True)

    def _name(self, index: int, error: InputError) -> InputError:
        """Return an error about an image that names the file, where the image is part of it."""
        if not _is_embedded(self.item("images", index)):
            return extended(error, f"; {self.path.name} names it{OR_WITHOUT}")
        _, _, reason = str(error).partition(f"{_EMBEDDED}{index}.")
        return InputError(f"image {index} {reason.partition(': ')[2]}", self.path)

    def _place(self, texture: Texture, use: Json, placement: Placement, lose: Note) -> Texture:
        """Return a texture as it lies on a surface, whose coordinates have been turned."""
        sampler = self.item("textures", use["index"]).get("sampler")
        sampler = {} if sampler is None else self.item("samplers", sampler)
        wraps = [sampler.get(key, REPEAT) for key in ("wrapS", "wrapT")]
        if unknown := {*map(shown, wraps)} - {*map(str, (CLAMP, MIRROR, REPEAT))}:
            lose(f"wrap mode {listed(sorted(unknown))}, which is read as repeat,")
        own = Placement.of(use)
        if own != placement and (
            own.coordinates != placement.coordinates or own.rotation or placement.rotation
        ):
            lose("texture coordinates of a further texture")
        if not placement.rotation:
            (s, _, u), (_, t, v) = replace(own, rotation=0.0).matrix.tolist()
            texture = replace(texture, scale=(s, t), offset=(u, v))
        clamp, is_nearest = (
            (wraps[0] == CLAMP, wraps[1] == CLAMP),
            sampler.get("magFilter") == NEAREST,
        )
        texture = replace(texture, clamp=clamp, nearest=is_nearest)
        return texture.mirrored(wraps[0] == MIRROR, wraps[1] == MIRROR)


def _is_embedded(image: Json) -> bool:
    return "uri" not in image or bool(image["uri"].startswith("data:"))
