"""Cost of many images on many processors, extrapolated from the images of a data set."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.datasets.dataset import FOLDER, small_tasks
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table, skipped
from benchmarks.harness.timing import timed
from photonmap import dataset
from photonmap.dataset.jobs import schedule
from photonmap.dataset.jobs.render_image import Task
from photonmap.dataset.report.page import Entry

IMAGES, CORES = 100_000, (1, 100, 10_000)
COMPILING = 24.0
"""CPU seconds of a worker that has to compile all kernels: see docs/scale.md."""
EMPTY = 3000
"""Number of empty jobs with which the scheduler is timed."""


def run(options: Options) -> list[Table]:
    """Read the data set given, or the one that the benchmark `dataset` left behind."""
    folder = options.dataset or FOLDER
    title = f"scale: {IMAGES:,} images".replace(",", " ")
    if not folder.exists():
        return [skipped(title, "needs a data set: run the benchmark dataset, or give --dataset")]
    entries = dataset.open(folder).entries
    rate = _jobs_a_second() if find_spec("distributed") else None
    return [_cost(entries), _sizes(folder, entries), _extrapolated(title, folder, entries, rate)]


def _cost(entries: Sequence[Entry]) -> Table:
    """Return the cost of an image."""
    spent = [entry["cpu_seconds"] for entry in entries]
    width, height = entries[0]["size"]
    table = Table(f"scale: CPU seconds per image, {width}×{height}", ["", "seconds"])
    table.rows = [["mean", statistics.mean(spent)], ["longest", max(spent)]]
    return table


def _sizes(folder: Path, entries: Sequence[Entry]) -> Table:
    """Return the size of each format."""
    table = Table("scale: MB per image", ["format", "MB"])
    for suffix, size in _bytes_by_suffix(folder, entries).items():
        table.rows.append([suffix, size / 1e6])
    return table


def _bytes_by_suffix(folder: Path, entries: Sequence[Entry]) -> dict[str, float]:
    """Return the mean bytes of an image's files, by suffix."""
    total: dict[str, float] = {}
    for entry in entries:
        for name in entry["files"]:
            file = folder / entry["name"] / name
            total[file.suffix] = total.get(file.suffix, 0.0) + file.stat().st_size / len(entries)
    return total


def _extrapolated(title: str, folder: Path, entries: Sequence[Entry], rate: float | None) -> Table:
    """Return hours, and the load on everything else.

    Workers compile simultaneously; the cores or the scheduler limit the rate of images; and in the
    end everything waits for the longest image.
    """
    mean = statistics.mean(entry["cpu_seconds"] for entry in entries)
    longest = max(entry["cpu_seconds"] for entry in entries)
    size = sum(_bytes_by_suffix(folder, entries).values())
    shares = ["compiling, %", "longest image, %", "scheduler busy, %"]
    rates = ["images per second", "MB/s written", "TB in total"]
    table = Table(title, ["cores", "hours", *shares, *rates])
    for cores in CORES:
        handing_out = IMAGES / rate if rate else 0.0
        rendering = max(IMAGES * mean / cores, handing_out)
        tail = longest if cores > 1 else 0.0
        seconds = COMPILING + rendering + tail
        parts = [100.0 * COMPILING / seconds, 100.0 * tail / seconds]
        busy = 100.0 * handing_out / rendering if rate else None
        pace = IMAGES / seconds
        row = [seconds / 3600.0, *parts, busy, pace, pace * size / 1e6, IMAGES * size / 1e12]
        table.rows.append([cores, *row])
    if rate:
        table.notes = [f"the scheduler handed out {rate:.0f} empty jobs per second here"]
    return table


def _jobs_a_second() -> float:
    """Return the empty jobs per second of a scheduler and one worker on this machine."""
    tasks = small_tasks("nowhere")[:1] * EMPTY
    with (
        schedule.start_local_cluster(1) as cluster,
        mock.patch.object(schedule, "render_image", _nothing),
    ):
        seconds = timed(lambda: list(schedule.run_tasks(tasks, cluster.scheduler_address)))
    return EMPTY / seconds


def _nothing(task: Task) -> dict[str, Any]:
    return {}
