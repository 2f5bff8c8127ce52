"""How a data set names the files that it was made from: copies in its folder, or near it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from photonmap.spectra.curves import EXTRAPOLATE
from photonmap.spectra.sensor_curves import table_of

INPUTS = "inputs"
"""Folder of a data set with the small files that it was made from."""
CURVES, SENSOR = ("bands", "rgb"), "sensor"
"""What files of sensitivities are for; each has a folder of its own."""


def kept_as(role: str, path: Path) -> str:
    """Return the copy of a file of sensitivities, as seen from the folder of its data set."""
    return f"{INPUTS}/{role}/{path.name}"


def with_table(text: str, rename: Callable[[Path], str]) -> str:
    """Return bands or an RGB space with their file, if they are one, renamed."""
    path = table_of(text)
    if path is None:
        return text
    return (EXTRAPOLATE if text.strip().startswith(EXTRAPOLATE) else "") + rename(path)


def without_folder(text: str) -> str:
    """Return bands or an RGB space with the bare name of their file, if they are one."""
    return with_table(text, lambda path: path.name)


def seen_from(folder: Path, path: str) -> str:
    """Return a file beside a data set, or below its parent, as seen from there; else its name.

    >>> seen_from(Path("/data/set"), "/data/rooms/a.obj"), seen_from(Path("/data/set"), "/b.obj")
    ('../rooms/a.obj', 'b.obj')
    """
    near = Path(os.path.relpath(path, folder))
    return Path(path).name if near.parts[:2] == ("..", "..") else near.as_posix()
