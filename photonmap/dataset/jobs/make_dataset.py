"""Make a data set: find what is missing, render it, and keep the manifest."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from photonmap.capture.sensor import Sensor
from photonmap.dataset.files import manifest
from photonmap.dataset.files.splits import part_of
from photonmap.dataset.jobs.costs import Agenda
from photonmap.dataset.jobs.job_scene import copy_inputs
from photonmap.dataset.jobs.plan import CONTENT, TEXT, CommonSettings, Job
from photonmap.dataset.jobs.render_image import ENTRY, Task, by_image, grouped, hearing, read_entry
from photonmap.dataset.jobs.schedule import LOCAL, run_fastest, run_tasks
from photonmap.errors import warn
from photonmap.runtime.wording import enumerated
from photonmap.runtime.workers import AUTO
from photonmap.runtime.writing import FULL

Entries = dict[str, dict[str, Any]]
_NOT_BEGUN = "not rendered, as the disk is full; free some space, and continue with --resume"


@dataclass(frozen=True)
class Extra:
    """What is asked of each image beside its arrays."""

    sensor: Sensor | None = None  # that takes photos, which the head describes; None for no photos
    # seconds of rendering after which an image stops short of its error; None for the usual
    time_limit: float | None = None
    buffers: tuple[str, ...] | None = None  # names of those that files hold; None for all


@dataclass
class Outcome:
    """The images of a data set after a run."""

    entries: Entries  # of all images that exist, by name
    failures: dict[str, str] = field(default_factory=dict)  # reason of each failure, by name
    rendered: int = 0  # number of images that this run rendered


def describe_dataset(
    preset: str,
    common: CommonSettings,
    formats: Sequence[str],
    jobs: Sequence[Job],
    full: bool = False,
    sensor: dict[str, Any] | None = None,
    buffers: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Return the head of a data set: settings, versions, and the names of its images and files."""
    from photonmap.results.record import describe_code

    sizes = {part_of(job.geometry): list(job.common.size) for job in jobs}
    apart = {part: size for part, size in sizes.items() if size != list(common.size)}
    return {
        "format": manifest.FORMAT,
        "preset": Path(preset).name,
        "common": describe_common(common),
        "formats": sorted(formats),
        "full": full,
        "sensor": sensor,
        "buffers": buffers and list(buffers),
        "versions": describe_code(),
        "images": [job.name for job in jobs],
        **({"split_sizes": apart} if apart else {}),
    }


def describe_common(common: CommonSettings) -> dict[str, Any]:
    """Return what a head says of the settings of all images: of files, their names alone."""
    settings = asdict(common.with_curves(lambda _, path: path.name))
    for name in ("munsell", "illuminants"):
        settings[name] = Path(settings[name]).name if settings[name] else None
    if not common.is_by_content:
        del settings["identity"]
    return json.loads(json.dumps(settings))


def read_identity(folder: Path) -> str:
    """Return what identifies files of bands and RGB in the data set of a folder, old or new."""
    if not (folder / manifest.HEAD).is_file():
        return CONTENT
    return manifest.read_head(folder)["common"].get("identity", TEXT)


def make_dataset(
    folder: Path,
    head: dict[str, Any],
    jobs: Sequence[Job],
    formats: Sequence[str],
    scheduler: str = LOCAL,
    workers: int | str = 1,
    log: Callable[[str], None] = lambda line: None,
    extra: Extra | None = None,
) -> Outcome:
    """Render the images that a folder does not have yet, and write its manifest.

    Images of an earlier run are kept if their files are unchanged, also those that are not among
    the jobs: of these, a warning says how many there are. After Ctrl-C the manifest lists
    the images that are finished.

    Parameters
    ----------
    folder : checked by `photonmap.dataset.files.manifest.check_dataset_folder`
    head : of the data set, as `describe_dataset` returns it
    jobs : its images; the folder may hold more, of the same data set with other seeds
    formats : of the files
    scheduler, workers : where to render, see `photonmap.dataset.jobs.schedule`; with `AUTO`, in
        as many processes of this machine as are fastest
    log : called with a line for each image, and once where kernels are compiled
    extra : what is asked of each image beside its arrays
    """
    extra = Extra() if extra is None else extra
    folder.mkdir(parents=True, exist_ok=True)
    with manifest.locked(folder):
        manifest.remove_leftovers(folder)
        if jobs:
            copy_inputs(folder, jobs, extra.sensor)
        outcome = Outcome(_find_entries(folder, jobs, log))
        _warn_of_others(folder, jobs, outcome.entries)
        manifest.write_head(folder, head, outcome.entries)
        manifest.write_lines(folder, outcome.entries.values())
        target, how = str(folder.resolve()), {"full": head["full"], **vars(extra)}
        left = [job for job in jobs if job.name not in outcome.entries]
        tasks = [
            Task(job, target, tuple(formats), head["versions"], **how, **rest)
            for job, rest in grouped(left, jobs)
        ]
        try:
            with hearing(log):
                _run(tasks, scheduler, workers, outcome, log)
        finally:
            if scheduler == LOCAL:
                manifest.remove_leftovers(folder)  # of workers that were killed
            asked = [job.name for job in jobs if job.name in outcome.entries]
            order = dict.fromkeys([*asked, *outcome.entries])  # the jobs come first
            outcome.entries = {name: outcome.entries[name] for name in order}
            manifest.write_lines(folder, outcome.entries.values())
    return outcome


def _run(
    tasks: Sequence[Task],
    scheduler: str,
    workers: int | str,
    outcome: Outcome,
    log: Callable[[str], None],
) -> None:
    """Render images until all are done, or the disk is full; say what they cost, and the rest."""
    agenda, count = Agenda(tasks, outcome.entries.values()), sum(len(task.jobs) for task in tasks)
    if workers == AUTO and scheduler == LOCAL:
        running = run_fastest(agenda, log)
    else:
        running = run_tasks(agenda, scheduler, 1 if workers == AUTO else int(workers))
    with closing(running) as results:
        for task, result in results:
            agenda.learn(task, result)
            for name, found in by_image(task, result).items():
                line = _take(outcome, Path(task.folder), name, found)
                done = outcome.rendered + len(outcome.failures)
                log(f"{done}/{count} {line}; {agenda.describe()}")
            if any(sign in reason for reason in outcome.failures.values() for sign in FULL):
                break
    for job in (job for task in tasks for job in task.jobs):
        if job.name not in outcome.entries and job.name not in outcome.failures:
            outcome.failures[job.name] = _NOT_BEGUN


def _take(outcome: Outcome, folder: Path, name: str, found: dict[str, Any] | str) -> str:
    """Take in what came of an image; return a line that says so."""
    if isinstance(found, str):
        outcome.failures[name] = found
        return f"{name} failed: {found}"
    outcome.entries[name] = found
    outcome.rendered += 1
    manifest.append_line(folder, found)
    error = "unknown" if found["error"] is None else f"{found['error']:.4f}"
    return f"{name}: error {error}, {sum(found['seconds'].values()):.1f} s"


def _find_entries(folder: Path, jobs: Sequence[Job], log: Callable[[str], None]) -> Entries:
    """Return the entries of complete images in a folder, those of the jobs first."""
    names = [job.name for job in jobs]
    others = sorted(path.name for path in folder.iterdir() if path.is_dir())
    found: Entries = {}
    for name in dict.fromkeys([*names, *others]):
        entry = read_entry(folder / name)
        if entry is not None:
            found[name] = entry
        elif (folder / name / ENTRY).is_file() or (name in names and (folder / name).is_dir()):
            log(f"{name} is damaged, and " + ("rendered again" if name in names else "left out"))
    return found


def _warn_of_others(folder: Path, jobs: Sequence[Job], entries: Entries) -> None:
    """Warn of images of earlier runs that are not among the jobs, and say what becomes of them."""
    if not (folder / manifest.HEAD).is_file():
        return
    asked = {job.name for job in jobs}
    others = dict.fromkeys([*manifest.read_head(folder)["images"], *entries])
    kept = [name for name in others if name not in asked and name in entries]
    dropped = [name for name in others if name not in asked and name not in entries]
    texts = {
        "images of earlier runs that are not asked for stay in the set": kept,
        "those that are not asked for and never were finished leave its list": dropped,
    }
    said = [f"{t} ({len(names)}: {enumerated(names, 1)})" for t, names in texts.items() if names]
    if said:
        warn(f"{folder}: {'; '.join(said)}")
