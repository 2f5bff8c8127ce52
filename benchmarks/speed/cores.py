"""What more cores would bring: the serial share of a pass, and how finely the rest is divided.

Passes run on one thread, and every task of every parallel call is timed, in processor time, which
other programs do not lengthen. What is left of a pass is serial. On n cores a call takes as long as
its tasks, handed out in their order to whichever core is free, and calls wait for each other:
Amdahl's law, but with the tails of calls that have few tasks. Memory bandwidth is left out.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import photonmap as pm
from benchmarks.harness.table import Cell, Table
from photonmap.compile.scene_arrays import compile_scene
from photonmap.dataset.scenes.build import build_scene
from photonmap.film.budget import usual_photons
from photonmap.film.moments import Accumulator
from photonmap.integrators.base import PassSetup
from photonmap.integrators.photon_mapping.integrator import PhotonIntegrator
from photonmap.kernels.core.passes import Film
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

CORES = (2, 16, 64)
PASSES = 4
STAGES = ("photons", "camera pass", "sharing", "statistics")
SCENES: dict[str, tuple[Callable[[], pm.Scene], tuple[int, int], str]] = {
    "Cornell box, 256×256, RGB": (pm.scenes.cornell_box, (256, 256), "rgb"),
    "with mirror and glass": (pm.scenes.cornell_balls, (256, 256), "rgb"),
    "living_room, 320×240, 6 bands": (lambda: build_scene("living_room"), (320, 240), "6"),
}


class TimedWorkers(Workers):
    """Threads that keep the seconds of every task, call by call."""

    def __init__(self, threads: int) -> None:
        super().__init__(threads)
        self.calls: list[list[float]] = []

    def map(self, task: Callable[[int], Any], count: int, whole: bool = False) -> list[Any]:
        """Return what `Workers.map` does."""
        seconds = [0.0] * count

        def timed(index: int) -> Any:
            start = time.thread_time()
            result = task(index)
            seconds[index] = time.thread_time() - start
            return result

        self.calls.append(seconds)
        return super().map(timed, count, whole)


@dataclass
class Stage:
    """One stage of a pass on one thread."""

    seconds: float
    calls: list[list[float]] = field(default_factory=list)
    """seconds of the tasks of each parallel call"""

    @property
    def serial(self) -> float:
        """Seconds outside all tasks."""
        return max(self.seconds - sum(map(sum, self.calls)), 0.0)

    def on(self, cores: int) -> float:
        """Return the seconds on so many cores."""
        return self.serial + sum(makespan(tasks, cores) for tasks in self.calls)


def makespan(tasks: list[float], cores: int) -> float:
    """Return when the last task ends if each in turn goes to the core that is free first."""
    free = [0.0] * cores
    for seconds in tasks:
        heapq.heappush(free, heapq.heappop(free) + seconds)
    return max(free)


def cores_tables() -> list[Table]:
    """Return the tables: serial shares and speed-ups of stages, one for each scene."""
    return [_table(name, *scene) for name, scene in SCENES.items()]


def _table(name: str, make: Callable[[], pm.Scene], size: tuple[int, int], bands: str) -> Table:
    stages = _measure(make(), size, bands)
    table = Table(
        f"scaling with cores: a pass, {name}",
        ["stage", "ms, 1 thread", "serial ms", "tasks", *(f"× on {cores}" for cores in CORES)],
    )
    for label, parts in stages.items():
        table.rows.append([label, *_row(parts)])
    every = [part for parts in stages.values() for part in parts]
    whole = sum(part.seconds for part in every)
    table.rows.append(["pass", *_row(every)])
    serial = sum(part.serial for part in every) / whole
    table.notes = [
        f"serial share {serial:.1%}: by Amdahl's law "
        + ", ".join(f"{1.0 / (serial + (1.0 - serial) / n):.1f} on {n}" for n in CORES)
        + " cores; the columns count whole tasks, too",
    ]
    return table


def _measure(scene: pm.Scene, size: tuple[int, int], bands: str) -> dict[str, list[Stage]]:
    """Run passes after the first one, which sets up; return the stages of each."""
    columns, film = Bands.parse(bands), Film(*size, True)
    pixels = film.width * film.height
    with TimedWorkers(1) as workers:
        compiled = compile_scene(scene, columns, film.width / film.height)
        setup = PassSetup(compiled, film, columns.count, usual_photons(pixels), 0, workers)
        integrator = PhotonIntegrator(setup)
        moments = Accumulator(pixels, columns.count, workers, compiled.has_residual)
        stages: dict[str, list[Stage]] = {label: [] for label in STAGES}
        for index in range(PASSES + 1):
            for label, stage in zip(
                STAGES, _pass(integrator, moments, workers, index), strict=True
            ):
                if index > 0:
                    stages[label].append(stage)
    return stages


def _pass(
    integrator: PhotonIntegrator, moments: Accumulator, workers: TimedWorkers, index: int
) -> Iterator[Stage]:
    """Run the stages of a pass; give what each took."""

    def timed(call: Callable[[], Any]) -> tuple[Any, Stage]:
        workers.calls = []
        start = time.process_time()
        result = call()
        return result, Stage(time.process_time() - start, workers.calls)

    def add() -> None:
        moments.add(estimate.pixels, estimate.via_specular)
        moments.error()

    maps, photons = timed(lambda: integrator.trace_photons(index))
    yield photons
    estimate, camera = timed(lambda: integrator.run_camera_pass(index, maps))
    yield camera
    estimate, sharing = timed(lambda: integrator.share(index, estimate))
    yield sharing
    yield timed(add)[1]


def _row(parts: list[Stage]) -> list[Cell]:
    """Return means over passes: ms, serial ms; tasks of the longest call; and speed-ups."""
    seconds = sum(part.seconds for part in parts)
    tasks = max((len(call) for part in parts for call in part.calls), default=0)
    return [
        1e3 * seconds / PASSES,
        1e3 * sum(part.serial for part in parts) / PASSES,
        tasks,
        *(seconds / sum(part.on(cores) for part in parts) for cores in CORES),
    ]
