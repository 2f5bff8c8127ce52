"""Results as tables in text and CSV."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike

from photonmap.report.files import replacing, write_csv
from photonmap.sensors.color_error import METHODS, ColorRow
from photonmap.sensors.comparison import BestRow
from photonmap.sensors.interreflection import ErrorRow

COLUMNS = ("bands", "bounces", "mean_percent", "max_percent")
"""Columns of the CSV file."""

BEST_COLUMNS = (
    *("bands", "1 bounce %", "2 bounces %", "ΔE", "best σ/bin", "ΔE", "best spread", "ΔE"),
)


def error_table(rows: Sequence[ErrorRow]) -> str:
    """Return a table of errors in percent, with the pairs that count and the worst of them."""
    cells = [
        [
            row.bands,
            str(row.bounces),
            f"{100.0 * row.mean:.3f}",
            f"{100.0 * row.worst:.3f}",
            f"{100.0 * row.kept:.1f}",
            " and ".join(row.worst_pair),
        ]
        for row in rows
    ]
    return _table(["bands", "bounces", "mean %", "max %", "counted %", "worst"], cells)


def color_table(rows: Sequence[ColorRow]) -> str:
    """Return a table of ΔE2000, a line for each set of bands and number of bounces."""
    by_key = {(row.bands, row.bounces, row.method): row for row in rows}
    cells = []
    for bands, bounces in dict.fromkeys((row.bands, row.bounces) for row in rows):
        found = [by_key[bands, bounces, method] for method in METHODS]
        values = [f"{x:.3f}" for row in found for x in (row.mean, row.p95, row.worst)]
        cells.append([bands, str(bounces), *values])
    heads = [f"{method} {what}" for method in METHODS for what in ("mean", "p95", "max")]
    return _table(["bands", "bounces", *heads], cells)


def best_line(row: BestRow | None = None) -> str:
    """Return one line of the table of best bands; its head without a row."""
    if row is None:
        cells: Sequence[str] = BEST_COLUMNS
    else:
        spread = (f"{row.spread:.3f}", f"{row.spread_delta:.3f}") if row.count > 1 else ("-", "-")
        values = (100.0 * row.one, 100.0 * row.two, row.usual, row.width, row.width_delta)
        cells = (str(row.count), *(f"{value:.3f}" for value in values), *spread)
    widths = [max(len(head), 6) for head in BEST_COLUMNS]
    pairs = list(zip(cells, widths, strict=True))
    return "  ".join([pairs[0][0].ljust(pairs[0][1]), *(cell.rjust(w) for cell, w in pairs[1:])])


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Align columns of text to the right; the first, and one called "worst", to the left."""
    lines = [head, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    left = [name in ("bands", "worst") for name in head]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if flush else cell.rjust(width)
            for cell, width, flush in zip(line, widths, left, strict=True)
        ).rstrip()
        for line in lines
    )


def write_errors(path: str | PathLike[str], rows: Sequence[ErrorRow]) -> None:
    """Write errors in percent, one row for each set of bands and number of bounces.

    Raises
    ------
    OSError : writing fails
    """
    cells = [
        [row.bands, row.bounces, f"{100.0 * row.mean:#.6g}", f"{100.0 * row.worst:#.6g}"]
        for row in rows
    ]
    with replacing(path) as part:
        write_csv(part, COLUMNS, cells)
