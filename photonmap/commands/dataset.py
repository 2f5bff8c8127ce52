"""The command `python -m photonmap dataset`: render, resume, and verify data sets."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.commands.dataset_options import USUAL, add_arguments
from photonmap.commands.exit_codes import FAILED, INTERRUPTED
from photonmap.errors import InputError, warn
from photonmap.io.scene_source import use_measured_sets
from photonmap.settings import DATASET, OPTIONS, taken_by

if TYPE_CHECKING:
    from photonmap.dataset.jobs.make_dataset import Extra, Outcome
    from photonmap.dataset.jobs.plan import CommonSettings, Job

__all__ = ["HELP", "add_arguments", "run"]

HELP = "Render a data set of ground truth into FOLDER, or verify or publish the one that is there."

_VERIFY, _FLOW, _PUBLISH, _EXPORT = "verify", "flow", "publish", "export"
_NAMED = 4
"""Largest number of failed images that one line names."""


def run(options: argparse.Namespace) -> int:
    """Render a data set, or verify one; return 1 if images failed, 130 after Ctrl-C, else 0.

    Raises
    ------
    InputError
        if an option is not permitted, or the folder cannot hold the data set
    """
    words = options.words
    if words[0] == _VERIFY and len(words) == 2:
        return _verify(Path(words[1]), options)
    if words[0] == _PUBLISH and len(words) == 2:
        return _publish(Path(words[1]), options)
    if words[0] == _FLOW and len(words) == 2:
        return _write_flow(Path(words[1]), options)
    if words[0] == _EXPORT and len(words) == 3:
        return _write_export(Path(words[1]), Path(words[2]), options)
    if words[0] == _EXPORT and len(words) < 3:
        raise InputError("export needs the folder of a data set and a new one to write to")
    if len(words) > 1:
        raise InputError(f"expected one folder, not {len(words)}: {' '.join(words)}")
    if words[0] in (_VERIFY, _FLOW, _PUBLISH):
        raise InputError(
            f"{words[0]} needs the folder of a data set; a folder of that name is written "
            f"./{words[0]}"
        )
    return _make(Path(words[0]), options)


def _make(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.files.chosen_buffers import check_chosen
    from photonmap.dataset.files.image_files import check_formats
    from photonmap.dataset.files.inputs import describe_left_out
    from photonmap.dataset.files.manifest import CHOICES, check_dataset_folder
    from photonmap.dataset.files.photos import choose_sensor
    from photonmap.dataset.jobs.make_dataset import Extra, describe_dataset, read_identity
    from photonmap.dataset.jobs.schedule import check_scheduler

    _settle(folder, options)
    formats = tuple(dict.fromkeys(options.format))
    check_formats(formats)
    check_scheduler(options.scheduler, options.workers)
    common, jobs, faults = _plan(options, read_identity(folder))
    sensor, described = choose_sensor(options.sensor)
    chosen = check_chosen(options.buffers, formats, sensor is not None)
    head = describe_dataset(options.preset, common, formats, jobs, options.full, described, chosen)
    head["choices"] = {name: getattr(options, name) for name in CHOICES}
    head["left_out"] = describe_left_out(folder, faults)
    check_dataset_folder(folder, head, options.resume or options.dry_run or options.estimate)
    extra = Extra(sensor, options.time_limit, chosen)
    if options.dry_run or options.estimate:
        _preview(jobs, extra, formats, options)
        return _tell(faults)
    return max(_render(folder, head, jobs, extra, options), _tell(faults))


def _settle(folder: Path, options: argparse.Namespace) -> None:
    """Let options that are not given be those of the data set that is resumed, or the usual ones.

    Raises
    ------
    InputError
        if the manifest of that data set is damaged
    """
    from photonmap.dataset.files.manifest import HEAD, read_options

    is_there = options.resume and (folder / HEAD).is_file()
    begun = read_options(folder) if is_there else {}
    for name, usual in USUAL.items():
        if getattr(options, name) is None:
            setattr(options, name, begun.get(name, usual))


def _preview(
    jobs: list[Job], extra: Extra, formats: tuple[str, ...], options: argparse.Namespace
) -> None:
    """Print the images, or what they will cost."""
    from photonmap.dataset.jobs.estimate import estimate, list_costs
    from photonmap.dataset.jobs.listing import list_jobs
    from photonmap.dataset.jobs.notices import hearing
    from photonmap.dataset.jobs.render_image import Task

    if options.dry_run:
        print("\n".join(list_jobs(jobs)))
        return
    task = partial(Task, formats=formats, full=options.full, **vars(extra))
    with hearing((lambda line: None) if options.quiet else _print_progress):
        costs = estimate(task, jobs)
    print("\n".join(list_costs(costs)))


def _render(
    folder: Path,
    head: dict[str, Any],
    jobs: list[Job],
    extra: Extra,
    options: argparse.Namespace,
) -> int:
    """Render what is missing, and report; return the exit code."""
    from photonmap.dataset.jobs.make_dataset import make_dataset

    log = (lambda line: None) if options.quiet else _print_progress
    where = options.scheduler, options.workers
    try:
        outcome = make_dataset(folder, head, jobs, head["formats"], *where, log, extra)
    except KeyboardInterrupt:
        print(
            "photonmap: interrupted; finished images are kept: continue with --resume",
            file=sys.stderr,
        )
        return INTERRUPTED
    return _report(folder, head, outcome, options)


def _tell(faults: dict[str, str]) -> int:
    """Print why scene files cannot be read; return the exit code."""
    from photonmap.dataset.files.inputs import as_line

    for fault in faults.items():
        print(f"photonmap: failed: {as_line(*fault)}", file=sys.stderr)
    return FAILED if faults else 0


def _plan(
    options: argparse.Namespace, identity: str
) -> tuple[CommonSettings, list[Job], dict[str, str]]:
    """Check the options; list the images, and why scene files cannot be read."""
    from photonmap.dataset.files.inputs import as_line
    from photonmap.dataset.jobs.job_scene import describe_inputs, read_user_scenes
    from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
    from photonmap.dataset.jobs.presets import load_preset, with_illuminations
    from photonmap.results.record import describe_measured_sets

    use_measured_sets(options.munsell, options.illuminants)
    preset = with_illuminations(load_preset(options.preset), options.illuminations)
    given = {name: getattr(options, name) for name in taken_by(DATASET)}
    for name, value in given.items():
        OPTIONS[name].checked(value)
    sets: dict[str, Any] = {
        name: str(Path(path).resolve()) if path else None
        for name, path in describe_measured_sets().items()
    }
    looks = {
        name: getattr(preset, name) if getattr(options, name) is None else getattr(options, name)
        for name in ("materials", "lightness", "scale")
    }
    common = describe_inputs(
        CommonSettings(
            **given | {"bands": str(options.bands)},
            **looks,
            recolor=preset.recolor,
            rgb=options.rgb,
            identity=identity,
            **sets,
        ).with_curves(lambda _, path: str(path.resolve()))
    )
    files, faults = read_user_scenes(preset.files)
    if faults and not (files or preset.scenes):
        raise InputError(as_line(*next(iter(faults.items()))))
    jobs = plan_jobs(preset, files, common, options.seed, options.count)
    return common, jobs, faults


def _print_progress(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _report(
    folder: Path, head: dict[str, Any], outcome: Outcome, options: argparse.Namespace
) -> int:
    """Write the report, and print what came out; return the exit code."""
    from photonmap.dataset.files.inputs import lines_of
    from photonmap.dataset.report.page import mean_share, write_report
    from photonmap.report.pages import has_jinja

    entries = list(outcome.entries.values())
    written = write_report(folder, entries, lines_of(head)) if entries else []
    if not has_jinja():
        warn("the report's page needs jinja2: pip install 'photonmap[dataset]'")
    for reason in dict.fromkeys(outcome.failures.values()):
        names = [name for name, why in outcome.failures.items() if why == reason]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        print(f"photonmap: failed: {', '.join(names[:_NAMED])}{more}: {reason}", file=sys.stderr)
    if not options.quiet:
        kept = len(outcome.entries) - outcome.rendered
        earlier = f", {kept} rendered earlier" if kept else ""
        failed = f", {len(outcome.failures)} failed" if outcome.failures else ""
        print(f"{outcome.rendered} images rendered{earlier}{failed}: {folder}")
        hours = sum(entry.get("cpu_seconds", 0.0) for entry in outcome.entries.values()) / 3600.0
        print(f"all images took {hours:.3g} processor hours")
        if (share := mean_share(outcome.entries.values())) is not None:
            print(f"direct light is {share:.3f} of direct + indirect on average")
        for path in written:
            print(path)
    late = sum(not entry["reached"] for entry in outcome.entries.values())
    if late:
        warn(
            f"{late} of {len(outcome.entries)} images did not reach their error in time; they are "
            "marked in the manifest"
        )
    return FAILED if outcome.failures else 0


def _verify(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.jobs.verify import verify

    use_measured_sets(options.munsell, options.illuminants)
    log = None if options.quiet else print
    faults = verify(folder, options.sample, log, scenes=options.scenes)
    for fault in faults:
        print(f"photonmap: fault: {fault}", file=sys.stderr)
    return FAILED if faults else 0


def _write_flow(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.jobs.flows import FOLDER, write_flows

    use_measured_sets(options.munsell, options.illuminants)
    log = (lambda line: None) if options.quiet else _print_progress
    written = write_flows(folder, log, options.scenes)
    if not options.quiet:
        print(f"{len(written)} pairs of views: {folder / FOLDER}")
    return 0


def _write_export(folder: Path, output: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.publication.export import SHARD, export

    if options.license is None:
        raise InputError("export needs a license; add --license CC-BY-4.0, or another")
    most = SHARD if options.shard_size is None else options.shard_size
    log = (lambda line: None) if options.quiet else _print_progress
    export(folder, output, options.layout, options.license, options.arrays, most, log)
    if not options.quiet:
        print(output)
    return 0


def _publish(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.publication.publish import publish

    if options.license is None:
        raise InputError("publish needs a license; add --license CC-BY-4.0, or another")
    written = publish(folder, options.license)
    if not options.quiet:
        for path in written:
            print(path)
    return 0
