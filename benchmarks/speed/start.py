"""The time of the first run on a new machine, and of every later one."""

from __future__ import annotations

import json
import statistics
import tempfile
from pathlib import Path

from benchmarks.harness.children import run_photonmap
from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.table import Table

SCENE = ROOT / "scenes" / "cornell_box.obj"
LATER = 5
STAGES = ("load", "compile", "render")


def run(options: Options) -> list[Table]:
    """Run the command with an empty kernel cache, then again with a full one."""
    table = Table(
        "start: seconds of python -m photonmap scenes/cornell_box.obj --size 64x64",
        ["run", "seconds", "target: at most", *STAGES],
    )
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "image.exr"
        arguments = [str(SCENE), "--size", "64x64", "--threads", str(options.threads)]
        arguments += ["--output", str(output)]
        environment = {"NUMBA_CACHE_DIR": str(Path(folder) / "cache")}
        runs = []
        for _ in range(1 + LATER):
            seconds = run_photonmap(arguments, environment).seconds
            record = json.loads(output.with_suffix(".json").read_text())
            runs.append([seconds, *(record["seconds"][stage] for stage in STAGES)])
    later = [statistics.median(column) for column in zip(*runs[1:], strict=True)]
    for name, target, (seconds, *stages) in (("first", "20", runs[0]), ("later", "2", later)):
        table.rows.append([name, seconds, target, *stages])
    table.notes = [
        f"later: medians of {LATER}; the remaining time is Python, imports and writing files"
    ]
    return [table]
