"""The command `python -m photonmap dataset`: render, resume, and verify data sets."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from photonmap.commands import FAILED, INTERRUPTED, shared
from photonmap.dataset.files.lean import ALWAYS
from photonmap.errors import InputError, warn
from photonmap.film.budget import DEFAULT_ERROR
from photonmap.io.scene_source import use_measured_sets
from photonmap.runtime.options import read_list, read_memory
from photonmap.settings import DATASET, OPTIONS, taken_by
from photonmap.spectra.projection import REC2020, SPACES

if TYPE_CHECKING:
    from photonmap.dataset.jobs.make_dataset import Extra, Outcome
    from photonmap.dataset.jobs.plan import CommonSettings, Job

HELP = "Render a data set of ground truth into FOLDER, or verify, publish or export a finished one."

_USUAL: dict[str, Any] = {
    **{name: OPTIONS[name].default for name in taken_by(DATASET)},
    "size": (640, 480),
    "error": f"{DEFAULT_ERROR}",
    "preset": "small",
    "count": 1,
    "seed": 0,
    "illuminations": [],
    "materials": None,
    "lightness": None,
    "scale": None,
    "format": ["exr", "png"],
    "full": False,
    "buffers": None,
    "rgb": REC2020,
    "own_noise": False,
}
"""Values of options that neither the command nor a resumed data set gives; None means not given."""


_SCENES: list[shared.Row] = [
    ("preset", "NAME", "small, icip2013, varied, or FILE.toml", {"default_text": "small"}),
    ("count", "N", "number of seeds for which each scene is built",
     {"read": int, "default_text": "1"}),
    ("seed", "N", "first of the seeds", {"read": int, "default_text": "0"}),
    ("materials", None, "materials of procedural scenes",
     {"choices": ("lambertian", "mixed", "textured", "glossy", "rich", "fluorescent"),
      "default_text": "the preset's, or lambertian"}),
    ("lightness", "R", "mean reflectance of procedural scenes",
     {"read": float, "default_text": "the preset's, or as chips are drawn"}),
    ("scale", "F", "scale of rooms, 0.8 to 3",
     {"read": float, "default_text": "the preset's, or 1"}),
    ("illuminations", "LIST", "names separated by commas, such as white,random_3",
     {"read": read_list,
      "default_text": "the preset's, or white,colored,two_planckian,two_mixed"}),
    *shared.MEASURED_SETS,
    ("own_noise", None,
     "render each image by itself, with noise of its own; otherwise, images of a view that differ "
     "in the spectra of lights alone are rendered together, and share their noise",
     {"default": False}),
]  # fmt: skip
"""Which scenes are rendered, how they look, and what lights them."""
_FILES: list[shared.Row] = [
    ("format", "LIST", "file formats, of exr, hdf5 and png, separated by commas",
     {"read": read_list, "default_text": "exr,png"}),
    ("full", None,
     "write all arrays in single precision, also those that follow from others; the files are 3 to "
     "7 times as large", {"default": False}),
    ("buffers", "LIST",
     "names of the buffers that files hold, with their errors and those of light groups, "
     f"separated by commas; {', '.join(ALWAYS)} are always among them",
     {"read": read_list, "default_text": "all"}),
    ("rgb", "SPACE",
     f"space of the images in RGB: {', '.join(SPACES)}, a camera, or FILE.csv of three "
     "sensitivities", {"default_text": REC2020}),
    ("sensor", "NAME",
     "also write a photo of each image by this camera: its name, or a FILE.toml as "
     "`photonmap sensor` takes it", {}),
]  # fmt: skip
"""What is written of each image."""
_WORK: list[shared.Row] = [
    ("time_limit", "S",
     "seconds after which an image ends even if its error is not reached, and is marked so",
     {"read": shared.number(0.001, 1e9, " s"), "default_text": "1 hour"}),
    *shared.scheduler_rows(may_be_auto=True),
    ("resume", None,
     "render only images that are missing or damaged, with the options of the set",
     {"default": False}),
    ("dry_run", None, "list the images without rendering them", {"default": False}),
    ("estimate", None,
     "estimate what the images will cost, by scene, from small pilot renders, and stop",
     {"default": False}),
]  # fmt: skip
"""How and where images are rendered."""
_FINISHED: dict[str, list[shared.Row]] = {
    "verify": [
        ("sample", "N", "number of images to render again and compare",
         {"read": int, "default": 1}),
        ("scenes", "DIR",
         "folder of the scene files, if they moved after the set was made; also for flow", {}),
    ],
    "publish": [
        ("license", "NAME",
         "one of CC0-1.0, CC-BY-4.0, CC-BY-SA-4.0, CC-BY-NC-4.0, or a file with another license",
         {}),
    ],
    "export": [
        ("layout", None, "tar files with an index, or Parquet tables",
         {"choices": ("webdataset", "huggingface"), "default": "webdataset"}),
        ("shard_size", "SIZE", "largest size of a file, as in 512M or 1G",
         {"read": read_memory, "default_text": "512M"}),
        ("arrays", "LIST",
         "names of arrays, as in rgb.radiance,rgb.shading,shading,depth; rgb.NAME is in the set's "
         "RGB",
         {"read": read_list, "default_text":
          "light, reflectance and shading in RGB, depth, normals, ids, masks"}),
    ],
}  # fmt: skip
"""Options of what is done to a finished data set."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.usage = (
        f"{parser.prog} FOLDER [options]\n"
        f"       {parser.prog} verify FOLDER [--sample N] [--scenes DIR]\n"
        f"       {parser.prog} flow FOLDER\n       {parser.prog} publish FOLDER --license NAME\n"
        f"       {parser.prog} export FOLDER NEW --layout LAYOUT --license NAME"
    )
    text = "folder of the data set; created where it is missing"
    parser.add_argument("words", nargs="+", metavar="FOLDER", help=text)
    shared.add_group(parser, "scenes", _SCENES)
    usual = {"size": "640x480"} | {name: str(_USUAL[name]) for name in ("bands", "pixel", "error")}
    changes = {name: {"default": None, "default_text": text} for name, text in usual.items()}
    shared.add_options(parser, DATASET, **changes)
    for title, rows in {"files": _FILES, "work": _WORK, **_FINISHED}.items():
        shared.add_group(parser, title, rows)
    parser.set_defaults(full=None, own_noise=None)
    shared.add_quiet(parser)


def run(options: argparse.Namespace) -> int:
    """Render a data set, or do to one what the first word says; return an exit code."""
    word, *rest = options.words
    action, count = _ACTIONS.get(word, (_make, 0))
    if word in _ACTIONS and len(rest) == count:
        return action(*map(Path, rest), options)
    if word == "export" and len(rest) < count:
        raise InputError("export needs the folder of a data set and a new one to write to")
    if rest:
        raise InputError(f"expected one folder, not {1 + len(rest)}: {' '.join(options.words)}")
    if word in _ACTIONS:
        raise InputError(
            f"{word} needs the folder of a data set; a folder of that name is written ./{word}"
        )
    return _make(Path(word), options)


def _make(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.files.image_files import check_formats, choose_sensor
    from photonmap.dataset.files.lean import check_chosen
    from photonmap.dataset.files.manifest import CHOICES, check_dataset_folder, describe_left_out
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
    """Give options that were left out the values of a resumed data set, or the usual ones."""
    from photonmap.dataset.files.manifest import HEAD, read_options

    is_there = options.resume and (folder / HEAD).is_file()
    begun = read_options(folder) if is_there else {}
    for name, usual in _USUAL.items():
        if getattr(options, name) is None:
            setattr(options, name, begun.get(name, usual))


def _preview(
    jobs: list[Job], extra: Extra, formats: tuple[str, ...], options: argparse.Namespace
) -> None:
    """Print the images, or what they will cost."""
    from photonmap.dataset.jobs.costs import estimate, list_costs
    from photonmap.dataset.jobs.plan import list_jobs
    from photonmap.dataset.jobs.render_image import Task, hearing

    if options.dry_run:
        print("\n".join(list_jobs(jobs)))
        return
    task = partial(Task, formats=formats, full=options.full, **vars(extra))
    with hearing(shared.progress_log(options)):
        costs = estimate(task, jobs)
    print("\n".join(list_costs(costs)))


def _render(
    folder: Path, head: dict[str, Any], jobs: list[Job], extra: Extra, options: argparse.Namespace
) -> int:
    """Render what is missing, and report; return the exit code."""
    from photonmap.dataset.jobs.make_dataset import make_dataset

    where = options.scheduler, options.workers, shared.progress_log(options)
    try:
        outcome = make_dataset(folder, head, jobs, head["formats"], *where, extra)
    except KeyboardInterrupt:
        text = "interrupted; finished images are kept: continue with --resume"
        print(f"photonmap: {text}", file=sys.stderr)
        return INTERRUPTED
    return _report(folder, head, outcome, options)


def _tell(faults: dict[str, str]) -> int:
    """Print why scene files cannot be read; return the exit code."""
    from photonmap.dataset.files.manifest import as_line

    for fault in faults.items():
        print(f"photonmap: failed: {as_line(*fault)}", file=sys.stderr)
    return FAILED if faults else 0


def _plan(
    options: argparse.Namespace, identity: str
) -> tuple[CommonSettings, list[Job], dict[str, str]]:
    """Check the options; list the images, and why scene files cannot be read."""
    from photonmap.dataset.files.manifest import as_line
    from photonmap.dataset.jobs.job_scene import describe_inputs, read_user_scenes
    from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
    from photonmap.dataset.jobs.presets import load_preset, with_illuminations
    from photonmap.results.record import describe_measured_sets
    from photonmap.spectra.bands import Bands

    use_measured_sets(options.munsell, options.illuminants)
    preset = with_illuminations(load_preset(options.preset), options.illuminations)
    given = {name: getattr(options, name) for name in taken_by(DATASET)}
    for name, value in given.items():
        OPTIONS[name].checked(value)
    sets = describe_measured_sets().items()
    looks = {
        name: getattr(preset, name) if getattr(options, name) is None else getattr(options, name)
        for name in ("materials", "lightness", "scale")
    }
    given |= looks | {"bands": str(options.bands), "rgb": options.rgb, "identity": identity}
    given["own_noise"] = options.own_noise
    given |= {name: str(Path(path).resolve()) if path else None for name, path in sets}
    chosen = CommonSettings(**given, recolor=preset.recolor)
    common = describe_inputs(chosen.with_curves(lambda _, path: str(path.resolve())))
    own = None if preset.recolor else Bands.parse(common.bands)
    files, faults = read_user_scenes(preset.files, own)
    if faults and not (files or preset.scenes):
        raise InputError(as_line(*next(iter(faults.items()))))
    jobs = plan_jobs(preset, files, common, options.seed, options.count)
    return common, jobs, faults


def _report(
    folder: Path, head: dict[str, Any], outcome: Outcome, options: argparse.Namespace
) -> int:
    """Write the report, and print what came out; return the exit code."""
    from photonmap.dataset.files.manifest import lines_of
    from photonmap.dataset.report.page import mean_share, write_report
    from photonmap.report.pages import has_jinja

    entries = list(outcome.entries.values())
    written = write_report(folder, entries, lines_of(head)) if entries else []
    if not has_jinja():
        warn("the report's page needs jinja2: pip install 'photonmap[dataset]'")
    shared.print_failures(outcome.failures)
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
    if late := sum(not entry["reached"] for entry in outcome.entries.values()):
        which = f"{late} of {len(outcome.entries)} images"
        warn(f"{which} did not reach their error in time; they are marked in the manifest")
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
    written = write_flows(folder, shared.progress_log(options), options.scenes)
    shared.say(options, f"{len(written)} pairs of views: {folder / FOLDER}")
    return 0


def _write_export(folder: Path, output: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.publication.export import SHARD, export

    _check_license("export", options)
    most = SHARD if options.shard_size is None else options.shard_size
    log = shared.progress_log(options)
    export(folder, output, options.layout, options.license, options.arrays, most, log)
    shared.say(options, output)
    return 0


def _publish(folder: Path, options: argparse.Namespace) -> int:
    from photonmap.dataset.publication.publish import publish

    _check_license("publish", options)
    shared.say(options, *publish(folder, options.license))
    return 0


def _check_license(word: str, options: argparse.Namespace) -> None:
    if options.license is None:
        raise InputError(f"{word} needs a license; add --license CC-BY-4.0, or another")


_ACTIONS: dict[str, tuple[Callable[..., int], int]] = {
    "verify": (_verify, 1),
    "flow": (_write_flow, 1),
    "publish": (_publish, 1),
    "export": (_write_export, 2),
}
"""What is done to a finished data set, by the first word, and how many folders follow it."""
