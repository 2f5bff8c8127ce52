"""The command `python -m photonmap study`: what accuracy costs in time, for one scene."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from photonmap.arguments import limits, size
from photonmap.errors import InputError
from photonmap.progress import Lines, Progress, Silent
from photonmap.scene_options import add_scene_options, load_chosen_scene, name_measured_sets

if TYPE_CHECKING:
    from photonmap.study.findings import Findings
    from photonmap.study.measure import Study
    from photonmap.study.sweeps import Extent

HELP = "sweep what can be chosen, and show what accuracy costs in time: FOLDER/study.html"

_MINUTES, _QUICK_MINUTES = 5.0, 0.2
_MOST_MINUTES = 24 * 60.0
_SIZE, _QUICK_SIZE = (128, 128), (32, 32)
_NEEDS = ("jinja2", "matplotlib")


class _Stages(Lines):
    """Tells of renders under way every few seconds, and of compiling; not of each beginning."""

    def stage(self, name: str) -> None:
        """Print the stage's name where it takes long."""
        if name == "first compile":
            super().stage(name)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_scene_options(parser)
    start = parser.add_argument_group("what sweeps start from")
    start.add_argument("--bands", default="6", metavar="BANDS", help="as for a render (default 6)")
    start.add_argument("--range", type=limits, metavar="LOW:HIGH", help="of the bands, nm")
    start.add_argument("--size", type=size, metavar="WxH", help="default 128x128; quick: 32x32")
    start.add_argument("--seed", type=int, default=0, metavar="N", help="default 0")
    start.add_argument("--threads", type=int, metavar="N", help="default: every processor")
    extent = parser.add_argument_group("extent")
    extent.add_argument("--quick", action="store_true", help="few points, in seconds")
    extent.add_argument(
        "--minutes",
        type=_minutes,
        metavar="M",
        help=f"of rendering in all, which scales how far sweeps go (default {_MINUTES:g})",
    )
    files = parser.add_argument_group("files")
    files.add_argument("--output", metavar="FOLDER", help="default: SCENE's name and -study, here")
    files.add_argument("--quiet", action="store_true", help="print errors and warnings alone")


def run(options: argparse.Namespace) -> None:
    """Measure, and write study.html, study.csv and the plots; after Ctrl-C, what there is.

    Raises
    ------
    InputError
        if an option is none, the scene cannot be rendered, or the folder not be written to
    KeyboardInterrupt
        at Ctrl-C before there was a reference to measure errors by
    """
    _check_packages()
    from photonmap.study.about import describe_study
    from photonmap.study.files import check_folder, write_study
    from photonmap.study.findings import Findings
    from photonmap.study.machine import Others, choose_clock, describe_machine

    folder = check_folder(options.output or f"{Path(options.scene).stem}-study")
    study, extent = _prepare(options)
    machine = describe_machine()
    with Others() as others:
        interrupted = _measure(study, extent)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is done is kept
    try:
        assert study.reference is not None
        threads = study.record["arguments"]["threads"]
        points = choose_clock(study.points, others.share, threads)
        found = Findings(points, study.base.bands, study.reference.own_errors())
        about = describe_study(study, extent, interrupted, machine, others.share)
        write_study(folder, found, about)
    finally:
        signal.signal(signal.SIGINT, before)
    if not options.quiet:
        _report(found, folder, interrupted)


def _check_packages() -> None:
    if missing := [name for name in _NEEDS if find_spec(name) is None]:
        names = " and ".join(missing)
        raise InputError(f"the study needs {names}: pip install 'photonmap[study]'")


def _prepare(options: argparse.Namespace) -> tuple[Study, Extent]:
    """Check the options and load the scene."""
    from photonmap.bands import Bands
    from photonmap.study.measure import Study
    from photonmap.study.point import Settings
    from photonmap.study.sweeps import Extent, check_largest

    Bands.parse(options.bands, options.range)
    name_measured_sets(options)
    quick = options.quick
    seconds = 60.0 * (options.minutes or (_QUICK_MINUTES if quick else _MINUTES))
    extent = Extent.quick(seconds) if quick else Extent(seconds)
    if options.range is not None:
        extent = extent.without_rgb()
    settings = Settings(
        bands=options.bands,
        size=options.size or (_QUICK_SIZE if quick else _SIZE),
        seed=options.seed,
    )
    progress: Progress = Silent() if options.quiet else _Stages()
    tell = (lambda line: None) if options.quiet else _print
    scene = load_chosen_scene(options)
    study = Study(scene, settings, options.range, options.threads, progress, tell)
    check_largest(study, extent)
    return study, extent


def _measure(study: Study, extent: Extent) -> bool:
    """Run the sweeps; return whether Ctrl-C ended them."""
    from photonmap.study.sweeps import run_sweeps

    try:
        run_sweeps(study, extent)
    except KeyboardInterrupt:
        if not study.points:
            raise
        return True
    return False


def _print(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _report(found: Findings, folder: Path, interrupted: bool) -> None:
    """Print the recommendation, and where the page is."""
    from photonmap.study.files import PAGE
    from photonmap.study.words import recommend

    for sentence in recommend(found.laws, found.base):
        print(sentence)
    state = "interrupted after " if interrupted else ""
    print(f"{state}{len(found.points)} points: {folder / PAGE}")


def _minutes(text: str) -> float:
    """Read minutes of a study."""
    try:
        minutes = float(text)
    except ValueError:
        minutes = math.nan
    if not 0.0 < minutes <= _MOST_MINUTES:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no number of minutes above 0, {_MOST_MINUTES:g} at most"
        )
    return minutes
