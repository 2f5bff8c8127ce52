"""The tables of experiments as comma-separated values and LaTeX."""

from __future__ import annotations

from pathlib import Path

from photonmap.evaluate.experiments.table import Cell, Table
from photonmap.evaluate.report.numbers import number
from photonmap.evaluate.report.tables import escaped, write_rows


def write_table(path: Path, table: Table) -> None:
    """Write a table; each figure is followed by its small print."""
    heads = [table.heads[0]]
    for head in table.heads[1:]:
        heads += [head, f"{head}, note"]
    rows = []
    for name, cells in table.rows:
        row = [name]
        for cell in cells:
            row += ["" if cell.value is None else repr(float(cell.value)), cell.note]
        rows.append(row)
    write_rows(path, heads, rows)


def as_tabular(table: Table) -> str:
    """Return a tabular for LaTeX with the package booktabs; small print is left out."""
    lines = [f"% {table.title}", f"\\begin{{tabular}}{{l{'r' * (len(table.heads) - 1)}}}"]
    lines += ["\\toprule", " & ".join(map(escaped, table.heads)) + r" \\", "\\midrule"]
    for name, cells in table.rows:
        lines.append(" & ".join([escaped(name), *map(_value, cells)]) + r" \\")
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}", ""])


def _value(cell: Cell) -> str:
    return "--" if cell.value is None else f"${number(cell.value)}$"
