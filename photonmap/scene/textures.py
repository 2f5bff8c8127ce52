"""Textures: images on surfaces, shared where one file is used several times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.wording import shown
from photonmap.scene.images import LINEAR_TABLE, Image, as_texels, read_mask, read_texture
from photonmap.spectra.curves import Color, Spectrum

Triple = tuple[float, float, float]
FARTHEST = 1e9
"""Largest texture coordinate, scale and offset whose texel indices kernels can represent."""
_PLACEMENT = (
    ("scale", 2, -FARTHEST, FARTHEST, f"two numbers within ±{FARTHEST:g}"),
    ("offset", 2, -FARTHEST, FARTHEST, f"two numbers within ±{FARTHEST:g}"),
    ("factor", 3, 0.0, np.finfo(np.float64).max, "three finite numbers from 0"),
)
"""How many numbers say how a texture lies and what multiplies it, and between which they are."""
ROWS = 256  # Rows of an image summed at a time, so that temporary arrays stay small


@dataclass(frozen=True)
class Texture:
    """An image on a surface, interpolated bilinearly between the centres of its texels, or not.

    Its lower left corner lies at texture coordinates (0, 0), its upper right one at (1, 1); it is
    looked up at `scale` · (u, v) + `offset`. As a reflectance or emission it is linear RGB, which
    becomes a spectrum as other RGB does; as an opacity or a roughness it is its luminance.

    Parameters
    ----------
    image : its texels
    scale, offset : of texture coordinates
    clamp : whether its edge texels extend beyond the unit square, or whether along u and along v;
        otherwise it repeats
    factor : multiplies linear red, green and blue
    nearest : whether each texel has one colour up to its edges, without interpolation

    Raises
    ------
    InputError : the image is an array or a file, or a number is not finite or out of range
    """

    image: Image
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool | tuple[bool, bool] = False
    factor: Triple = (1.0, 1.0, 1.0)
    nearest: bool = False

    def __post_init__(self) -> None:
        """Refuse another kind of image, and numbers by which texels cannot be found."""
        if not isinstance(self.image, Image):
            raise InputError(
                f"a texture cannot be made of {shown(self.image)} directly; "
                "use photonmap.Texture.of for an array, Texture.read for a file"
            )
        for name, count, low, high, remedy in _PLACEMENT:
            value = getattr(self, name)
            try:
                numbers = np.array(value, np.float64)
            except (TypeError, ValueError):
                numbers = np.empty(0)
            if numbers.shape != (count,) or not ((numbers >= low) & (numbers <= high)).all():
                raise InputError(f"a texture's {name} is {shown(value)}; give {remedy}")
        if np.shape(self.clamp) not in ((), (2,)):
            remedy = "give True or False, or one of them for u and one for v"
            raise InputError(f"a texture's clamp is {shown(self.clamp)}; {remedy}")
        along, up = self.clamps
        object.__setattr__(self, "clamp", along if along == up else (along, up))

    @property
    def clamps(self) -> tuple[bool, bool]:
        """Whether it is clamped along u, and along v."""
        along, up = np.broadcast_to(self.clamp, 2).tolist()
        return bool(along), bool(up)

    @classmethod
    def read(cls, path: str | PathLike[str], linear: bool = False, **mapping: Any) -> Texture:
        """Read an image; textures of the same file share it.

        Parameters
        ----------
        path : a file that OpenImageIO reads
        linear : whether integers are linear instead of sRGB; floats always are
        mapping : scale, offset, clamp, factor, nearest

        Raises
        ------
        InputError : the file cannot be read
        """
        return cls(shared_image(path, linear), **mapping)

    @classmethod
    def of(cls, texels: Any, srgb: bool = True, **mapping: Any) -> Texture:
        """Make a texture from an array.

        Parameters
        ----------
        texels : (H, W), (H, W, 1) or (H, W, 3), top row first; uint8, or linear
            numbers
        srgb : whether uint8 texels are encoded in sRGB
        mapping : scale, offset, clamp, factor, nearest

        Raises
        ------
        InputError : they are no such array
        """
        if isinstance(texels, str | PathLike):
            raise InputError(f"{shown(texels)} is not an array; read it by photonmap.Texture.read")
        array = as_texels(texels)
        array = array[..., None] if array.ndim == 2 else array
        if array.dtype != np.uint8:
            return cls(Image(np.ascontiguousarray(array, np.float32), False), **mapping)
        return cls(Image(np.ascontiguousarray(array), srgb), **mapping)

    def mirrored(self, across: bool, up: bool) -> Texture:
        """Return it repeating with every other copy mirrored, from left to right or upside down.

        Parameters
        ----------
        across, up : whether it is mirrored along u and along v; where not, it stays as it is
        """
        texels, (s, t), (u, v) = self.image.texels, self.scale, self.offset
        if across:
            texels, s, u = np.concatenate([texels, texels[:, ::-1]], axis=1), s / 2, u / 2
        if up:
            texels, t, v = np.concatenate([texels[::-1], texels], axis=0), t / 2, v / 2
        if not (across or up):
            return self
        image = Image(texels, self.image.srgb)
        clamp = self.clamps[0] and not across, self.clamps[1] and not up
        return replace(self, image=image, scale=(s, t), offset=(u, v), clamp=clamp)

    @property
    def values(self) -> NDArray[Any]:
        """What its texels hold, (H, W, C)."""
        return self.image.texels

    @cached_property
    def mean(self) -> Triple:
        """Mean linear RGB over the image."""
        texels, table = self.values, self.image.table.astype(np.float64)
        total = np.zeros(texels.shape[2])
        for start in range(0, len(texels), ROWS):
            part = texels[start : start + ROWS]
            if part.dtype == np.uint8:
                for channel in range(len(total)):
                    count = np.bincount(part[..., channel].ravel(), minlength=256)
                    total[channel] += count @ table
            else:
                total += part.sum(axis=(0, 1), dtype=np.float64)
        return self._triple(total / (texels.shape[0] * texels.shape[1]))

    @property
    def color(self) -> Color:
        """Its mean over the image."""
        return self.mean

    @cached_property
    def largest(self) -> float:
        """The largest linear value."""
        most = self.values.max(axis=0).max(axis=0)  # over both at once takes ten times as long
        return max(self._triple(self.image.table[most] if most.dtype == np.uint8 else most))

    def _triple(self, channels: NDArray[Any]) -> Triple:
        red, green, blue = (np.ones(3) * channels * self.factor).tolist()
        return red, green, blue


Paint = Color | Texture  # What a material's reflectance or emission may be: a colour or a texture


def is_black(color: Paint) -> bool:
    """Return whether a colour or a texture is 0 everywhere."""
    if isinstance(color, Texture):
        return color.largest == 0.0
    if isinstance(color, float | tuple):  # asked of all materials many times
        return not (any(color) if isinstance(color, tuple) else color)
    return not np.any(color.values if isinstance(color, Spectrum) else color)


def mean_color(color: Paint) -> Color:
    """Return the mean of a texture; any other colour unchanged."""
    return color.color if isinstance(color, Texture) else color


def mean_number(value: float | Texture) -> float:
    """Return the mean of a texture of numbers, such as opacities; a number unchanged."""
    if isinstance(value, Texture):
        return float(np.dot(LUMINANCE, value.mean))
    return value


def lie_alike(one: object, other: object) -> bool:
    """Return whether two textures lie alike on a surface; what is no texture lies as any does."""
    if not (isinstance(one, Texture) and isinstance(other, Texture)):
        return True
    return _placed(one) == _placed(other)


def _placed(texture: Texture) -> tuple[Any, ...]:
    return texture.scale, texture.offset, texture.clamp, texture.nearest


def resized(texture: Texture, shape: Sequence[int]) -> NDArray[np.float32]:
    """Return linear RGB at the centres of as many texels as a shape says, (H, W, 3)."""
    values = texture.image.linear(slice(None), slice(None))
    for axis, count in enumerate(shape):
        size = values.shape[axis]
        if size == count:
            continue
        place = (np.arange(count) + 0.5) * size / count - 0.5
        low = np.floor(place)
        near = np.array((low, low + 1), np.int64)
        near = np.clip(near, 0, size - 1) if texture.clamps[1 - axis] else near % size
        weight = (place - low).astype(np.float32).reshape(-1, *(1,) * (2 - axis))
        weight = (weight >= 0.5).astype(np.float32) if texture.nearest else weight
        first, second = (np.take(values, rows, axis) for rows in near)
        values = first + weight * (second - first)
    return np.asarray(values * np.array(texture.factor, np.float32))


_images: WeakValueDictionary[tuple[Any, ...], Image] = WeakValueDictionary()


def shared_image(path: str | PathLike[str], linear: bool = False, mask: bool = False) -> Image:
    """Read a texture or a mask, unless the same file has been read before and is in use."""
    path = Path(path)
    try:
        state = path.stat()
        key: tuple[Any, ...] | None
        key = (path.resolve(), state.st_mtime_ns, state.st_size, linear, mask)
    except (OSError, ValueError):
        key = None
    image = None if key is None else _images.get(key)
    if image is None:
        image = _as_mask(read_mask(path, linear)) if mask else read_texture(path, linear)
        if key is not None:
            _images[key] = image
    return image


def _as_mask(values: NDArray[np.float32]) -> Image:
    """Return an image of one channel, in bytes if they represent it exactly."""
    count = np.rint(np.minimum(values, 1.0) * 255).astype(np.uint8)
    if np.array_equal(LINEAR_TABLE[count], values):
        return Image(count[..., None], False)
    return Image(np.ascontiguousarray(values[..., None]), False)


def check_texture(texture: Texture, most: float = np.inf) -> None:
    """Refuse an image with values outside [0, most]."""
    texels = texture.values
    if texels.dtype == np.float32 and not (texels.min() >= 0.0 and texels.max() < np.inf):
        raise InputError(
            "the texture has values that are negative or not finite; give finite values from 0"
        )
    if texture.largest > most:
        remedy = f"keep it between 0 and 1{rescaling(texture.largest)}"
        raise InputError(f"the texture reaches {texture.largest:.6g}; {remedy}")


def rescaling(largest: float) -> str:
    """Return the advice to divide what seems to be integers of 8 or 16 bits; "" for others."""
    for bits in (8, 16):
        if 2.0 <= largest < 1 << bits:
            return f"; divide what is of {bits} bits by {(1 << bits) - 1}"
    return ""
