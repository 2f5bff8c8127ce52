"""The files that a data set is made from: copies in its folder, near it, or left out of it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from photonmap.errors import warn
from photonmap.runtime.wording import enumerated
from photonmap.spectra.curves import EXTRAPOLATE
from photonmap.spectra.sensitivities import table_of

INPUTS = "inputs"
"""Folder of a data set with the small files that it was made from."""
CURVES, SENSOR, LIGHTS = ("bands", "rgb"), "sensor", "lights"
"""What files of sensitivities and of spectra are for; each has a folder of its own."""


def kept_as(role: str, path: Path) -> str:
    """Return the copy of a file of curves, as seen from the folder of its data set."""
    return f"{INPUTS}/{role}/{path.name}"


def role_of_light(digest: str) -> str:
    """Return the folder of a light's spectrum: lights of one name may have several."""
    return f"{LIGHTS}/{digest}"


def with_table(text: str, rename: Callable[[Path], str]) -> str:
    """Return bands, an RGB space or a light with their file, if they are one, renamed."""
    path = table_of(text)
    if path is None:
        return text
    return (EXTRAPOLATE if text.strip().startswith(EXTRAPOLATE) else "") + rename(path)


def without_folder(text: str) -> str:
    """Return bands, an RGB space or a light with the bare name of their file, if they are one."""
    return with_table(text, lambda path: path.name)


def seen_from(folder: Path, path: str) -> str:
    """Return a file beside a data set, or below its parent, as seen from there; else its name.

    >>> seen_from(Path("/data/set"), "/data/rooms/a.obj"), seen_from(Path("/data/set"), "/b.obj")
    ('../rooms/a.obj', 'b.obj')
    """
    near = Path(os.path.relpath(path, folder))
    return Path(path).name if near.parts[:2] == ("..", "..") else near.as_posix()


def reason_of(path: str, error: Exception) -> str:
    """Return why a scene file cannot be read, with files named as seen from its folder."""
    folders = (Path(path).parent, Path(path).resolve().parent)
    names = "|".join(re.escape(f"{folder}{os.sep}") for folder in folders)
    return re.sub(rf"(?<![^\s'\"(])(?:{names})", "", str(error))


def as_line(scene: str, reason: str) -> str:
    """Return a scene file and its reason.

    >>> as_line("mine/a.obj", "a.obj:1: no number"), as_line("mine/a.obj", "a.mtl: no name")
    ('mine/a.obj:1: no number', 'mine/a.obj: a.mtl: no name')
    """
    rest = reason.removeprefix(Path(scene).name)
    return f"{scene}{rest}" if rest != reason and rest.startswith(":") else f"{scene}: {reason}"


def describe_left_out(folder: Path, faults: Mapping[str, str]) -> list[dict[str, str]]:
    """Return what the head of a data set says of scene files that it leaves out.

    Parameters
    ----------
    folder : of the data set, from which files near it are named
    faults : why they cannot be read, by path, as `reason_of` returns it
    """
    here = folder.resolve()
    return [
        {"scene": seen_from(here, str(Path(path).resolve())), "reason": reason}
        for path, reason in faults.items()
    ]


def lines_of(head: Mapping[str, Any]) -> list[str]:
    """Return a line for each scene file that a data set leaves out; none of older sets."""
    return [as_line(**each) for each in head.get("left_out", ())]


def warn_of_left_out(head: Mapping[str, Any]) -> None:
    """Warn of scene files that a data set leaves out."""
    scenes = [each["scene"] for each in head.get("left_out", ())]
    if scenes:
        count, them = ("1 file", "it") if len(scenes) == 1 else (f"{len(scenes)} files", "them")
        warn(
            f"scenes of {count} are missing from the set, as {enumerated(scenes, 1)} could not be "
            f"read; mend {them}, and run the data set again with --resume"
        )
