"""A study from its first render to its report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from photonmap.runtime.interrupts import ignoring_interrupts
from photonmap.study.machine import BackgroundLoad, choose_clock, describe_machine
from photonmap.study.measure import Study
from photonmap.study.report.about import describe_study
from photonmap.study.report.files import write_study
from photonmap.study.report.findings import Findings
from photonmap.study.sweeps import Extent, run_sweeps


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
