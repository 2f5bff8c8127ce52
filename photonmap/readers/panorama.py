"""Read maps of radiance all around: latitude-longitude images of any format."""

from __future__ import annotations

from contextlib import closing
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError


def read_panorama(path: str | PathLike[str]) -> NDArray[np.float32]:
    """Read an image of any format that OpenImageIO knows as linear RGB, (H, 2H, 3) float32.

    Floating-point pixels are linear as they stand, whole numbers are sRGB.

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
            raise InputError(f"cannot be read ({reason}); mend the file", path)
    rgb = np.asarray(pixels, np.float32)[..., [names.index(name) for name in ("R", "G", "B")]]
    if spec.format.basetype not in (OpenImageIO.HALF, OpenImageIO.FLOAT, OpenImageIO.DOUBLE):
        rgb = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return check_panorama(rgb, str(path))


def check_panorama(image: ArrayLike, owner: str) -> NDArray[np.float32]:
    """Return a map as (H, 2H, 3) float32; InputError names its owner if it is none."""
    try:
        values = np.asarray(image, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.ndim != 3 or values.shape[2] != 3:
        raise InputError(f"{owner}: is no map of radiance; give (height, 2 * height, 3) numbers")
    _check_shape(values.shape[0], values.shape[1], owner)
    sound = (values >= 0.0) & (values <= np.finfo(np.float32).max)
    if not sound.all():
        row, column, channel = np.argwhere(~sound)[0]
        raise InputError(
            f"{owner}: pixel (row {row}, column {column}) is {values[row, column, channel]:g}; "
            f"radiance is finite and not negative"
        )
    return np.ascontiguousarray(values, dtype=np.float32)


def _check_shape(height: int, width: int, owner: str) -> None:
    if not 0 < 2 * height == width:
        raise InputError(f"{owner}: is {width}x{height}; a map all around is twice as wide as high")
