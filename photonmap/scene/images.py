"""Read the images of textures, masks and environments, in linear values."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming, naming_file, warn
from photonmap.kernels.core.color import LUMINANCE
from photonmap.runtime.bounds import check_unpacked, refuse_large
from photonmap.runtime.terminal import quiet_libraries
from photonmap.runtime.wording import brief, listed, shown
from photonmap.scene.image_headers import (
    FLOATS,
    PLAIN,
    PNG,
    RADIANCE,
    RAMP,
    TIFF,
    ColorSpace,
    Header,
    as_rgbe,
    png_space,
    radiance_header,
    read_header,
    tiff_space,
    turned,
    unreadable,
)
from photonmap.spectra.curves import Floats
from photonmap.spectra.rgb_spaces import Transfer, decode_linear, decode_srgb, to_srgb
from photonmap.spectra.tables import read_bytes

if TYPE_CHECKING:
    import OpenImageIO

_ALPHA = ("a", "alpha")
_ALPHAS = {"ar", "ag", "ab"}  # OpenEXR's of each colour
_ASSOCIATED = ("openexr", "tiff")  # Formats whose colours alpha has multiplied unless they say so
_PREMULTIPLIED = 4  # Of attributes in TGA files
_LABS = (8, 9, 10)  # TIFF's PhotometricInterpretation of CIE L*a*b*
_CUBE = "CubeFace Environment"
OUTSIDE = 1e-3  # By which colours may lie outside of the gamut unnoticed, of their largest value
_LUMINANCE = np.array(LUMINANCE, np.float32)
LINEAR_TABLE: NDArray[np.float32] = (np.arange(256) / 255).astype(np.float32)
"""(256,) linear values of 8-bit linear texels."""


SRGB_TABLE: NDArray[np.float32] = decode_srgb(RAMP).astype(np.float32)
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
    """Read an image of OpenImageIO's as linear sRGB; grey is repeated, alpha left out.

    What the file states of its colours is applied: whether alpha has multiplied them, their
    encoding and primaries; or a warning says what is not. Unless it states others, integers are
    sRGB, and floats linear. An `InputError` says that the file is missing, damaged or not an image,
    its channels are neither RGB nor grey, or a value is negative or not finite.

    linear : of data, such as directions: values are as they are stored, whatever their space
    """
    return read_channels(path).image(linear)


def read_mask(path: str | PathLike[str], linear: bool = False) -> NDArray[np.float32]:
    """Read an image as a mask, (H, W): its alpha, which is linear, or else its luminance.

    As `read_texture` otherwise.
    """
    channels = read_channels(path)
    alpha = channels.alpha()
    return channels.luminance(linear) if alpha is None else alpha


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
        texels = channels.straight()
        texels = texels[..., [min(index, texels.shape[2] - 1)]]
        _check_values(channels.path, texels)
        return Image(np.ascontiguousarray(texels), False)

    return data


@dataclass(frozen=True, eq=False)
class Channels:
    """All channels of an image file, upright."""

    path: Path  # the file
    pixels: NDArray[Any]
    """(H, W, C) uint8; float32 of all other types, integers divided by their largest value"""
    names: list[str]  # of the channels, in lower case
    is_float: bool  # whether the file holds floats
    is_associated: bool = False  # whether alpha has multiplied colours
    space: ColorSpace = PLAIN  # of its colours
    sphere: str = ""  # what the file states that is not used where its picture is a sky

    def image(self, linear: bool = False) -> Image:
        """Return RGB, as `read_texture` does."""
        texels = self.straight()
        transfer, matrix = self._conversion(linear)
        if texels.dtype == np.uint8 and matrix is None and transfer in (decode_srgb, decode_linear):
            texels = np.repeat(texels, 3, axis=2) if texels.shape[2] == 1 else texels
            return Image(np.ascontiguousarray(texels), transfer is decode_srgb)
        _check_values(self.path, texels)
        texels = self._convert(texels, transfer, matrix)
        return Image(np.ascontiguousarray(texels, np.float32), False)

    def light(self) -> NDArray[np.float32]:
        """Return linear RGB that shines, (H, W, 3): as over black where alpha is below 1."""
        transfer, matrix = self._conversion()
        light = self._convert(self.straight(), transfer, matrix)
        alpha = None if self._is_opaque() else self.alpha()
        if alpha is None:
            return light
        count = np.count_nonzero(alpha < 1.0)
        warn(f"{self.path}: {count} pixels of light have an alpha below 1: it dims them")
        light = light * alpha[..., None]
        if self.is_associated:  # what shines without covering anything
            stored = self._convert(self._colors(), transfer, matrix)
            light = np.where(alpha[..., None] > 0.0, light, stored)
        return light

    def sky(self) -> NDArray[np.float32]:
        """Return `light` of a map of all directions, of whose shape nothing stated is used."""
        if self.sphere:
            warn(f"{self.path}: {self.sphere}; the map is read as a whole sphere all the same")
        return self.light()

    def luminance(self, linear: bool = False) -> NDArray[np.float32]:
        """Return a mask, (H, W): the luminance of RGB, whatever its primaries."""
        texels = self.straight()
        _check_values(self.path, texels)
        return self._convert(texels, self._conversion(linear)[0], None) @ _LUMINANCE

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

    def straight(self) -> NDArray[Any]:
        """Return stored RGB or grey, (H, W, 3 or 1), divided by alpha if that has multiplied it.

        Black below an alpha of 0 is unknown, and becomes the colour of the nearest pixel that
        covers something; light there stays as it is.
        """
        colors = self._colors()
        alpha = None if not self.is_associated or self._is_opaque() else self.alpha()
        if alpha is None:
            return colors
        values = LINEAR_TABLE[colors] if colors.dtype == np.uint8 else colors
        covers = alpha > 0.0
        values = np.divide(values, alpha[..., None], out=values.copy(), where=covers[..., None])
        unknown = ~covers & (values == 0.0).all(axis=2)
        if unknown.any() and covers.any():
            from scipy.ndimage import distance_transform_edt

            nearest = distance_transform_edt(~covers, return_distances=False, return_indices=True)
            values[unknown] = values[tuple(nearest[:, unknown])]
        return values if self.is_float else np.minimum(values, 1.0)

    def _colors(self) -> NDArray[Any]:
        colors = _find_colors(self.path, self.names)
        in_order = colors == [0, 1, 2]  # as a slice, which is copied fast or not at all
        return np.ascontiguousarray(self.pixels[..., slice(3) if in_order else colors])

    def has_other_primaries(self) -> bool:
        """Return whether the file states primaries that are not those of sRGB."""
        return self.space.primaries is not None and to_srgb(self.space.primaries) is not None

    def _is_opaque(self) -> bool:
        """Return whether alpha is 1 everywhere, or there is none."""
        alphas = [i for i, name in enumerate(self.names) if name in _ALPHA]
        most = 255 if self.pixels.dtype == np.uint8 else 1.0
        return not alphas or bool((self.pixels[..., alphas[0]] == most).all())

    def _conversion(self, linear: bool = False) -> tuple[Transfer, Floats | None]:
        """Return how stored values become linear, and the matrix to sRGB if one is needed."""
        if linear:
            return decode_linear, None
        if self.space.refused:
            raise InputError(self.space.refused, self.path)
        if self.space.lost:
            taken = f"; its colours are taken as {'linear ' * self.is_float}sRGB"
            is_usual = self.space.primaries is None and self.space.transfer is None
            warn(f"{self.path}: {'; '.join(self.space.lost)}{taken * is_usual}")
        usual = decode_linear if self.is_float else decode_srgb
        with naming_file(self.path):
            matrix = None if self.space.primaries is None else to_srgb(self.space.primaries)
        return self.space.transfer or usual, matrix

    def _convert(
        self, texels: NDArray[Any], transfer: Transfer, matrix: Floats | None
    ) -> NDArray[np.float32]:
        """Return linear sRGB, (H, W, 3), of stored RGB or grey."""
        if texels.dtype == np.uint8 and transfer is decode_srgb:
            values = SRGB_TABLE[texels]
        elif texels.dtype == np.uint8:
            channels = np.arange(texels.shape[2])
            table = transfer(np.repeat(RAMP[:, None], len(channels), axis=1)).astype(np.float32)
            values = table[texels, channels]
        else:
            values = transfer(texels).astype(np.float32, copy=False)
        if values.shape[2] == 1:
            return np.repeat(values, 3, axis=2)
        return values if matrix is None else self._clip(values @ matrix.T.astype(np.float32))

    def _clip(self, rgb: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return colours clipped to the gamut of sRGB, and say how many lay outside of it."""
        outside = rgb.min(axis=2) < -OUTSIDE * rgb.max(axis=2)
        most = np.inf if self.is_float else 1.0
        outside |= rgb.max(axis=2) > most + OUTSIDE
        if count := np.count_nonzero(outside):
            warn(f"{self.path}: {count} of its {outside.size} colours lie outside sRGB; clipped")
        return np.clip(rgb, 0.0, most)


def read_channels(path: str | PathLike[str], as_stored: bool = False) -> Channels:
    """Read all channels; a file that is missing, damaged or not an image is an `InputError`.

    as_stored : whatever the file states of its orientation and the space of its colours
    """
    path = Path(path)
    data = read_bytes(path)
    stated = png_space(path, data) if data.startswith(PNG) else None
    stated = tiff_space(data) if data.startswith(TIFF) else stated
    header = radiance_header(path, data) if data.startswith(RADIANCE) else None
    rgbe = as_rgbe(data) if header else None
    del data
    if rgbe is None:
        channels, found = _decode(path, path, stated)
    else:
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "image.hdr"
            copy.write_bytes(rgbe)
            channels, found = _decode(path, copy, stated)
    orientation, gain, space, sphere = header or found
    pixels = channels.pixels
    if gain is not None:
        pixels = pixels / gain.astype(np.float32)
    if as_stored:
        return replace(channels, pixels=pixels)
    return replace(channels, pixels=turned(pixels, orientation), space=space, sphere=sphere)


def _decode(path: Path, stored: Path, stated: ColorSpace | None) -> tuple[Channels, Header]:
    """Decode a file, and find what it states; errors name another path."""
    import OpenImageIO

    config = OpenImageIO.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    with quiet_libraries():
        file = OpenImageIO.ImageInput.open(str(stored), config)
    if file is None:
        raise unreadable(path, OpenImageIO.geterror())
    try:
        spec, kind = file.spec(), file.format_name()
        _check_spec(path, spec)
        texels = str(spec.format)
        as_type, size = ("uint8", 1) if texels == "uint8" else ("float", 4)
        check_unpacked(path, spec.width * spec.height * spec.nchannels * size)
        with quiet_libraries():
            pixels = file.read_image(0, 0, 0, spec.nchannels, as_type)
            error = file.geterror()
            if pixels is None or error:
                raise unreadable(path, error or "no pixels")
            are_several = kind in _ASSOCIATED and file.seek_subimage(1, 0)
        file.geterror()
        if are_several:
            warn(f"{path}: holds several images; the first is read")
        if kind == "tiff" and any(name.startswith("channel") for name in spec.channelnames):
            warn(f"{path}: does not say what its last channel is, such as alpha; it is left out")
    except MemoryError as error:
        refuse_large(error, path)
    finally:
        file.close()
    shape = (spec.height, spec.width, spec.nchannels)
    names = [name.lower() for name in spec.channelnames]
    channels = Channels(
        path, pixels.reshape(shape), names, texels in FLOATS, _is_associated(spec, kind)
    )
    return channels, read_header(path, spec, kind, stated)


def _is_associated(spec: OpenImageIO.ImageSpec, kind: str) -> bool:
    """Return whether alpha has multiplied the colours of a file."""
    if kind == "targa":
        return spec.get_int_attribute("targa:alpha_type") == _PREMULTIPLIED
    return kind in _ASSOCIATED and not spec.get_int_attribute("oiio:UnassociatedAlpha")


def _check_spec(path: Path, spec: OpenImageIO.ImageSpec) -> None:
    """Refuse deep, empty and cropped images, and colours of another kind."""
    window = (spec.x, spec.y, spec.width, spec.height, spec.depth)
    full = (spec.full_x, spec.full_y, spec.full_width, spec.full_height, 1)
    if min(spec.width, spec.height, spec.nchannels) < 1:
        raise InputError("has no pixels; save it again", path)
    if spec.deep:
        raise InputError("is a deep image; save it flattened", path)
    if window != full:
        message = f"holds {spec.width}x{spec.height} pixels of a larger or smaller picture"
        raise InputError(f"{message}; save the whole picture", path)
    if spec.get_string_attribute("textureformat") == _CUBE:
        raise InputError("shows the faces of a cube; save it by latitude and longitude", path)
    if spec.get_int_attribute("tiff:PhotometricInterpretation") in _LABS:
        raise InputError("holds CIE L*a*b*; save it as RGB", path)
    if _ALPHAS & {name.lower() for name in spec.channelnames}:
        raise InputError("has an alpha for each colour; save it with one", path)


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

    Floating-point pixels are linear, integers are sRGB, unless the file states other colours.
    Where it has alpha, it shines as over black. An `InputError` says that it cannot be read, is not
    twice as wide as high, lacks red, green or blue, or has a value that is negative or not finite.
    """
    if not Path(path).is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    channels = read_channels(path)
    missing = [name for name in "rgb" if name not in channels.names]
    if missing:
        raise InputError(f"has no channel {missing[0].upper()}; give an image in RGB", path)
    return check_panorama(channels.sky(), str(path))


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
