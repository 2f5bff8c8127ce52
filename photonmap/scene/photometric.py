"""Photometric files: how the intensity of a luminaire depends on direction (IES LM-63, type C)."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.spectra.curves import Floats

Table = NDArray[np.float32]

POLAR, AZIMUTHS = 181, 361
"""Directions of a table that is read from a file: every degree."""
_TYPE_C = 1
_RANGES = ((0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, 360.0), (90.0, 270.0))
"""Azimuths of a file, first and last; the others follow by symmetry."""
_LARGEST = float(np.finfo(np.float32).max)


def read_ies(path: str | PathLike[str]) -> Table:
    """Read an IES file of type C, without tilt, as a table over directions.

    It is (181, 361) float32 candelas: polar angles of 0° to 180° from the axis of the luminaire,
    which points down, and azimuths of 0° to 360°, counterclockwise as seen from above. Other files
    are an `InputError`.
    """
    try:
        text = Path(path).read_text(encoding="latin-1")
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path) from None
    return parse_ies(text, path)


def parse_ies(text: str, path: str | PathLike[str]) -> Table:
    """Return the table of an IES file, as `read_ies`; the path is for errors."""
    head, tilt, body = text.partition("TILT=")
    kind, _, body = body.partition("\n")
    if not tilt or kind.strip() != "NONE":
        found = f"TILT={kind.strip()}" if tilt else "no TILT line"
        raise InputError(f"{found}: give an IES file with TILT=NONE", path, head.count("\n") + 1)
    numbers = np.array([_number(word, path) for word in body.replace(",", " ").split()])
    polar, azimuths, candelas = _split(numbers, path)
    _check_angles(polar, azimuths, path)
    if not ((candelas >= 0.0) & (candelas <= _LARGEST)).all():
        raise InputError("has intensities that are negative or not finite; export it again", path)
    if not candelas.any():
        raise InputError("has no intensity in any direction; export it again", path)
    return _resample(polar, azimuths, candelas)


def _number(word: str, path: str | PathLike[str]) -> float:
    """Return a finite number of a file."""
    try:
        number = float(word)
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f"{shown(word)} is not a number; export it again", path)
    return number


def _split(numbers: Floats, path: str | PathLike[str]) -> tuple[Floats, Floats, Floats]:
    """Return polar angles (V,), azimuths (H,), both in degrees, and candelas (H, V)."""
    if len(numbers) < 13:
        raise InputError("ends before its angles; export it again", path)
    polar_count, azimuth_count, kind = (int(number) for number in numbers[3:6])
    wanted = 13 + polar_count + azimuth_count + polar_count * azimuth_count
    if kind != _TYPE_C:
        raise InputError(f"photometry of type {shown(kind)}: give a file of type C (1)", path)
    if min(polar_count, azimuth_count) < 1 or len(numbers) != wanted:
        raise InputError(
            f"has {len(numbers)} numbers where {polar_count} × {azimuth_count} angles need "
            f"{wanted}; export it again",
            path,
        )
    polar = numbers[13 : 13 + polar_count]
    azimuths = numbers[13 + polar_count :][:azimuth_count]
    candelas = numbers[13 + polar_count + azimuth_count :].reshape(azimuth_count, polar_count)
    with np.errstate(over="ignore", invalid="ignore"):
        return polar, azimuths, candelas * numbers[2] * numbers[10]


def _check_angles(polar: Floats, azimuths: Floats, path: str | PathLike[str]) -> None:
    """Refuse angles that do not increase, or that leave directions undefined."""
    if (np.diff(polar) <= 0.0).any() or (np.diff(azimuths) <= 0.0).any():
        raise InputError("has angles that do not increase; export it again", path)
    if polar[0] < 0.0 or polar[-1] > 180.0:
        raise InputError(
            f"has polar angles of {polar[0]:g} to {polar[-1]:g}; give them within 0 to 180", path
        )
    if (azimuths[0], azimuths[-1]) not in _RANGES:
        raise InputError(
            f"has azimuths of {azimuths[0]:g} to {azimuths[-1]:g}; give 0 alone, 0 to 90, 180 or "
            f"360, or 90 to 270",
            path,
        )


def _resample(polar: Floats, azimuths: Floats, candelas: Floats) -> Table:
    """Return candelas at every degree; a file may hold a quarter, a half or all of the azimuths."""
    degrees = np.arange(AZIMUTHS, dtype=float)
    first, last = azimuths[0], azimuths[-1]
    if last == 0.0:
        degrees[:] = 0.0
    elif first == 90.0:
        degrees = 90.0 + np.abs((degrees + 90.0) % 360.0 - 180.0)
    elif last == 90.0:
        degrees = np.abs((degrees + 90.0) % 180.0 - 90.0)
    elif last == 180.0:
        degrees = np.abs((degrees + 180.0) % 360.0 - 180.0)
    everywhere = np.stack([
        np.interp(np.arange(POLAR, dtype=float), polar, line, left=0.0, right=0.0)
        for line in candelas
    ])  # fmt: skip
    table = np.stack([np.interp(degrees, azimuths, column) for column in everywhere.T])
    return table.astype(np.float32)


def save_ies(described: str | PathLike[str] | ArrayLike, path: str | PathLike[str]) -> None:
    """Write a table, (V, H), over polar angles and azimuths as an IES file of type C.

    The table is an array or that of another file.
    """
    values = _check_table(described)
    polar, azimuths = (
        np.linspace(0.0, end, n) for end, n in zip((180.0, 360.0), values.shape, strict=True)
    )
    lines = [
        "IESNA:LM-63-2002",
        "TILT=NONE",
        f"1 -1 1 {len(polar)} {len(azimuths)} 1 2 0 0 0",
        "1 1 0",
        *(" ".join(f"{value:.9g}" for value in row) for row in (polar, azimuths, *values.T)),
    ]
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")


def _check_table(described: str | PathLike[str] | ArrayLike) -> Table:
    """Return a table, of a file or of an array, at its own directions."""
    if isinstance(described, str | PathLike):
        return read_ies(described)
    try:
        table = np.asarray(described, np.float64)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or min(table.shape) < 2:
        raise InputError(
            f"the table of intensities must be numbers (V, H), 2 × 2 at least, not {table.shape}"
        )
    if not ((table >= 0.0) & (table <= _LARGEST)).all():
        raise InputError(
            "the table of intensities has values that are negative or not finite; correct them"
        )
    return table.astype(np.float32)


def _resize(table: Table) -> Table:
    """Return a table at every degree, linear between its own directions."""
    if table.shape == (POLAR, AZIMUTHS):
        return table
    rows, columns = (np.linspace(0.0, 1.0, n) for n in table.shape)
    across = np.stack([np.interp(np.linspace(0.0, 1.0, AZIMUTHS), columns, row) for row in table])
    down = [np.interp(np.linspace(0.0, 1.0, POLAR), rows, column) for column in across.T]
    return np.stack(down, axis=1).astype(np.float32)


def as_table(described: str | PathLike[str] | ArrayLike) -> Table:
    """Return a (181, 361) table, of a file or of an array, relative to its mean over directions.

    An `InputError` says that the file cannot be read, or that the table is not (V, H), is negative,
    or all dark.
    """
    table = _resize(_check_table(described))
    if (mean := mean_over_directions(table)) == 0.0:
        raise InputError("the table of intensities is 0 in all directions")
    return (table / mean).astype(np.float32)


def mean_over_directions(table: NDArray[Any]) -> float:
    """Return the mean of a (181, 361) table over all directions."""
    weights = np.sin(np.linspace(0.0, np.pi, len(table)))
    return float(np.average(table[:, :-1].mean(axis=1, dtype=np.float64), weights=weights))
