"""Hugging Face's layout: Parquet tables by split, which its `datasets` package reads."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.dataset.files.image_files import PREVIEWED
from photonmap.dataset.files.reader import Image
from photonmap.dataset.publication.samples import Samples, array_file, describe, pictures_of
from photonmap.errors import InputError

if TYPE_CHECKING:
    import pyarrow

DATA = "data"
_FIELDS = {
    "name": "string", "scene": "string", "seed": "int64", "illumination": "string",
    "view": "string", "width": "int32", "height": "int32", "error": "float64", "reached": "bool",
    "manifest": "string",
}  # fmt: skip
"""Columns beside pictures and arrays, and their types."""


def column_of(name: str) -> str:
    """Return the column of an array: "rgb_shading" of "rgb.shading"."""
    return name.replace(".", "_")


def check_pyarrow() -> None:
    """Raise `InputError` without pyarrow."""
    if find_spec("pyarrow") is None:
        raise InputError("Parquet tables need pyarrow: pip install 'photonmap[publish]'")


def write_tables(folder: Path, samples: Samples) -> None:
    """Write data/PART-00000.parquet … for each split.

    A row is an image, and a row group of its own, so that it can be read alone. Pictures are
    columns of images; arrays are columns of bytes, as .npy files have them.

    Raises
    ------
    InputError : an image has no such array, or is damaged
    OSError : a file cannot be written
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
    path: Path,
    schema: pyarrow.Schema,
    images: list[Image],
    row_of: Callable[[Image], dict[str, Any]],
    most: float,
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
    return {**dict(zip(_FIELDS, cells, strict=True)), **pictures, **_apart(arrays)}


def _apart(arrays: dict[str, Any]) -> dict[str, Any]:
    """Return arrays by columns that no picture has."""
    return {f"{name}_npy": data for name, data in arrays.items()}


def _schema(names: Sequence[str]) -> pyarrow.Schema:
    """Return the columns, with what `datasets` knows them as."""
    import pyarrow

    makers = {"string": pyarrow.string, "int64": pyarrow.int64, "int32": pyarrow.int32,
              "float64": pyarrow.float64, "bool": pyarrow.bool_}  # fmt: skip
    picture = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
    columns = [(name, makers[kind]()) for name, kind in _FIELDS.items()]
    columns += [(name, picture) for name in PREVIEWED]
    arrays = list(_apart(dict.fromkeys(map(column_of, names))))
    columns += [(name, pyarrow.binary()) for name in arrays]
    features: dict[str, Any] = {n: {"dtype": k, "_type": "Value"} for n, k in _FIELDS.items()}
    features |= {name: {"_type": "Image"} for name in PREVIEWED}
    features |= {name: {"dtype": "binary", "_type": "Value"} for name in arrays}
    described = json.dumps({"info": {"features": features}})
    return pyarrow.schema(columns, metadata={"huggingface": described})
