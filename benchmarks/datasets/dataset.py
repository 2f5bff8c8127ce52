"""Cost of a data set: each image, work besides rendering, memory, and a second worker."""

from __future__ import annotations

import os
import shutil
import statistics
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from benchmarks.harness.children import run_photonmap
from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.table import Table, skipped
from benchmarks.harness.timing import interleave, ratio
from photonmap import dataset
from photonmap.dataset.jobs.job_scene import describe_inputs
from photonmap.dataset.jobs.plan import CommonSettings, plan_jobs
from photonmap.dataset.jobs.presets import Preset
from photonmap.dataset.jobs.render_image import Task
from photonmap.dataset.jobs.schedule import run_tasks, start_local_cluster
from photonmap.dataset.report.page import Entry, by_scene, mean_share

FOLDER = ROOT / "out" / "bench-dataset"
SIZE, ERROR = "320x240", "0.03"
MOST_APART, MOST_MEMORY, LEAST_RATIO = 15.0, 1.5, 1.8
SMALL, REPEATS = (160, 120), 3
"""Size of the images that one and two workers render, and repeats."""


def run(options: Options) -> list[Table]:
    """Render a preset with the real command, or read a data set; compare one worker with two."""
    seconds = peak = None
    folder = options.dataset or FOLDER
    if options.dataset is None:
        shutil.rmtree(FOLDER, ignore_errors=True)
        FOLDER.parent.mkdir(exist_ok=True)
        arguments = ["dataset", str(FOLDER), "--preset", options.preset, "--quiet"]
        seconds, peak = run_photonmap([*arguments, "--size", SIZE, "--error", ERROR])
    entries = dataset.open(folder).entries
    return [_images(entries), _scenes(entries), _whole(folder, entries, seconds, peak), _workers()]


def _images(entries: Sequence[Entry]) -> Table:
    """List all images."""
    width, height = entries[0]["size"]
    table = Table(
        f"dataset: images of {width}×{height} in {entries[0]['bands']} bands",
        ["scene", "illumination", "target error", "error", "passes", "seconds"],
    )
    for entry in entries:
        row = [entry["job"]["illumination"], entry["job"]["common"]["error"], entry["error"]]
        table.rows.append([entry["geometry"], *row, entry["passes"], _seconds(entry)])
    return table


def _scenes(entries: Sequence[Entry]) -> Table:
    """Average the images of each scene."""
    table = Table(
        "dataset: means over the illuminations of each scene",
        ["scene", "images", "seconds", "longest", "error", "direct fraction"],
    )
    for scene, images in by_scene(entries).items():
        spent = [_seconds(entry) for entry in images]
        row = [len(images), statistics.mean(spent), max(spent)]
        errors = statistics.mean(entry["error"] for entry in images)
        table.rows.append([scene, *row, errors, mean_share(images)])
    return table


def _seconds(entry: Entry) -> float:
    return sum(entry["seconds"].values())


def _whole(
    folder: Path, entries: Sequence[Entry], seconds: float | None, peak: int | None
) -> Table:
    """Return what the whole set took; None where an existing set does not tell."""
    table = Table("dataset: in total", ["quantity", "value", "target: at most"])
    total = sum(map(_seconds, entries))
    apart = sum(entry["seconds"]["build"] + entry["seconds"]["write"] for entry in entries)
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    table.rows = [
        ["images", len(entries), None],
        ["seconds of the command", seconds, None],
        ["seconds of its images", total, None],
        ["CPU seconds of its images", sum(e["cpu_seconds"] for e in entries), None],
        ["building scenes and writing, % of these", 100.0 * apart / total, MOST_APART],
        ["peak memory of the worker, GB", peak and peak / 1e9, MOST_MEMORY],
        ["MB per image", size / 1e6 / len(entries), None],
    ]
    return table


def _workers() -> Table:
    """Render the same images with one single-threaded worker and with two, taking turns."""
    title = "dataset: single-threaded workers on the same images"
    if find_spec("distributed") is None:
        return skipped(title, "needs dask: pip install 'photonmap[cluster]'")
    if (os.cpu_count() or 1) < 2:
        return skipped(title, "needs two processors")
    with ExitStack() as stack:
        made = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        tasks = small_tasks(str(made))
        places = {n: stack.enter_context(start_local_cluster(n)).scheduler_address for n in (1, 2)}
        calls = {str(n): partial(_render, tasks, place) for n, place in places.items()}
        spent = interleave(calls, REPEATS, partial(_empty, made))
    table = Table(title, ["workers", "images", "seconds", "speed-up", "target: at least"])
    one, two = (statistics.median(spent[name]) for name in calls)
    faster = ratio(spent["1"], spent["2"])
    table.rows = [[1, len(tasks), one, 1.0, None], [2, len(tasks), two, faster, LEAST_RATIO]]
    table.notes = [f"medians of {REPEATS}, kernels and workers warm"]
    return table


def small_tasks(folder: str) -> list[Task]:
    """Return enough small images for the wait for the last one to hardly matter."""
    common = describe_inputs(CommonSettings(SMALL, "6", ERROR))
    jobs = plan_jobs(Preset("two", ("jug", "boulder")), [], common)
    return [Task(job, folder, ("exr", "png"), threads=1) for job in jobs]


def _render(tasks: Sequence[Task], scheduler: str) -> None:
    """Render all images; raise RuntimeError if one fails."""
    for task, result in run_tasks(tasks, scheduler):
        if isinstance(result, str):
            raise RuntimeError(f"{task.job.name}: {result}")


def _empty(folder: Path) -> None:
    """Remove the images, because existing ones are not rendered again."""
    for image in folder.iterdir():
        shutil.rmtree(image)
