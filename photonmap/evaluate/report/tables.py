"""The tables of an evaluation and of its experiments: as text, comma-separated values and LaTeX."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from photonmap.evaluate.bench.measure import ILLUMINANT, MEAN_LAYER, Column
from photonmap.evaluate.bench.scores import Evaluation, Summary
from photonmap.evaluate.intervals import Interval
from photonmap.report.tables import aligned, write_csv


class Cell(NamedTuple):
    """A figure of a table."""

    value: float | None  # None where there is none
    note: str = ""  # small print, such as an interval


@dataclass(frozen=True)
class Table:
    """A table of an experiment."""

    name: str  # of its files and its anchor on the page
    title: str  # above it
    meaning: str  # what it shows and how it was measured
    heads: Sequence[str]  # of the columns, that of the rows' names first
    rows: Sequence[tuple[str, Sequence[Cell]]]  # name and figures, as many as `heads` asks for
    findings: Sequence[str] = ()  # sentences on what it shows, computed from it


def number(value: float) -> str:
    """Return a number with three significant digits."""
    text = f"{value:#.3g}".rstrip(".")
    return text if "e" not in text else f"{value:.2g}"


def interval(ends: Interval | None) -> str:
    """Return an interval as text; "" for none."""
    return "" if ends is None else f"[{number(ends.low)}, {number(ends.high)}]"


_SUMMARY = (
    "method", "metric", "layer", "figure", "value", "low", "high", "truth_low", "truth_high",
    "scored", "failed",
)  # fmt: skip
_SCORES = ("method", "image", "scene", "metric", "layer", "score", "why_none")
_SPECIAL = {character: f"\\{character}" for character in "#$%&_{}"} | {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
}  # fmt: skip


def by_metric(summaries: Iterable[Summary]) -> dict[str, dict[str, dict[str, Summary]]]:
    """Return summaries by metric, then method, then title: the layer; of an illuminant, the figure.

    Titles head the columns of a metric's table.
    """
    found: dict[str, dict[str, dict[str, Summary]]] = {}
    for summary in summaries:
        metric, layer = summary.column
        title = summary.figure if layer == ILLUMINANT else layer
        found.setdefault(metric, {}).setdefault(summary.method, {})[title] = summary
    return found


def titles(rows: dict[str, dict[str, Summary]]) -> list[str]:
    """Return the titles of a metric's columns, those of any method."""
    return list(dict.fromkeys(title for cells in rows.values() for title in cells))


def as_text(evaluation: Evaluation, summaries: Sequence[Summary]) -> str:
    """Return a table of each metric: a row a method, figures with their intervals over scenes."""
    blocks = []
    for metric, methods in by_metric(summaries).items():
        heads = titles(methods)
        rows = [[metric, *heads, "images"]]
        for method, cells in methods.items():
            most = max(cells.values(), key=lambda cell: cell.scored)
            shown = [_with_notes(cells.get(head), most.scored) for head in heads]
            failed = f", {most.failed} failed" if most.failed else ""
            rows.append([method, *shown, f"{most.scored} of {len(evaluation.images)}{failed}"])
        blocks.append("\n".join(aligned(rows)))
    return "\n\n".join(blocks)


def notes_of(summary: Summary, most: int) -> str:
    """Return the interval of a figure, and how many images it is over if these are not `most`."""
    few = f"{summary.scored} images" if summary.scored < most else ""
    return " ".join(filter(None, [interval(summary.over_scenes), few]))


def _with_notes(summary: Summary | None, most: int) -> str:
    if summary is None:
        return "-"
    return f"{number(summary.value)} {notes_of(summary, most)}".rstrip()


def write_summary(path: Path, summaries: Sequence[Summary]) -> None:
    """Write all figures with their intervals over scenes and over the truth, a row each."""
    none = ("", "")
    rows = [
        [s.method, *s.column, s.figure, s.value, *(s.over_scenes or none), *(s.over_truth or none),
         s.scored, s.failed]
        for s in summaries
    ]  # fmt: skip
    write_csv(path, _SUMMARY, rows)


def write_scores(path: Path, evaluation: Evaluation) -> None:
    """Write the score of each method, image, metric and layer, or why there is none."""
    scenes = dict(zip(evaluation.images, evaluation.scenes, strict=True))
    rows: list[list[Any]] = []
    for method in evaluation.methods:
        for image in evaluation.images:
            head = [method.name, image, scenes[image]]
            if image in method.failures:
                rows.append([*head, "", "", "", method.failures[image]])
                continue
            measured = method.measured[image]
            rows += [[*head, *column, score, ""] for column, score in measured.scores.items()]
            rows += [[*head, *column, "", why] for column, why in measured.undefined.items()]
    write_csv(path, _SCORES, rows)


def write_latex(path: Path, evaluation: Evaluation, summaries: Sequence[Summary]) -> None:
    """Write a tabular of decompositions and one of illuminants, for the package booktabs.

    Decompositions show each metric's mean over layers, or its only layer; intervals over scenes
    stand below; the best value of a column is bold.
    """
    wanted = [s for s in summaries if s.column.layer != ILLUMINANT and _is_headline(s, summaries)]
    tables = [wanted, [s for s in summaries if s.column.layer == ILLUMINANT]]
    notes = f"% {evaluation.dataset}: {len(evaluation.images)} images, 95% intervals over scenes\n"
    path.write_text(notes + "\n".join(map(_tabular, filter(None, tables))), encoding="utf-8")


def _is_headline(summary: Summary, summaries: Sequence[Summary]) -> bool:
    """Return whether a summary is that of the mean over layers, or there is no such."""
    mean = Column(summary.column.metric, MEAN_LAYER)
    return summary.column == mean or not any(other.column == mean for other in summaries)


def _tabular(summaries: Sequence[Summary]) -> str:
    columns = list(dict.fromkeys((s.column, s.figure) for s in summaries))
    cells = {(s.method, s.column, s.figure): s for s in summaries}
    best = {key: min(s.value for s in summaries if (s.column, s.figure) == key) for key in columns}
    heads = [c.metric if c.layer != ILLUMINANT else f"{c.metric}, {f}" for c, f in columns]
    rows = []
    for method in dict.fromkeys(s.method for s in summaries):
        found = [cells.get((method, *key)) for key in columns]
        values = [_latex_value(s, best) for s in found]
        ends = [f"\\scriptsize {interval(s.over_scenes)}" if s else "" for s in found]
        rows += [[escaped(method), *values], ["", *ends]]
    return _booktabs(["", *heads], rows)


def _latex_value(summary: Summary | None, best: dict[tuple[Column, str], float]) -> str:
    if summary is None:
        return "--"
    text = number(summary.value)
    bold = summary.value == best[summary.column, summary.figure]
    return f"\\textbf{{{text}}}" if bold else text


def escaped(text: str) -> str:
    """Return text with the characters escaped that LaTeX reads otherwise."""
    return "".join(_SPECIAL.get(character, character) for character in text)


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
    write_csv(path, heads, rows)


def as_tabular(table: Table) -> str:
    """Return a tabular for LaTeX with the package booktabs; small print is left out."""
    rows = [
        [escaped(name), *("--" if c.value is None else f"${number(c.value)}$" for c in cells)]
        for name, cells in table.rows
    ]
    return f"% {table.title}\n{_booktabs(table.heads, rows)}"


def _booktabs(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a tabular of rows that LaTeX can read, below heads that are escaped here."""
    head, *lines = (" & ".join(row) + r" \\" for row in (map(escaped, heads), *rows))
    begin = f"\\begin{{tabular}}{{l{'r' * (len(heads) - 1)}}}"
    end = ["\\bottomrule", "\\end{tabular}", ""]
    return "\n".join([begin, "\\toprule", head, "\\midrule", *lines, *end])
