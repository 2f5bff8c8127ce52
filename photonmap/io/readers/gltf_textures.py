"""Read the textures of glTF files: images in files, in buffers and in data URIs."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Note, read_embedded
from photonmap.io.readers.registry import OR_WITHOUT, MissingTextures, extended
from photonmap.runtime.files import named_image
from photonmap.scene.images import Channels, Image, read_channels
from photonmap.scene.textures import Texture
from photonmap.spectra.curves import Floats

CLAMP, MIRROR = 33071, 33648  # Values of a sampler's wrapS and wrapT; they repeat by default
_TRANSFORM = "KHR_texture_transform"
_EMBEDDED = "photonmap_image_"  # How the names of files begin that embedded images are decoded from
Json = Mapping[str, Any]
Item = Callable[[str, int], dict[str, Any]]


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


UNMOVED = Placement()


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
    item: Item  # returns an item of a top-level array, by its name and index
    view: Callable[[int], bytes | memoryview]  # returns the bytes of a buffer view
    missing: MissingTextures  # what becomes of an image that cannot be read
    lost: list[str] = field(default_factory=list)  # images that could not be read
    _known: dict[tuple[int, Callable[[Channels], Any]], Any] = field(default_factory=dict)
    _last: tuple[int, Channels] | None = None

    def texture(
        self, use: Json, channel: Callable[[Channels], Image], placement: Placement, lose: Note
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
        if not _is_embedded(image):
            return read_channels(named_image(self.path.parent, unquote(image["uri"])))
        data: bytes | memoryview
        if "uri" in image:
            data = base64.b64decode(image["uri"].partition(",")[2], validate=True)
        else:
            data = self.view(image["bufferView"])
        kind = image.get("mimeType", "image/png")[6:]
        return read_embedded(data, f"{_EMBEDDED}{index}.{kind}")

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
        wraps = sampler.get("wrapS"), sampler.get("wrapT")
        if wraps.count(CLAMP) == 1:
            lose("textures that are clamped in one direction")
        own = Placement.of(use)
        if own != placement and (
            own.coordinates != placement.coordinates or own.rotation or placement.rotation
        ):
            lose("texture coordinates of a further texture")
        if not placement.rotation:
            (s, _, u), (_, t, v) = replace(own, rotation=0.0).matrix.tolist()
            texture = replace(texture, scale=(s, t), offset=(u, v))
        texture = replace(texture, clamp=wraps.count(CLAMP) == 2)
        return texture.mirrored(wraps[0] == MIRROR, wraps[1] == MIRROR)


def _is_embedded(image: Json) -> bool:
    return "uri" not in image or bool(image["uri"].startswith("data:"))
