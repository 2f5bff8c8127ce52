"""Buffers as layers of one OpenEXR image in linear sRGB, as compositors read them."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError

LAYER = "photonmap"
"""Name of the layer whose passes the buffers are."""
COMBINED, DEPTH = "Combined", "Depth"
"""What compositors call the picture and its depth."""
_NAMES = {"radiance": COMBINED, "depth": DEPTH}
_CHANNELS = {1: ("Z",), 3: ("X", "Y", "Z")}


def write_layers(
    colors: Mapping[str, NDArray[Any]],
    others: Mapping[str, NDArray[Any]],
    path: str | PathLike[str],
) -> None:
    """Write FILE.exr in one part, with channels named as in "photonmap.direct.R", float32.

    The radiance is called Combined, and has `coverage` as its alpha; depth is called Depth.

    Parameters
    ----------
    colors : buffers in linear sRGB, (H, W, 3)
    others : buffers without a colour, (H, W) or (H, W, 3)
    path : FILE.exr

    Raises
    ------
    InputError
        if the suffix is another one
    OSError
        if writing fails
    """
    import OpenImageIO

    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise InputError("layers are written as OpenEXR; write FILE.exr", path)
    channels: dict[str, NDArray[Any]] = {}
    for name, image in {**colors, **others}.items():
        planes = image.reshape(*image.shape[:2], -1)
        letters = ("R", "G", "B") if name in colors else _CHANNELS[planes.shape[-1]]
        for letter, plane in zip(letters, np.moveaxis(planes, -1, 0), strict=True):
            channels[f"{LAYER}.{_pass_name(name)}.{letter}"] = plane
    if "radiance" in colors and "coverage" in others:
        channels[f"{LAYER}.{COMBINED}.A"] = others["coverage"]
    height, width = next(iter(channels.values())).shape
    spec = OpenImageIO.ImageSpec(width, height, len(channels), OpenImageIO.FLOAT)
    spec.channelnames = tuple(channels)
    spec.attribute("compression", "zip")
    path.parent.mkdir(parents=True, exist_ok=True)
    file = OpenImageIO.ImageOutput.create("exr")
    assert file is not None
    pixels = np.stack([plane.astype(np.float32) for plane in channels.values()], axis=-1)
    done = file.open(str(path), spec) and file.write_image(pixels)
    if not (done and file.close()):
        raise OSError(f"cannot write {path.name}: {file.geterror()}")


def _pass_name(name: str) -> str:
    """Return what a buffer is called: dots would separate layers."""
    return _NAMES.get(name, name.replace(".", "_"))
