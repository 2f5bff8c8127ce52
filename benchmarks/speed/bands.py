"""What more bands cost."""

from __future__ import annotations

import statistics
from typing import Any

import photonmap as pm
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table

COUNTS = (3, 6, 31)
TARGETS = {3: None, 6: "1.1", 31: "2.5"}
SIZE, PASSES, REPEATS = (256, 256), 8, 9


def run(options: Options) -> list[Table]:
    """Render the same number of passes in different numbers of bands, taking turns."""
    scene = pm.scenes.cornell_box()
    settings: dict[str, Any] = {"size": SIZE, "threads": options.threads}
    spent: dict[int, list[float]] = {count: [] for count in COUNTS}
    for count in COUNTS:
        ours.warm_up(scene, bands=count, **settings)
    for _ in range(REPEATS):
        for count in COUNTS:
            spent[count].append(ours.render(scene, bands=count, passes=PASSES, **settings)[1])
    table = Table(
        f"bands: seconds for {PASSES} passes, Cornell box, 256×256 (medians of {REPEATS})",
        ["bands", "seconds", "relative to 3", "target: at most"],
    )
    for count in COUNTS:
        ratios = [many / few for many, few in zip(spent[count], spent[3], strict=True)]
        table.rows.append(
            [count, statistics.median(spent[count]), statistics.median(ratios), TARGETS[count]]
        )
    return [table]
