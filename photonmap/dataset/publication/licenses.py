"""Licences of data sets by name, or from a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from photonmap.errors import InputError
from photonmap.runtime.wording import suggest

_NAMES = {
    "CC0-1.0": ("CC0 1.0 Universal", "https://creativecommons.org/publicdomain/zero/1.0/"),
    "CC-BY-4.0": (
        "Creative Commons Attribution 4.0 International",
        "https://creativecommons.org/licenses/by/4.0/",
    ),
    "CC-BY-SA-4.0": (
        "Creative Commons Attribution-ShareAlike 4.0 International",
        "https://creativecommons.org/licenses/by-sa/4.0/",
    ),
    "CC-BY-NC-4.0": (
        "Creative Commons Attribution-NonCommercial 4.0 International",
        "https://creativecommons.org/licenses/by-nc/4.0/",
    ),
}
NAMES = tuple(_NAMES)
"""SPDX names of the licences."""


@dataclass(frozen=True)
class License:
    """A licence.

    Parameters
    ----------
    name : of SPDX, or that of the user's file
    url : of its text; "" for the user's
    text : of the file LICENSE
    """

    name: str
    url: str
    text: str


def find_license(name: str) -> License:
    """Return a licence by its SPDX name, or one of the user's from a file of its text.

    Raises
    ------
    InputError : there is none of this name, and no such file
    """
    if name in _NAMES:
        title, url = _NAMES[name]
        text = f"This data set is licensed under {title}.\n\nThe legal code is at\n{url}legalcode\n"
        return License(name, url, text)
    if not Path(name).is_file():
        raise InputError(f"there is no license {name!r}; {suggest(name, NAMES)} (or give a file)")
    return License(Path(name).name, "", Path(name).read_text(encoding="utf-8"))
