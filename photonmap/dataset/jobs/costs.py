"""What images cost: estimated from pilots, and learnt in a run, whose order follows from it."""

from __future__ import annotations

import math
import tempfile
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

from photonmap.dataset.jobs.job_scene import KEPT, make_scene
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import Task, by_image, grouped, render_image
from photonmap.errors import InputError
from photonmap.film.budget import LEAST_PHOTONS, usual_photons
from photonmap.report.tables import aligned
from photonmap.runtime.progress import duration

Kind = tuple[str, int, tuple[int, int]]
"""Scene, number of lights and size: images that share them cost about the same."""


def kind_of(job: Job) -> Kind:
    """Return what decides how long an image takes."""
    return job.stem, len(job.colors), job.common.size


def seconds_of(entry: dict[str, Any]) -> float:
    """Return the wall-clock seconds that an image took, without compilation."""
    seconds = entry["seconds"]
    return float(sum(seconds.values()) - seconds["compile"])


class Agenda(Iterator[Task]):
    """The images that are left: one of each kind first, whose time tells which kinds take longest.

    Then come the scenes whose images take longest, so that no worker waits for a long image at the
    end. All images of a scene follow each other, until so few scenes are left that all stay in
    memory.

    Parameters
    ----------
    tasks : in the order of the list
    entries : of images that were rendered earlier, which tell how long their kinds take
    """

    def __init__(self, tasks: Iterable[Task], entries: Iterable[dict[str, Any]] = ()) -> None:
        self._known: dict[Kind, list[float]] = defaultdict(list)
        for entry in entries:
            self._known[kind_of(Job.from_description(entry["job"]))].append(seconds_of(entry))
        self._first, self._waiting = deque[Task](), dict[str, deque[Task]]()
        seen = {*self._known}
        for task in tasks:
            kinds = set(map(kind_of, task.jobs))
            is_new = not kinds <= seen
            seen |= kinds
            part = self._waiting.setdefault(task.job.geometry, deque())
            (self._first if is_new else part).append(task)
        self._waiting = {scene: part for scene, part in self._waiting.items() if part}
        self._running: dict[str, Task] = {}
        self._current: str | None = None
        self._begun, self._busy, self._cpu = time.monotonic(), 0.0, 0.0

    def __next__(self) -> Task:
        """Return the task that is to begin now."""
        if self._first:
            task = self._first.popleft()
        elif self._waiting:
            if self._current not in self._waiting or len(self._waiting) <= KEPT:
                longest = {at: max(map(self._seconds, of)) for at, of in self._waiting.items()}
                self._current = max(longest, key=longest.__getitem__)
            part = self._waiting[self._current]
            task = max(part, key=self._seconds)
            part.remove(task)
            if not part:
                del self._waiting[self._current]
        else:
            raise StopIteration
        self._running[task.job.name] = task
        return task

    def learn(self, task: Task, result: dict[str, Any] | str) -> None:
        """Take note of what came of a task: the entries of images, or why there are none."""
        del self._running[task.job.name]
        results = by_image(task, result)
        for job in task.jobs:
            entry = results[job.name]
            if isinstance(entry, dict):
                self._known[kind_of(job)].append(seconds_of(entry))
                self._busy += sum(entry["seconds"].values())
                self._cpu += entry["cpu_seconds"]

    @property
    def seconds_left(self) -> float:
        """Seconds that the rest would take if its images were rendered one by one."""
        left = chain(self._first, *self._waiting.values(), self._running.values())
        kinds = Counter(kind_of(job) for task in left for job in task.jobs)
        return sum(count * self._expected(kind) for kind, count in kinds.items())

    def describe(self) -> str:
        """Return what this run has cost so far, and how long the rest will take."""
        cost = f"{self._cpu / 3600.0:.2g} processor hours"
        if not (self._first or self._waiting or self._running):
            return cost
        at_once = self._busy / max(time.monotonic() - self._begun, 1e-9)
        return f"{cost}, about {duration(self.seconds_left / max(at_once, 1e-3))} left"

    def _seconds(self, task: Task) -> float:
        """Return how long an image may take: for ever while the first of its kind has not ended."""
        running = {kind_of(job) for each in self._running.values() for job in each.jobs}
        kinds = [*map(kind_of, task.jobs)]
        is_unknown = any(kind in running and kind not in self._known for kind in kinds)
        return math.inf if is_unknown else sum(map(self._expected, kinds))

    def _expected(self, kind: Kind) -> float:
        """Return the mean seconds of a kind; those of all kinds for one that is not known."""
        found = self._known.get(kind) or [each for known in self._known.values() for each in known]
        return sum(found) / len(found) if found else 0.0


_SMALLER = 4  # by how much a pilot is smaller than its images, in width and height


@dataclass(frozen=True)
class Cost:
    """The cost of images."""

    images: int = 0  # how many
    seconds: float = 0.0  # of wall-clock time, without compilation
    cpu_seconds: float = 0.0  # of all processors
    bytes: float = 0.0  # of their files

    def __add__(self, other: Cost) -> Cost:
        """Return the cost of both."""
        return Cost(*(getattr(self, name) + getattr(other, name) for name in vars(self)))


def estimate(task: Callable[[Job, str], Task], jobs: Sequence[Job]) -> dict[str, Cost]:
    """Return the costs of images by scene.

    One image of each scene, number of lights and size is rendered to the same error, a quarter as
    wide and high but of 16384 pixels at least, and written. Files and writing grow with the pixels,
    rendering half with them and half with the photons of a pass, and building the scene does not:
    it counts once for all images of a scene and seed. `task` returns the task of a job that writes
    into a folder.
    """
    pilots: dict[tuple[Kind, ...], Cost] = {}
    buildings: dict[str, Cost] = {}
    built = set[str]()
    costs: dict[str, Cost] = {}
    failure: InputError | None = None
    for job, rest in grouped(jobs, jobs):
        key = tuple(map(kind_of, (job, *rest.get("others", ()))))
        if key not in pilots:
            try:
                pilots[key], building = _pilot(lambda to: replace(task(job, to), **rest), job)  # noqa: B023
                buildings.setdefault(job.stem, building)
            except InputError as error:  # as in the set, it is left out
                failure, pilots[key] = error, Cost()
        costs[job.stem] = costs.get(job.stem, Cost()) + pilots[key]
        if job.geometry not in built:
            built.add(job.geometry)
            costs[job.stem] += buildings.get(job.stem, Cost())
    if failure and not any(cost.images for cost in costs.values()):
        raise failure
    return costs


def _pilot(task: Callable[[str], Task], job: Job) -> tuple[Cost, Cost]:
    """Return the cost of a task, from smaller images, and what building its scene first adds.

    The task of the job writes into a folder.
    """
    width, height = job.common.size
    area = width * height
    part = math.sqrt(min(max(area / _SMALLER**2, LEAST_PHOTONS), area) / area)
    size = max(round(width * part), 1), max(round(height * part), 1)
    scale = area / (size[0] * size[1])
    with tempfile.TemporaryDirectory(prefix="photonmap-") as folder:
        work = task(folder).at_size(size)
        found = by_image(work, render_image(work))
        entries = {name: entry for name, entry in found.items() if isinstance(entry, dict)}
        for reason in found.values():
            if isinstance(reason, str) and not entries:
                raise InputError(reason)
        files = [Path(folder) / name / file for name in entries for file in entries[name]["files"]]
        size_of_files = sum(path.stat().st_size for path in files)
    seconds = {
        name: sum(entry["seconds"][name] for entry in entries.values())
        for name in ("build", "compile", "render", "write")
    }
    start = time.perf_counter()
    make_scene(work.job)  # again, as for the next light
    again = min(time.perf_counter() - start, seconds["build"])
    limit = (work.time_limit or math.inf) * len(entries)
    photons = usual_photons(area) / usual_photons(size[0] * size[1])
    rendering = min(seconds["render"] * (scale + photons) / 2.0, limit)
    used = sum(entry["cpu_seconds"] for entry in entries.values())
    busy = used / max(sum(seconds.values()), 1e-9)
    total = again + rendering + seconds["write"] * scale
    building = seconds["build"] - again
    cost = Cost(len(entries), total, total * busy, size_of_files * scale)
    return cost, Cost(0, building, building * busy)


def list_costs(costs: dict[str, Cost]) -> Iterator[str]:
    """Yield a table of the costs by scene, and a line of the whole."""
    rows: list[tuple[str, ...]] = [("scene", "images", "s each", "processor s each", "MB each")]
    for scene, cost in costs.items():
        count = max(cost.images, 1)
        each = (cost.seconds / count, cost.cpu_seconds / count, cost.bytes / count / 1e6)
        rows.append((scene, str(cost.images), *(f"{value:.3g}" for value in each)))
    yield from aligned(rows)
    whole = sum(costs.values(), Cost())
    yield (
        f"{whole.images} images: about {duration(whole.seconds)} in one process, "
        f"{whole.cpu_seconds / 3600.0:.3g} processor hours, {whole.bytes / 1e9:.3g} GB"
    )
