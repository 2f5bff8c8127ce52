"""The files of an evaluation: all of them or none."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from photonmap.evaluate.bench.scores import Evaluation, Summary
from photonmap.evaluate.experiments.table import Table
from photonmap.evaluate.report.experiment_tables import as_tabular, write_table
from photonmap.evaluate.report.gallery import Gallery
from photonmap.evaluate.report.page import write_page
from photonmap.evaluate.report.tables import write_latex, write_scores, write_summary

PAGE, SUMMARY, SCORES, LATEX = "report.html", "summary.csv", "scores.csv", "table.tex"


def write_report(
    folder: Path,
    evaluation: Evaluation,
    summaries: Sequence[Summary],
    gallery: Gallery,
    notes: Sequence[str] = (),
    tables: Sequence[Table] = (),
) -> None:
    """Write the page and the tables; none appears before all of them are complete.

    Parameters
    ----------
    folder : made where it is missing, like those above it
    summaries, gallery, notes, tables : as `photonmap.evaluate.report.page.write_page` takes them

    Raises
    ------
    OSError : writing fails
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=folder.parent) as made:
        part = Path(made)
        page = write_page(evaluation, summaries, gallery, notes, tables)
        (part / PAGE).write_text(page, encoding="utf-8")
        write_summary(part / SUMMARY, summaries)
        write_scores(part / SCORES, evaluation)
        write_latex(part / LATEX, evaluation, summaries)
        for table in tables:
            write_table(part / f"{table.name}.csv", table)
            (part / f"{table.name}.tex").write_text(as_tabular(table), encoding="utf-8")
        folder.mkdir(exist_ok=True)
        for file in part.iterdir():
            file.replace(folder / file.name)
