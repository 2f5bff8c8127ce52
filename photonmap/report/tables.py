"""Tables as aligned text and as comma-separated values."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from photonmap.errors import visible

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")
"""What begins a cell that spreadsheets compute, or hides that from the eye."""


def aligned(rows: Sequence[Sequence[Any]], right: Collection[int] = ()) -> Iterator[str]:
    """Yield rows of cells as lines, their columns aligned left, or `right` by number."""
    texts = [[visible(str(cell)) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    for row in texts:
        cells = (
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join(cells).rstrip()


def write_csv(path: Path, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write comma-separated values under a head; None is an empty cell.

    Texts that spreadsheets would take for formulas begin with an apostrophe.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([_as_text(cell) for cell in row] for row in chain([head], rows))


def _as_text(cell: Any) -> Any:
    """Return a cell that no spreadsheet computes.

    >>> [_as_text(cell) for cell in ("=1+1", "-2.5", "-", -2.5, "a=b")]
    ["'=1+1", '-2.5', "'-", -2.5, 'a=b']
    """
    if not isinstance(cell, str) or not cell.startswith(_FORMULA):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell
