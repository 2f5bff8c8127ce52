"""Export a data set to the layouts that training reads: WebDataset's and Hugging Face's."""

from __future__ import annotations

import io
import json
import re
import tarfile
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import check_distinct
from photonmap.dataset.files.derived_buffers import as_rgb
from photonmap.dataset.files.image_files import PREVIEWED, hash_files, previews
from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.manifest import warn_of_left_out
from photonmap.dataset.files.reader import Image, open_dataset
from photonmap.dataset.publication.card import find_license, how_to_read, write_card
from photonmap.dataset.publication.publish import (
    CARD,
    LICENSE,
    by_split,
    check_complete,
    warn_of_empty,
)
from photonmap.errors import InputError
from photonmap.io.png import encode_png
from photonmap.runtime.wording import suggest
from photonmap.runtime.writing import check_output_folder, drafts_beside

if TYPE_CHECKING:
    import pyarrow

WEBDATASET, HUGGING_FACE = "webdataset", "huggingface"
LAYOUTS = (WEBDATASET, HUGGING_FACE)
SHARD = 2.0**29
"""Usual bytes of a shard."""
_LEAST = 4096  # fewest bytes of a shard that can be asked for


def export(
    folder: str | PathLike[str],
    output: str | PathLike[str],
    layout: str,
    license_name: str,
    names: Sequence[str] | None = None,
    most: float = SHARD,
    log: Callable[[str], None] = lambda line: None,
) -> None:
    """Write a data set in another layout, by split, with a data card and its licence.

    Parameters
    ----------
    folder : of a data set of which all images are there
    output : new folder to write to; it appears when all is written
    layout : one of `LAYOUTS`
    license_name : of SPDX, see `photonmap.dataset.publication.card`; or a file of its text
    names : of the arrays: "depth", "shading@lamp", and "rgb.shading" in the set's RGB; None for
        `DEFAULT`, as far as the images hold them
    most : bytes of a file, unless a single sample is larger
    log : called with a line for each split

    Raises
    ------
    InputError : the folder holds no data set, images are missing, a name is not known, the output
        is not new, or a package is missing
    OSError : the files cannot be written
    """
    if layout not in LAYOUTS:
        raise InputError(f"there is no layout {layout!r}; {suggest(layout, LAYOUTS)}")
    if not most >= _LEAST:
        raise InputError(f"shards of {most:g} bytes are too small; choose {_LEAST} or more")
    if layout == HUGGING_FACE:
        check_pyarrow()
    license_, images = find_license(license_name), open_dataset(folder)
    check_complete(images)
    warn_of_left_out(images.head)
    wanted = list(dict.fromkeys(usual_names(images[0]) if names is None else names))
    for name in wanted:
        read_array(images[0], name)
    write = write_shards if layout == WEBDATASET else write_tables
    with new_folder(output) as made:
        parts = by_split(images)
        warn_of_empty(parts)
        write(made, Samples(parts, wanted, most, log))
        head = _configs(parts) if layout == HUGGING_FACE else []
        title = images.folder.resolve().name
        card = write_card(images, license_, title, how_to_read(layout), head)
        (made / CARD).write_text(card, encoding="utf-8")
        (made / LICENSE).write_text(license_.text, encoding="utf-8")


def _configs(parts: Iterable[str]) -> list[str]:
    """Return where Hugging Face finds the files of each split, for the head of the card."""
    files = [
        f"  - split: {'validation' if part == 'val' else part}\n    path: {DATA}/{part}-*.parquet"
        for part in parts
    ]
    return ["configs:", "- config_name: default", "  data_files:", *files]


RGB = "rgb."
"""Stands before the name of an array in the set's RGB."""
DEFAULT = (
    "rgb.radiance", "rgb.direct", "rgb.indirect", "rgb.reflectance", "rgb.shading", "depth",
    "normal", "object_id", "valid", "pure",
)  # fmt: skip
"""Arrays that are exported unless others are asked for."""
_LEFT_OUT = ("files", "arrays", "statistics", "fingerprint")
"""What the manifest says of an image's own files, which samples do not repeat."""


class Samples(NamedTuple):
    """What is exported."""

    parts: dict[str, list[Image]]  # images by split
    names: Sequence[str]  # of the arrays, as `read_array` takes them
    most: float  # bytes of a file, unless a single sample is larger
    log: Callable[[str], None]  # called with a line for each split

    def halves(self) -> frozenset[str]:
        """Return the names of the arrays that all images hold in half precision, as lean files do.

        They are exported so, which loses nothing, and an array has one type in all samples.
        """
        found = {*self.names}
        for images in self.parts.values():
            for image in images:
                found &= image.halves | {RGB + name for name in image.rgb_halves}
        return frozenset(found)


def usual_names(image: Image) -> list[str]:
    """Return those of `DEFAULT` that an image holds."""
    return [
        name for name in DEFAULT if image.chosen is None or name.removeprefix(RGB) in image.chosen
    ]


def read_array(image: Image, name: str) -> NDArray[Any]:
    """Return an array by the name that `--arrays` takes: "depth", "rgb.shading", "shading@lamp"."""
    where, bare = (image.rgb, name[len(RGB) :]) if name.startswith(RGB) else (image, name)
    if bare not in where:
        known = [*image, *(RGB + each for each in image.rgb)]
        raise InputError(f"{image.name} has no array {name!r}; {suggest(name, known)}")
    return where[bare]


def members_of(
    image: Image, names: Sequence[str], halves: Collection[str] = ()
) -> dict[str, bytes]:
    """Return the files of a sample by their endings; the arrays of `halves` in half precision."""
    endings = {name: re.sub(r"[^\w.@-]", "_", name) for name in names}  # as files can be called
    check_distinct(endings)
    arrays = {f"{endings[name]}.npy": array_file(image, name, halves) for name in names}
    pictures = {f"{name}.png": data for name, data in pictures_of(image).items()}
    return {"json": describe(image).encode(), **pictures, **arrays}


def pictures_of(image: Image) -> dict[str, bytes]:
    """Return the 8-bit sRGB pictures of an image as PNG files, by the names of their buffers."""
    files = {name: inside(image.folder, f"{name}.png") for name in PREVIEWED}
    if all(path.is_file() for path in files.values()):
        return {name: path.read_bytes() for name, path in files.items()}
    shown = previews(image.result, as_rgb(image.result))
    return {name: encode_png(picture) for name, picture in shown.items()}


def describe(image: Image) -> str:
    """Return what the manifest says of an image, as JSON."""
    entry = {name: value for name, value in image.entry.items() if name not in _LEFT_OUT}
    return json.dumps(entry, ensure_ascii=False)


def array_file(image: Image, name: str, halves: Collection[str] = ()) -> bytes:
    """Return an array as the bytes of a .npy file, in half precision if it is one of `halves`."""
    array, file = read_array(image, name), io.BytesIO()
    kind = np.float16 if name in halves else array.dtype
    np.save(file, np.ascontiguousarray(array, kind), allow_pickle=False)
    return file.getvalue()


@contextmanager
def new_folder(output: str | PathLike[str]) -> Iterator[Path]:
    """Give a folder to write to, which becomes `output` when all is written, or vanishes."""
    folder = check_output_folder(output, "the export")
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError("is not empty; choose a new folder", folder)
    with drafts_beside(folder) as made:
        whole = made / folder.name
        whole.mkdir()
        yield whole
        if folder.is_dir():
            folder.rmdir()
        whole.rename(folder)


INDEX, SHARDS = "index.jsonl", "shards.json"
FORMAT = "photonmap shards 1"


def write_shards(folder: Path, samples: Samples) -> None:
    """Write PART-000000.tar … for each split, index.jsonl and shards.json.

    A line of the index has the name, key, split and shard of a sample; its `offset` and `length`,
    bytes; and `members`, those of the contents of each file by its ending.
    """
    shards: list[dict[str, Any]] = []
    names, halves = list(samples.names), samples.halves()
    with (folder / INDEX).open("w", encoding="utf-8") as index:
        for part, images in samples.parts.items():
            writer = _Writer(folder, part, samples.most)
            for image in images:
                line = writer.add(image, members_of(image, names, halves))
                index.write(json.dumps(line, ensure_ascii=False) + "\n")
            writer.close()
            digests = hash_files(folder, [path.name for path in writer.paths])
            for path in writer.paths:
                about = {"bytes": path.stat().st_size, "sha256": digests[path.name]}
                shards.append({"name": path.name, "split": part, **about})
            samples.log(f"{part}: images {len(images)}, shards {len(writer.paths)}")
    head = {"format": FORMAT, "arrays": names, "halves": sorted(halves), "shards": shards}
    (folder / SHARDS).write_text(json.dumps(head, indent=2) + "\n", encoding="utf-8")


class _Writer:
    """Writes samples to the shards of a split; begins another where one would be too large."""

    def __init__(self, folder: Path, part: str, most: float) -> None:
        self._folder, self._part, self._most = folder, part, most
        self._tar: tarfile.TarFile | None = None
        self.paths: list[Path] = []

    def add(self, image: Image, members: dict[str, bytes]) -> dict[str, Any]:
        """Write a sample; return its line of the index."""
        key = image.name.replace(".", "_")  # a dot ends the key of a sample
        files = sum(tarfile.BLOCKSIZE + _padded(len(data)) for data in members.values())
        tar = self._open(files + 2 * tarfile.BLOCKSIZE)  # with what ends a tar file
        begin, places = tar.offset, {}
        for ending, data in members.items():
            info = tarfile.TarInfo(f"{key}.{ending}")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
            places[ending] = [tar.offset - _padded(len(data)), len(data)]
        where = {"offset": begin, "length": tar.offset - begin, "members": places}
        what = {"name": image.name, "key": key, "split": self._part}
        return {**what, "shard": self.paths[-1].name, **where}

    def _open(self, more: int) -> tarfile.TarFile:
        """Return the shard that takes so many bytes more."""
        if self._tar and self._tar.offset + more <= self._most:
            return self._tar
        self.close()
        path = self._folder / f"{self._part}-{len(self.paths):06}.tar"
        self.paths.append(path)
        self._tar = tarfile.open(path, "w", format=tarfile.GNU_FORMAT)  # noqa: SIM115
        return self._tar

    def close(self) -> None:
        """End the shard."""
        if self._tar is not None:
            self._tar.close()
            self._tar = None


def _padded(size: int) -> int:
    return -(-size // tarfile.BLOCKSIZE) * tarfile.BLOCKSIZE


DATA = "data"
_FIELDS = {
    "name": "string", "scene": "string", "seed": "int64", "illumination": "string",
    "view": "string", "width": "int32", "height": "int32", "error": "float64", "reached": "bool",
    "manifest": "string",
}  # fmt: skip
"""Columns beside pictures and arrays, and their types."""


def column_of(name: str) -> str:
    """Return the column of an array, which no picture has: "rgb_shading_npy" of "rgb.shading"."""
    return name.replace(".", "_") + "_npy"


def check_pyarrow() -> None:
    """Raise `InputError` without pyarrow."""
    if find_spec("pyarrow") is None:
        raise InputError("Parquet tables need pyarrow: pip install 'photonmap[publish]'")


def write_tables(folder: Path, samples: Samples) -> None:
    """Write data/PART-00000.parquet … for each split.

    A row is an image, and a row group of its own, so that it can be read alone. Pictures are
    columns of images; arrays are columns of bytes, as .npy files have them.
    """
    (folder / DATA).mkdir()
    schema = _schema(samples.names)
    row_of = partial(_row, names=samples.names, halves=samples.halves())
    for part, images in samples.parts.items():
        files, rest = 0, images
        while rest:
            path = folder / DATA / f"{part}-{files:05}.parquet"
            rest = _write_table(path, schema, rest, row_of, samples.most)
            files += 1
        samples.log(f"{part}: images {len(images)}, files {files}")


def _write_table(
    path: Path, schema: pyarrow.Schema, images: list[Image], row_of: Callable, most: float
) -> list[Image]:
    """Write rows until the file has its size; return the images that are left."""
    import pyarrow
    import pyarrow.parquet

    with (
        path.open("wb") as file,
        pyarrow.parquet.ParquetWriter(file, schema, compression="zstd") as writer,
    ):
        for index, image in enumerate(images):
            begin = file.tell()
            writer.write_table(pyarrow.Table.from_pylist([row_of(image)], schema))
            if 2 * file.tell() - begin > most:
                return images[index + 1 :]
    return []


def _row(image: Image, names: Sequence[str], halves: Collection[str]) -> dict[str, Any]:
    entry, job = image.entry, image.entry["job"]
    width, height = entry["size"]
    values = (image.name, image.geometry, job["seed"], job["illumination"], job["view"]["name"])
    cells = (*values, width, height, entry["error"], entry["reached"], describe(image))
    pictures = {
        name: {"bytes": data, "path": f"{image.name}-{name}.png"}
        for name, data in pictures_of(image).items()
    }
    arrays = {column_of(name): array_file(image, name, halves) for name in names}
    return {**dict(zip(_FIELDS, cells, strict=True)), **pictures, **arrays}


def _schema(names: Sequence[str]) -> pyarrow.Schema:
    """Return the columns, with what `datasets` knows them as."""
    import pyarrow

    picture = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
    columns = [(name, pyarrow.type_for_alias(kind)) for name, kind in _FIELDS.items()]
    columns += [(name, picture) for name in PREVIEWED]
    arrays = list(dict.fromkeys(map(column_of, names)))
    columns += [(name, pyarrow.binary()) for name in arrays]
    features: dict[str, Any] = {n: {"dtype": k, "_type": "Value"} for n, k in _FIELDS.items()}
    features |= {name: {"_type": "Image"} for name in PREVIEWED}
    features |= {name: {"dtype": "binary", "_type": "Value"} for name in arrays}
    described = json.dumps({"info": {"features": features}})
    return pyarrow.schema(columns, metadata={"huggingface": described})
