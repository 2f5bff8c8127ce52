"""Estimates that were made elsewhere, read from a folder by the names of a data set's images.

FOLDER/IMAGE/LAYER.png or .exr, or FOLDER/IMAGE.npz with arrays LAYER; LAYER is reflectance, shading
or illuminant. OpenEXR and NPZ are linear; PNG is sRGB, or linear if said so.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.inside import inside
from photonmap.errors import InputError, naming_file, warn
from photonmap.evaluate.bench.measure import LAYERS
from photonmap.evaluate.methods.method import Estimate, Method, View
from photonmap.evaluate.metrics.arrays import Floats, real
from photonmap.runtime.bounds import Shapes, read_npz
from photonmap.runtime.wording import listed, suggest
from photonmap.scene.images import decode_srgb

ENCODINGS = ("srgb", "linear")  # What the values of a PNG may be
_SUFFIXES = (".png", ".exr")
_ARRAYS = ".npz"


def predictions(
    folder: str | PathLike[str], images: Iterable[str], encoding: str = "srgb"
) -> Method:
    """Return a `Method` of the folder's name that reads its estimates.

    Parameters
    ----------
    folder : of predictions
    images : names of the data set's images
    encoding : of PNG files, one of `ENCODINGS`

    Raises
    ------
    InputError : there is no such folder or encoding, or it has no prediction for any image
    """
    root, known = Path(folder), set(images)
    if encoding not in ENCODINGS:
        raise InputError(f"there is no encoding {encoding!r}; {suggest(encoding, ENCODINGS)}")
    if not root.is_dir():
        raise InputError("is not a folder; choose the folder of the predictions", root)
    found = {
        path.name if path.is_dir() else path.stem
        for path in root.iterdir()
        if path.is_dir() or path.suffix == _ARRAYS
    }
    if not found & known:
        raise InputError(
            f"has no prediction for an image of the data set, such as {min(known)}/reflectance.png "
            f"or {min(known)}.npz; name predictions by the images in manifest.jsonl",
            root,
        )
    if strangers := sorted(found - known):
        warn(
            f"{root}: {len(strangers)} predictions belong to no image of the data set "
            f"({listed(strangers, 3)}); they are ignored"
        )
    return Method(root.resolve().name, partial(_read, root, encoding))


def _read(root: Path, encoding: str, view: View) -> Estimate:
    """Read the layers of an image."""
    arrays = inside(root, f"{view.name}{_ARRAYS}", is_part=True)
    layers = _read_arrays(arrays) if arrays.is_file() else {}
    for layer in LAYERS:
        for suffix in _SUFFIXES:
            path = inside(root, f"{view.name}/{layer}{suffix}")
            if path.is_file():
                if layer in layers:
                    raise InputError(f"there is more than one {layer}; keep one of them", path)
                layers[layer] = read_picture(path, encoding)
    if not layers:
        raise InputError("there is no IMAGE/LAYER.png, IMAGE/LAYER.exr or IMAGE.npz", root)
    return Estimate(**layers)


def _read_arrays(path: Path) -> dict[str, Floats]:
    """Read the layers of an NPZ file."""
    names: list[str] = []

    def choose(shapes: Shapes) -> list[str]:
        names.extend(shapes)
        return [name for name in LAYERS if name in shapes]

    try:
        arrays = read_npz(path, choose)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot be read ({error}); write it with numpy.savez", path) from None
    if not arrays:
        raise InputError(
            f"has none of the arrays {listed(LAYERS)}; it has {listed(names)}; rename them", path
        )
    with naming_file(path):
        return {name: real(array, name) for name, array in arrays.items()}


def read_picture(path: Path, encoding: str) -> Floats:
    """Read a picture as (H, W, C), without alpha; integers are scaled to [0, 1]."""
    import OpenImageIO

    hints = OpenImageIO.ImageSpec()
    hints["oiio:UnassociatedAlpha"] = 1  # or else values are multiplied by alpha
    file = OpenImageIO.ImageInput.open(str(path), hints)
    if file is None:
        raise InputError(f"cannot be read ({OpenImageIO.geterror()}); write it again", path)
    spec = file.spec()
    pixels: Any = file.read_image(OpenImageIO.FLOAT)
    reason = file.geterror()
    file.close()
    if pixels is None:
        raise InputError(f"cannot be read ({reason}); write it again", path)
    colors = [index for index in range(spec.nchannels) if index != spec.alpha_channel]
    values = pixels[..., colors].astype(np.float64)
    return decode_srgb(values) if path.suffix == ".png" and encoding == "srgb" else values
