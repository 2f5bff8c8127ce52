"""Which files may be opened: those that scenes name."""

from __future__ import annotations

import os.path
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from os import PathLike
from pathlib import Path, PureWindowsPath

from photonmap.errors import InputError, warn
from photonmap.runtime.wording import shown

_ROOT: ContextVar[Path | None] = ContextVar("root", default=None)
"""Folder of the files that may be opened; None for any folder."""


@contextmanager
def reading_below(root: str | PathLike[str] | None, scene: Path) -> Iterator[None]:
    """Have `named_file` refuse what lies outside of a folder; None for that of the scene.

    A folder that does not exist is an `InputError`.
    """
    folder = scene.parent if root is None else Path(root)
    if root is not None and not folder.is_dir():
        raise InputError("is no folder; name the one in which the scene's files lie", folder)
    token = _ROOT.set(folder)
    try:
        yield
    finally:
        _ROOT.reset(token)


def allowed_folder(scene: Path) -> Path:
    """Return the folder below which the files of a scene may lie."""
    return _ROOT.get() or scene.parent


def named_file(folder: Path, name: str) -> Path:
    """Return the path of a file that is named relative to a folder.

    Outside of the folder of `reading_below`, by `..` or an absolute path, it is an `InputError`.
    """
    path, root = folder / name, _ROOT.get()
    if root is not None and not is_below(path, root):
        raise InputError(f"{shown(name)} {outside(root)}")
    return path


def named_image(folder: Path, name: str) -> Path:
    """Return the path of an image that is named relative to a folder, perhaps as on Windows.

    Of an absolute name, which is that of another machine more often than not, a file of its last
    part in the folder is taken, with a warning. Refused is what `named_file` refuses.
    """
    windows, root = PureWindowsPath(name), _ROOT.get()
    beside, named = folder / windows.name, folder / name
    is_there = (root is None or is_below(named, root)) and named.is_file()
    if (windows.drive or windows.root) and beside.is_file() and not is_there:
        warn(f"{shown(name)} is an absolute name: {beside} is taken in its place")
        return beside
    path = named_file(folder, name)
    if "\\" in name and not path.exists():
        path = named_file(folder, name.replace("\\", "/"))
    return path


def is_below(path: Path, root: Path) -> bool:
    """Return whether a path lies in a folder by its name; links may lead elsewhere."""
    normal, folder = (Path(os.path.normpath(each.absolute())) for each in (path, root))
    return normal.is_relative_to(folder)


def outside(root: Path) -> str:
    """Return what is wrong with a file that is not below a folder, and what to do."""
    return (
        f"lies outside of the folder {root}; "
        "copy it there, or name a folder that holds all files by --root (root=...)"
    )
