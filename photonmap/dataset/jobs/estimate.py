"""What a data set will cost, from small pilots of its scenes."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from photonmap.dataset.jobs.job_scene import make_scene
from photonmap.dataset.jobs.plan import Job
from photonmap.dataset.jobs.render_image import Task, render_image
from photonmap.errors import InputError
from photonmap.film.budget import LEAST_PHOTONS, usual_photons
from photonmap.report.tables import aligned
from photonmap.runtime.progress import duration

_SMALLER = 4
"""By how much a pilot is smaller than its images, in width and height."""
Key = tuple[str, int, tuple[int, int]]


@dataclass(frozen=True)
class Cost:
    """The cost of images.

    Parameters
    ----------
    images : how many
    seconds : of wall-clock time, without compilation
    cpu_seconds : of all processors
    bytes : of their files
    """

    images: int = 0
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    bytes: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        """Return the cost of both."""
        return Cost(
            self.images + other.images,
            self.seconds + other.seconds,
            self.cpu_seconds + other.cpu_seconds,
            self.bytes + other.bytes,
        )


def estimate(task: Callable[[Job, str], Task], jobs: Sequence[Job]) -> dict[str, Cost]:
    """Return the costs of images by scene.

    One image of each scene, number of lights and size is rendered to the same error, a quarter as
    wide and high but of 16384 pixels at least, and written. Files and writing grow with the pixels,
    rendering half with them and half with the photons of a pass, and building the scene does not:
    it counts once for all images of a scene and seed.

    Parameters
    ----------
    task : returns the task of a job that writes into a folder
    jobs : of the data set

    Raises
    ------
    InputError : no scene can be rendered
    """
    pilots: dict[Key, Cost] = {}
    buildings: dict[str, Cost] = {}
    built = set[str]()
    costs: dict[str, Cost] = {}
    failure: InputError | None = None
    for job in jobs:
        key = (job.stem, len(job.colors), job.common.size)
        if key not in pilots:
            try:
                pilots[key], building = _pilot(task, job)
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


def _pilot(task: Callable[[Job, str], Task], job: Job) -> tuple[Cost, Cost]:
    """Return the cost of an image, from a smaller one, and what building its scene first adds."""
    width, height = job.common.size
    size = _reduced(job.common.size)
    scale = width * height / (size[0] * size[1])
    small = replace(job, common=replace(job.common, size=size))
    with tempfile.TemporaryDirectory(prefix="photonmap-") as folder:
        work = task(small, folder)
        entry = render_image(work)
        files = [Path(folder) / small.name / name for name in entry["files"]]
        size_of_files = sum(path.stat().st_size for path in files)
    start = time.perf_counter()
    make_scene(small)  # again, as for the next light
    again = min(time.perf_counter() - start, entry["seconds"]["build"])
    seconds = entry["seconds"]
    limit = work.time_limit or math.inf
    photons = usual_photons(width * height) / usual_photons(size[0] * size[1])
    rendering = min(seconds["render"] * (scale + photons) / 2.0, limit)
    busy = entry["cpu_seconds"] / max(sum(seconds.values()), 1e-9)
    total = again + rendering + seconds["write"] * scale
    building = seconds["build"] - again
    return Cost(1, total, total * busy, size_of_files * scale), Cost(0, building, building * busy)


def _reduced(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size of a pilot."""
    area = size[0] * size[1]
    pixels = min(max(area / _SMALLER**2, LEAST_PHOTONS), area)
    width, height = (round(length * math.sqrt(pixels / area)) for length in size)
    return max(width, 1), max(height, 1)


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
