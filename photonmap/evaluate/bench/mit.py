"""The data set of Grosse et al. 2009: photographs of objects with known reflectance and shading.

R. Grosse, M. K. Johnson, E. H. Adelson and W. T. Freeman, "Ground truth dataset and baseline
evaluations for intrinsic image algorithms", ICCV 2009. A folder for each object holds linear PNG
files of 16 bits: diffuse.png, shading.png, reflectance.png, mask.png and light01.png to
light10.png, the object in other lights.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.manifest import HEAD
from photonmap.errors import InputError
from photonmap.evaluate.bench.images import Kind, Shot, Truth, white_level
from photonmap.evaluate.bench.predictions import read_picture
from photonmap.evaluate.methods.method import View
from photonmap.evaluate.metrics.arrays import Floats, Mask
from photonmap.runtime.wording import listed

_NEEDED = ("diffuse.png", "shading.png", "reflectance.png", "mask.png")
_PARTS = "light*.png"


def is_mit(folder: Path) -> bool:
    """Return whether a folder has objects in MIT's layout, and is no data set of photonmap."""
    return not (folder / HEAD).exists() and any(folder.glob(f"*/{_NEEDED[0]}"))


class MitSet:
    """The objects of a folder.

    `InputError` if there is none, one lacks a file, or a link leads out of the folder.
    """

    def __init__(self, folder: Path) -> None:
        found = sorted(path.parent for path in folder.glob(f"*/{_NEEDED[0]}"))
        if not found:
            raise InputError(
                f"has no OBJECT/{_NEEDED[0]}; choose the folder of MIT's objects", folder
            )
        for path in found:
            files = [inside(folder, f"{path.name}/{name}") for name in _NEEDED]
            if missing := [file.name for file in files if not file.is_file()]:
                raise InputError(f"has no {listed(missing, 4)}; unpack the data set again", path)
        self._folders = found

    def __len__(self) -> int:
        """Return the number of objects."""
        return len(self._folders)

    @property
    def geometries(self) -> list[str]:
        """The names of the objects: scenes of one image each."""
        return [path.name for path in self._folders]

    def shots(self) -> Iterator[Shot]:
        """Yield the objects in diffuse light, and as they are in other lights."""
        for folder in self._folders:
            yield _shot(folder)


def _shot(folder: Path) -> Shot:
    """Read an object."""
    image, shading, reflectance, masked = (read_picture(folder / n, "linear") for n in _NEEDED)
    mask = masked.mean(axis=-1) > 0.0
    if not mask.any():
        raise InputError("has no valid pixel; unpack it again", folder / _NEEDED[-1])
    bands = image.shape[2]
    for name, layer in zip(_NEEDED[1:], (shading, reflectance, masked), strict=True):
        if layer.shape[:2] != mask.shape or image.shape[:2] != mask.shape:
            raise InputError(f"differs in size from {_NEEDED[0]}; unpack it again", folder / name)
    seen, light, painted = (
        _scaled(np.broadcast_to(layer, (*mask.shape, bands)), mask)
        for layer in (image, shading, reflectance)
    )
    lights = [inside(folder.parent, f"{folder.name}/{p.name}") for p in sorted(folder.glob(_PARTS))]
    others = [read_picture(path, "linear") for path in lights]
    relit = tuple(np.where(mask[..., None], _scaled(each, mask), np.nan) for each in others)
    truth = Truth(folder.name, folder.name, seen, painted, light, mask.astype(np.int64), mask, {})
    return Shot(truth, View(folder.name, seen, mask, relit), Kind("", ""))


def _scaled(image: Floats, mask: Mask) -> Floats:
    """Return an image of which the 99th percentile of grey values is 1."""
    return np.asarray(image / white_level(image, mask), np.float64)
