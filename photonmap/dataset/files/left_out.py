"""Scene files that cannot be read, and are left out of a data set."""

from __future__ import annotations

import os
import re
from pathlib import Path


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
