"""What a result is made of, checked: images of one size, and a record that JSON can hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import row_of
from photonmap.errors import InputError
from photonmap.film.blocks import SIDE
from photonmap.runtime.wording import shown
from photonmap.spectra.bands import Bands

Images = dict[str, NDArray[Any]]


def as_images(images: Mapping[str, Any], kind: str) -> Images:
    """Return images by name, lists among them as arrays; messages call one of them by its kind.

    An `InputError` says that they go by no names, or one is not numbers of shape (H, W) or (H, W,
    N).
    """
    if not isinstance(images, Mapping):
        raise InputError(f"{kind}s {shown(images)} go by no names; give arrays in a dictionary")
    return {name: _as_image(image, f"{kind} {shown(name)}") for name, image in images.items()}


def _as_image(image: Any, owner: str) -> NDArray[Any]:
    try:
        array = np.asanyarray(image)
    except ValueError:
        raise InputError(f"{owner} has lines of different lengths; make them equal") from None
    if array.dtype.kind not in "biuf":
        raise InputError(f"{owner} is of type {array.dtype}; give real numbers")
    if array.ndim not in (2, 3):
        raise InputError(f"{owner} has shape {array.shape}, not (H, W) or (H, W, N)")
    return array


def check_shapes(buffers: Images, errors: Images, block_errors: Images, bands: Bands) -> None:
    """Raise `InputError` unless all images are of one size and have all bands.

    Errors have the shape of their buffer, where there is one; those of blocks a value for each.
    """
    if not isinstance(bands, Bands):
        raise InputError(f"bands {shown(bands)} are no photonmap.Bands; take Bands.parse(…)")
    if not buffers:
        raise InputError("a result of no buffers; give one or more images by name")
    first, image = next(iter(buffers.items()))
    size = image.shape[:2]
    blocks = tuple(-(-side // SIDE) for side in size)
    for kind, images, sides in (
        ("buffer", buffers, size),
        ("error", errors, size),
        ("block error", block_errors, blocks),
    ):
        for name, other in images.items():
            row, own = row_of(name), buffers.get(name, other)
            banded = row is not None and row.is_banded
            wanted = (*sides, *((bands.count,) if banded else own.shape[2:]))
            if other.shape != wanted:
                found = f"{kind} {name!r} has shape {other.shape}"
                raise InputError(f"{found}, not {wanted} as {first!r}")


def as_record(value: Any) -> Any:
    """Return a record in plain Python types; what JSON cannot hold is an `InputError`."""
    if value is None or type(value) in (str, int, float, bool):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return as_record(value.tolist())
    if isinstance(value, Mapping):
        return {name: as_record(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [as_record(each) for each in value]
    if isinstance(value, str | int | float):
        return value
    raise InputError(f"the record has {shown(value)}, which JSON cannot hold; leave it out")
