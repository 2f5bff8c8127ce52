"""What many images would take on many processors, from what the images of a data set took."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.dataset import FOLDER, small_tasks, start_workers
from benchmarks.options import Options
from benchmarks.table import Table, skipped
from benchmarks.timing import timed
from photonmap import dataset
from photonmap.dataset import schedule
from photonmap.dataset.produce import Task

IMAGES, CORES = 100_000, (1, 100, 10_000)
COMPILING = 24.0
"""Processor seconds of a worker for kernels that none has compiled yet: see docs/scale.md."""
EMPTY = 3000
"""Jobs that do nothing, by which the scheduler is timed."""

Entry = dict[str, Any]


def run(options: Options) -> list[Table]:
    """Read the set that is named, or the one that the benchmark `dataset` left."""
    folder = options.dataset or FOLDER
    title = f"scale: {IMAGES:,} images".replace(",", " ")
    if not folder.exists():
        return [skipped(title, "needs a data set: run the benchmark dataset, or name --dataset")]
    entries = dataset.open(folder).entries
    rate = _jobs_a_second() if find_spec("distributed") else None
    return [_cost(entries), _sizes(folder, entries), _extrapolated(title, folder, entries, rate)]


def _cost(entries: Sequence[Entry]) -> Table:
    """Return what an image costs."""
    spent = [entry["cpu_seconds"] for entry in entries]
    width, height = entries[0]["size"]
    table = Table(f"scale: processor seconds of an image, {width}×{height}", ["", "seconds"])
    table.rows = [["mean", statistics.mean(spent)], ["longest", max(spent)]]
    return table


def _sizes(folder: Path, entries: Sequence[Entry]) -> Table:
    """Return the bytes of each format."""
    table = Table("scale: MB an image", ["format", "MB"])
    for suffix, size in _bytes_by_suffix(folder, entries).items():
        table.rows.append([suffix, size / 1e6])
    return table


def _bytes_by_suffix(folder: Path, entries: Sequence[Entry]) -> dict[str, float]:
    """Return the mean bytes of an image's files, by their suffix."""
    total: dict[str, float] = {}
    for entry in entries:
        for name in entry["files"]:
            file = folder / entry["name"] / name
            total[file.suffix] = total.get(file.suffix, 0.0) + file.stat().st_size / len(entries)
    return total


def _extrapolated(title: str, folder: Path, entries: Sequence[Entry], rate: float | None) -> Table:
    """Return hours, and what everything else has to keep up with.

    Workers compile at the same time; images take what the cores, or the scheduler, need for them;
    and in the end all wait for the longest.
    """
    mean = statistics.mean(entry["cpu_seconds"] for entry in entries)
    longest = max(entry["cpu_seconds"] for entry in entries)
    size = sum(_bytes_by_suffix(folder, entries).values())
    told = ["hours", "compiling, %", "the longest, %", "scheduler busy, %", "images a second"]
    table = Table(title, ["cores", *told, "MB/s written", "TB in all"])
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
        table.notes = [f"the scheduler handed out {rate:.0f} empty jobs a second here"]
    return table


def _jobs_a_second() -> float:
    """Return how many jobs that do nothing a scheduler of this machine and one worker finish."""
    tasks = small_tasks("nowhere")[:1] * EMPTY
    with start_workers(1) as cluster, mock.patch.object(schedule, "produce", _nothing):
        seconds = timed(lambda: list(schedule.run_tasks(tasks, cluster.scheduler_address)))
    return EMPTY / seconds


def _nothing(task: Task) -> dict[str, Any]:
    return {}
