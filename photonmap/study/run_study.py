"""A study from its first render to its files: study.html, study.csv and the plots."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from photonmap.report.files import written_together
from photonmap.report.plots import save_figure
from photonmap.report.tables import write_csv
from photonmap.runtime.interrupts import ignoring_interrupts
from photonmap.study.convergence import Findings
from photonmap.study.machine import BackgroundLoad, choose_clock, describe_machine
from photonmap.study.measure import COLUMNS, Study
from photonmap.study.page import About, describe_study, write_page
from photonmap.study.plots import drawn_figures
from photonmap.study.sweeps import Extent, run_sweeps

PAGE, TABLE = "study.html", "study.csv"


def write_study(folder: Path, found: Findings, about: About) -> None:
    """Write the page, the table and the plots; none appears before all of them are complete.

    Raises
    ------
    OSError : writing fails
    """
    with written_together(folder) as part:
        figures = drawn_figures(found)
        (part / PAGE).write_text(write_page(found, about, figures), encoding="utf-8")
        write_csv(part / TABLE, COLUMNS, [[*point.row().values()] for point in found.points])
        for name, figure in figures.items():
            save_figure(figure, part / f"{name}.png")


@dataclass(frozen=True)
class Outcome:
    """What a study found.

    Parameters
    ----------
    findings : its points, and the laws fitted to them
    interrupted : whether Ctrl-C ended the sweeps
    """

    findings: Findings
    interrupted: bool


def run_study(study: Study, extent: Extent, folder: Path) -> Outcome:
    """Run the sweeps, and write study.html, study.csv and the plots; after Ctrl-C, what there is.

    Raises
    ------
    InputError : no pixel counts, or the folder cannot be written to
    KeyboardInterrupt : Ctrl-C before there was a reference to measure errors against
    """
    machine = describe_machine()
    with BackgroundLoad() as others:
        interrupted = _sweep(study, extent)
    with ignoring_interrupts():
        assert study.reference is not None
        threads = study.record["arguments"]["threads"]
        points = choose_clock(study.points, others.share, threads)
        findings = Findings(points, study.base.bands, study.reference.own_errors())
        about = describe_study(study, extent, interrupted, machine, others.share)
        write_study(folder, findings, about)
    return Outcome(findings, interrupted)


def _sweep(study: Study, extent: Extent) -> bool:
    """Run the sweeps; return whether Ctrl-C ended them."""
    try:
        run_sweeps(study, extent)
    except KeyboardInterrupt:
        if not study.points:
            raise
        return True
    return False
