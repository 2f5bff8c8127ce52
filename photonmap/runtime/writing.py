"""Where files can be written, files that are written whole or not at all, and what full disks say.

Drafts lie in a temporary folder beside their place, and move there when all of them are complete.
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError

FULL = ("No space left", "MB are free", "quota exceeded")
"""What the messages of a full disk have in them."""
_LONGEST = 255
"""Bytes of a name that nearly all file systems take."""
_FULL = (errno.ENOSPC, errno.EDQUOT)
_REMEDIES = {
    "room": ", and {free} are free; make room on this disk",
    "a higher limit": "; raise the limit of files' sizes",
    "something unknown": "; check the disk",
}
_NEARLY_FULL = 100e6
"""Free bytes on a disk below which an error without a number, as OpenEXR's, may mean it is full."""


def check_length(path: str | PathLike[str]) -> None:
    """Check that the file system takes a path and each name in it, also of what is missing.

    An `InputError` says which is too long.
    """
    absolute = Path(path).absolute()
    parents = (absolute, *absolute.parents)
    there = next(each for each in parents if os.path.exists(each))  # noqa: PTH110, may be too long
    for name in (*absolute.parts, str(absolute)):
        try:
            (there / name).lstat()
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                raise InputError(too_long(name)) from None


def too_long(path: str) -> str:
    """Return what is wrong with a path that the disk does not take, and what to do."""
    longest = max(Path(path).parts, key=len, default="")
    name = longest if len(os.fsencode(longest)) > _LONGEST else path
    size = len(os.fsencode(name))
    return f"{name[:40]}… is a name of {size} bytes, too long for this disk; choose a shorter one"


def check_writable(folder: Path, wanted: Path) -> None:
    """Check that a folder can be written to, or made; `InputError` names the wanted file if not."""
    check_length(wanted)
    nearest = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    try:
        with tempfile.TemporaryFile(dir=nearest):  # permissions alone do not suffice
            pass
    except OSError as error:
        reason = error.strerror or error
        message = f"cannot write to the folder {nearest} ({reason}); choose another"
        raise InputError(message, wanted) from None


def check_output_folder(path: str | PathLike[str], contents: str) -> Path:
    """Return the path of a folder that can be written to, or made; any other is an `InputError`.

    `contents` are what it is for, as in "the data set".
    """
    folder = Path(path)
    check_length(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"this is a file; choose a folder for {contents}", folder)
    check_writable(folder, folder)
    return folder


def check_file(path: str | PathLike[str]) -> None:
    """Check that a file can be written, before the work that fills it."""
    path = Path(path)
    check_length(path)
    if path.is_dir():
        raise InputError("is a folder; name a file", path)
    check_writable(path.parent, path)


class WriteError(OSError):
    """A file for which a disk has no room: its name, the bytes it needs, and a remedy."""

    reason: str  # as the system gave it
    made: int  # bytes that were written before


@contextmanager
def naming_written(
    wanted: str | PathLike[str], size: float | None = None, drafts: Path | None = None
) -> Iterator[None]:
    """Have an `OSError` about a disk without room name the file, the bytes it needs, and a remedy.

    Parameters
    ----------
    wanted : the file or folder that is to be written
    size : bytes that it takes, about; None for more than there was room for
    drafts : the file or folder in which they are
    """
    try:
        yield
    except OSError as error:
        wanted = Path(wanted)
        place = next(each for each in wanted.absolute().parents if each.exists())
        here = 0 if drafts is None else _bytes_in(drafts)
        made, free = here + getattr(error, "made", 0), here + shutil.disk_usage(place).free
        text = " ".join(str(error).split())
        lack = _lack(error, text, free)
        if lack is None:
            raise
        reason = getattr(error, "reason", None) or (error.errno and error.strerror) or text
        reason = reason.replace(f"{drafts}/", "")
        is_full = lack == "room"
        least = max(made, free if is_full else 0)
        amount = f"more than {_megabytes(least)}" if size is None else f"about {_megabytes(size)}"
        remedy = _REMEDIES[lack].format(free=_megabytes(free))
        problem = f"it needs {amount}{remedy}"
        named = WriteError(f"cannot write {wanted} ({reason}): {problem}, or choose another folder")
        named.errno = errno.ENOSPC if is_full else error.errno
        named.reason, named.made = reason, made
        raise named from None


def _lack(error: OSError, text: str, free: int) -> str | None:
    """Return what a write lacked, one of `_REMEDIES`; None if the error says something else."""
    if error.errno in _FULL or any(sign in text for sign in FULL):
        return "room"
    if error.errno is None and free < _NEARLY_FULL:
        return "room"
    if error.errno == errno.EFBIG or os.strerror(errno.EFBIG) in text:
        return "a higher limit"
    return "something unknown" if error.errno is None else None


def _bytes_in(place: Path) -> int:
    """Return the bytes of a file, or of all files in a folder."""
    return sum(file.stat().st_size for file in (place, *place.rglob("*")) if file.is_file())


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.3g} MB"


@contextmanager
def drafts_beside(
    wanted: str | PathLike[str], size: float | None = None, place: Path | None = None
) -> Iterator[Path]:
    """Yield a temporary folder for the drafts of a file or folder; it vanishes with what is in it.

    Parameters
    ----------
    wanted, size : as for `naming_written`
    place : folder in which drafts lie, made if it is missing; that of `wanted` by default
    """
    place = Path(wanted).parent if place is None else place
    with naming_written(wanted, size):
        place.mkdir(parents=True, exist_ok=True)
        made = tempfile.TemporaryDirectory(prefix=".photonmap-", dir=place)
    with made as name, naming_written(wanted, size, Path(name)):
        yield Path(name)


@contextmanager
def written_together(
    folder: Path, wanted: Path | None = None, size: float | None = None
) -> Iterator[Path]:
    """Yield a temporary folder whose files move to `folder` when all of them are complete.

    `folder` and those above it are made where they are missing. Errors name `wanted`, by default
    the folder, and the bytes it takes.
    """
    place = folder if folder.is_dir() else folder.parent
    with drafts_beside(wanted or folder, size, place) as made:
        yield made
        folder.mkdir(exist_ok=True)
        for file in made.iterdir():
            file.replace(folder / file.name)


@contextmanager
def replacing(path: str | PathLike[str], size: float | None = None) -> Iterator[Path]:
    """Yield a temporary path to write to, which replaces the file when all is written.

    `size` in bytes, if it is known, is named where there is no room for it.
    """
    path = Path(path)
    with written_together(path.parent, path, size) as made:
        yield made / path.name


@contextmanager
def replacing_target(path: str | PathLike[str], size: float) -> Iterator[Path]:
    """Yield a path as `replacing` does, but for the file that a link leads to.

    What is no file, such as a device, is written in place.
    """
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        with naming_written(path, size):
            yield Path(path)
        return
    with written_together(target.parent, Path(path), size) as made:
        yield made / target.name
