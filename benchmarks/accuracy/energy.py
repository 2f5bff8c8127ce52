"""Difference between the mean light of a 30 s render and that of the reference."""

from __future__ import annotations

import photonmap as pm
from benchmarks.accuracy.truth import SIZE, Truth
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table, skipped

SECONDS = 30.0
TARGET = 0.002
NAMES = {"radiance": "full", "direct": "direct", "indirect": "indirect"}


def run(options: Options) -> list[Table]:
    """Render for 30 s and compare means over the pixels that show no emission."""
    title = f"energy: mean light after {SECONDS:.0f} s relative to the reference, Cornell box, RGB"
    truth = Truth(options.reference)
    if truth.reason:
        return [skipped(title, truth.reason)]
    scene = pm.scenes.cornell_box()
    settings = {"bands": "rgb", "size": SIZE, "threads": options.threads}
    ours.warm_up(scene, **settings)
    result, _ = ours.render(scene, seconds=SECONDS, **settings)
    table = Table(title, ["buffer", "all bands, %", "R, %", "G, %", "B, %"])
    for name, reference in NAMES.items():
        total, each = truth.energy(reference, result.buffers[name])
        table.rows.append([name, *(f"{100.0 * value:+.3f}" for value in (total, *each))])
    table.notes = [f"{result.record['passes']} passes; target: within ±{100 * TARGET:.1f} %"]
    return [table]
