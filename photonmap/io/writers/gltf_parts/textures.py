"""Textures of glTF files: sRGB in PNG, with opacity as alpha."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.io.png import encode_png
from photonmap.io.readers.gltf_parts.textures import CLAMP
from photonmap.io.writers.gltf_parts.draft import Draft
from photonmap.kernels.core.color import LUMINANCE
from photonmap.scene.images import Image, encode_srgb
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture, Triple, mean_number

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

    def color(
        self, texture: Texture, owner: str, most: float = 1.0
    ) -> tuple[dict[str, Any], Triple]:
        """Add a colour texture; return the JSON that names it, and a factor up to `most`."""
        if isinstance(texture, SpectralTexture):
            self.draft.note(_SPECTRA, owner)
        image, factor = self._image(texture, None, owner, most)
        return self._use(image, texture), factor

    def masked(
        self, color: Texture | None, mask: Texture, owner: str
    ) -> tuple[dict[str, Any], Triple, float]:
        """Add a texture of a colour, or of white, and of opacity.

        Returns
        -------
        The JSON that names it, and the factors of colour and opacity
        """
        if color is None:
            color = replace(mask, image=_WHITE, factor=(1.0, 1.0, 1.0))
        elif _placement(color) != _placement(mask):
            self.draft.note(_APART, owner)
            return *self.color(color, owner), mean_number(mask)
        image, factor = self._image(color, mask, owner)
        return self._use(image, color), factor, 1.0

    def data(self, texture: Texture) -> dict[str, Any]:
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

    def _use(self, image: int, texture: Texture) -> dict[str, Any]:
        """Return the JSON that names an image placed as a texture is."""
        key = image, texture.clamp
        if key not in self._textures:
            item: dict[str, Any] = {"source": image}
            if texture.clamp:
                sampler = {"wrapS": CLAMP, "wrapT": CLAMP}
                item["sampler"] = self.draft.add("samplers", sampler)
            self._textures[key] = self.draft.add("textures", item)
        use: dict[str, Any] = {"index": self._textures[key]}
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
    """Repeat texels until they fill a shape."""
    rows, columns = (
        np.arange(wanted) * there // wanted
        for wanted, there in zip(shape, texels.shape, strict=False)
    )
    return texels[rows[:, None], columns]
