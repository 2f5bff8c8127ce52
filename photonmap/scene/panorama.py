"""Radiance maps of the whole sphere: latitude-longitude images, read, checked and written."""

from __future__ import annotations

from contextlib import closing
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError, naming
from photonmap.scene.images import SRGB_TABLE, as_texels, decode_srgb, write_image


def read_panorama(path: str | PathLike[str]) -> NDArray[np.float32]:
    """Read an image of any format that OpenImageIO knows as linear RGB, (H, 2H, 3) float32.

    Floating-point pixels are linear, integers are sRGB.

    Raises
    ------
    InputError
        if it cannot be read, is not twice as wide as high, lacks red, green or blue, or has a
        value that is negative or not finite
    """
    import OpenImageIO

    if not Path(path).is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        reason = OpenImageIO.geterror().partition("\n")[0]
        raise InputError(f"cannot be read ({reason}); give an .exr, .hdr or .png", path)
    with closing(file):
        spec = file.spec()
        names = [name.upper() for name in spec.channelnames]
        missing = [name for name in ("R", "G", "B") if name not in names]
        if missing:
            raise InputError(f"has no channel {missing[0]}; give an image in RGB", path)
        _check_shape(spec.height, spec.width, str(path))
        pixels = file.read_image(0, 0, 0, spec.nchannels, OpenImageIO.FLOAT)
        if pixels is None:
            reason = file.geterror().partition("\n")[0]
            raise InputError(f"cannot be read ({reason}); save it again", path)
    rgb = np.asarray(pixels, np.float32)[..., [names.index(name) for name in ("R", "G", "B")]]
    if spec.format.basetype not in (OpenImageIO.HALF, OpenImageIO.FLOAT, OpenImageIO.DOUBLE):
        rgb = decode_srgb(rgb)
    return check_panorama(rgb, str(path))


def save_panorama(image: str | PathLike[str] | ArrayLike, path: str | PathLike[str]) -> None:
    """Write a map, an array or that of another file, as OpenEXR.

    Raises
    ------
    InputError : it is not a map, or its file cannot be read
    OSError : writing fails
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
    _check_shape(values.shape[0], values.shape[1], owner)
    sound = (values >= 0.0) & (values <= np.finfo(np.float32).max)
    if not sound.all():
        row, column, channel = np.argwhere(~sound)[0]
        raise InputError(
            f"{owner}: pixel (row {row}, column {column}) is {values[row, column, channel]:g}; "
            f"give finite values from 0"
        )
    return np.ascontiguousarray(values, dtype=np.float32)


def _check_shape(height: int, width: int, owner: str) -> None:
    if not 0 < 2 * height == width:
        raise InputError(f"{owner}: is {width}x{height}; give a map twice as wide as high")
