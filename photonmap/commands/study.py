"""The command `python -m photonmap study`: what accuracy costs in time, for one scene."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from photonmap.commands import INTERRUPTED, shared
from photonmap.errors import InputError
from photonmap.runtime.progress import Lines, Progress, Silent
from photonmap.settings import STUDY

if TYPE_CHECKING:
    from photonmap.study.measure import Study
    from photonmap.study.run_study import Outcome
    from photonmap.study.sweeps import Extent

HELP = "Sweep the options of a render, and show what accuracy costs in time: FOLDER/study.html."

_MINUTES, _QUICK_MINUTES = 5.0, 0.2  # default minutes of rendering
_MINUTE_LIMITS = (0.001, 24 * 60.0)
_SIZE, _QUICK_SIZE = (128, 128), (32, 32)  # default width and height, pixels
_NEEDS = ("jinja2", "matplotlib")  # packages that the report is made with


class _Stages(Lines):
    """Prints a line every few seconds of a render, and where kernels are compiled."""

    def stage(self, name: str) -> None:
        """Print the stage's name where it takes long."""
        if name == "first compile":
            super().stage(name)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    shared.add_scene_options(parser)
    sizes = "128x128; with --quick 32x32"
    groups = shared.add_options(parser, STUDY, size={"default": None, "default_text": sizes})
    shared.add_range(groups["image"])
    minutes = f"{_MINUTES:g}; with --quick {_QUICK_MINUTES:g}"
    extent: list[shared.Row] = [
        ("quick", None, "measure only a few points, in seconds", {"default": False}),
        ("minutes", "M", "total minutes of rendering; with more, the sweeps go farther",
         {"read": shared.number(*_MINUTE_LIMITS, " minutes"), "default_text": minutes}),
    ]  # fmt: skip
    shared.add_group(parser, "extent", extent)
    usual = "SCENE-study in the current folder"
    more = {"default_text": usual, "short": "o", "read": shared.file_name}
    shared.add_group(parser, "files", [("output", "FOLDER", "where to write the report", more)])
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> int | None:
    """Measure, and write study.html, study.csv and the plots; after Ctrl-C, what there is."""
    _check_packages()
    from photonmap.runtime.writing import check_output_folder
    from photonmap.study.run_study import run_study

    folder = check_output_folder(options.output or f"{Path(options.scene).stem}-study", "the study")
    study, extent = _prepare(options)
    outcome = run_study(study, extent, folder)
    if not options.quiet:
        _report(outcome, folder)
    return INTERRUPTED if outcome.interrupted else None


def _check_packages() -> None:
    if missing := [name for name in _NEEDS if find_spec(name) is None]:
        names = " and ".join(missing)
        raise InputError(f"the study needs {names}: pip install 'photonmap[study]'")


def _prepare(options: argparse.Namespace) -> tuple[Study, Extent]:
    """Check the options and load the scene."""
    from photonmap.study.measure import Settings, Study
    from photonmap.study.sweeps import Extent, check_largest

    quick = options.quick
    seconds = 60.0 * (options.minutes or (_QUICK_MINUTES if quick else _MINUTES))
    extent = Extent.quick(seconds) if quick else Extent(seconds)
    if options.range is not None:
        extent = extent.without_rgb()
    given = shared.choose_options(options, STUDY)
    given["size"] = given["size"] or (_QUICK_SIZE if quick else _SIZE)
    given["bands"] = str(options.bands)
    base = Settings(**given)
    progress: Progress = Silent() if options.quiet else _Stages()
    log = shared.progress_log(options)
    scene = shared.choose_scene(options).load()
    study = Study(scene, base, options.range, progress, log)
    check_largest(study, extent)
    return study, extent


def _report(outcome: Outcome, folder: Path) -> None:
    """Print the recommendation, and where the page is."""
    from photonmap.study.convergence import recommend
    from photonmap.study.run_study import PAGE

    found = outcome.findings
    for sentence in recommend(found.laws, found.base):
        print(sentence)
    state = "interrupted after " if outcome.interrupted else ""
    print(f"{state}{len(found.points)} points: {folder / PAGE}")
