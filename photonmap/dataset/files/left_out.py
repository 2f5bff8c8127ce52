"""Scene files that cannot be read, and are left out of a data set."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from photonmap.dataset.files.inputs import seen_from
from photonmap.errors import warn
from photonmap.runtime.wording import enumerated


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
