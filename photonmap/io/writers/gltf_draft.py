"""A glTF file under construction: its JSON, its buffer and its textures, sRGB in PNG."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError, warn
from photonmap.io.png import encode_png
from photonmap.io.readers.gltf_textures import CLAMP
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import listed
from photonmap.scene.images import Image, encode_srgb
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture, Triple, mean_number

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
_SPECTRA = "the spectra of textures become their colours under D65"
_APART = "opacities that lie otherwise than the colour become their mean"
_RESIZED = "textures are enlarged to the size of another one in the same image"
_WHOLE = slice(None), slice(None)
_WHITE = Image(np.full((1, 1, 3), 255, np.uint8), True)


@dataclass
class TextureWriter:
    """Adds textures to a file, each image once."""

    draft: Draft  # the file
    _images: dict[Any, tuple[int, Triple]] = field(default_factory=dict)
    _textures: dict[tuple[int, bool], int] = field(default_factory=dict)
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
        elif _placement(color) != _placement(mask):
            self.draft.note(_APART, owner)
            return *self.color(color, owner), mean_number(mask)
        image, factor = self._image(color, mask, owner)
        return self._use(image, color), factor, 1.0

    def data(self, texture: Texture) -> Json:
        """Add a texture of numbers in linear RGB, in 8 bits if they hold it, or else in 16."""
        values = texture.image.linear(*_WHOLE).astype(np.float64)
        texels: NDArray[Any] = np.rint(255.0 * values).astype(np.uint8)
        if not np.allclose(texels / 255.0, values, rtol=0.0, atol=1e-6):
            texels = np.rint(65535.0 * values).astype(np.uint16)
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
        return np.dstack([texels, np.rint(65535.0 * alpha).astype(np.uint16)])

    def _use(self, image: int, texture: Texture) -> Json:
        key = image, texture.clamp
        if key not in self._textures:
            item: Json = {"source": image}
            if texture.clamp:
                sampler = {"wrapS": CLAMP, "wrapT": CLAMP}
                item["sampler"] = self.draft.add("samplers", sampler)
            self._textures[key] = self.draft.add("textures", item)
        use: Json = {"index": self._textures[key]}
        (s, t), (u, v) = texture.scale, texture.offset
        if (s, t, u, v) != (1.0, 1.0, 0.0, 0.0):
            transform = {"scale": [s, t], "offset": [u, 1.0 - t - v]}
            use["extensions"] = self.draft.use("KHR_texture_transform", transform)
        return use


def _placement(texture: Texture) -> tuple[Any, ...]:
    return texture.scale, texture.offset, texture.clamp


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
