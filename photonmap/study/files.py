"""The folder of a study: study.html, study.csv and the plots; all of them or none."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError
from photonmap.places import check_writable
from photonmap.study.about import About
from photonmap.study.drawing import as_png
from photonmap.study.findings import Findings
from photonmap.study.page import write_page
from photonmap.study.plots import drawn_figures
from photonmap.study.point import COLUMNS, Point

PAGE, TABLE = "study.html", "study.csv"


def check_folder(path: str | PathLike[str]) -> Path:
    """Check before a study that a folder can be made or written to.

    Raises
    ------
    InputError
        if it is a file, or the folder that it is in is missing or not writable
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file; name a folder for the study", folder)
    parent = folder if folder.is_dir() else folder.parent
    if not parent.is_dir():
        raise InputError(f"the folder {parent} does not exist; create it", folder)
    check_writable(parent, folder)
    return folder


def write_study(folder: Path, found: Findings, about: About) -> None:
    """Write the page, the table and the plots; none appears before all are complete.

    Raises
    ------
    OSError
        if writing fails
    """
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
    """Write every point as a row of comma-separated values, under `COLUMNS`."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(point.row() for point in points)
