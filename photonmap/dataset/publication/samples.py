"""The samples of an exported data set: what shards and tables hold of each image."""

from __future__ import annotations

import io
import json
import re
import shutil
import tempfile
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.files.derived_buffers import as_rgb
from photonmap.dataset.files.image_files import PREVIEWED, previews
from photonmap.dataset.files.reader import Dataset, Image
from photonmap.dataset.files.splits import PARTS, part_of
from photonmap.errors import InputError, warn
from photonmap.io.png import encode_png
from photonmap.runtime.file_checks import check_output_folder
from photonmap.runtime.wording import suggest

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
    """What is exported.

    Parameters
    ----------
    parts : images by split
    names : of the arrays, as `read_array` takes them
    most : bytes of a file, unless a single sample is larger
    log : called with a line for each split
    """

    parts: dict[str, list[Image]]
    names: Sequence[str]
    most: float
    log: Callable[[str], None]

    def halves(self) -> frozenset[str]:
        """Return the names of the arrays that all images hold in half precision, as lean files do.

        They are exported so, which loses nothing, and an array has one type in all samples.
        """
        found = {*self.names}
        for images in self.parts.values():
            for image in images:
                found &= image.halves | {RGB + name for name in image.rgb_halves}
        return frozenset(found)


def key_of(image: Image) -> str:
    """Return the name of an image without dots, which end the key of a sample."""
    return image.name.replace(".", "_")


def usual_names(image: Image) -> list[str]:
    """Return those of `DEFAULT` that an image holds."""
    return [
        name for name in DEFAULT if image.chosen is None or name.removeprefix(RGB) in image.chosen
    ]


def read_array(image: Image, name: str) -> NDArray[Any]:
    """Return an array by the name that `--arrays` takes: "depth", "rgb.shading", "shading@lamp".

    Raises
    ------
    InputError : there is none
    """
    where, bare = (image.rgb, name[len(RGB) :]) if name.startswith(RGB) else (image, name)
    if bare not in where:
        known = [*image, *(RGB + each for each in image.rgb)]
        raise InputError(f"{image.name} has no array {name!r}; {suggest(name, known)}")
    return where[bare]


def members_of(
    image: Image, names: Sequence[str], halves: Collection[str] = ()
) -> dict[str, bytes]:
    """Return what is exported of an image by the endings of its files: npy, png and json.

    Parameters
    ----------
    names : of the arrays
    halves : names of those to write in half precision

    Raises
    ------
    InputError : there is no array of a name, or the image is damaged
    """
    arrays = {f"{_file_name(name)}.npy": array_file(image, name, halves) for name in names}
    pictures = {f"{name}.png": data for name, data in pictures_of(image).items()}
    return {"json": describe(image).encode(), **pictures, **arrays}


def pictures_of(image: Image) -> dict[str, bytes]:
    """Return the 8-bit sRGB pictures of an image as PNG files, by the names of their buffers."""
    files = {name: image.folder / f"{name}.png" for name in PREVIEWED}
    if all(path.is_file() for path in files.values()):
        return {name: path.read_bytes() for name, path in files.items()}
    shown = previews(image.result, as_rgb(image.result))
    return {name: encode_png(picture) for name, picture in shown.items()}


def describe(image: Image) -> str:
    """Return what the manifest says of an image, as JSON."""
    entry = {name: value for name, value in image.entry.items() if name not in _LEFT_OUT}
    return json.dumps(entry, ensure_ascii=False)


def array_file(image: Image, name: str, halves: Collection[str] = ()) -> bytes:
    """Return an array as the bytes of a .npy file, in half precision if it is one of `halves`.

    Raises
    ------
    InputError : there is none
    """
    array, file = read_array(image, name), io.BytesIO()
    kind = np.float16 if name in halves else array.dtype
    np.save(file, np.ascontiguousarray(array, kind), allow_pickle=False)
    return file.getvalue()


def _file_name(name: str) -> str:
    """Return the name of an array as it can stand in the name of a file."""
    return re.sub(r"[^\w.@-]", "_", name)


def by_split(images: Dataset) -> dict[str, list[Image]]:
    """Return the images of each split that has any."""
    parts: dict[str, list[Image]] = defaultdict(list)
    for image in images:
        parts[image.entry.get("split") or part_of(image.geometry)].append(image)
    return {part: parts[part] for part in PARTS if part in parts}


def warn_of_empty(parts: Collection[str]) -> None:
    """Warn of the splits that are not among those that have images."""
    if missing := [part for part in PARTS if part not in parts]:
        warn(f"no scene is in {' and '.join(missing)}; a larger --count adds some")


@contextmanager
def new_folder(output: str | PathLike[str]) -> Iterator[Path]:
    """Give a folder to write to, which becomes `output` when all is written, or vanishes.

    Raises
    ------
    InputError : there is a file of this name, or a folder that is not empty
    """
    folder = check_output_folder(output, "the export")
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError("is not empty; choose a new folder", folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    made = Path(tempfile.mkdtemp(prefix=".photonmap-", dir=folder.parent))
    try:
        made.chmod(0o755)
        yield made
        if folder.is_dir():
            folder.rmdir()
        made.rename(folder)
    finally:
        shutil.rmtree(made, ignore_errors=True)
