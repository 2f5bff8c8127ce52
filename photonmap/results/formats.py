"""The formats that a result is written in, by suffix: OpenEXR, netCDF and HDF5, ENVI.

A netCDF-4 file is an HDF5 file, so FILE.nc and FILE.hdf5 hold the same; docs/guide.md describes it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from photonmap.errors import InputError
from photonmap.io.envi import write_envi
from photonmap.io.exr import Contents, Images, Projector, name_errors, write_exr
from photonmap.results.labelled import describe_array, make_dataset

Writer = Callable[[Contents, Path, Projector], list[Path]]
"""Writes the contents to a file of its suffix, and perhaps to others beside it; returns them."""


def _write_exr(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    write_exr(contents, path, to_rgb)
    return [path]


def _write_netcdf(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    """Write `Result.to_xarray`, with "/" in the names of light groups as "_"."""
    arrays = {name.replace("/", "_"): image for name, image in _arrays(contents).items()}
    data = make_dataset(arrays, contents.bands, contents.record)
    packed = {"zlib": True, "complevel": 1, "shuffle": True}
    encoding = {str(name): packed for name in data.data_vars}
    with no_cluster():
        data.to_netcdf(path, engine="h5netcdf", encoding=encoding)
    return [path]


@contextmanager
def no_cluster() -> Iterator[None]:
    """Keep xarray from locking a file through the cluster that Dask is, or was, connected to."""
    dask = sys.modules.get("dask")
    if dask is None:
        yield
        return
    with dask.config.set(scheduler="synchronous"):
        yield


def _write_envi(contents: Contents, path: Path, to_rgb: Projector) -> list[Path]:
    """Write FILE.hdr and FILE.img of the first buffer, FILE-NAME.hdr and so on of all others."""
    arrays, bands, written = _arrays(contents), contents.bands, list[Path]()
    for index, (name, image) in enumerate(arrays.items()):
        stem = f"{path.stem}-{name.replace('/', '_')}" if index else path.stem
        about = describe_array(name, image)
        labels, wavelengths = ["value"], None
        if about.dimensions[-1] == "band":
            labels, wavelengths = list(bands.names), bands.centroids
        elif image.ndim == 3:
            labels = ["x", "y", "z"]
        text = f"{name}: {about.meaning}; unit: {about.unit}"
        header = path.with_name(f"{stem}.hdr")
        written += write_envi(image, header, labels, wavelengths, text)
    return written


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


def check_format(path: Path) -> None:
    """Check that a format goes by this suffix, and that what it needs is installed.

    Raises
    ------
    InputError
        if not
    """
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
