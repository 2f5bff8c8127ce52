"""The files of a render: the image, a PNG to look at, a JSON record.

The suffix of the image chooses its format: OpenEXR, netCDF and HDF5, ENVI. A netCDF-4 file is an
HDF5 file, so FILE.nc and FILE.hdf5 hold the same; docs/guide.md describes it.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.buffers import (
    BUFFERS,
    BY_NAME,
    ERROR_ENDINGS,
    check_buffers,
    group_name,
    without_slash,
)
from photonmap.errors import InputError
from photonmap.io.envi import write_envi
from photonmap.io.exr import Contents, Images, Projector, name_errors, write_exr
from photonmap.io.png import write_png
from photonmap.results.labels import describe_array, make_dataset
from photonmap.results.preview import Preview
from photonmap.runtime.checkpoint import is_checkpoint
from photonmap.runtime.options import read_list
from photonmap.runtime.writing import check_length, check_writable, drafts_beside

Writer = Callable[[Contents, Path, Projector], list[Path]]
"""Writes the contents to a file of its suffix, and perhaps to others beside it; returns them."""


def _write_exr(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    write_exr(contents, path, to_rgb)
    return [path]


def _write_netcdf(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    """Write `Result.to_xarray`, with names `without_slash`."""
    arrays = {without_slash(name): image for name, image in _arrays(contents).items()}
    data = make_dataset(arrays, contents.bands, contents.record)
    packed = {"zlib": True, "complevel": 1, "shuffle": True}
    encoding = {str(name): packed for name in data.data_vars}
    with no_cluster():
        data.to_netcdf(path, engine="h5netcdf", encoding=encoding)
    return [path]


def no_cluster() -> AbstractContextManager[object]:
    """Keep xarray from locking a file through the cluster that Dask is, or was, connected to."""
    dask = sys.modules.get("dask")
    return nullcontext() if dask is None else dask.config.set(scheduler="synchronous")


def _write_envi(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    """Write the `_headers` of all arrays, and their values beside them."""
    arrays, bands, written = _arrays(contents), contents.bands, list[Path]()
    for (name, image), header in zip(arrays.items(), _headers(path, arrays), strict=True):
        about = describe_array(name, image)
        labels, wavelengths = ["value"], None
        if about.dimensions[-1] == "band":
            labels, wavelengths = list(bands.names), bands.centroids
        elif image.ndim == 3:
            labels = ["x", "y", "z"]
        text = f"{name}: {about.meaning}; unit: {about.unit}"
        written += write_envi(image, header, labels, wavelengths, text)
    return written


def _headers(path: Path, names: Iterable[str]) -> list[Path]:
    """Return FILE.hdr for the first of some arrays, and FILE-NAME.hdr for each of the others."""
    others = (f"{path.stem}-{without_slash(name)}" for name in list(names)[1:])
    return [path.with_name(f"{stem}.hdr") for stem in (path.stem, *others)]


def _arrays(contents: Contents) -> Images:
    """Return all arrays, radiance first and errors last."""
    buffers = dict(sorted(contents.buffers.items(), key=lambda item: item[0] != "radiance"))
    return buffers | name_errors(contents.errors, contents.block_errors)


WRITERS: dict[str, Writer] = {
    ".exr": _write_exr,
    ".nc": _write_netcdf,
    ".hdf5": _write_netcdf,
    ".h5": _write_netcdf,
    ".hdr": _write_envi,
    ".img": _write_envi,
}
"""Writers by the suffix of the output."""


def _check_format(path: Path) -> None:
    """Check that a format goes by this suffix, and that what it needs is installed."""
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        *known, last = WRITERS
        raise InputError(
            f"the name of the output must end in {', '.join(known)} or {last}, as in image.exr",
            path,
        )
    if writer is _write_netcdf:
        missing = [name for name in ("xarray", "h5netcdf") if find_spec(name) is None]
        if missing:
            raise InputError(
                f"files in {path.suffix} need {' and '.join(missing)}: "
                "pip install 'photonmap[netcdf]'",
                path,
            )


def check_output(
    path: str | PathLike[str],
    buffers: Iterable[str] | None = None,
    groups: Iterable[str] = (),
) -> Path:
    """Check before a render that FILE.exr, or its like, FILE.png and FILE.json can be written.

    An `InputError` says that there is no such format, it needs a package that is missing, the
    folder is not writable, the name of a file is too long, or that there is no buffer of a name.

    buffers : names of those to be written; None for all
    groups : names of the light groups that they are split by
    """
    check_buffers(buffers)
    names = BUFFERS if buffers is None else read_list(buffers)
    return _check_places(Path(path), _names_of(names, groups))


def _names_of(buffers: Iterable[str], groups: Iterable[str]) -> list[str]:
    """Return the names of all arrays that a render may have of some buffers, radiance first."""
    rows = [BY_NAME[name] for name in sorted(buffers, key=lambda name: name != "radiance")]
    split = {group_name(row.name, group): row for group in groups for row in rows if row.per_light}
    named = {row.name: row for row in rows} | split
    errors = [
        name + ending for name, row in named.items() if row.has_error for ending in ERROR_ENDINGS
    ]
    return [*named, *errors]


def _check_places(path: Path, arrays: Iterable[str]) -> Path:
    """Check the format of an output of some arrays, and that its files can be written."""
    _check_format(path)
    for file in _files_of(path, arrays):
        check_length(file)
        if file.is_dir():
            raise InputError("this is a folder; remove it or choose another name", file)
        if is_checkpoint(file):
            raise InputError("this is a checkpoint; remove it or choose another name", file)
    check_writable(path.parent, path)
    return path


def _files_of(path: Path, arrays: Iterable[str] = ()) -> list[Path]:
    """Return the files that are written for an output of some arrays."""
    headers = _headers(path, arrays) if _is_envi(path) else []
    values = [header.with_suffix(".img") for header in headers]
    files = [path, path.with_suffix(".png"), path.with_suffix(".json"), *headers, *values]
    return list(dict.fromkeys(files))


def _is_envi(path: Path) -> bool:
    return WRITERS.get(path.suffix.lower()) is _write_envi


def check_apart(checkpoint: Path, path: str | PathLike[str]) -> None:
    """Check that a checkpoint is none of the files that `save_all` writes for an output."""
    place, image = checkpoint.resolve(), Path(path)
    taken = place in [file.resolve() for file in _files_of(image)]
    if _is_envi(image) and place.parent == image.resolve().parent:  # of each buffer
        taken |= place.name.startswith(f"{image.stem}-") and place.suffix in (".hdr", ".img")
    if taken:
        problem = f"the checkpoint would be overwritten by the output {image}"
        raise InputError(f"{problem}; choose another name for one of them", checkpoint)


def save_all(
    contents: Contents,
    path: str | PathLike[str],
    to_rgb: Projector,
    preview: Callable[[], Preview] | None,
) -> None:
    """Write FILE.exr, FILE.png and FILE.json; none of them appears before all are complete.

    The suffix chooses the format, as `photonmap.results.files` lists them. The folder is made if it
    is missing. The JSON is the record, with the exposure of the PNG and the seconds that writing
    the images took. `to_rgb` projects radiance for the OpenEXR's viewers; `preview` makes the PNG,
    None for none. What cannot be written there is an `InputError`; a disk without room is an
    `OSError` that names the file, the bytes it needs and what to do.
    """
    arrays = _arrays(contents)
    path = _check_places(Path(path), arrays)
    record, start = contents.record, time.perf_counter()
    size = sum(image.nbytes for image in arrays.values())
    with drafts_beside(path, size) as folder:
        image = folder / path.name
        written = [image.with_suffix(".json")]
        if preview is not None:
            shown = preview()
            record = {**record, "exposure": shown.exposure}
            written.insert(0, image.with_suffix(".png"))
            write_png(shown.image, written[0])
        written += WRITERS[path.suffix.lower()](contents, image, to_rgb)
        seconds = {**record.get("seconds", {}), "write": time.perf_counter() - start}
        write_json({**record, "seconds": seconds}, image.with_suffix(".json"))
        for file in written:
            file.replace(path.with_name(file.name))


def write_json(record: dict[str, Any], path: str | PathLike[str]) -> None:
    """Write a JSON-able record, indented, UTF-8."""
    text = json.dumps(record, indent=2, ensure_ascii=False)
    Path(path).write_text(text + "\n", encoding="utf-8")
