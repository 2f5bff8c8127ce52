"""Lights whose spectra are in files: what is in them identifies them, not where they are."""

from __future__ import annotations

import hashlib
from pathlib import Path

from photonmap.errors import InputError
from photonmap.spectra.curves import EXTRAPOLATE
from photonmap.spectra.sensitivities import table_of
from photonmap.spectra.tables import read_table

_DIGITS = 10
"""Digits of a digest."""


def light_file(color: str) -> Path | None:
    """Return the file that a light names, perhaps with a factor after it; None if it names none."""
    return table_of(color) or table_of(color.rpartition(" ")[0])


def located_light(color: str, folder: Path) -> str:
    """Return a light with the absolute path of its file, if it has one, seen from a folder.

    A factor is left out, as the lights of data sets are scaled to a luminance of 1.
    """
    path = light_file(color)
    if path is None:
        return color
    held = EXTRAPOLATE if color.strip().startswith(EXTRAPOLATE) else ""
    return f"{held}{(folder / path).resolve()}"


def digest_of_light(color: str) -> str:
    """Return the digest of the curve in the file of a light; "" if it names none.

    Raises
    ------
    InputError : the file cannot be read
    """
    path = light_file(color)
    if path is None:
        return ""
    curve = read_table(path, kind="emission")[0]
    samples = curve.wavelengths.tobytes() + curve.values.tobytes()
    return hashlib.sha256(samples).hexdigest()[:_DIGITS]


def check_unchanged(color: str, digest: str) -> None:
    """Raise `InputError` if the file of a light has another curve than that of a digest."""
    if digest_of_light(color) != digest:
        raise InputError("has changed since the data set was begun; restore it", light_file(color))
