"""Checks of an image's arrays: identities of buffers, other formats, geometry traced again."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import names_where
from photonmap.dataset.files.image_files import BANDS_HDF5, digests, hypersim_images, read_hdf5
from photonmap.dataset.files.image_files import read_hypersim as read_frame
from photonmap.dataset.files.inputs import SENSOR, kept_as
from photonmap.dataset.files.lean import fits_half, restored, to_half
from photonmap.dataset.files.reader import Image
from photonmap.errors import InputError
from photonmap.io.exr import current_name
from photonmap.results.result import Result
from photonmap.scene.scene import Scene

ULPS, HALF_ULPS = 8, 2
"""Rounding errors of float32, and of half precision, by which sums and products may differ."""
_AT_CENTRE = ("depth", "distance", "normal", "object_id", "material_id")


def is_full(image: Image) -> bool:
    """Return whether an image's files hold everything in single precision."""
    return image.entry.get("full", True)


def check_digests(image: Image) -> Iterator[str]:
    """Yield the arrays that are not those that were rendered."""
    digests_then = image.entry.get("arrays", {})
    wanted = {current_name(name): digest for name, digest in digests_then.items()}
    found = digests(image.result)
    if changed := [name for name, digest in wanted.items() if found.get(name) != digest]:
        yield f"arrays differ from those that were rendered: {', '.join(changed)}"


def check_numbers(result: Result) -> Iterator[str]:
    """Yield the arrays that hold NaN."""
    for name, array in result.arrays.items():
        if np.isnan(array).any():
            yield f"{name} has NaN"


def check_identities(
    result: Result, full: bool = True, chosen: Collection[str] | None = None
) -> Iterator[str]:
    """Yield the identities of the buffers that do not hold.

    radiance is (emission + direct) + indirect, bit for bit where files are full. To rounding, the
    buffers of light groups add up to the whole, direct + indirect is reflectance × shading +
    residual, and scalar_shading × illuminant is shading. Those of buffers that the files were not
    asked to hold are left alone.
    """

    def holds(*names: str) -> bool:
        return chosen is None or {*names} <= {*chosen}

    if holds("emission", "direct", "indirect"):
        whole = (result.emission + result.direct) + result.indirect
        parts = [result.emission, result.direct, result.indirect]
        if not (np.array_equal(result.radiance, whole) if full else _close(whole, parts, full)):
            yield "radiance is not (emission + direct) + indirect"
    for name in names_where(per_light=True, has_error=True):
        parts = [split[name] for split in result.per_light.values() if name in split]
        if parts and not _close(_sum(parts), [result.buffers[name]], full):
            yield f"{name} is not the sum of its light groups"
    if holds("direct", "indirect", "residual"):
        product = result.reflectance * result.shading
        if not _close(_sum([result.direct, result.indirect]), [product, result.residual], full):
            yield "direct + indirect is not reflectance × shading + residual"
    scalar = result.buffers["scalar_shading"][..., None]
    if not _close(scalar * result.buffers["illuminant"], [result.shading], full):
        yield "scalar_shading × illuminant is not shading"


def check_rgb(image: Image) -> Iterator[str]:
    """Yield a fault if radiance in RGB is not emission + reflectance × shading + residual."""
    rgb, chosen = image.rgb, image.chosen
    if chosen is not None and not {"emission", "residual"} <= {*chosen}:
        return
    product = rgb["reflectance"] * rgb["shading"]
    parts = [rgb["emission"], product, rgb.get("residual", np.zeros_like(product))]
    if not _close(rgb["radiance"], parts, is_full(image)):
        yield "radiance in RGB is not emission + reflectance × shading + residual"


def check_formats_agree(image: Image) -> Iterator[str]:
    """Yield the arrays of HDF5 files that differ from those that the image is read from."""
    if not (image.folder / BANDS_HDF5).is_file():
        return
    try:
        there = restored(read_hdf5(image.folder / BANDS_HDF5)).arrays
        frames = read_frame(image.folder)
    except InputError as error:
        yield str(error)
        return
    here = image.result.arrays
    if differ := _differing(here, there):
        yield f"{BANDS_HDF5} has other arrays than the image: {', '.join(differ)}"
    if differ := _differing(hypersim_images(image.result, image.rgb), frames):
        yield f"Hypersim's files have other arrays than the image: {', '.join(differ)}"


def check_geometry(result: Result, scene: Scene, full: bool = True) -> Iterator[str]:
    """Yield the buffers at the pixels' centres that rays traced again do not give."""
    from photonmap.integrators.look import Onlooker

    assert scene.camera is not None
    seen = Onlooker(scene).see(scene.camera, result.size, _AT_CENTRE)
    if not full:
        seen = {n: to_half(image) if fits_half(n, image) else image for n, image in seen.items()}
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


def _close(whole: NDArray[Any], parts: Sequence[NDArray[Any]], full: bool) -> bool:
    """Return whether parts add up to a whole within rounding of their magnitudes."""
    scale = np.abs(whole.astype(np.float64)) + _sum([np.abs(part) for part in parts])
    kind = np.finfo(np.float32 if full else np.float16)
    smallest = kind.tiny if full else 8 * kind.smallest_subnormal
    allowed = (ULPS if full else HALF_ULPS) * float(kind.eps) * scale + float(smallest)
    return bool((np.abs(whole - _sum(parts)) <= allowed).all())


def check_photo(image: Image) -> Iterator[str]:
    """Yield what is wrong with the photo of an image, if it has one: it is exposed again.

    A photo by a file of sensitivities of which the set has no copy is left alone.
    """
    if image.entry.get("photo") is None:
        return
    from photonmap.capture.expose import expose
    from photonmap.capture.sensor import Sensor
    from photonmap.spectra.sensitivities import table_of

    try:
        photo = image.photo
        sensor = Sensor(**photo.record["sensor"])
        path = table_of(sensor.camera)
        kept = path and image.folder.parent / kept_as(SENSOR, path)
        if kept is None or kept.is_file():
            sensor = sensor if kept is None else replace(sensor, camera=str(kept))
            again = expose(image.result, sensor, photo.record["seed"])
            if not (
                np.array_equal(again.raw, photo.raw) and np.array_equal(again.truth, photo.truth)
            ):
                yield "the photo is not that of the radiance"
    except (InputError, TypeError) as error:
        yield f"the photo cannot be checked: {error}"
