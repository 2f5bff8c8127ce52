"""The time of the first run on a new machine, and of every later one."""

from __future__ import annotations

import json
import statistics
import tempfile
from pathlib import Path

import photonmap as pm
from benchmarks.harness.children import run_photonmap
from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.table import Table
from benchmarks.speed.all_matter import all_matter

LATER = 5
STAGES = ("load", "compile", "render")
TARGETS = {"Cornell box": (20, 2), "all matter": (30, None)}
"""Seconds at most, of the first run and of later ones"""


def run(options: Options) -> list[Table]:
    """Run the command with an empty kernel cache, then again with a full one."""
    table = Table(
        "start: seconds of python -m photonmap SCENE --size 64x64",
        ["scene", "run", "seconds", "target: at most", *STAGES],
    )
    for scene, targets in TARGETS.items():
        with tempfile.TemporaryDirectory() as folder:
            runs = _run(_file_of(scene, Path(folder)), Path(folder), options.threads)
        later = [statistics.median(column) for column in zip(*runs[1:], strict=True)]
        for name, target, (seconds, *stages) in zip(
            ("first", "later"), targets, (runs[0], later), strict=True
        ):
            table.rows.append([scene, name, seconds, target, *stages])
    table.notes = [
        f"later: medians of {LATER}; the remaining time is Python, imports and writing files",
        "all matter: glass of all kinds, metals, coats, plastic, clay, cloth, images, all lights",
    ]
    return [table]


def _file_of(scene: str, folder: Path) -> Path:
    """Return the file of a scene, which is written into `folder` if the project has none."""
    if scene == "Cornell box":
        return ROOT / "scenes" / "cornell_box.obj"
    file = folder / "all_matter.obj"
    pm.save_scene(all_matter(), file)
    return file


def _run(scene: Path, folder: Path, threads: int) -> list[list[float]]:
    """Return the seconds of each run, and of its stages."""
    output = folder / "image.exr"
    arguments = [str(scene), "--size", "64x64", "--threads", str(threads)]
    arguments += ["--output", str(output)]
    # An installed package has its bytecode.
    environment = {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONDONTWRITEBYTECODE": ""}
    runs = []
    for _ in range(1 + LATER):
        seconds = run_photonmap(arguments, environment).seconds
        record = json.loads(output.with_suffix(".json").read_text())
        runs.append([seconds, *(record["seconds"][stage] for stage in STAGES)])
    return runs
