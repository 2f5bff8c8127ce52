"""Ray maps: a ray for each pixel, in NPZ or OpenEXR files, read, checked and written."""

from __future__ import annotations

import zipfile
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.scene.images import read_channels

Rays = NDArray[np.float64]
CHANNELS = tuple(f"{part}.{axis}" for part in ("origin", "direction") for axis in "XYZ")
"""Channels of an OpenEXR file."""
_NAME = "rays"
"""The array of an NPZ file."""
_LARGEST = 1e30


def read_rays(path: str | PathLike[str]) -> Rays:
    """Read rays, (H, W, 6), from NPZ or OpenEXR.

    Raises
    ------
    InputError : the file cannot be read, or does not hold rays
    """
    path = Path(path)
    if not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    values = _read_exr(path) if path.suffix.lower() == ".exr" else _read_npz(path)
    return check_rays(values, str(path))


def check_rays(values: Any, label: str) -> Rays:
    """Return rays as read-only (H, W, 6) float64.

    Raises
    ------
    InputError : the shape is another, a number is not finite or above 1e30, or a direction is zero
    """
    try:
        is_checked = isinstance(values, np.ndarray) and not values.flags.writeable
        rays = np.array(values, np.float64, order="C", copy=None if is_checked else True)
    except (ValueError, TypeError):
        raise InputError(f"{label} is not an array of numbers; give (H, W, 6)") from None
    if rays.ndim != 3 or rays.shape[2] != 6 or not rays.size:
        raise InputError(f"{label} has shape {rays.shape}; give (H, W, 6), origin and direction")
    bad = ~(np.abs(rays) <= _LARGEST).all(axis=2)
    if bad.any():
        row, column = (int(index) for index in np.argwhere(bad)[0])
        raise InputError(
            f"{label} has a ray at row {row}, column {column} that is not finite; give six numbers "
            f"up to {_LARGEST:g}"
        )
    none = (rays[..., 3:] == 0.0).all(axis=2)
    if none.any():
        row, column = (int(index) for index in np.argwhere(none)[0])
        raise InputError(
            f"{label} has no direction at row {row}, column {column}; give every pixel one"
        )
    rays.flags.writeable = False
    return rays


def save_rays(rays: Any, path: str | PathLike[str]) -> None:
    """Write rays as NPZ."""
    np.savez_compressed(path, rays=np.asarray(rays))


def _read_npz(path: Path) -> Any:
    try:
        with np.load(path, allow_pickle=False) as file:
            if isinstance(file, np.ndarray) or _NAME not in file:
                raise InputError(f"has no array {_NAME!r}; save it as NPZ with this name", path)
            return file[_NAME]
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("is not an NPZ file; save it again", path) from None


def _read_exr(path: Path) -> Any:
    channels = read_channels(path)
    pixels, names = channels.pixels, channels.names
    missing = [name for name in CHANNELS if name.lower() not in names]
    if missing:
        raise InputError(f"has no channel {missing[0]}; give {', '.join(CHANNELS)}", path)
    return pixels[..., [names.index(name.lower()) for name in CHANNELS]]
