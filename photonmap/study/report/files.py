"""The files of a study: study.html, study.csv and the plots, all of them or none."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Sequence
from pathlib import Path

from photonmap.study.point import COLUMNS, Point
from photonmap.study.report.about import About
from photonmap.study.report.drawing import as_png
from photonmap.study.report.findings import Findings
from photonmap.study.report.page import write_page
from photonmap.study.report.plots import drawn_figures

PAGE, TABLE = "study.html", "study.csv"


def write_study(folder: Path, found: Findings, about: About) -> None:
    """Write the page, the table and the plots; none appears before all of them are complete.

    Raises
    ------
    OSError
        if writing fails
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=folder.parent) as made:
        part = Path(made)
        figures = drawn_figures(found)
        (part / PAGE).write_text(write_page(found, about, figures), encoding="utf-8")
        write_table(part / TABLE, found.points)
        for name, figure in figures.items():
            (part / f"{name}.png").write_bytes(as_png(figure))
        folder.mkdir(exist_ok=True)
        for file in part.iterdir():
            file.replace(folder / file.name)


def write_table(path: Path, points: Sequence[Point]) -> None:
    """Write the points as comma-separated values, a row each, under `COLUMNS`."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(point.row() for point in points)
