"""The command `python -m photonmap dataset`: render, go on with, and verify data sets."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.arguments import size
from photonmap.errors import InputError, warn
from photonmap.scene_options import add_measured_sets, name_measured_sets

if TYPE_CHECKING:
    from collections.abc import Sequence

    from photonmap.dataset.jobs import Common, Job
    from photonmap.dataset.run import Outcome

HELP = "render a data set of ground truth into FOLDER; or verify the one that is there"

_FAILED, _INTERRUPTED = 1, 130
_VERIFY = "verify"
_NAMED = 4
"""Images that one line names."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.usage = (
        f"{parser.prog} FOLDER [options]\n       {parser.prog} verify FOLDER [--sample N]"
    )
    parser.add_argument(
        "words", nargs="+", metavar="FOLDER", help="the data set's; it is made where it is missing"
    )
    _add_images(parser)
    _add_work(parser)
    check = parser.add_argument_group("verify")
    check.add_argument(
        "--sample", type=int, default=1, metavar="N", help="images to render again (default 1)"
    )


def _add_images(parser: argparse.ArgumentParser) -> None:
    """Add what decides the images."""
    what = parser.add_argument_group("what is rendered")
    what.add_argument(
        "--preset", default="small", metavar="NAME", help="small (default), icip2013, or FILE.toml"
    )
    what.add_argument("--count", type=int, default=1, metavar="N", help="seeds of each scene")
    what.add_argument("--seed", type=int, default=0, metavar="N", help="the first (default 0)")
    what.add_argument(
        "--materials", choices=("lambertian", "mixed"), help="default: the preset's, or lambertian"
    )
    add_measured_sets(what)
    image = parser.add_argument_group("image")
    image.add_argument("--bands", default="6", metavar="BANDS", help="as for a render (default 6)")
    image.add_argument("--size", type=size, default=(640, 480), metavar="WxH", help="640x480")
    image.add_argument(
        "--error", default="0.02", metavar="E", help="as for a render (default 0.02)"
    )


def _add_work(parser: argparse.ArgumentParser) -> None:
    """Add how and where images are rendered and written."""
    work = parser.add_argument_group("work")
    work.add_argument(
        "--format",
        type=lambda text: tuple(text.split(",")),
        default=("exr", "png"),
        metavar="LIST",
        help="of exr, hdf5, png (default: exr,png)",
    )
    work.add_argument(
        "--scheduler", default="local", metavar="ADDRESS", help="local, or one of dask.distributed"
    )
    work.add_argument("--workers", type=int, default=1, metavar="N", help="local processes")
    work.add_argument("--resume", action="store_true", help="render what is missing or damaged")
    work.add_argument("--dry-run", action="store_true", help="list the images, render none")
    work.add_argument("--quiet", action="store_true", help="print errors and warnings alone")


def run(options: argparse.Namespace) -> int:
    """Make a data set, or verify one; return 1 if images failed, 130 after Ctrl-C, else 0.

    Raises
    ------
    InputError
        if an option is none, or the folder is no place for the set
    """
    words = options.words
    if words[0] == _VERIFY and len(words) == 2:
        return _verify(Path(words[1]), options)
    if len(words) > 1:
        raise InputError(f"one folder is wanted, not {len(words)}: {' '.join(words)}")
    if words[0] == _VERIFY:
        raise InputError("verify needs the folder of a data set; of the name verify, ./verify")
    return _make(Path(words[0]), options)


def _make(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.files import check_formats
    from photonmap.dataset.manifest import check_folder, describe_set
    from photonmap.dataset.run import make_dataset
    from photonmap.dataset.schedule import check_scheduler

    formats = tuple(dict.fromkeys(options.format))
    check_formats(formats)
    check_scheduler(options.scheduler, options.workers)
    common, jobs = _plan(options)
    head = describe_set(options.preset, common, formats, jobs)
    check_folder(folder, head, options.resume or options.dry_run)
    if options.dry_run:
        _list(jobs)
        return 0
    tell = (lambda line: None) if options.quiet else _tell
    try:
        outcome = make_dataset(
            folder, head, jobs, formats, options.scheduler, options.workers, tell
        )
    except KeyboardInterrupt:
        print("photonmap: interrupted; what is done is kept: go on with --resume", file=sys.stderr)
        return _INTERRUPTED
    return _report(folder, outcome, options)


def _plan(options: argparse.Namespace) -> tuple[Common, list[Job]]:
    """Check the options, and list the images."""
    from photonmap.dataset.jobs import Common, plan_jobs
    from photonmap.dataset.presets import load_preset
    from photonmap.dataset.sources import describe_inputs, read_user_scenes
    from photonmap.goal import Goal
    from photonmap.settings import check_size
    from photonmap.spectra import munsell, text

    preset = load_preset(options.preset)
    name_measured_sets(options)
    check_size(options.size)
    Goal.parse(options.error)
    sets = [os.environ.get(name) for name in (munsell.VARIABLE, text.ILLUMINANTS)]
    chips, lights = (str(Path(path).resolve()) if path else None for path in sets)
    common = describe_inputs(
        Common(
            options.size,
            options.bands,
            options.error,
            options.materials or preset.materials,
            preset.recolor,
            chips,
            lights,
        )
    )
    files = read_user_scenes(preset.files)
    return common, plan_jobs(preset, files, common, options.seed, options.count)


def _list(jobs: Sequence[Job]) -> None:
    """Print a table of the images."""
    rows: list[Sequence[Any]] = [("image", "seed", "illumination", "lights", "view")]
    for job in jobs:
        lights = " + ".join(job.colors)
        rows.append((job.name, job.seed, job.illumination, lights, job.view.name or "its own"))
    widths = [max(len(str(row[i])) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print(
            "  ".join(f"{cell!s:<{wide}}" for cell, wide in zip(row, widths, strict=True)).rstrip()
        )
    common = jobs[0].common
    width, height = common.size
    print(f"{len(jobs)} images of {width}x{height}, bands {common.bands}, error {common.error}")


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _report(folder: Path, outcome: Outcome, options: argparse.Namespace) -> int:
    """Write the report, and print what came out; return the exit code."""
    from photonmap.dataset.report import has_jinja, mean_share, write_report

    written = write_report(folder, list(outcome.entries.values())) if outcome.entries else []
    if not has_jinja():
        warn("the report's page needs jinja2: pip install 'photonmap[dataset]'")
    for reason in dict.fromkeys(outcome.failures.values()):
        names = [name for name, why in outcome.failures.items() if why == reason]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        print(f"photonmap: failed: {', '.join(names[:_NAMED])}{more}: {reason}", file=sys.stderr)
    if not options.quiet:
        kept = len(outcome.entries) - outcome.rendered
        earlier = f", {kept} were there" if kept else ""
        failed = f", {len(outcome.failures)} failed" if outcome.failures else ""
        print(f"{outcome.rendered} images rendered{earlier}{failed}: {folder}")
        if (share := mean_share(outcome.entries.values())) is not None:
            print(f"direct light is {share:.3f} of direct + indirect on average")
        for path in written:
            print(path)
    return _FAILED if outcome.failures else 0


def _verify(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.verify import verify

    faults = verify(folder, options.sample, None if options.quiet else print)
    for fault in faults:
        print(f"photonmap: fault: {fault}", file=sys.stderr)
    return _FAILED if faults else 0
