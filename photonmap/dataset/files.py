"""The files of one image: OpenEXR, HDF5 under Hypersim's names, and PNG."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.errors import InputError
from photonmap.messages import suggest
from photonmap.output import name_errors, read_exr, sort_parts, write_exr, write_png
from photonmap.result import Result

FORMATS = ("exr", "hdf5", "png")
BANDS_EXR, RGB_EXR, BANDS_HDF5 = "bands.exr", "rgb.exr", "bands.hdf5"
SHOWN = ("radiance", "direct", "indirect", "reflectance", "shading")
"""Buffers with a PNG."""
_FINAL, _GEOMETRY = "images/scene_cam_00_final_hdf5", "images/scene_cam_00_geometry_hdf5"
_DATASET = "dataset"
_SHADING_SHOWN_AS, _PERCENTILE = 0.8, 99.0


def check_formats(formats: Collection[str]) -> None:
    """Check that there are such formats, that one of them holds arrays, and that h5py is there.

    Raises
    ------
    InputError : if not
    """
    for name in formats:
        if name not in FORMATS:
            raise InputError(f"there is no format {name!r}; {suggest(name, FORMATS)}")
    if not {"exr", "hdf5"} & set(formats):
        raise InputError("a data set needs exr or hdf5 among its formats: png holds no numbers")
    if "hdf5" in formats:
        check_h5py()


def check_h5py() -> None:
    """Raise `InputError` without h5py."""
    if find_spec("h5py") is None:
        raise InputError("HDF5 needs h5py: pip install 'photonmap[dataset]'")


def write_image(folder: Path, result: Result, rgb: Result, formats: Collection[str]) -> None:
    """Write an image's files into a folder of its own.

    Parameters
    ----------
    result : in its bands, with what `with_derived` adds
    rgb : the same in RGB
    """
    if "exr" in formats:
        write_exr(result, folder / BANDS_EXR)
        write_exr(rgb, folder / RGB_EXR)
    if "hdf5" in formats:
        _write_bands(folder / BANDS_HDF5, result)
        _write_hypersim(folder, result, rgb)
    if "png" in formats:
        for name, image in previews(result, rgb).items():
            write_png(image, folder / f"{name}.png")


def previews(result: Result, rgb: Result) -> dict[str, NDArray[np.uint8]]:
    """Return 8-bit sRGB images: lights at the exposure of radiance, reflectance as it is."""
    exposure = rgb.exposure
    luminance = rgb.buffers["scalar_shading"][result.buffers["valid"]]
    shown = float(np.percentile(luminance, _PERCENTILE)) if luminance.size else 0.0
    of_shading = _SHADING_SHOWN_AS / shown if shown > 0.0 else 1.0
    exposures = {"reflectance": 1.0, "shading": of_shading}
    return {
        name: Result({"radiance": rgb.buffers[name]}, {}, rgb.bands, {}).preview(
            exposures.get(name, exposure)
        )
        for name in SHOWN
    }


def _write_bands(path: Path, result: Result) -> None:
    """Write all buffers and errors to one HDF5 file, a dataset each."""
    import json

    import h5py

    with h5py.File(path, "w") as file:
        file.attrs["bands"] = json.dumps(result.bands.describe())
        file.attrs["record"] = json.dumps(result.record)
        for name, image in (result.buffers | name_errors(result)).items():
            file.create_dataset(name, data=image, compression="gzip", shuffle=True)


def _write_hypersim(folder: Path, result: Result, rgb: Result) -> None:
    """Write files of the names and the dataset that loaders of Hypersim look for.

    color = diffuse_reflectance × diffuse_illumination + residual there, so that emission is part of
    the residual; the background has infinite depth in no file: it is 0.
    """
    import h5py

    final = {
        "color": rgb.radiance,
        "diffuse_reflectance": rgb.reflectance,
        "diffuse_illumination": rgb.shading,
        "residual": rgb.radiance - rgb.reflectance * rgb.shading,
    }
    geometry = {
        "depth_meters": result.depth,
        "normal_world": result.normal,
        "render_entity_id": result.object_id.astype(np.int32),
    }
    for place, images in ((_FINAL, final), (_GEOMETRY, geometry)):
        (folder / place).mkdir(parents=True)
        for name, image in images.items():
            with h5py.File(folder / place / f"frame.0000.{name}.hdf5", "w") as file:
                file.create_dataset(_DATASET, data=image, compression="gzip", shuffle=True)


def read_image(folder: Path) -> Result:
    """Read the buffers in bands of an image that `write_image` wrote, from EXR or else HDF5.

    Raises
    ------
    InputError : neither is there, or it is damaged
    """
    if (folder / BANDS_EXR).is_file():
        return Result(*read_exr(folder / BANDS_EXR))
    if (folder / BANDS_HDF5).is_file():
        return _read_bands(folder / BANDS_HDF5)
    raise InputError(f"has neither {BANDS_EXR} nor {BANDS_HDF5}; render it with --resume", folder)


def read_rgb(folder: Path) -> dict[str, NDArray[Any]]:
    """Read the buffers in RGB of an image, as `as_rgb` names them.

    Raises
    ------
    InputError : they cannot be read
    """
    if (folder / RGB_EXR).is_file():
        return read_exr(folder / RGB_EXR)[0]
    from photonmap.dataset.derived import as_rgb

    return as_rgb(read_image(folder)).buffers


def _read_bands(path: Path) -> Result:
    """Read what `_write_bands` wrote."""
    import json

    check_h5py()
    import h5py

    try:
        with h5py.File(path) as file:
            bands = Bands.from_description(json.loads(file.attrs["bands"]))
            record = json.loads(file.attrs["record"])
            parts = {name: file[name][()] for name in file}
    except (OSError, KeyError, ValueError) as error:
        raise InputError(f"this is damaged: {error}; render it with --resume", path) from None
    buffers, errors, blocks = sort_parts(parts)
    return Result(buffers, errors, bands, record, blocks)


def hash_files(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file in a folder, by its path in it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): _sha256(path) for path in files}


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
