"""Checks of an image's arrays: identities of buffers, other formats, geometry traced again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.dataset.files.image_files import BANDS_HDF5, hypersim_images, read_hdf5
from photonmap.dataset.files.image_files import read_hypersim as read_frame
from photonmap.dataset.files.reader import Image
from photonmap.errors import InputError
from photonmap.results.result import Result
from photonmap.scene.scene import Scene

ULPS = 8
"""Rounding errors of float32 by which sums and products of buffers may differ."""
_AT_CENTRE = ("depth", "distance", "normal", "object_id", "material_id")


def check_numbers(result: Result) -> Iterator[str]:
    """Yield the arrays that hold NaN."""
    for name, array in result.arrays.items():
        if np.isnan(array).any():
            yield f"{name} has NaN"


def check_identities(result: Result) -> Iterator[str]:
    """Yield the identities of the buffers that do not hold.

    radiance is (emission + direct) + indirect, bit for bit. To `ULPS`, the buffers of light groups
    add up to the whole, direct + indirect is reflectance × shading + residual, and scalar_shading ×
    illuminant is shading.
    """
    whole = (result.emission + result.direct) + result.indirect
    if not np.array_equal(result.radiance, whole):
        yield "radiance is not (emission + direct) + indirect"
    for name in names_where(per_light=True, has_error=True):
        parts = [split[name] for split in result.per_light.values() if name in split]
        if parts and not _close(_sum(parts), [result.buffers[name]]):
            yield f"{name} is not the sum of its light groups"
    product = result.reflectance * result.shading
    if not _close(_sum([result.direct, result.indirect]), [product, result.residual]):
        yield "direct + indirect is not reflectance × shading + residual"
    scalar = result.buffers["scalar_shading"][..., None]
    if not _close(scalar * result.buffers["illuminant"], [result.shading]):
        yield "scalar_shading × illuminant is not shading"


def check_rgb(image: Image) -> Iterator[str]:
    """Yield a fault if radiance in RGB is not emission + reflectance × shading + residual."""
    rgb = image.rgb
    parts = [rgb["emission"], rgb["reflectance"] * rgb["shading"], rgb["residual"]]
    if not _close(rgb["radiance"], parts):
        yield "radiance in RGB is not emission + reflectance × shading + residual"


def check_formats_agree(image: Image) -> Iterator[str]:
    """Yield the arrays of HDF5 files that differ from those that the image is read from."""
    if not (image.folder / BANDS_HDF5).is_file():
        return
    try:
        there = read_hdf5(image.folder / BANDS_HDF5).arrays
        frames = read_frame(image.folder)
    except InputError as error:
        yield str(error)
        return
    here = image.result.arrays
    if differ := _differing(here, there):
        yield f"{BANDS_HDF5} has other arrays than the image: {', '.join(differ)}"
    if differ := _differing(hypersim_images(image.result, image.rgb), frames):
        yield f"Hypersim's files have other arrays than the image: {', '.join(differ)}"


def check_geometry(result: Result, scene: Scene) -> Iterator[str]:
    """Yield the buffers at the pixels' centres that rays traced again do not give."""
    from photonmap.integrators.look import Onlooker

    assert scene.camera is not None
    seen = Onlooker(scene).see(scene.camera, result.size, _AT_CENTRE)
    there = {name: result.buffers[name] for name in seen if name in result.buffers}
    if differ := [name for name, image in there.items() if not np.array_equal(image, seen[name])]:
        yield f"rays traced again give other values: {', '.join(differ)}"


def _differing(here: dict[str, NDArray[Any]], there: dict[str, NDArray[Any]]) -> list[str]:
    names = {**here, **there}
    return [
        name
        for name in names
        if name not in here or name not in there or not np.array_equal(here[name], there[name])
    ]


def _sum(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.sum(np.array(parts, np.float64), axis=0)


def _close(whole: NDArray[Any], parts: Sequence[NDArray[Any]]) -> bool:
    """Return whether parts add up to a whole within rounding of their magnitudes."""
    scale = np.abs(whole.astype(np.float64)) + _sum([np.abs(part) for part in parts])
    allowed = ULPS * np.finfo(np.float32).eps * scale + np.finfo(np.float32).tiny
    return bool((np.abs(whole - _sum(parts)) <= allowed).all())
