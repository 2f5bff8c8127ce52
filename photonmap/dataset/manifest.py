"""The folder of a data set: manifest.json says what it is, manifest.jsonl has a line an image."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.dataset.jobs import Common, Job
from photonmap.errors import InputError
from photonmap.places import check_writable

HEAD, LINES = "manifest.json", "manifest.jsonl"
FORMAT = "photonmap data set 1"
_KEYS = {"name", "geometry", "job", "files"}
"""Some of those of an image's line."""


def describe_set(
    preset: str, common: Common, formats: Sequence[str], jobs: Sequence[Job]
) -> dict[str, Any]:
    """Return the head of a data set: what it was asked to be, and the names of its images."""
    from photonmap.record import describe_code

    return {
        "format": FORMAT,
        "preset": preset,
        "common": json.loads(json.dumps(asdict(common))),
        "formats": sorted(formats),
        "versions": describe_code(),
        "images": [job.name for job in jobs],
    }


def check_code(wanted: dict[str, str]) -> None:
    """Check that images rendered here are those of a data set, bit for bit.

    Parameters
    ----------
    wanted : what `photonmap.record.describe_code` returned where the set was begun

    Raises
    ------
    InputError : something is of another version here
    """
    from photonmap.record import describe_code

    here = describe_code()
    if told := told_apart({name: (wanted[name], here.get(name)) for name in wanted}):
        raise InputError(f"this worker has other versions: {told}; install those of the set")


def check_folder(path: str | PathLike[str], head: dict[str, Any], resume: bool) -> Path:
    """Check that a data set may be begun in a folder, or gone on with.

    Parameters
    ----------
    head : of the set that is to be there
    resume : go on with what is there

    Raises
    ------
    InputError : it holds another data set, or other files, or cannot be written to
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file; name a folder for the data set", folder)
    if folder.is_dir() and any(folder.iterdir()):
        _check_there(folder, head, resume)
    parent = folder if folder.is_dir() else folder.parent
    if not parent.is_dir():
        raise InputError(f"the folder {parent} does not exist; create it", folder)
    check_writable(parent, folder)
    return folder


def _check_there(folder: Path, head: dict[str, Any], resume: bool) -> None:
    """Refuse a folder that holds anything but the same data set, to be gone on with."""
    if not (folder / HEAD).is_file():
        raise InputError("this folder holds other files; name an empty one, or a new one", folder)
    there = read_head(folder)
    if not resume:
        raise InputError("holds a data set; add --resume, or name another folder", folder)
    if told := _difference(there, head):
        remedy = "name another folder, or bring back what the set was begun with"
        raise InputError(f"holds another data set: {told}; {remedy}", folder)


def _difference(there: dict[str, Any], here: dict[str, Any]) -> str:
    """Say in what two heads differ that images of one set have in common; "" if in nothing."""
    pairs = {
        **{key: (there.get(key), here[key]) for key in ("formats",)},
        **{key: (there["common"].get(key), value) for key, value in here["common"].items()},
        **{key: (there["versions"].get(key), value) for key, value in here["versions"].items()},
    }
    del pairs["munsell"], pairs["illuminants"]
    if pairs["inputs"][0] != pairs["inputs"][1]:
        pairs["curves of bands or measured sets"] = ("others", "these")
    del pairs["inputs"]
    told = told_apart(pairs)
    if not told and not set(there["images"]) & set(here["images"]):
        return f"preset {there['preset']} and other seeds there, {here['preset']} here"
    return told


def told_apart(pairs: dict[str, tuple[Any, Any]]) -> str:
    """Say which entries differ there and here; "" if none does."""
    return ", ".join(
        f"{name} {there} there, {here} here"
        for name, (there, here) in pairs.items()
        if there != here
    )


def read_head(folder: str | PathLike[str]) -> dict[str, Any]:
    """Return the head of a data set.

    Raises
    ------
    InputError : the folder holds none
    """
    path = Path(folder) / HEAD
    try:
        head = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("holds no data set; give a folder that has one", folder) from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({error}); it is damaged", path) from None
    if not isinstance(head, dict) or head.get("format") != FORMAT:
        raise InputError("is no head of a data set of this version", path)
    return head


def read_lines(folder: str | PathLike[str]) -> list[dict[str, Any]]:
    """Return the entries of all images, in the order of the manifest.

    Raises
    ------
    InputError : the manifest is missing or damaged
    """
    path = Path(folder) / LINES
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        entries = [json.loads(line) for line in lines]
        if any(not isinstance(entry, dict) or not entry.keys() >= _KEYS for entry in entries):
            raise ValueError("a line is of no image")
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({error}); run the set with --resume", path) from None
    return entries


def write_head(folder: Path, head: dict[str, Any]) -> None:
    """Write the head, whole; images of an earlier one stay listed."""
    if (folder / HEAD).is_file():
        head = {
            **head,
            "images": list(dict.fromkeys([*read_head(folder)["images"], *head["images"]])),
        }
    _write_whole(folder / HEAD, json.dumps(head, indent=2, ensure_ascii=False) + "\n")


def write_lines(folder: Path, entries: Iterable[dict[str, Any]]) -> None:
    """Write the manifest of images, whole."""
    text = "".join(json.dumps(entry, ensure_ascii=False) + "\n" for entry in entries)
    _write_whole(folder / LINES, text)


def append_line(folder: Path, entry: dict[str, Any]) -> None:
    """Add an image to the manifest."""
    with (folder / LINES).open("a", encoding="utf-8") as file:
        file.write(json.dumps(entry, ensure_ascii=False) + "\n")


def remove_leftovers(folder: Path) -> None:
    """Remove what a run that was ended from outside left half-written."""
    for path in folder.glob(".photonmap-*"):
        shutil.rmtree(path, ignore_errors=True)


def _write_whole(path: Path, text: str) -> None:
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as made:
        file = Path(made) / path.name
        file.write_text(text, encoding="utf-8")
        file.replace(path)
