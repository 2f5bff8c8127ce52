"""The files of a render: the image, in one of several formats, a PNG to look at, a JSON record."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable, Iterable
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import check_buffers
from photonmap.errors import InputError
from photonmap.io.exr import Contents, Projector
from photonmap.io.png import write_png
from photonmap.results.formats import WRITERS, check_format
from photonmap.runtime.file_checks import check_writable


class Preview(NamedTuple):
    """An 8-bit image and the exposure at which it shows radiance."""

    image: NDArray[np.uint8]
    """(H, W, 3) sRGB"""
    exposure: float


def check_output(path: str | PathLike[str], buffers: Iterable[str] | None = None) -> Path:
    """Check before a render that FILE.exr, FILE.png and FILE.json can be written.

    Parameters
    ----------
    path : FILE.exr, or a file of another of `photonmap.results.formats`
    buffers : names of those to be written; None for all

    Raises
    ------
    InputError
        if there is no such format, it needs a package that is missing, the folder is not
        writable, or there is no such buffer
    """
    check_buffers(buffers)
    path = Path(path)
    check_format(path)
    for file in (path, path.with_suffix(".png"), path.with_suffix(".json")):
        if file.is_dir():
            raise InputError("this is a folder; remove it or choose another name", file)
    check_writable(path.parent, path)
    return path


def save_all(
    contents: Contents,
    path: str | PathLike[str],
    to_rgb: Projector,
    preview: Callable[[], Preview] | None,
) -> None:
    """Write FILE.exr, FILE.png and FILE.json; none of them appears before all are complete.

    The suffix chooses the format, as `photonmap.results.formats` lists them. The folder is made if
    it is missing.

    The JSON is the record, with the exposure of the PNG and the seconds that writing the images
    took.

    Parameters
    ----------
    contents : what to write to the image, and the record
    path : FILE.exr, or a file of another format
    to_rgb : projects radiance for the OpenEXR's viewers
    preview : makes the PNG; None for none

    Raises
    ------
    InputError
        if such files cannot be written to `path`
    OSError
        if writing fails
    """
    path = check_output(path)
    record, start = contents.record, time.perf_counter()
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as folder:
        image = Path(folder) / path.name
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
