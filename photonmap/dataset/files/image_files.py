"""The files of one image: OpenEXR, HDF5 (bands, and Hypersim's layout), PNG, and a photo."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import with_slash, without_slash
from photonmap.dataset.files.derived_buffers import as_rgb
from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.lean import RGB, as_lean, held_in, restored
from photonmap.errors import InputError
from photonmap.io.exr import current_name, list_parts, read_exr, sort_parts
from photonmap.io.png import write_png
from photonmap.kernels.core.color import LUMINANCE
from photonmap.results.preview import as_bytes, with_highlights
from photonmap.results.result import Result
from photonmap.runtime.wording import suggest
from photonmap.spectra.bands import Bands

if TYPE_CHECKING:
    from photonmap.capture.sensor import Sensor

FORMATS = ("exr", "hdf5", "png")
BANDS_EXR, RGB_EXR, BANDS_HDF5 = "bands.exr", "rgb.exr", "bands.hdf5"
PREVIEWED = ("radiance", "direct", "indirect", "reflectance", "shading")
"""Buffers that have a PNG."""
SHOWN = (*PREVIEWED, "fluorescence")
"""These, and those that have one where surfaces fluoresce."""
_FINAL, _GEOMETRY = "images/scene_cam_00_final_hdf5", "images/scene_cam_00_geometry_hdf5"
_DATASET = "dataset"
_DIGITS = 16
_TIMES = ("seconds", "predicted_seconds", "resumed")
"""What a record says of a render that does not decide its arrays."""
_AGAIN = "render it again with --resume"
_SHADING_SHOWN_AS, _PERCENTILE = 0.8, 99.0
"""Linear value that a PNG gives to this percentile of scalar shading over valid pixels."""
_WHITE_SHOWN_AS = 0.7
"""Linear value that a PNG gives to a white surface in the median light of the valid pixels."""


def check_formats(formats: Collection[str]) -> None:
    """Check that the formats exist, that one of them holds arrays, and that h5py is installed."""
    for name in formats:
        if name not in FORMATS:
            raise InputError(f"there is no format {name!r}; {suggest(name, FORMATS)}")
    if not {"exr", "hdf5"} & set(formats):
        problem = "a data set needs exr or hdf5 among its formats"
        raise InputError(f"{problem}, as png does not hold arrays")
    if "hdf5" in formats:
        check_h5py()


def check_h5py() -> None:
    """Raise `InputError` without h5py."""
    if find_spec("h5py") is None:
        raise InputError("HDF5 needs h5py: pip install 'photonmap[dataset]'")


def write_image(
    folder: Path,
    result: Result,
    rgb: Result,
    formats: Collection[str],
    full: bool = False,
    chosen: Collection[str] | None = None,
) -> dict[str, str]:
    """Write the files of an image into its own folder; return digests of the arrays in them.

    Parameters
    ----------
    result, rgb : with the buffers that `with_derived` adds; and the same in the set's RGB
    full : write everything as it is, and not what `as_lean` keeps
    chosen : names of the buffers to write; None for all
    """
    held, held_rgb = held_in(result, chosen), held_in(rgb, chosen)
    held, halves = (held, []) if full else as_lean(held)
    held_rgb, rgb_halves = (held_rgb, []) if full else as_lean(held_rgb, RGB)
    held, held_rgb = _without_times(held), _without_times(held_rgb)
    if "exr" in formats:
        held.save_exr(folder / BANDS_EXR, halves)
        held_rgb.save_exr(folder / RGB_EXR, rgb_halves)
    if "hdf5" in formats:
        _write_bands(folder / BANDS_HDF5, held, halves)
        _write_hypersim(folder, hypersim_images(held, held_rgb.buffers))
    if "png" in formats:
        for name, image in previews(result, as_rgb(result), SHOWN).items():
            write_png(image, folder / f"{name}.png")
    return digests(held)


def digests(result: Result) -> dict[str, str]:
    """Return a digest of every array, whatever the format of its file: part of a SHA-256."""
    return {
        name: hashlib.sha256(np.ascontiguousarray(image).data).hexdigest()[:_DIGITS]
        for name, image in result.arrays.items()
    }


def _without_times(result: Result) -> Result:
    """Return a result without times and threads in its record: equal images have equal files."""
    record = {name: value for name, value in result.record.items() if name not in _TIMES}
    if "arguments" in record:
        record["arguments"] = {**record["arguments"]}
        record["arguments"].pop("threads", None)
    if "effects" in record:
        record["effects"] = {
            name: {key: value for key, value in effect.items() if key != "seconds"}
            for name, effect in record["effects"].items()
        }
    return replace(result, record=record)


def previews(
    result: Result, rgb: Result, names: Iterable[str] = PREVIEWED
) -> dict[str, NDArray[np.uint8]]:
    """Return 8-bit sRGB images: light as a light meter exposes it, shading at its own exposure.

    Highlights of light are compressed, see `photonmap.results.preview.with_highlights`.
    Buffers that are not there are left out.
    """
    exposure = _metered(rgb, result.buffers["valid"])
    luminance = rgb.buffers["scalar_shading"][result.buffers["valid"]]
    shown = float(np.percentile(luminance, _PERCENTILE)) if luminance.size else 0.0
    of_shading = _SHADING_SHOWN_AS / shown if shown > 0.0 else 1.0
    exposures = {"reflectance": 1.0, "shading": of_shading}
    return {
        name: as_bytes(rgb.buffers[name], exposures[name])
        if name in exposures
        else as_bytes(with_highlights(rgb.buffers[name] * exposure), 1.0)
        for name in names
        if name in rgb.buffers
    }


def _metered(rgb: Result, valid: NDArray[np.bool_]) -> float:
    """Return the exposure at which a white surface in the median of the light is shown as 0.7.

    Bright spots, such as the reveal of a window, do not count, unlike in `Result.exposure`.
    """
    light = rgb.buffers["shading"][valid] @ np.array(LUMINANCE)
    median = float(np.median(light)) if light.size else 0.0
    return _WHITE_SHOWN_AS / median if median > 0.0 else rgb.exposure


def _write_bands(path: Path, result: Result, halves: Collection[str]) -> None:
    """Write all buffers and errors to one HDF5 file, as a dataset each."""
    import h5py

    with h5py.File(path, "w") as file:
        file.attrs["bands"] = json.dumps(result.bands.describe())
        file.attrs["record"] = json.dumps(result.record)
        for name, image in result.arrays.items():
            data = image.astype(np.float16) if name in halves else image
            file.create_dataset(without_slash(name), data=data, compression="gzip", shuffle=True)


def hypersim_images(result: Result, rgb: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return images by the paths of their files, which loaders of Hypersim expect.

    There, color = diffuse_reflectance × diffuse_illumination + residual, so emission and
    fluorescence are part of the residual. `depth_meters` is the distance from the camera, 0 for
    the background, whose `render_entity_id` is −1. In files without a distance, depth is it.
    """
    ids = result.object_id
    reflectance, shading = rgb["reflectance"], rgb["shading"]
    places = {
        _FINAL: {
            "color": rgb["radiance"],
            "diffuse_reflectance": reflectance,
            "diffuse_illumination": shading,
            "residual": rgb["radiance"] - reflectance * shading,
        },
        _GEOMETRY: {
            "depth_meters": result.distance if "distance" in result.buffers else result.depth,
            "normal_world": result.normal,
            "render_entity_id": np.where(ids > 0, ids.astype(np.int32), np.int32(-1)),
        },
    }
    return {
        f"{place}/frame.0000.{name}.hdf5": image
        for place, images in places.items()
        for name, image in images.items()
    }


def _write_hypersim(folder: Path, images: Mapping[str, NDArray[Any]]) -> None:
    import h5py

    for place, image in images.items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        with h5py.File(folder / place, "w") as file:
            file.create_dataset(_DATASET, data=image, compression="gzip", shuffle=True)


def read_hypersim(folder: Path) -> dict[str, NDArray[Any]]:
    """Return what `hypersim_images` returned when the files were written."""
    check_h5py()
    import h5py

    images: dict[str, NDArray[Any]] = {}
    for place in (_FINAL, _GEOMETRY):
        for path in sorted((folder / place).glob("*.hdf5")):
            try:
                with h5py.File(path) as file:
                    images[f"{place}/{path.name}"] = file[_DATASET][()]
            except (OSError, KeyError) as error:
                raise InputError(f"is damaged ({error}); {_AGAIN}", path) from None
    return images


def read_image(folder: Path) -> Result:
    """Read the buffers of an image in its bands, from EXR if there is one, else from HDF5."""
    if (folder / BANDS_EXR).is_file():
        return restored(Result(*read_exr(folder / BANDS_EXR)))
    if (folder / BANDS_HDF5).is_file():
        return restored(read_hdf5(folder / BANDS_HDF5))
    raise InputError(f"has neither {BANDS_EXR} nor {BANDS_HDF5}; {_AGAIN}", folder)


def read_hdf5(path: Path) -> Result:
    """Read the buffers of an image from the HDF5 file of its bands."""
    check_h5py()
    import h5py

    try:
        with h5py.File(path) as file:
            bands = Bands.from_description(json.loads(file.attrs["bands"]))
            record = json.loads(file.attrs["record"])
            parts = {_name_of(name): file[name][()] for name in file}
    except (OSError, KeyError, ValueError) as error:
        raise InputError(f"is damaged ({error}); {_AGAIN}", path) from None
    for name, image in parts.items():
        parts[name] = image.astype(np.float32) if image.dtype == np.float16 else image
    buffers, errors, block_errors = sort_parts(parts)
    return Result(buffers, errors, bands, record, block_errors)


def hdf5_halves(path: Path) -> tuple[list[str], list[str]]:
    """Return the names of the arrays in an HDF5 file of bands, and of those in half precision."""
    import h5py

    with h5py.File(path) as file:
        halves = [_name_of(name) for name in file if file[name].dtype == np.float16]
        return [_name_of(name) for name in file], halves


def _name_of(dataset: str) -> str:
    """Return what an array of an HDF5 file is called now."""
    return current_name(with_slash(dataset))


def list_arrays(folder: Path) -> list[str]:
    """Return the names of the arrays in the file that `read_image` reads; no image is read."""
    if (folder / BANDS_EXR).is_file():
        return [current_name(name) for name in list_parts(folder / BANDS_EXR)]
    return hdf5_halves(folder / BANDS_HDF5)[0]


def list_files(folder: Path) -> list[str]:
    """Return the paths of all files in a folder, relative to it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return [path.relative_to(folder).as_posix() for path in files]


def hash_files(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """Return the SHA-256 of files by their paths relative to a folder; "" for missing ones.

    Raises
    ------
    InputError : a path is not one that `inside` follows
    """
    files = {name: inside(folder, name) for name in names}
    return {name: _sha256(path) if path.is_file() else "" for name, path in files.items()}


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


PHOTO = "photo"
"""Folder of an image that holds its photo."""
READ_FOLDERS = (f"{PHOTO}/", f"{_FINAL}/", f"{_GEOMETRY}/")
"""What the paths of the files begin with that are read by what is in their folder."""
_TOLD = ("time_s", "saturated", "negative")  # what the manifest says of a photo


def choose_sensor(text: str | None) -> tuple[Sensor, dict[str, Any]] | tuple[None, None]:
    """Return the sensor of a camera or a FILE.toml, and what the head of a set says of it."""
    if text is None:
        return None, None
    from photonmap.capture.expose import find_response
    from photonmap.capture.sensor import load_sensor
    from photonmap.spectra.sensitivities import table_of

    sensor = load_sensor(text)
    if (path := table_of(sensor.camera)) is not None:
        sensor = replace(sensor, camera=str(path.resolve()))
    curves = json.dumps(find_response(sensor).bands.describe())
    digest = hashlib.sha256(curves.encode()).hexdigest()[:_DIGITS]
    return sensor, {**sensor.describe(), "sensitivities": digest}


def add_photo(
    folder: Path, result: Result, sensor: Sensor, seed: int, full: bool
) -> dict[str, Any]:
    """Write the photo of an image, of the radiance that its files hold; return its description."""
    from photonmap.capture.expose import expose
    from photonmap.capture.photo import write_photo

    seen = result.select(["radiance", "emission"])
    photo = expose(seen if full else as_lean(seen)[0], sensor, seed)
    (folder / PHOTO).mkdir()
    write_photo(photo, folder / PHOTO)
    return describe_photo(photo.record)


def describe_photo(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the manifest says of a photo, from its record."""
    return {name: record[name] for name in _TOLD}
