"""Tables of raw numbers, rounded only for display."""

from __future__ import annotations

from dataclasses import dataclass, field

from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

Cell = float | str | None


@dataclass
class Table:
    """One table of a benchmark.

    Parameters
    ----------
    title, columns : with units
    rows : numbers, text, or None for an empty cell
    notes : lines below the table
    """

    title: str
    columns: list[str]
    rows: list[list[Cell]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def skipped(title: str, reason: str) -> Table:
    """Return an empty table that states the reason."""
    return Table(title, ["skipped"], [[reason]])


def shown(cell: Cell) -> str:
    """Return a number to three significant digits, integers and large numbers in full."""
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    if isinstance(cell, int) or abs(cell) >= 1000:
        return f"{cell:,.0f}".replace(",", " ")
    return f"{cell:#.3g}".rstrip(".")


def show(table: Table) -> None:
    """Print a table."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=120)
    console.print(escape(table.title), highlight=False, style="bold")
    grid = RichTable()
    for index, column in enumerate(table.columns):
        grid.add_column(escape(column), justify="left" if index == 0 else "right")
    for row in table.rows:
        grid.add_row(*(escape(shown(cell)) for cell in row))
    console.print(grid)
    for note in table.notes:
        console.print(escape(note), highlight=False)


def markdown(table: Table) -> str:
    """Return a table in Markdown, as in docs/performance.md."""
    lines = [table.columns, ["---"] + ["---:"] * (len(table.columns) - 1)]
    lines += [[shown(cell) for cell in row] for row in table.rows]
    grid = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    notes = "".join(f"\n{note}.\n" for note in table.notes)
    return f"{table.title}\n\n{grid}\n{notes}"
