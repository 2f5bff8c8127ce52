"""The report of an evaluation: a page that contains all tables and pictures, and table files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.evaluate.bench.measure import METRICS, Column
from photonmap.evaluate.bench.scores import Evaluation, MethodScores, Summary
from photonmap.evaluate.intervals import LEVEL
from photonmap.evaluate.metrics.arrays import Floats
from photonmap.evaluate.report.gallery import Gallery
from photonmap.evaluate.report.tables import (
    Cell,
    Table,
    as_tabular,
    by_metric,
    interval,
    notes_of,
    number,
    titles,
    write_latex,
    write_scores,
    write_summary,
    write_table,
)
from photonmap.report.pages import has_jinja, render_page
from photonmap.runtime.writing import written_together


def check_jinja() -> None:
    """Raise `InputError` without Jinja, which the page needs."""
    if not has_jinja():
        raise InputError("the report needs jinja2: pip install 'photonmap[evaluate]'")


def write_page(
    evaluation: Evaluation,
    summaries: Sequence[Summary],
    gallery: Gallery,
    notes: Sequence[str],
    tables: Sequence[Table],
) -> str:
    """Return the page: of an evaluation and its summaries, and of the tables of experiments.

    The gallery has the pictures of the best and worst estimates, and of disagreements; notes are
    lines on how estimates came about.
    """
    return render_page(
        __package__,
        "evaluation.html",
        evaluation=evaluation,
        count=len(evaluation.images),
        scenes=len(set(evaluation.scenes)),
        level=f"{100 * LEVEL:g}%",
        notes=notes,
        metrics=[_metric(name, rows) for name, rows in by_metric(summaries).items()],
        comparisons=evaluation.comparisons(),
        experiments=tables,
        tables=_score_tables(evaluation),
        methods=[_method(method) for method in evaluation.methods],
        failures=evaluation.failures,
        undefined=_undefined(evaluation),
        cases=gallery.cases,
        disagreements=gallery.disagreements,
        number=number,
        interval=interval,
        notes_of=notes_of,
    )


def _metric(name: str, rows: dict[str, dict[str, Summary]]) -> dict[str, Any]:
    """Return a metric's table: for each method, the summary of most images, and those by title."""
    heads = titles(rows)
    found = [
        (method, max(cells.values(), key=lambda cell: cell.scored), [cells.get(h) for h in heads])
        for method, cells in rows.items()
    ]
    return {"about": METRICS[name], "heads": heads, "rows": found}


def _score_tables(evaluation: Evaluation) -> list[dict[str, Any]]:
    """Return the mean scores of scenes, and those of images, for one column of each metric."""
    columns: dict[str, Column] = {}
    for method in evaluation.methods:
        for column in method.columns:
            columns[column.metric] = column  # the mean over layers comes last
    tables = []
    for column in (columns[name] for name in METRICS if name in columns):
        methods = [method for method in evaluation.methods if column in method.columns]
        scores = np.array([method.values(column, evaluation.images) for method in methods]).T
        scenes = np.array(evaluation.scenes, object)
        tables.append(
            {
                "column": column,
                "methods": [method.name for method in methods],
                "scenes": [(s, _means(scores[scenes == s])) for s in dict.fromkeys(scenes)],
                "images": [
                    (image, _means(row[None]))
                    for image, row in zip(evaluation.images, scores, strict=True)
                ],
            }
        )
    return tables


def _means(scores: Floats) -> list[Cell]:
    """Return the means of (K, M) over the images that have a score."""
    columns = [column[np.isfinite(column)] for column in scores.T]
    return [Cell(float(column.mean()) if column.size else None) for column in columns]


def _method(method: MethodScores) -> dict[str, Any]:
    """Return what is said of a method: time, and the settings that scenes were given."""
    seconds = list(method.seconds.values())
    settings = {
        scene: ", ".join(f"{name} {value:.3g}" for name, value in chosen.items())
        for scene, chosen in method.settings.items()
        if chosen
    }
    return {
        "name": method.name,
        "seconds": f"{sum(seconds) / len(seconds):.2g}" if seconds else "–",
        "settings": settings,
    }


def _undefined(evaluation: Evaluation) -> list[tuple[str, str, int]]:
    """Return metrics that are not defined for some images: name, reason, and how many images."""
    found: dict[tuple[str, str], set[str]] = {}
    for method in evaluation.methods:
        for image, measured in method.measured.items():
            for column, reason in measured.undefined.items():
                found.setdefault((column.metric, reason), set()).add(image)
    return [(metric, reason, len(images)) for (metric, reason), images in found.items()]


PAGE, SUMMARY, SCORES, LATEX = "report.html", "summary.csv", "scores.csv", "table.tex"


def write_report(
    folder: Path,
    evaluation: Evaluation,
    summaries: Sequence[Summary],
    gallery: Gallery,
    notes: Sequence[str] = (),
    tables: Sequence[Table] = (),
) -> None:
    """Write the page and the tables, or raise `OSError`: none appears before all are complete.

    The folder is made where it is missing, like those above it; the rest is as `write_page` takes
    it.
    """
    with written_together(folder) as part:
        page = write_page(evaluation, summaries, gallery, notes, tables)
        (part / PAGE).write_text(page, encoding="utf-8")
        write_summary(part / SUMMARY, summaries)
        write_scores(part / SCORES, evaluation)
        write_latex(part / LATEX, evaluation, summaries)
        for table in tables:
            write_table(part / f"{table.name}.csv", table)
            (part / f"{table.name}.tex").write_text(as_tabular(table), encoding="utf-8")
