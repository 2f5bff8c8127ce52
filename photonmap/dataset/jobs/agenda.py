"""In which order the images of a data set are rendered, and how long the rest will take."""

from __future__ import annotations

import math
import time
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Any

from photonmap.dataset.jobs.job_scene import KEPT
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import Task
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
            is_new = kind_of(task.job) not in seen
            seen.add(kind_of(task.job))
            part = self._waiting.setdefault(task.job.geometry, deque())
            (self._first if is_new else part).append(task)
        self._waiting = {scene: part for scene, part in self._waiting.items() if part}
        self._running: dict[str, Kind] = {}
        self._current: str | None = None
        self._begun, self._busy, self._cpu = time.monotonic(), 0.0, 0.0

    def __next__(self) -> Task:
        """Return the task that is to begin now."""
        if self._first:
            task = self._first.popleft()
        elif self._waiting:
            if self._current not in self._waiting or len(self._waiting) <= KEPT:
                self._current = max(self._waiting, key=self._longest)
            part = self._waiting[self._current]
            task = max(part, key=self._seconds)
            part.remove(task)
            if not part:
                del self._waiting[self._current]
        else:
            raise StopIteration
        self._running[task.job.name] = kind_of(task.job)
        return task

    def learn(self, task: Task, result: dict[str, Any] | str) -> None:
        """Take note of the entry of an image, or of why there is none."""
        kind = self._running.pop(task.job.name)
        if isinstance(result, dict):
            self._known[kind].append(seconds_of(result))
            self._busy += sum(result["seconds"].values())
            self._cpu += result["cpu_seconds"]

    @property
    def seconds_left(self) -> float:
        """Seconds that the rest would take if its images were rendered one by one."""
        waiting = chain(self._first, *self._waiting.values())
        kinds = Counter(kind_of(task.job) for task in waiting)
        left = sum(count * self._expected(kind) for kind, count in kinds.items())
        return left + sum(map(self._expected, self._running.values()))

    def describe(self) -> str:
        """Return what this run has cost so far, and how long the rest will take."""
        cost = f"{self._cpu / 3600.0:.2g} processor hours"
        if not (self._first or self._waiting or self._running):
            return cost
        at_once = self._busy / max(time.monotonic() - self._begun, 1e-9)
        return f"{cost}, about {duration(self.seconds_left / max(at_once, 1e-3))} left"

    def _longest(self, scene: str) -> float:
        """Return the seconds of the longest image of a scene that is left."""
        return max(map(self._seconds, self._waiting[scene]))

    def _seconds(self, task: Task) -> float:
        """Return how long an image may take: for ever while the first of its kind has not ended."""
        kind = kind_of(task.job)
        is_unknown = kind not in self._known and kind in self._running.values()
        return math.inf if is_unknown else self._expected(kind)

    def _expected(self, kind: Kind) -> float:
        """Return the mean seconds of a kind; those of all kinds for one that is not known."""
        found = self._known.get(kind) or [each for known in self._known.values() for each in known]
        return sum(found) / len(found) if found else 0.0
