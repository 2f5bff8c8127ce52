"""Buffers as layers of one OpenEXR image in linear sRGB, as compositors read them."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cache, lru_cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import ERROR_ENDINGS, Buffer, check_distinct, row_of
from photonmap.errors import InputError
from photonmap.scene.images import write_image
from photonmap.spectra.bands import Bands

if TYPE_CHECKING:
    import OpenImageIO

Images = dict[str, NDArray[Any]]
Projector = Callable[[NDArray[Any]], NDArray[np.float32]]
"""Projects lines of radiance (h, W, N) onto linear sRGB, (h, W, 3)."""

_RGB = ("R", "G", "B")
_ERROR, _BLOCK_ERROR = ERROR_ENDINGS
"""Endings of the names of parts that hold standard errors, and those of means over blocks."""
_COMPRESSION = "zip"
"""Lossless, and every reader knows it; htj2k and zstd do better, but need the latest OpenEXR."""
_NO_DATE = ""  # In place of when a file was written, so that equal images are equal files
_LINES = 64
"""Lines of an image that are written at a time: a multiple of the 16 compressed together."""
_RECORD, _BANDS = "photonmapRecord", "photonmapBands"
"""Attributes of part 0, JSON: the run record and `Bands.describe`."""
_NAMES, _NAMED = "photonmapNames", {"object_id": "objects", "material_id": "materials"}
"""Attribute of parts of ids, JSON: the names of 1, 2, …; and the entry of the record with them."""

_XARRAY, _ENVI = "xarray.open_dataset reads them", "Spectral Python reads them"
_FOR_OTHERS = {".nc": _XARRAY, ".hdf5": _XARRAY, ".h5": _XARRAY, ".hdr": _ENVI, ".img": _ENVI}
"""Suffixes that results are written to but not read from, and what to read them with."""

FORMER_NAMES = {"specular_albedo": "specular_reflectance"}
"""What buffers were called in files of earlier versions, and what they are called now."""
LAYER = "photonmap"  # Name of the layer whose passes the buffers are
COMBINED, DEPTH = "Combined", "Depth"  # What compositors call the picture and its depth
_PASSES = {"radiance": COMBINED, "depth": DEPTH}
_LETTERS = {1: ("Z",), 3: ("X", "Y", "Z")}


class Contents(NamedTuple):
    """What a file holds, as `photonmap.Result` does."""

    buffers: Images
    errors: Images  # standard errors by the names of their buffers
    bands: Bands
    record: dict[str, Any]  # JSON-able
    block_errors: Images
    """standard errors of means over blocks of pixels, by the names of their buffers"""


def channel_names(component: str, centroids: Sequence[float] | NDArray[np.float64]) -> list[str]:
    """Return the layout's channel names for centroids in nm, which are moved up until unique.

    Parameters
    ----------
    component : "S0" for light, "T" for reflectance

    Examples
    --------
    >>> channel_names("S0", [550.0, 550.0])
    ['S0.550,000000nm', 'S0.550,000001nm']
    """
    names: list[str] = []
    for centroid in centroids:
        micro = round(centroid * 1e6)
        while (name := f"{component}.{micro // 10**6},{micro % 10**6:06}nm") in names:
            micro += 1
        names.append(name)
    return names


@cache
def sensitivity_texts(bands: Bands) -> tuple[str, ...]:
    """Return the sensitivities of bands as attributes, "550nm:0.1;560nm:0.2".

    Decimal points and no semicolon at the end: so the authors' library and colour-science read
    it. The former drops the last sample, which is why each curve ends with a 0 outside its range.
    """
    texts = []
    for curve in bands.sensitivities:
        nm, values = curve.wavelengths, curve.values
        open_ends = tuple((values[[0, -1]] != 0.0).astype(int))
        nm = np.pad(nm, open_ends, constant_values=(nm[0] - 1e-6, nm[-1] + 1e-6))
        samples = zip(nm, np.pad(values, open_ends), strict=True)
        texts.append(";".join(f"{at:.9g}nm:{value:.9g}" for at, value in samples))
    return tuple(texts)


def name_errors(errors: Images, block_errors: Images) -> Images:
    """Return standard errors by the names of their parts: "direct.error", "indirect.error8"."""
    named = {name + _ERROR: image for name, image in errors.items()}
    return named | {name + _BLOCK_ERROR: image for name, image in block_errors.items()}


def current_name(part: str) -> str:
    """Return what a part of a file is called now: a buffer, or a standard error.

    Examples
    --------
    >>> current_name("specular_albedo"), current_name("direct@sun.error")
    ('specular_reflectance', 'direct@sun.error')
    """
    return FORMER_NAMES.get(part, part)


def sort_parts(parts: Images) -> tuple[Images, Images, Images]:
    """Return the buffers, errors and errors of blocks among the parts of a file."""
    endings: dict[str, Images] = {"": {}, _ERROR: {}, _BLOCK_ERROR: {}}
    for part, image in parts.items():
        ending = next((e for e in (_BLOCK_ERROR, _ERROR) if part.endswith(e)), "")
        endings[ending][part.removesuffix(ending)] = image
    return endings[""], endings[_ERROR], endings[_BLOCK_ERROR]


def write_exr(
    contents: Contents, path: str | PathLike[str], to_rgb: Projector, halves: Collection[str] = ()
) -> None:
    """Write all buffers and errors to one multi-part OpenEXR, part by part.

    Part 0 is `radiance`, if it is there, with R, G, B for viewers, in linear sRGB. The other
    buffers follow in their order, then the errors, named as in "direct.error", and those of blocks
    of pixels, as in "indirect.error8", which are smaller images.

    halves : names of the parts to write in half precision

    Raises
    ------
    OSError : the file cannot be written; a part of it may be there
    """
    import OpenImageIO

    bands = contents.bands
    parts = dict(sorted(contents.buffers.items(), key=lambda item: item[0] != "radiance"))
    parts |= name_errors(contents.errors, contents.block_errors)
    specs = [_describe(part, image, bands, part in halves) for part, image in parts.items()]
    height, width = next(iter(contents.buffers.values())).shape[:2]
    for spec in specs:
        spec.full_width, spec.full_height = width, height  # the same in all parts of a file
    specs[0].attribute(_RECORD, json.dumps(contents.record))
    specs[0].attribute(_BANDS, json.dumps(bands.describe()))
    for part, spec in zip(parts, specs, strict=True):
        if names := contents.record.get(_NAMED.get(part, "")):
            spec.attribute(_NAMES, json.dumps(names))
    file = OpenImageIO.ImageOutput.create("exr")
    assert file is not None
    with closing(file):
        done = file.open(str(path), specs)
        for index, (part, image) in enumerate(parts.items()):
            done = done and (index == 0 or file.open(str(path), specs[index], "AppendSubimage"))
            first = 0
            for lines in _lines(part, image, bands, to_rgb):
                done = done and file.write_scanlines(first, first + len(lines), 0, lines)
                first += len(lines)
        if not (done and file.close()):
            raise OSError(file.geterror())


def read_exr(path: str | PathLike[str], names: Collection[str] | None = None) -> Contents:
    """Read what `write_exr` wrote; half precision becomes float32.

    names : of the parts to read; None for all
    """
    with closing(_open(path)) as file:
        head = file.spec()
        if _RECORD not in head or _BANDS not in head:
            raise InputError("this was not written by photonmap; give a FILE.exr that was", path)
        try:
            record = json.loads(head.get_string_attribute(_RECORD))
            bands = _described_bands(head.get_string_attribute(_BANDS))
            parts = dict(
                _read_part(file, index, bands)
                for index, spec in enumerate(_specs(file))
                if names is None or _part_name(spec) in names
            )
        except ValueError as error:
            raise InputError(f"this is damaged: {error}", path) from None
    buffers, errors, block_errors = sort_parts(parts)
    return Contents(buffers, errors, bands, record, block_errors)


@lru_cache(maxsize=4)
def _described_bands(text: str) -> Bands:
    """Return the bands of a head; parts of files that are read one by one have the same."""
    return Bands.from_description(json.loads(text))


def _open(path: str | PathLike[str]) -> OpenImageIO.ImageInput:
    """Open a file; raise `InputError` if there is none of this name, or it is no OpenEXR."""
    import OpenImageIO

    if Path(path).is_dir():
        raise InputError("this is a folder; give the FILE.exr of a render", path)
    if not Path(path).is_file():
        if Path(path).exists():
            raise InputError("this is a device or a pipe; give the FILE.exr of a render", path)
        raise InputError("there is no such file; check its name", path)
    if (file := OpenImageIO.ImageInput.open(str(path))) is not None:
        return file
    reason = OpenImageIO.geterror().partition("\n")[0]
    if (suffix := Path(path).suffix.lower()) in _FOR_OTHERS:
        how = f"files in {suffix} are for other programs, as {_FOR_OTHERS[suffix]}"
        raise InputError(f"{how}; save the render as FILE.exr too, and give that", path)
    if not str(path).lower().endswith(".exr"):
        raise InputError("this is not a render; give the FILE.exr of one", path)
    raise InputError(f"this is not an OpenEXR file, or it is damaged: {reason}", path)


def list_parts(path: str | PathLike[str], half: bool = False) -> list[str]:
    """Return the names of a file's parts, or of those in half precision; no image is read."""
    with closing(_open(path)) as file:
        kept = [spec for spec in _specs(file) if not half or str(spec.format) == "half"]
        return [_part_name(spec) for spec in kept]


def _specs(file: OpenImageIO.ImageInput) -> list[OpenImageIO.ImageSpec]:
    count = file.spec().get_int_attribute("oiio:subimages", 1)
    return [file.spec(i) for i in range(count)]


def _part_name(spec: OpenImageIO.ImageSpec) -> str:
    return current_name(spec.get_string_attribute("oiio:subimagename"))


def _row_of(part: str) -> Buffer | None:
    """Return the row of the buffer that a part belongs to: direct's of "direct@sun.error"."""
    return row_of(part.removesuffix(_BLOCK_ERROR).removesuffix(_ERROR))


def _is_integer(part: str) -> bool:
    """Return whether a part holds uint32: the image of such a buffer, not its error."""
    row = row_of(part)
    return row is not None and row.is_integer


def _channels(part: str, bands: Bands) -> list[str]:
    row = _row_of(part)
    if row is not None and row.channels is not None:
        return list(row.channels)
    if bands.centroids is None:
        return list(_RGB)
    is_light = row is None or row.quantity == "radiance"
    return channel_names("S0" if is_light else "T", bands.centroids)


def _describe(part: str, image: NDArray[Any], bands: Bands, half: bool) -> OpenImageIO.ImageSpec:
    """Describe a part: its size, its channels and the attributes of the spectral layout."""
    import OpenImageIO

    height, width = image.shape[:2]
    names = _channels(part, bands)
    viewers = _RGB if part == "radiance" and not bands.is_rgb else ()
    real = OpenImageIO.HALF if half else OpenImageIO.FLOAT
    kind = OpenImageIO.UINT if _is_integer(part) else real
    spec = OpenImageIO.ImageSpec(width, height, len(viewers) + len(names), kind)
    spec.channelnames = (*viewers, *names)
    attributes = {"oiio:subimagename": part, "compression": _COMPRESSION, "DateTime": _NO_DATE}
    if names[0].startswith(("S0.", "T.")):
        attributes["spectralLayoutVersion"] = "1.0"
        attributes |= zip(names, sensitivity_texts(bands), strict=True)
    if names[0].startswith("S0."):
        attributes["emissiveUnits"] = "W.m^-2.sr^-1"
    for name, text in attributes.items():
        spec.attribute(name, text)
    return spec


def _lines(
    part: str, image: NDArray[Any], bands: Bands, to_rgb: Projector
) -> Iterator[NDArray[Any]]:
    """Give a part's channels as `_describe` lists them: (lines, W, C), from the top down."""
    kind = np.uint32 if _is_integer(part) else np.float32
    for first in range(0, len(image), _LINES):
        lines = image[first : first + _LINES]
        if part == "radiance" and not bands.is_rgb:
            lines = np.concatenate([to_rgb(lines), lines], axis=-1)
        yield np.ascontiguousarray(lines.reshape(*lines.shape[:2], -1), dtype=kind)


def _read_part(file: OpenImageIO.ImageInput, index: int, bands: Bands) -> tuple[str, NDArray[Any]]:
    """Return a part's name and its image, its channels in the order of the bands."""
    import OpenImageIO

    spec = file.spec(index)
    part = _part_name(spec)
    names, row = _channels(part, bands), _row_of(part)
    if not set(names) <= set(spec.channelnames):
        raise ValueError(f"part {part!r} does not have the channels that its bands need")
    kind = OpenImageIO.UINT if _is_integer(part) else OpenImageIO.FLOAT
    pixels = file.read_image(index, 0, 0, spec.nchannels, kind)
    if pixels is None:
        raise ValueError(f"part {part!r} cannot be read: {file.geterror()}")
    if names != list(spec.channelnames):
        pixels = np.take(pixels, [spec.channelindex(name) for name in names], axis=-1)
    if row is not None and not row.is_banded and len(names) == 1:
        pixels = pixels[..., 0]
    return part, pixels.astype(bool) if row is not None and row.is_mask else pixels


def write_layers(
    colors: Mapping[str, NDArray[Any]],
    others: Mapping[str, NDArray[Any]],
    path: str | PathLike[str],
) -> None:
    """Write FILE.exr in one part, with channels named as in "photonmap.direct.R", float32.

    The radiance is called Combined, and has `coverage` as its alpha; depth is called Depth.

    colors : buffers in linear sRGB, (H, W, 3)
    others : buffers without a colour, (H, W) or (H, W, 3)
    """
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise InputError("layers are written as OpenEXR; write FILE.exr", path)
    channels: dict[str, NDArray[Any]] = {}
    images = {**colors, **others}
    # dots would separate layers
    layers = {name: _PASSES.get(name, name.replace(".", "_")) for name in images}
    check_distinct(layers)
    for name, image in images.items():
        planes = image.reshape(*image.shape[:2], -1)
        letters = ("R", "G", "B") if name in colors else _LETTERS[planes.shape[-1]]
        for letter, plane in zip(letters, np.moveaxis(planes, -1, 0), strict=True):
            channels[f"{LAYER}.{layers[name]}.{letter}"] = plane
    if "radiance" in colors and "coverage" in others:
        channels[f"{LAYER}.{COMBINED}.A"] = others["coverage"]
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.stack([plane.astype(np.float32) for plane in channels.values()], axis=-1)
    write_image(pixels, path, tuple(channels))
