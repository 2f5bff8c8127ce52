"""The time and space it takes to save the state of a render."""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path

import photonmap as pm
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from photonmap.runtime.checkpoint import EVERY, MOST_SHARE

SIZES = ((256, 256), (512, 512), (1024, 1024))
TIMES = 5


def run(options: Options) -> list[Table]:
    """Save after the only pass; return how long it takes, as a share of the time too."""
    table = Table(
        "checkpoint: one save, 6 bands",
        ["size", "MB", "seconds", "interval, s", "share of the time, %", "target: at most"],
    )
    box = pm.scenes.cornell_box()
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            file = Path(folder) / "state"
            seconds = [
                pm.render(
                    box, bands=6, size=size, passes=1, threads=options.threads, checkpoint=file
                ).record["seconds"]["checkpoint"]
                for _ in range(TIMES)
            ]
            spent = statistics.median(seconds)
            every = max(EVERY, spent / MOST_SHARE)
            table.rows.append(
                [
                    f"{size[0]}x{size[1]}",
                    file.stat().st_size / 1e6,
                    spent,
                    every,
                    100.0 * spent / (every + spent),
                    2,
                ]
            )
    table.notes = [f"medians of {TIMES}; saved every {EVERY:.0f} s, or less often if it takes long"]
    return [table]
