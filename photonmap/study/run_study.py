"""A study from its first render to its files: study.html, study.csv and the plots."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.film.budget import LEAST_PASSES
from photonmap.report.pages import render_page
from photonmap.report.plots import as_svg, save_figure
from photonmap.report.tables import write_csv
from photonmap.runtime.terminal import answering_interrupts
from photonmap.runtime.writing import written_together
from photonmap.study import convergence, measure
from photonmap.study.convergence import BUFFER, PATH, TARGETS, Findings, Law, Power
from photonmap.study.errors import BUFFERS, CAPTIONS, REFERENCE_BANDS, Kind, color_bar
from photonmap.study.plots import drawn_figures
from photonmap.study.sweeps import Extent, bands_label, run_sweeps

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def describe_study(
    study: measure.Study, extent: Extent, interrupted: bool, machine: dict[str, Any], others: float
) -> dict[str, Any]:
    """Return the texts that describe a study, which has its reference, on the page.

    `machine` is what `describe_machine` returns, and `others` the fraction of the processors that
    other programs took.
    """
    width, height = study.base.size
    record = study.record
    triangles = record["scene"]["triangles"]
    bands, clock = bands_label(study.base.bands), _clock(study, others)
    pairs = [
        ("scene", f"{study.name}, {triangles} triangles"),
        ("image", f"{width}×{height}, {study.base.pixel} pixels, {bands}, seed {study.base.seed}"),
        ("photons per pass", str(record["arguments"]["photons"])),
        ("effects", ", ".join(name for name, e in record["effects"].items() if e["on"])),
        ("reference", _reference(study)),
        ("rendering", f"{study.spent:.0f} s of {extent.seconds:.0f} s allowed"),
        ("threads", f"{record['arguments']['threads']} of {machine['processors']} processors"),
        ("machine", f"{machine['processor']}, {machine['system']}"),
        ("clock", clock),
        ("versions", ", ".join(f"{name} {v}" for name, v in machine["versions"].items())),
    ]
    repeats = f"{extent.repeats} run{'s' * (extent.repeats > 1)}"
    why = {name: effect["why"] for name, effect in record["effects"].items()}
    shown = f"{width}×{height} pixels, {bands} unless stated, {triangles} triangles"
    return {
        "title": study.name,
        "subtitle": f"{shown}; {machine['processor']}, {record['arguments']['threads']} threads",
        "base": bands,
        "interrupted": interrupted,
        "pairs": pairs,
        "why": why,
        "clock": clock,
        "repeats": repeats,
    }


def _reference(study: measure.Study) -> str:
    """Return how the reference was rendered, and its own errors."""
    reference = study.reference
    assert reference is not None
    errors = ", ".join(f"{name} {100 * reference.own_error(name):.2g}%" for name in BUFFERS)
    return (
        f"photon mapping, {reference.passes} passes in two halves, {reference.seconds:.0f} s; "
        f"its own error: {errors}"
    )


def _clock(study: measure.Study, others: float) -> str:
    """Return which clock seconds are by, and why."""
    load = f"other programs took {others:.0%} of the processors"
    if others <= measure.MAX_BACKGROUND_LOAD:
        return f"wall-clock time, without loading and compiling; {load}"
    longer = study.spent * study.record["arguments"]["threads"] / study.processor
    return (
        f"processor time divided by threads, without loading and compiling, as {load}; "
        f"wall-clock time was {longer:.1f} times as long"
    )


_DASH = "–"
_BARS: tuple[Kind, ...] = ("true", "stated", "delta")


def write_page(found: Findings, about: dict[str, Any], figures: dict[str, Figure]) -> str:
    """Return the page; `about` is what `describe_study` returns, and `figures` are by name."""
    return render_page(
        __package__,
        "study.html",
        about=about,
        sentences=convergence.recommend(found.laws, found.base),
        targets=[f"{100 * target:g}%" for target in TARGETS],
        many=REFERENCE_BANDS,
        least=LEAST_PASSES,
        laws=[_law_row(law, found) for law in found.laws],
        figures={name: as_svg(figure, name) for name, figure in figures.items()},
        facts=_facts(found),
        choices=[_choice_row(index, point, found, about) for index, point in found.of("choices")],
        points=[_point_row(index, point) for index, point in enumerate(found.points)],
        data={
            "points": [_point_data(point) for point in found.points],
            "bars": {kind: {"colors": color_bar(kind), "what": CAPTIONS[kind]} for kind in _BARS},
            "first": max((index for index, _ in found.of("passes")), default=0),
        },
    )


def _law_row(law: Law, found: Findings) -> dict[str, Any]:
    """Return the table row of a law: seconds to each target, and spectral errors."""
    cells = []
    for target in TARGETS:
        took = law.seconds_to(target)
        cells.append({"text": convergence.duration(took.seconds), "beyond": took.extrapolated})
    points = [point for _, point in found.most_passes("bands")]
    colors = {bands_label(point.settings.bands): point.color for point in points}
    texts = [_DASH] * 6
    if color := colors.get(law.label):
        deltas = map(convergence.two_digits, astuple(color)[:4])
        texts = [*deltas, *map(convergence.percent, (color.shading, color.indirect))]
    return {"label": law.label, "cells": cells, "color": texts}


def _facts(found: Findings) -> dict[str, str]:
    """Return the numbers that captions quote, as text."""
    facts = {"honesty": f"{found.correction.ratio:.2f}"}
    for sweep in ("passes", "path"):
        for buffer in ("radiance", "shading"):
            facts[f"{sweep}_{buffer}"] = _slope(found.slope(sweep, buffer))
        facts[f"{sweep}_by_passes"] = _slope(found.slope(sweep, BUFFER, by_passes=True))
    if (path := found.bias) is not None:
        bias = f"{100 * path.mean_difference:+.2f}% ± {100 * path.mean_error:.2f}%"
        facts["bias"] = bias.replace("-", "−")
    return facts


def _slope(law: Power | None) -> str:
    """Return the exponent of a law, with its standard error if it is known."""
    if law is None:
        return _DASH
    spread = "" if math.isnan(law.uncertainty) else f" ± {law.uncertainty:.3f}"
    return f"{law.exponent:.3f}{spread}".replace("-", "−")


def _choice_row(
    index: int, point: measure.Point, found: Findings, about: dict[str, Any]
) -> dict[str, Any]:
    """Return the table row of a choice: its cost and effect against the default settings."""
    usual = found.of("choices")[0][1]
    changed = convergence.change_beyond_noise(point)
    return {
        "index": index,
        "label": point.label,
        "why": about["why"].get(point.label.removeprefix("without "), ""),
        "seconds": f"{point.seconds:.2f}",
        "relative": f"{point.processor / usual.processor:.2f}",
        "stated": convergence.percent(point.stated["radiance"]),
        "mean": f"{100 * point.mean_difference:+.1f}%".replace("-", "−"),
        "changed": "none beyond noise" if changed is None else convergence.percent(changed),
    }


def _point_row(index: int, point: measure.Point) -> dict[str, Any]:
    """Return a row of the table of all points."""
    settings = point.settings
    return {
        "index": index,
        "cells": [
            *(point.sweep, point.label, settings.method, settings.bands),
            *(f"{settings.size[0]}×{settings.size[1]}", settings.passes, settings.photons),
            f"{point.seconds:.2f}",
            *(_percent_or_dash(point.stated.get(buffer)) for buffer in ("radiance", "shading")),
            *(_percent_or_dash(point.true.get(buffer)) for buffer in ("radiance", "shading")),
            convergence.two_digits(point.color.delta_mean) if point.color else _DASH,
        ],
    }


def _point_data(point: measure.Point) -> dict[str, Any]:
    """Return what the page shows when a point is selected."""
    settings, shown = point.settings, point.error_map
    errors = [
        [buffer, *(_percent_or_dash(kind.get(buffer)) for kind in (point.stated, point.true))]
        for buffer in BUFFERS
    ]
    rest = [
        ["method", "photon mapping" if settings.method == "photon" else PATH],
        ["bands", settings.bands],
        ["size", f"{settings.size[0]}×{settings.size[1]}, {settings.pixel} pixels"],
        ["passes", f"{settings.passes} of {settings.photons} photons"],
        ["effects", settings.effects.replace(",", ", ")],
        ["seconds", f"{point.seconds:.3g}; by the wall clock {point.wall:.3g}"],
    ]
    if settings.method != "photon":
        rest[3][1] = str(settings.passes)
    if point.color:
        mean, p95, *of_indirect = map(convergence.two_digits, astuple(point.color)[:4])
        rest.append(["ΔE2000, mean / 95%", f"{mean} / {p95}"])
        rest.append(["of indirect light", " / ".join(of_indirect)])
    return {
        "title": f"{point.label} ({point.sweep})",
        "picture": point.picture,
        "map": shown.image if shown else "",
        "kind": shown.kind if shown else "",
        "scale": _scale(shown.kind, shown.scale) if shown else "",
        "settings": rest,
        "errors": errors,
    }


def _scale(kind: Kind, scale: float) -> str:
    return f"{scale:g}" if kind == "delta" else f"{100 * scale:g}%"


def _percent_or_dash(value: float | None) -> str:
    return _DASH if value is None or math.isnan(value) else f"{100 * value:#.3g}%"


PAGE, TABLE = "study.html", "study.csv"


def write_study(folder: Path, found: Findings, about: dict[str, Any]) -> None:
    """Write the page, the table and the plots; none appears before all of them are complete."""
    with written_together(folder) as part:
        figures = drawn_figures(found)
        (part / PAGE).write_text(write_page(found, about, figures), encoding="utf-8")
        write_csv(
            part / TABLE, measure.COLUMNS, [[*point.row().values()] for point in found.points]
        )
        for name, figure in figures.items():
            save_figure(figure, part / f"{name}.png")


@dataclass(frozen=True)
class Outcome:
    """What a study found, and whether Ctrl-C ended its sweeps."""

    findings: Findings
    interrupted: bool


def run_study(study: measure.Study, extent: Extent, folder: Path) -> Outcome:
    """Run the sweeps, and write the page, the table and the plots; after Ctrl-C, what there is."""
    machine = measure.describe_machine()
    interrupted = False
    with measure.BackgroundLoad() as others:
        try:
            run_sweeps(study, extent)
        except KeyboardInterrupt:
            if not study.points:
                raise
            interrupted = True
    with answering_interrupts():
        assert study.reference is not None
        threads = study.record["arguments"]["threads"]
        points = measure.choose_clock(study.points, others.share, threads)
        findings = Findings(points, study.base.bands, study.reference.own_errors())
        about = describe_study(study, extent, interrupted, machine, others.share)
        write_study(folder, findings, about)
    return Outcome(findings, interrupted)
