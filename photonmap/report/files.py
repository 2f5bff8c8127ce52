"""Files that are written whole or not at all."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError
from photonmap.runtime.files import check_writable


def check_file(path: str | PathLike[str]) -> None:
    """Check that a file can be written, before the work that fills it."""
    path = Path(path)
    if path.is_dir():
        raise InputError("is a folder; name a file", path)
    check_writable(path.parent, path)


@contextmanager
def written_together(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder whose files move to `folder` when all of them are complete.

    `folder` and those above it are made where they are missing.
    """
    place = folder if folder.is_dir() else folder.parent
    place.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=place) as made:
        yield Path(made)
        folder.mkdir(exist_ok=True)
        for file in Path(made).iterdir():
            file.replace(folder / file.name)


@contextmanager
def replacing(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path to write to, which replaces the file when all is written."""
    with written_together(Path(path).parent) as part:
        yield part / Path(path).name
