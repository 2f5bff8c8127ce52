"""Write what a data set is published with into its folder."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.dataset.files.image_files import hash_files, list_files
from photonmap.dataset.files.manifest import FORMAT, HEAD, INPUTS, LINES, locked, warn_of_left_out
from photonmap.dataset.files.reader import Dataset, Image, open_dataset
from photonmap.dataset.files.schema import GROWN_HEAD_KINDS, faults_of_entry, misfits
from photonmap.dataset.files.splits import PARTS, part_of
from photonmap.dataset.publication.card import find_license, how_to_read, write_card
from photonmap.dataset.publication.metadata import (
    describe_cameras,
    describe_coco,
    describe_croissant,
)
from photonmap.errors import InputError, warn
from photonmap.runtime.wording import listed
from photonmap.runtime.writing import written_together

CARD, LICENSE, SUMS = "README.md", "LICENSE", "SHA256SUMS"
CROISSANT, COCO, CAMERAS = "croissant.json", "annotations.json", "cameras.json"
_IDS = "object_id"  # buffer that annotations are made from


def publish(folder: str | PathLike[str], license_name: str) -> list[Path]:
    """Write the data card, licence, checksums, Croissant metadata, annotations and cameras.

    Without the ids of objects in the images, there are no annotations; scenes that are left out and
    splits without any scene are warned of. Files of these names are replaced, all of them or none.

    Parameters
    ----------
    folder : of a data set of which all images are there
    license_name : of SPDX, see `photonmap.dataset.publication.card`; or a file of its text

    Raises
    ------
    InputError : the folder holds no data set, images are missing, or there is no such licence
    OSError : the files cannot be written
    """
    license_, folder = find_license(license_name), Path(folder)
    images = open_dataset(folder)
    check_complete(images)
    warn_of_left_out(images.head)
    warn_of_empty(by_split(images))
    title = folder.resolve().name
    has_ids = all(_IDS in image for image in images)
    if not has_ids:
        warn(f"the images hold no {_IDS}, see --buffers, so there is no {COCO}")
    card = write_card(images, license_, title, how_to_read("folder", has_ids))
    with locked(folder), written_together(folder) as part:
        digests = hash_files(folder, (HEAD, LINES))
        inputs = [f"{INPUTS}/{name}" for name in list_files(folder / INPUTS)]
        (part / LICENSE).write_text(license_.text, encoding="utf-8")
        (part / CARD).write_text(card, encoding="utf-8")
        if has_ids:
            _write(part / COCO, describe_coco(images, license_))
        _write(part / CAMERAS, describe_cameras(images))
        _write(part / CROISSANT, describe_croissant(images, license_, title, digests))
        digests |= hash_files(part, list_files(part)) | hash_files(folder, inputs)
        for entry in images.entries:
            digests |= {f"{entry['name']}/{name}": sha for name, sha in entry["files"].items()}
        lines = "".join(f"{digest}  {name}\n" for name, digest in digests.items())
        (part / SUMS).write_text(lines, encoding="utf-8")  # as `sha256sum -c` reads it
        written = list_files(part)
    return [folder / name for name in written]


def check_complete(images: Dataset) -> None:
    """Raise `InputError` if images of a data set are missing, damaged in the manifest, or none."""
    there = {image.name for image in images}
    if missing := [name for name in images.head["images"] if name not in there]:
        names, remedy = listed(missing, 3), "run the data set again with --resume"
        raise InputError(f"{len(missing)} images are missing ({names}); {remedy}", images.folder)
    if not there:
        raise InputError("the data set has no images; run it again with --resume", images.folder)
    is_old = images.head["format"] != FORMAT
    if fault := next(misfits(images.head, GROWN_HEAD_KINDS), ""):
        raise InputError(f"{fault}; see what `dataset verify` finds", images.folder / HEAD)
    for number, entry in enumerate(images.entries, start=1):
        if faults := faults_of_entry(entry, is_old):
            problem = f"{entry['name']}: {faults[0]}; see what `dataset verify` finds"
            raise InputError(problem, images.folder / LINES, number)


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


def _write(path: Path, contents: Any) -> None:
    path.write_text(json.dumps(contents, ensure_ascii=False) + "\n", encoding="utf-8")
