"""Export a data set to the layouts that training reads: WebDataset's and Hugging Face's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike

from photonmap.dataset.files.inputs import warn_of_left_out
from photonmap.dataset.files.reader import open_dataset
from photonmap.dataset.publication.card import write_card
from photonmap.dataset.publication.licenses import find_license
from photonmap.dataset.publication.publish import CARD, LICENSE, check_complete
from photonmap.dataset.publication.samples import (
    Samples,
    by_split,
    new_folder,
    read_array,
    usual_names,
    warn_of_empty,
)
from photonmap.dataset.publication.shards import write_shards
from photonmap.dataset.publication.tables import DATA, check_pyarrow, write_tables
from photonmap.errors import InputError
from photonmap.runtime.wording import suggest

WEBDATASET, HUGGING_FACE = "webdataset", "huggingface"
LAYOUTS = (WEBDATASET, HUGGING_FACE)
SHARD = 2.0**29
"""Usual bytes of a shard."""
_LEAST = 4096
"""Fewest bytes of a shard that can be asked for."""

_READING = {
    WEBDATASET: """\
```python
import webdataset

for sample in webdataset.WebDataset("train-000000.tar").decode():
    sample["rgb.reflectance.npy"], sample["rgb.shading.npy"], sample["json"]
```

`index.jsonl` says where each sample and each of its files lies, as offset and length in bytes, so
that single arrays can be read over HTTP: `photonmap.dataset.open_shards(URL)[NAME]["rgb.shading"]`.
`shards.json` has sizes and checksums.""",
    HUGGING_FACE: """\
```python
import io

import datasets
import numpy

for row in datasets.load_dataset(".", split="train"):
    row["radiance"]  # a picture, 8-bit sRGB
    numpy.load(io.BytesIO(row["rgb_shading_npy"]))  # the array
```

`manifest` of a row is what is known of its image, as JSON. A row is a row group of its own.""",
}


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
    license_name : of SPDX, see `photonmap.dataset.publication.licenses`; or a file of its text
    names : of the arrays: "depth", "shading@lamp", and "rgb.shading" in the set's RGB; None for
        `samples.DEFAULT`, as far as the images hold them
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
        head = _configs(list(parts)) if layout == HUGGING_FACE else []
        title = images.folder.resolve().name
        card = write_card(images, license_, title, _READING[layout], head)
        (made / CARD).write_text(card, encoding="utf-8")
        (made / LICENSE).write_text(license_.text, encoding="utf-8")


def _configs(parts: Sequence[str]) -> list[str]:
    """Return where Hugging Face finds the files of each split, for the head of the card."""
    names = {"val": "validation"}
    files = [
        line
        for part in parts
        for line in (
            f"  - split: {names.get(part, part)}",
            f"    path: {DATA}/{part}-*.parquet",
        )
    ]
    return ["configs:", "- config_name: default", "  data_files:", *files]
