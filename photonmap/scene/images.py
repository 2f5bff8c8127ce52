"""Read the images of textures, masks and environments, in linear values."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.bounds import check_unpacked, refuse_large
from photonmap.runtime.terminal import quiet_libraries
from photonmap.runtime.wording import brief, listed, shown
from photonmap.spectra.curves import Floats
from photonmap.spectra.tables import read_bytes

if TYPE_CHECKING:
    import OpenImageIO

_FLOATS = ("half", "float", "double")
_ALPHA = ("a", "alpha")
_PNG = b"\x89PNG\r\n\x1a\n"
_LUMINANCE = np.array(LUMINANCE, np.float32)
LINEAR_TABLE: NDArray[np.float32] = (np.arange(256) / 255).astype(np.float32)
"""(256,) linear values of 8-bit linear texels."""


def decode_srgb(values: NDArray[Any]) -> NDArray[Any]:
    """Return the linear values of sRGB-encoded ones in [0, 1], IEC 61966-2-1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode_srgb(linear: Floats) -> Floats:
    """Return the sRGB encoding of linear values in [0, 1], IEC 61966-2-1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


SRGB_TABLE: NDArray[np.float32] = decode_srgb(np.arange(256) / 255).astype(np.float32)
"""(256,) linear values of 8-bit sRGB."""


@dataclass(frozen=True, eq=False, repr=False)
class Image:
    """A texture in memory; bytes are decoded when they are looked up.

    Without texels, or with those of another shape or type, it is an `InputError`.
    """

    texels: NDArray[np.uint8] | NDArray[np.float32]
    """(H, W, 3) uint8 or float32, RGB, or (H, W, 1) grey, top row first; float32 is linear"""
    srgb: bool  # whether uint8 texels are encoded in sRGB

    __repr__ = brief

    def __post_init__(self) -> None:
        """Refuse what kernels would misread."""
        shape, kind = np.shape(self.texels), getattr(self.texels, "dtype", type(self.texels))
        if len(shape) != 3 or shape[2] not in (1, 3) or 0 in shape:
            has_alpha = len(shape) == 3 and shape[2] in (2, 4)
            remedy = "; leave alpha out: a material has its own" if has_alpha else ""
            wanted = "(H, W, 3) or (H, W, 1)"
            raise InputError(f"the texture's texels must be {wanted}, not {shape}{remedy}")
        if kind not in (np.uint8, np.float32):
            raise InputError(f"the texture's texels must be uint8 or float32, not {kind}")

    @property
    def table(self) -> NDArray[np.float32]:
        """The linear values of uint8 texels, (256,)."""
        return SRGB_TABLE if self.srgb else LINEAR_TABLE

    def linear(self, rows: Any, columns: Any) -> NDArray[np.float32]:
        """Return the linear RGB of pixels by indices, arrays of them, or slices."""
        texels: NDArray[Any] = self.texels[rows, columns]
        return self.table[texels] if texels.dtype == np.uint8 else texels


def as_texels(values: Any) -> NDArray[Any]:
    """Return an array of texels: uint8, or linear numbers of another type.

    Refuse what is no array of numbers, and integers of 16 bits, whose scale is unknown.
    """
    try:
        texels = np.asarray(values)
    except ValueError:
        texels = np.empty(0, object)
    if texels.dtype.kind not in "buif":
        raise InputError(f"{shown(values)} is not an array of numbers; give (H, W, 3) of them")
    if texels.dtype == np.uint16:
        raise InputError("texels must not be uint16; divide by 65535, and decode those in sRGB")
    return texels


def read_texture(path: str | PathLike[str], linear: bool = False) -> Image:
    """Read an image of OpenImageIO's as RGB; grey is repeated, alpha is ignored.

    Integers are sRGB unless `linear`; floats always are linear. An `InputError` says that the file
    is missing, damaged or not an image, its channels are neither RGB nor grey, or a value is
    negative or not finite.
    """
    return read_channels(path).image(linear)


def read_mask(path: str | PathLike[str], linear: bool = False) -> NDArray[np.float32]:
    """Read an image as a mask, (H, W): its alpha, which is linear, or else its luminance.

    As `read_texture` otherwise.
    """
    channels = read_channels(path)
    alpha = channels.alpha()
    if alpha is None:
        return channels.image(linear).linear(slice(None), slice(None)) @ _LUMINANCE
    return alpha


def write_image(pixels: NDArray[Any], path: str | PathLike[str], names: Sequence[str] = ()) -> None:
    """Write (H, W, C) uint16, or as 32-bit floats, in the format of the suffix; or `OSError`.

    Floats are linear. Equal images are equal files, for their date is left out.

    names : of the channels; "R", "G", "B" and so on by default
    """
    import OpenImageIO

    height, width, channels = pixels.shape
    kind = np.uint16 if pixels.dtype == np.uint16 else np.float32
    written = OpenImageIO.UINT16 if kind == np.uint16 else OpenImageIO.FLOAT
    spec = OpenImageIO.ImageSpec(width, height, channels, written)
    if names:
        spec.channelnames = tuple(names)
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "")
    file = OpenImageIO.ImageOutput.create(str(path))
    opened = file and file.open(str(path), spec)
    texels = np.ascontiguousarray(pixels, kind)
    if not (file and opened and file.write_image(texels) and file.close()):
        reason = file.geterror() if file else OpenImageIO.geterror()
        raise OSError(f"cannot write {Path(path).name}: {reason}")


def _channel(index: int) -> Callable[[Channels], Image]:
    """Return a method that returns one of three channels of linear data, or the only one."""

    def data(channels: Channels) -> Image:
        colors = _find_colors(channels.path, channels.names)
        texels = channels.pixels[..., [colors[min(index, len(colors) - 1)]]]
        _check_values(channels.path, texels)
        return Image(np.ascontiguousarray(texels), False)

    return data


@dataclass(frozen=True, eq=False)
class Channels:
    """All channels of an image file."""

    path: Path  # the file
    pixels: NDArray[Any]
    """(H, W, C) uint8; float32 of all other types, integers divided by their largest value"""
    names: list[str]  # of the channels, in lower case
    is_float: bool  # whether the file holds floats

    def image(self, linear: bool = False) -> Image:
        """Return RGB, as `read_texture` does."""
        texels = self.pixels[..., _find_colors(self.path, self.names)]
        if texels.shape[2] == 1:
            texels = np.repeat(texels, 3, axis=2)
        if texels.dtype == np.uint8:
            return Image(np.ascontiguousarray(texels), not linear)
        _check_values(self.path, texels)
        if not (linear or self.is_float):
            texels = decode_srgb(texels)
        return Image(np.ascontiguousarray(texels, np.float32), False)

    def alpha(self) -> NDArray[np.float32] | None:
        """Return the channel that is alpha, (H, W); None if there is none."""
        alpha = next((i for i, name in enumerate(self.names) if name in _ALPHA), None)
        if alpha is None:
            return None
        values = self.pixels[..., alpha]
        if values.dtype == np.uint8:
            return LINEAR_TABLE[values]
        _check_values(self.path, values[..., None])
        return np.ascontiguousarray(values)

    def opacity(self) -> Image:
        """Return alpha, 1 if there is none."""
        alpha = self.alpha()
        texels = np.ones((1, 1), np.float32) if alpha is None else alpha
        return Image(np.ascontiguousarray(texels[..., None], np.float32), False)

    def data(self) -> Image:
        """Return linear RGB."""
        return self.image(linear=True)

    red, green, blue = _channel(0), _channel(1), _channel(2)


def read_channels(path: str | PathLike[str]) -> Channels:
    """Read all channels; a file that is missing, damaged or not an image is an `InputError`."""
    import OpenImageIO

    path = Path(path)
    data = read_bytes(path)
    if data.startswith(_PNG):
        _check_png(path, data)
    del data
    config = OpenImageIO.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    with quiet_libraries():
        file = OpenImageIO.ImageInput.open(str(path), config)
    if file is None:
        raise _unreadable(path, OpenImageIO.geterror())
    try:
        spec = file.spec()
        _check_spec(path, spec)
        kind = str(spec.format)
        size = 1 if kind == "uint8" else 4
        check_unpacked(path, spec.width * spec.height * spec.nchannels * size)
        with quiet_libraries():
            pixels = file.read_image(
                0, 0, 0, spec.nchannels, "uint8" if kind == "uint8" else "float"
            )
        error = file.geterror()
        if pixels is None or error:
            raise _unreadable(path, error or "no pixels")
    except MemoryError as error:
        refuse_large(error, path)
    finally:
        file.close()
    shape = (spec.height, spec.width, spec.nchannels)
    names = [name.lower() for name in spec.channelnames]
    return Channels(path, pixels.reshape(shape), names, kind in _FLOATS)


def _unreadable(path: Path, reason: str) -> InputError:
    reason = " ".join(reason.split())[:100]
    message = f"cannot be read as an image ({reason})"
    return InputError(f"{message}; save it again as PNG, JPEG, TIFF, EXR or HDR", path)


def _check_spec(path: Path, spec: OpenImageIO.ImageSpec) -> None:
    """Refuse deep, empty and cropped images."""
    window = (spec.x, spec.y, spec.width, spec.height, spec.depth)
    full = (spec.full_x, spec.full_y, spec.full_width, spec.full_height, 1)
    if min(spec.width, spec.height, spec.nchannels) < 1:
        raise InputError("has no pixels; save it again", path)
    if spec.deep:
        raise InputError("is a deep image; save it flattened", path)
    if window != full:
        message = f"holds {spec.width}x{spec.height} pixels of a larger or smaller picture"
        raise InputError(f"{message}; save the whole picture", path)


def _check_png(path: Path, data: bytes) -> None:
    """Refuse a damaged PNG file, about which libpng would print to the standard error."""
    at, kind = len(_PNG), b""
    while kind != b"IEND":
        if at + 12 > len(data):
            raise _unreadable(path, "the PNG file is truncated")
        size, kind = struct.unpack_from(">I4s", data, at)
        end = at + 8 + size
        if data[end : end + 4] != struct.pack(">I", zlib.crc32(memoryview(data)[at + 4 : end])):
            raise _unreadable(path, f"the PNG file is damaged at byte {at}")
        at = end + 4


def _find_colors(path: Path, names: list[str]) -> list[int]:
    """Find R, G and B, or the one channel that is not alpha."""
    if {"r", "g", "b"} <= set(names):
        return [names.index(name) for name in "rgb"]
    others = [index for index, name in enumerate(names) if name not in _ALPHA]
    if len(others) != 1:
        raise InputError(f"has the channels {listed(names)}; save it as RGB or grey", path)
    return others


def _check_values(path: Path, texels: NDArray[np.float32]) -> None:
    """Refuse NaN, infinite and negative values."""
    bad = ~((texels >= 0) & (texels < np.inf))
    if bad.any():
        row, column, _ = index = tuple(np.argwhere(bad)[0])
        message = f"pixel in row {row}, column {column} has {texels[index]:g}"
        raise InputError(f"{message}; save finite values from 0", path)


def read_panorama(path: str | PathLike[str]) -> NDArray[np.float32]:
    """Read an image of any format that OpenImageIO knows as linear RGB, (H, 2H, 3) float32.

    Floating-point pixels are linear, integers are sRGB. An `InputError` says that it cannot be
    read, is not twice as wide as high, lacks red, green or blue, or has a value that is negative or
    not finite.
    """
    if not Path(path).is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    channels = read_channels(path)
    missing = [name for name in "rgb" if name not in channels.names]
    if missing:
        raise InputError(f"has no channel {missing[0].upper()}; give an image in RGB", path)
    rgb = channels.pixels[..., [channels.names.index(name) for name in "rgb"]]
    if rgb.dtype == np.uint8:
        rgb = rgb * np.float32(1.0 / 255.0)
    return check_panorama(rgb if channels.is_float else decode_srgb(rgb), str(path))


def save_panorama(image: str | PathLike[str] | ArrayLike, path: str | PathLike[str]) -> None:
    """Write a map, an array or that of another file, as OpenEXR, or raise `OSError`.

    What is not a map, or a file that cannot be read, is an `InputError`.
    """
    if isinstance(image, str | PathLike):
        write_image(read_panorama(image), path)
    else:
        write_image(check_panorama(image, "the map"), path)


def check_panorama(image: ArrayLike, owner: str) -> NDArray[np.float32]:
    """Return a map as (H, 2H, 3) float32; `InputError` names its owner otherwise.

    Texels of uint8 are sRGB, as those of files and textures are.
    """
    with naming(owner):
        texels = as_texels(image)
    values = SRGB_TABLE[texels] if texels.dtype == np.uint8 else texels.astype(np.float64)
    if values.ndim != 3 or values.shape[2] != 3:
        raise InputError(f"{owner}: is not a radiance map; give (height, 2 * height, 3) numbers")
    height, width, _ = values.shape
    if not 0 < 2 * height == width:
        raise InputError(f"{owner}: is {width}x{height}; give a map twice as wide as high")
    sound = (values >= 0.0) & (values <= np.finfo(np.float32).max)
    if not sound.all():
        row, column, channel = np.argwhere(~sound)[0]
        raise InputError(
            f"{owner}: pixel (row {row}, column {column}) is {values[row, column, channel]:g}; "
            f"give finite values from 0"
        )
    return np.ascontiguousarray(values, dtype=np.float32)
