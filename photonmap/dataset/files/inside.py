"""What a path inside a data set, its shards or a folder of predictions may be."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError
from photonmap.runtime.wording import shown

_LONGEST, _LONGEST_PART = 1024, 255
"""Bytes of a path, and of a name in it, that file systems take."""
_PLAIN = re.compile(r"[\w@-]{1,64}(\.[\w@-]{1,64}){0,2}", re.ASCII)
"""Names of files as sets have them, which are decided at once unless they are devices."""
_DEVICES = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³]) *(\..*)?", re.I)
"""Names that are devices in Windows, whatever their suffix."""
_UNSEEN = {"Cc", "Cs", "Zl", "Zp"}
"""Unicode's categories of control characters, halves of surrogate pairs, and ends of lines."""


def inside(folder: str | PathLike[str], name: object, is_part: bool = False) -> Path:
    """Return the path of a file or folder that is named as seen from a set's folder.

    This function alone decides what such a name may be: relative, with slashes between parts of
    which none is empty, "." or ".."; without drive letters, backslashes, control characters and
    names that Windows reserves; and, as far as it exists, not a link that leaves the folder.

    Parameters
    ----------
    folder : of the set
    name : as a manifest, an index or another file has it
    is_part : whether the name is that of a file or folder right in `folder`

    Raises
    ------
    InputError : it may not be followed
    """
    path = Path(folder, check_inside(name, folder, is_part))
    root = Path(folder).resolve()
    try:
        leaves = not path.resolve().is_relative_to(root)
    except (OSError, RuntimeError):  # links in a circle
        leaves = True
    if leaves:
        problem = f"{shown(name)} is a link that leaves the folder"
        raise InputError(f"{problem}; put what it leads to in its place", folder)
    return path


def check_inside(name: object, place: str | PathLike[str], is_part: bool = False) -> str:
    """Return a name if `inside` may follow it, links left aside; else name the place it is in."""
    why = fault_of(name, is_part) if isinstance(name, str) else "is not a text"
    if isinstance(name, str) and not why:
        return name
    problem = f"{shown(name)} is no path inside a set, as it {why}"
    raise InputError(f"{problem}; get the set again from where it was made", place)


@lru_cache(maxsize=2**14)
def fault_of(name: str, is_part: bool = False) -> str:
    """Return why a name does not lead to a place inside a folder; "" if it does.

    >>> fault_of("../a"), fault_of("a/b"), fault_of("a/b", is_part=True)
    ('has a part ".."', '', 'has several parts')
    """
    if _PLAIN.fullmatch(name) and not _DEVICES.fullmatch(name):
        return ""
    parts = name.split("/")
    unseen = [each for each in name if unicodedata.category(each) in _UNSEEN]
    device = next(filter(_DEVICES.fullmatch, parts), "")
    faults = {
        "has characters that cannot be seen": unseen,
        "has a backslash": "\\" in name,
        "is absolute": name.startswith("/"),
        "has a colon, as after a drive letter": ":" in name,
        "has an empty part": "" in parts,
        'has a part "."': "." in parts,
        'has a part ".."': ".." in parts,
        "has several parts": is_part and len(parts) > 1,
        f"has a part {device!r}, a device in Windows": device,
        "has a part that ends in a dot or a space": any(each[-1:] in ". " for each in parts),
    }
    if why := next((why for why, is_so in faults.items() if is_so), ""):
        return why
    size = max(len(each.encode()) for each in parts)
    return "is too long" if size > _LONGEST_PART or len(name.encode()) > _LONGEST else ""
