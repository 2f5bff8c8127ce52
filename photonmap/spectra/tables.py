"""Read curves from tables in text: a column of wavelengths, then a column for each curve."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.errors import InputError
from photonmap.runtime.wording import shown
from photonmap.spectra.curves import Floats, SpectrumSet, check_wavelengths

_TEXT = bytes([9, 10, 11, 12, 13, *range(32, 127), *range(128, 256)])
_COMMENT_LINE = ("#", "%", "//")
_COMMENT = re.compile(r"(?:#|//|(?<=[\s,;])%\s*[^\W\d]).*")
"""A comment after numbers; "45 %" is not one but a value in percent."""

Row = tuple[int, list[float]]


def read_table(
    path: str | PathLike[str], low: float = -np.inf, high: float = np.inf, kind: str = "value"
) -> SpectrumSet:
    """Read the curves of a table, whose first column is the wavelength, nm.

    Commas, semicolons, tabs or spaces separate the columns, as they do in the first line. Between
    semicolons or tabs, a comma in a number is a decimal comma. #, % and // start comments. A first
    line that does not start with a number names the columns; those without a name are called after
    the file. Values lie from `low` to `high`; messages call them a `kind`. An `InputError` says
    that the file is not a table of numbers, the wavelengths do not increase or are not in nm, or a
    value is not finite or lies outside.
    """
    path = Path(path)
    header, rows = _read_rows(path)
    lines = [line for line, _ in rows]
    table = np.array([numbers for _, numbers in rows])
    wavelengths, values = table[:, 0], table[:, 1:]
    count = values.shape[1]
    made_up = [path.stem if count == 1 else f"{path.stem} {k + 1}" for k in range(count)]
    names = tuple(name or other for name, other in zip(header[1:] or made_up, made_up, strict=True))
    _check_finite(path, lines, table, kind)
    try:
        check_wavelengths(wavelengths)
    except InputError as error:
        falls = np.append(np.flatnonzero(np.diff(wavelengths) <= 0) + 1, 0)
        raise InputError(str(error), path, lines[falls[0]]) from None
    outside = np.argwhere(~((values >= low) & (values <= high)))
    if outside.size:
        row, column = outside[0]
        message = f"{kind} is {values[row, column]:.6g} at {wavelengths[row]:g} nm; "
        message += _limits(values, low, high, kind)
        if len(names) > 1:
            message += f" (column {shown(names[column])})"
        raise InputError(message, path, lines[row])
    return SpectrumSet(wavelengths, values.T.copy(), names)


def read_bytes(path: Path) -> bytes:
    """Read a file whole; raise `InputError` if it is missing, unreadable, a folder or empty."""
    try:
        data = path.read_bytes()
    except IsADirectoryError:
        raise InputError("is a directory; name a file", path) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"cannot be read ({reason}); check the file's name", path) from None
    if not data:
        raise InputError("is empty; save the file again", path)
    return data


def read_arrays(path: Path, load: Callable[[BytesIO], Any], save: str = "it again") -> Any:
    """Read the arrays of a file, by name; raise `InputError` where it is damaged."""
    data = read_bytes(path)
    try:
        return dict(load(BytesIO(data)))
    except InputError:
        raise
    except Exception as error:  # what a damaged file raises is not documented
        message = f"cannot be read as {path.suffix} ({error}); save {save}"
        raise InputError(message, path) from None


def read_lines(path: Path) -> list[str]:
    """Read the lines of a text file in UTF-8, or in Latin-1 where it is not.

    One that cannot be read, is empty, or is not text is an `InputError`.
    """
    data = read_bytes(path)
    if junk := data.translate(None, _TEXT):
        line = data.count(b"\n", 0, data.index(junk[0])) + 1
        message = f"is not a text file (byte 0x{junk[0]:02x}); unpack it, or save it as UTF-8 text"
        raise InputError(message, path, line)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return re.split("\r\n|\r|\n", text)


def read_numbers(path: Path) -> tuple[Floats, NDArray[np.int64], list[tuple[int, str]]]:
    """Read numbers separated by white space, their lines, and comments after how many numbers."""
    numbers: list[float] = []
    lines: list[int] = []
    comments: list[tuple[int, str]] = []
    for line, text in enumerate(read_lines(path), start=1):
        if text.lstrip().startswith("#"):
            comments.append((len(numbers), text.strip()))
            continue
        for word in text.split():
            try:
                numbers.append(_parse_number(word))
            except ValueError:
                message = f"{shown(word)} is not a number; write numbers separated by spaces"
                raise InputError(message, path, line) from None
            lines.append(line)
    if not numbers:
        raise InputError("holds no numbers; name another file", path)
    return np.array(numbers), np.array(lines), comments


def _parse_number(cell: str, separator: str = " ") -> float:
    """Read a number, which may have a decimal comma if commas do not separate."""
    if "_" in cell:
        raise ValueError
    return float(cell.replace(",", ".") if separator in ";\t" else cell)


def _read_rows(path: Path) -> tuple[list[str], list[Row]]:
    """Read the cells of the header, if there is one, and the rows with their line numbers."""
    header: list[str] = []
    rows: list[Row] = []
    separator, first, width = "", 0, 0
    for line, text in enumerate(read_lines(path), start=1):
        if text.lstrip().startswith(_COMMENT_LINE) or not text.strip(" \t,;"):
            continue
        if not first:
            first, separator = line, _find_separator(_COMMENT.sub("", text))
            header = _split(text, separator)
            try:
                _parse_number(header[0], separator)
            except ValueError:
                continue
            header = []
        cells = _split(_COMMENT.sub("", text), separator)
        while cells and not cells[-1]:
            cells.pop()
        numbers = _parse_row(path, line, cells, separator)
        if not rows:
            width = len(cells)
            while len(header) > width and not header[-1]:
                header.pop()
            width = len(header) or width
        if len(cells) != width:
            message = f"has {len(cells)} cells, but line {first} has {width}; give each row as many"
            raise InputError(f"{message}, and quote names that hold separators", path, line)
        if width < 2:
            raise InputError("has no value; write a wavelength and one value or more", path, line)
        rows.append((line, numbers))
    if len(rows) < 2:
        message = "holds fewer than 2 rows of numbers; write one for each wavelength"
        raise InputError(message, path, first or None)
    return header, rows


def _find_separator(text: str) -> str:
    """Return the separator of the columns of a line; a space stands for any white space."""
    bare = re.sub('"[^"]*"', "", text).rstrip()
    return next((mark for mark in ";\t," if mark in bare), " ")


def _split(text: str, separator: str) -> list[str]:
    """Cut a line into cells, which may be quoted."""
    if separator == " ":
        return [cell.strip('"') for cell in re.findall(r'"[^"]*"|\S+', text)]
    try:
        cells = next(csv.reader([text], delimiter=separator, skipinitialspace=True))
    except csv.Error:
        cells = text.split(separator)
    return [cell.strip() for cell in cells]


def _parse_row(path: Path, line: int, cells: list[str], separator: str) -> list[float]:
    """Read the numbers of a row."""
    numbers: list[float] = []
    try:
        for cell in cells:
            numbers.append(_parse_number(cell, separator))  # noqa: PERF401, its length is the cell's index
    except ValueError:
        message = (
            f"{shown(cells[len(numbers)])} is not a number; write numbers with a decimal point"
        )
        remedy = "separate the columns by commas, semicolons, tabs or spaces"
        raise InputError(f"{message}, and {remedy}", path, line) from None
    return numbers


def _check_finite(path: Path, lines: list[int], table: Floats, kind: str) -> None:
    """Raise `InputError` if a wavelength or value is NaN or infinite."""
    bad = np.argwhere(~np.isfinite(table))
    if bad.size:
        row, column = bad[0]
        what = f"{kind if column else 'wavelength'} is {table[row, column]}"
        where = f" at {table[row, 0]:g} nm" if column else ""
        message = f"{what}{where}; write a finite number, or leave the row out"
        raise InputError(message, path, lines[row])


def _limits(values: Floats, low: float, high: float, kind: str) -> str:
    """Return the range of the values as a remedy, with the usual reason for leaving it."""
    if low == 0 and high == np.inf:
        return f"{kind} cannot be negative"
    percent = 0.9 < high < 1.1 and np.mean((values > 2) & (values <= 110)) > 0.5
    remedy = ": divide percent by 100" if percent else ""
    return f"it must lie between {low:.3g} and {float(f'{high:.3g}'):g}{remedy}"
