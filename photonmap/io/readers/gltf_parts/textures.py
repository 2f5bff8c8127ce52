"""Read the textures of glTF files: images in files, in buffers and in data URIs."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.registry import MissingTextures
from photonmap.scene.images import read_alpha, read_channels
from photonmap.scene.textures import Texture, Triple, shared_image

CLAMP, MIRROR = 33071, 33648
"""Values of a sampler's wrapS and wrapT; they repeat by default."""
_TRANSFORM = "KHR_texture_transform"
Item = Callable[[str, int], dict[str, Any]]
Placement = dict[str, Any]


@dataclass
class Textures:
    """The textures of a file.

    Parameters
    ----------
    path : the file
    item : returns an item of a top-level array, by its name and index
    view : returns the bytes of a buffer view
    missing : what becomes of an image that cannot be read
    lost : images that could not be read
    """

    path: Path
    item: Item
    view: Callable[[int], bytes | memoryview]
    missing: MissingTextures
    lost: list[str] = field(default_factory=list)
    _known: dict[tuple[int, Callable[[Path], Any]], Any] = field(default_factory=dict)

    def color(self, use: Mapping[str, Any], lose: Callable[[str], None]) -> Texture | None:
        """Return a colour texture; None if it is missing, which is noted.

        Parameters
        ----------
        use : the JSON that names it
        lose : takes what is not simulated

        Raises
        ------
        InputError : its image cannot be read, and `missing` is "error"
        """
        image = self._read(use, shared_image)
        return None if image is None else Texture(image, **self._placement(use, lose))

    def opacity(
        self, use: Mapping[str, Any], factor: float, cutoff: float | None
    ) -> Texture | float:
        """Return a texture's alpha times a factor, or 0 and 1 below and above a cutoff."""
        mask = self._read(use, read_alpha)
        values = np.float32(factor) * (np.ones((1, 1), np.float32) if mask is None else mask)
        if cutoff is not None:
            values = (values >= cutoff).astype(np.float32)
        if (values == values[0, 0]).all():
            return float(values[0, 0])
        return Texture.of(values[..., None], **self._placement(use, lambda _: None))

    def means(self, use: Mapping[str, Any]) -> Triple:
        """Return the means of three channels of linear data; 1 if their image is missing."""
        means: Triple | None = self._read(use, _read_means)
        return means or (1.0, 1.0, 1.0)

    def _read(self, use: Mapping[str, Any], read: Callable[[Path], Any]) -> Any:
        """Return what a function makes of the image's file, once; None if it is missing."""
        texture = self.item("textures", use["index"])
        index = texture.get("source")
        if index is None:
            raise InputError("has textures other than PNG and JPEG; export those", self.path)
        if (index, read) not in self._known:
            self._known[index, read] = self._read_image(index, read)
        return self._known[index, read]

    def _read_image(self, index: int, read: Callable[[Path], Any]) -> Any:
        image = self.item("images", index)
        try:
            if "uri" in image and not image["uri"].startswith("data:"):
                return read(self.path.parent / unquote(image["uri"]))
            return self._read_embedded(index, image, read)
        except InputError:
            if self.missing == "error":
                raise
            self.lost.append(image.get("uri", f"image {index}")[:80])
            return None

    def _read_embedded(self, index: int, image: dict[str, Any], read: Callable[[Path], Any]) -> Any:
        """Return what a function makes of an image that is part of the file."""
        data: bytes | memoryview
        if "uri" in image:
            data = base64.b64decode(image["uri"].partition(",")[2], validate=True)
        else:
            data = self.view(image["bufferView"])
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"image_{index}.{image.get('mimeType', 'image/png')[6:]}"
            path.write_bytes(data)
            try:
                return read(path)
            except InputError as error:
                reason = str(error).rpartition(f"{path}: ")[2]
                raise InputError(f"image {index} {reason}", self.path) from None

    def _placement(self, use: Mapping[str, Any], lose: Callable[[str], None]) -> Placement:
        """Return how a texture lies on a surface, v counting upwards."""
        sampler = self.item("textures", use["index"]).get("sampler")
        sampler = {} if sampler is None else self.item("samplers", sampler)
        wraps = sampler.get("wrapS"), sampler.get("wrapT")
        if MIRROR in wraps:
            lose("mirrored textures")
        if wraps.count(CLAMP) == 1:
            lose("textures that are clamped in one direction")
        transform = use.get("extensions", {}).get(_TRANSFORM, {})
        if use.get("texCoord", 0) or transform.get("texCoord", 0):
            lose("further texture coordinates")
        if transform.get("rotation", 0.0):
            lose("rotation of textures")
        (s, t), (u, v) = transform.get("scale", (1.0, 1.0)), transform.get("offset", (0.0, 0.0))
        return {"scale": (s, t), "offset": (u, 1.0 - t - v), "clamp": wraps.count(CLAMP) == 2}


def _read_means(path: Path) -> Triple:
    """Return the means of three channels of linear data; of one channel, three times its mean."""
    pixels = read_channels(path)[0]
    largest = 255.0 if pixels.dtype == np.uint8 else 1.0
    means = pixels.mean(axis=(0, 1), dtype=np.float64) / largest
    red, green, blue = (float(means[min(channel, len(means) - 1)]) for channel in range(3))
    return red, green, blue
