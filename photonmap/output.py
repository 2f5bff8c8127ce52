"""The files of a render: one multi-part OpenEXR, a PNG to look at and a JSON record.

The OpenEXR layout is that of A. Fichet, R. Pacanowski and A. Wilkie, "An OpenEXR Layout for
Spectral Images", JCGT 10(3), 2021; part 0 is what its readers see.
"""

from __future__ import annotations

import json
import shutil
import struct
import tempfile
import time
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from photonmap.bands import Bands
from photonmap.errors import InputError
from photonmap.messages import suggest
from photonmap.places import check_writable

if TYPE_CHECKING:
    import OpenImageIO

    from photonmap.result import Result

Images = dict[str, NDArray[Any]]

LITTLE_ROOM = 100e6
"""Bytes on a disk, below which one may be full."""

_CHANNELS: dict[str, tuple[str, ...]] = {
    "coverage": ("Y",),
    "unresolved": ("Y",),
    "passes": ("count",),
    "depth": ("Z",),
    "normal": ("X", "Y", "Z"),
    "object_id": ("id",),
    "material_id": ("id",),
}
"""Channels of the buffers without bands."""

OF_SMOOTH = ("caustics", "residual")
"""Buffers that only scenes with mirrors or glass have."""
LIGHT = ("radiance", "emission", "direct", "indirect", *OF_SMOOTH)
BANDED = (*LIGHT, "reflectance", "shading", "covariance")
BUFFERS = (*BANDED, *_CHANNELS)
"""Names of all buffers that a render may have."""

_MASKS = ("unresolved", "valid", "light_source", "background")
_DERIVED = dict.fromkeys(("scalar_shading", *_MASKS[1:]), ("Y",))
"""Channels of buffers without bands that data sets add."""

_INTEGERS = (*_MASKS, "passes", "object_id", "material_id")
_SHARES = ("reflectance", "illuminant", "illuminant_direct")
"""Buffers with bands that have no unit."""
_RGB = ("R", "G", "B")
_ERROR, _OF_BLOCKS = ".error", ".error8"
_COMPRESSION = "zip"
"""Lossless, and every reader knows it; htj2k and zstd do better, but need the latest OpenEXR."""

_LINES = 64
"""Of an image that are written at a time: a multiple of what is compressed together, 16."""

_RECORD, _BANDS = "photonmapRecord", "photonmapBands"
"""Attributes of part 0, JSON: `Result.record` and `Bands.describe`."""


def in_order(buffers: Images) -> Images:
    """Return buffers in the order of `BUFFERS`, then those of each group as in "direct@sun"."""
    groups = ["", *dict.fromkeys(name.partition("@")[2] for name in buffers)]

    def place(name: str) -> tuple[int, int]:
        buffer, _, group = name.partition("@")
        return groups.index(group), BUFFERS.index(buffer)

    return {name: buffers[name] for name in sorted(buffers, key=place)}


def check_buffers(names: Iterable[str] | None) -> None:
    """Raise InputError if one of the names is of no buffer, or if there is none; None is all."""
    if names is None:
        return
    names = list(names)
    for name in names:
        if name not in BUFFERS:
            raise InputError(f"there is no buffer {name!r}; {suggest(name, BUFFERS)}")
    if not names:
        raise InputError("no buffer was chosen")


def check_output(path: str | PathLike[str], buffers: Iterable[str] | None = None) -> Path:
    """Check before a render that FILE.exr, FILE.png and FILE.json can be written.

    Parameters
    ----------
    path : FILE.exr
    buffers : names of those to be written; None for all

    Raises
    ------
    InputError
        if the suffix is another, the folder is missing or not writable, or there is no such buffer
    """
    check_buffers(buffers)
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise InputError("the name of the output must end in .exr, as in image.exr", path)
    for file in (path, path.with_suffix(".png"), path.with_suffix(".json")):
        if file.is_dir():
            raise InputError("this is a folder; remove it or choose another name", file)
    folder = path.parent
    if not folder.is_dir():
        state = "is not a folder" if folder.exists() else "does not exist"
        raise InputError(f"the folder {folder} {state}; create it or choose another", path)
    check_writable(folder, path)
    return path


def save_all(
    result: Result, path: str | PathLike[str], buffers: Iterable[str] | None = None
) -> None:
    """Write FILE.exr, FILE.png and FILE.json; none of them appears before all are complete.

    The PNG shows `radiance` and is left out where there is none; the JSON is the record, with the
    `exposure` of the PNG and the seconds that writing the images took.

    Parameters
    ----------
    result : what to write
    path : FILE.exr
    buffers : names of those to write to the OpenEXR, with their errors; None for all

    Raises
    ------
    InputError
        if `path` is no place for such files, or a buffer is missing
    OSError
        if writing fails
    """
    path = check_output(path)
    chosen = result if buffers is None else result.select(buffers)
    record, start = result.record, time.perf_counter()
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as folder:
        image = Path(folder) / path.name
        written = [image.with_suffix(".json"), image]
        if "radiance" in result.buffers:
            record = {**record, "exposure": result.exposure}
            written.insert(0, image.with_suffix(".png"))
            write_png(result.preview(), written[0])
        write_exr(chosen, image)
        seconds = {**record.get("seconds", {}), "write": time.perf_counter() - start}
        write_json({**record, "seconds": seconds}, image.with_suffix(".json"))
        for file in written:
            file.replace(path.with_name(file.name))


def write_json(record: dict[str, Any], path: str | PathLike[str]) -> None:
    """Write a JSON-able record, indented, UTF-8."""
    text = json.dumps(record, indent=2, ensure_ascii=False)
    Path(path).write_text(text + "\n", encoding="utf-8")


def write_png(preview: NDArray[np.uint8], path: str | PathLike[str]) -> None:
    """Write an (H, W, 3) uint8 image in sRGB."""
    Path(path).write_bytes(encode_png(preview))


def encode_png(preview: NDArray[np.uint8]) -> bytes:
    """Return an (H, W, 3) uint8 image in sRGB as the bytes of a PNG file (ISO/IEC 15948)."""
    height, width, _ = preview.shape
    packer, above, packed = zlib.compressobj(), np.zeros(3 * width, np.uint8), []
    for line in preview.reshape(height, -1):
        # 2 is the filter that stores differences to the line above.
        packed.append(packer.compress(b"\2" + (line - above).tobytes()))
        above = line
    chunks = {
        b"IHDR": struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0),
        b"sRGB": b"\0",
        b"IDAT": b"".join([*packed, packer.flush()]),
        b"IEND": b"",
    }
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    )


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
    it. The former drops the last sample, which is why each curve ends with the 0 beyond its cut.
    """
    texts = []
    for curve in bands.sensitivities:
        nm, values = curve.wavelengths, curve.values
        open_ends = tuple((values[[0, -1]] != 0.0).astype(int))
        nm = np.pad(nm, open_ends, constant_values=(nm[0] - 1e-6, nm[-1] + 1e-6))
        samples = zip(nm, np.pad(values, open_ends), strict=True)
        texts.append(";".join(f"{at:.9g}nm:{value:.9g}" for at, value in samples))
    return tuple(texts)


def _base(part: str) -> str:
    """Return the buffer that a part holds: "direct" of "direct@sun.error"."""
    return part.removesuffix(_OF_BLOCKS).removesuffix(_ERROR).partition("@")[0]


def _channels(part: str, bands: Bands) -> list[str]:
    """Return the names of a part's channels, in the order of the buffer's last axis."""
    buffer = _base(part)
    if planes := _CHANNELS.get(buffer) or _DERIVED.get(buffer):
        return list(planes)
    if bands.centroids is None:
        return list(_RGB)
    return channel_names("T" if buffer in _SHARES else "S0", bands.centroids)


def _spec(part: str, image: NDArray[Any], bands: Bands) -> OpenImageIO.ImageSpec:
    """Describe a part: its size, its channels and the attributes of the spectral layout."""
    import OpenImageIO

    height, width = image.shape[:2]
    names = _channels(part, bands)
    viewers = _RGB if part == "radiance" and not bands.is_rgb else ()
    kind = OpenImageIO.UINT if part in _INTEGERS else OpenImageIO.FLOAT
    spec = OpenImageIO.ImageSpec(width, height, len(viewers) + len(names), kind)
    spec.channelnames = (*viewers, *names)
    attributes = {"oiio:subimagename": part, "compression": _COMPRESSION}
    if names[0].startswith(("S0.", "T.")):
        attributes["spectralLayoutVersion"] = "1.0"
        attributes |= zip(names, sensitivity_texts(bands), strict=True)
    if names[0].startswith("S0."):
        attributes["emissiveUnits"] = "W.m^-2.sr^-1"
    for name, text in attributes.items():
        spec.attribute(name, text)
    return spec


def _pixels(part: str, image: NDArray[Any], result: Result) -> Iterator[NDArray[Any]]:
    """Give a part's channels as `_spec` lists them: (lines, W, C) float32 or uint32, top down."""
    kind = np.uint32 if part in _INTEGERS else np.float32
    for first in range(0, len(image), _LINES):
        lines = image[first : first + _LINES]
        if part == "radiance" and not result.bands.is_rgb:
            rgb = replace(result, buffers={part: lines}, errors={}).rgb()
            lines = np.concatenate([rgb, lines], axis=-1)
        yield np.ascontiguousarray(lines.reshape(*lines.shape[:2], -1), dtype=kind)


def write_exr(result: Result, path: str | PathLike[str]) -> None:
    """Write all buffers and errors to one multi-part OpenEXR, part by part.

    Part 0 is `radiance`, if it is there, with R, G, B for viewers, in linear sRGB. The other
    buffers follow in their order, then the errors, named as in "direct.error", and those of blocks
    of pixels, as in "indirect.error8", which are smaller images.

    Raises
    ------
    OSError
        if writing fails
    """
    import OpenImageIO

    parts = dict(sorted(result.buffers.items(), key=lambda item: item[0] != "radiance"))
    parts |= name_errors(result)
    specs = [_spec(part, image, result.bands) for part, image in parts.items()]
    for spec in specs:
        spec.full_width, spec.full_height = result.size  # the same in all parts of a file
    specs[0].attribute(_RECORD, json.dumps(result.record))
    specs[0].attribute(_BANDS, json.dumps(result.bands.describe()))
    file = OpenImageIO.ImageOutput.create("exr")
    assert file is not None
    with closing(file):
        done = file.open(str(path), specs)
        for index, (part, image) in enumerate(parts.items()):
            done = done and (index == 0 or file.open(str(path), specs[index], "AppendSubimage"))
            first = 0
            for lines in _pixels(part, image, result):
                done = done and file.write_scanlines(first, first + len(lines), 0, lines)
                first += len(lines)
        if not (done and file.close()):
            why = file.geterror() + _tell_if_full(Path(path).parent)
            raise OSError(f"cannot write {Path(path).name}: {why}")


def _tell_if_full(folder: Path) -> str:
    """Tell how much room a folder's disk has, if it is little: OpenEXR does not say."""
    free = shutil.disk_usage(folder).free
    return f" ({free / 1e6:.1f} MB are free there)" if free < LITTLE_ROOM else ""


def name_errors(result: Result) -> Images:
    """Return the errors of a result, and those of blocks, by the names they have in files."""
    errors = {name + _ERROR: image for name, image in result.errors.items()}
    return errors | {name + _OF_BLOCKS: image for name, image in result.block_errors.items()}


def sort_parts(parts: Images) -> tuple[Images, Images, Images]:
    """Return the buffers, errors and errors of blocks among what a file has."""
    endings = {"": {}, _ERROR: {}, _OF_BLOCKS: {}}  # type: dict[str, Images]
    for part, image in parts.items():
        ending = next((e for e in (_OF_BLOCKS, _ERROR) if part.endswith(e)), "")
        endings[ending][part.removesuffix(ending)] = image
    return endings[""], endings[_ERROR], endings[_OF_BLOCKS]


def read_exr(
    path: str | PathLike[str],
) -> tuple[Images, Images, Bands, dict[str, Any], Images]:
    """Read what `write_exr` wrote: buffers, errors, bands, record and errors of blocks.

    Raises
    ------
    InputError
        if there is no such file, or it was not written by photonmap
    """
    import OpenImageIO

    if not Path(path).is_file():
        raise InputError("there is no such file", path)
    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        reason = OpenImageIO.geterror().partition("\n")[0]
        raise InputError(f"this is no OpenEXR, or damaged: {reason}", path)
    with closing(file):
        head = file.spec()
        if _RECORD not in head or _BANDS not in head:
            raise InputError("this was not written by photonmap; give a FILE.exr that was", path)
        try:
            record = json.loads(head.get_string_attribute(_RECORD))
            bands = Bands.from_description(json.loads(head.get_string_attribute(_BANDS)))
            count = head.get_int_attribute("oiio:subimages", 1)
            parts = dict(_read_part(file, index, bands) for index in range(count))
        except ValueError as error:
            raise InputError(f"this is damaged: {error}", path) from None
    buffers, errors, blocks = sort_parts(parts)
    return buffers, errors, bands, record, blocks


def _read_part(file: OpenImageIO.ImageInput, index: int, bands: Bands) -> tuple[str, NDArray[Any]]:
    """Return a part's name and its image, or raise ValueError; bands return to their order."""
    import OpenImageIO

    spec = file.spec(index)
    part = spec.get_string_attribute("oiio:subimagename")
    names = _channels(part, bands)
    if not set(names) <= set(spec.channelnames):
        raise ValueError(f"part {part!r} has other channels than its bands ask for")
    kind = OpenImageIO.UINT if part in _INTEGERS else OpenImageIO.FLOAT
    pixels = file.read_image(index, 0, 0, spec.nchannels, kind)
    if pixels is None:
        raise ValueError(f"part {part!r} cannot be read: {file.geterror()}")
    if names != list(spec.channelnames):
        pixels = np.take(pixels, [spec.channelindex(name) for name in names], axis=-1)
    if len(names) == 1 and _base(part) in (*_CHANNELS, *_DERIVED):
        pixels = pixels[..., 0]
    return part, pixels.astype(bool) if part in _MASKS else pixels
