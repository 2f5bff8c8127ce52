"""Make a data set: find what is missing, render it, keep the manifest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from photonmap.dataset.jobs import Job
from photonmap.dataset.manifest import append_line, remove_leftovers, write_head, write_lines
from photonmap.dataset.produce import Task, read_entry
from photonmap.dataset.schedule import LOCAL, run_tasks

Entries = dict[str, dict[str, Any]]


@dataclass
class Outcome:
    """What became of a data set's images.

    Parameters
    ----------
    entries : of all images that are there, by name
    failures : why the others are not, by name
    rendered : how many are new
    """

    entries: Entries
    failures: dict[str, str] = field(default_factory=dict)
    rendered: int = 0


def make_dataset(
    folder: Path,
    head: dict[str, Any],
    jobs: Sequence[Job],
    formats: Sequence[str],
    scheduler: str = LOCAL,
    workers: int = 1,
    tell: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Render the images that a folder does not have yet, and write its manifest.

    What an earlier run left is kept where its files are those written. After Ctrl-C the manifest
    has what is done.

    Parameters
    ----------
    folder : as `photonmap.dataset.manifest.check_folder` passed it
    head : of the data set
    jobs : its images; a folder may hold more, of the same set with other seeds
    tell : is told of each image

    Raises
    ------
    InputError : the scheduler cannot be reached
    KeyboardInterrupt : at Ctrl-C
    """
    folder.mkdir(exist_ok=True)
    remove_leftovers(folder)
    write_head(folder, head)
    outcome = Outcome(_find_entries(folder, jobs, tell))
    write_lines(folder, outcome.entries.values())
    missing = [job for job in jobs if job.name not in outcome.entries]
    place, versions = str(folder.resolve()), head["versions"]
    tasks = [Task(job, place, tuple(formats), versions) for job in missing]
    try:
        for task, result in run_tasks(tasks, scheduler, workers):
            _take(outcome, task.job.name, result, folder)
            done = outcome.rendered + len(outcome.failures)
            tell(f"{done}/{len(tasks)} {_line(task.job.name, result)}")
    finally:
        outcome.entries = _in_order(outcome.entries, jobs)
        write_lines(folder, outcome.entries.values())
    return outcome


def _in_order(entries: Entries, jobs: Sequence[Job]) -> Entries:
    """Return entries in the order of the jobs, then the others."""
    places = {job.name: place for place, job in enumerate(jobs)}
    order = sorted(entries, key=lambda name: places.get(name, len(places)))
    return {name: entries[name] for name in order}


def _find_entries(folder: Path, jobs: Sequence[Job], tell: Callable[[str], None]) -> Entries:
    """Return the entries of complete images: of these jobs, and others of the folder."""
    names = [job.name for job in jobs]
    others = sorted(path.name for path in folder.iterdir() if path.is_dir())
    found: Entries = {}
    for name in dict.fromkeys([*names, *others]):
        entry = read_entry(folder / name)
        if entry is not None:
            found[name] = entry
        elif (folder / name).is_dir():
            tell(f"{name} is damaged, and " + ("rendered again" if name in names else "left out"))
    return found


def _take(outcome: Outcome, name: str, result: dict[str, Any] | str, folder: Path) -> None:
    """Keep an image's entry, or why it failed."""
    if isinstance(result, str):
        outcome.failures[name] = result
        return
    outcome.entries[name] = result
    outcome.rendered += 1
    append_line(folder, result)


def _line(name: str, result: dict[str, Any] | str) -> str:
    if isinstance(result, str):
        return f"{name} failed: {result}"
    seconds = sum(result["seconds"].values())
    error = "unknown" if result["error"] is None else f"{result['error']:.4f}"
    return f"{name}: error {error}, {seconds:.1f} s"
