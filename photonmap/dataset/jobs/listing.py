"""The images of a data set as lines of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from photonmap.dataset.files.inputs import without_folder
from photonmap.dataset.jobs.plan import Job
from photonmap.report.tables import aligned


def list_jobs(jobs: Sequence[Job]) -> Iterator[str]:
    """Yield a table of the images, a line each, and what they share."""
    rows: list[Sequence[Any]] = [("image", "seed", "illumination", "lights", "view")]
    for job in jobs:
        shares = job.shares and [f" {share:.1%}" for share in job.shares]
        colors = list(map(without_folder, job.colors))
        lights = " + ".join(map(str.__add__, colors, shares or [""] * len(colors)))
        rows.append((job.name, job.seed, job.illumination, lights, job.view.name or "its own"))
    yield from aligned(rows)
    common = jobs[0].common
    sizes = dict.fromkeys("{}x{}".format(*job.common.size) for job in jobs)
    yield f"{len(jobs)} images of {' and '.join(sizes)}, bands {common.bands}, error {common.error}"
