"""Sensitivity curves as a file or a name has them, of unequal heights."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from photonmap.errors import InputError
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.spectra import names
from photonmap.spectra.curves import EXTRAPOLATE, FILES, Spectrum
from photonmap.spectra.tables import read_table


def table_of(text: str) -> Path | None:
    """Return the file that a text names; None if it is the name of an observer or a camera."""
    path = Path(text.strip().removeprefix(EXTRAPOLATE).strip())
    return path if path.suffix.lower() in FILES else None


def check_camera(text: str) -> str:
    """Return the name of a camera or an observer; files and bands are not looked at.

    Raises
    ------
    InputError : there is none of this name
    """
    body = text.strip().removeprefix(EXTRAPOLATE).strip()
    is_bands = ":" in body or body.isdecimal() or body.lower() == "rgb"
    if table_of(body) is not None or is_bands:
        return text
    try:
        names.sensors(body)
    except InputError:
        known = names.sensor_names()
        meant = suggest(body, known)
        others = f" Known are {listed(known, len(known))};" if "?" in meant else ";"
        raise InputError(
            f"{shown(body)} is not known; {meant}{others} or give a FILE.csv of sensitivities"
        ) from None
    return text


def read_sensors(text: str) -> tuple[list[str], list[Spectrum]]:
    """Return the channels of a FILE.csv, an observer or a camera, and curves in the source's unit.

    Raises
    ------
    InputError
        if the file cannot be read, or there is no such name
    """
    body, path = text.strip(), table_of(text)
    held = body.startswith(EXTRAPOLATE)
    if path is not None:
        table = read_table(path, kind="sensitivity")
        pairs = list(zip(table.names, table, strict=True))
    else:
        pairs = list(names.sensors(body.removeprefix(EXTRAPOLATE).strip()))
    curves = [replace(curve, extrapolate=held) for _, curve in pairs]
    return [name for name, _ in pairs], curves
