"""How far the mean light of a 30 s render lies from the reference's."""

from __future__ import annotations

import photonmap as pm
from benchmarks import ours
from benchmarks.options import Options
from benchmarks.table import Table, skipped
from benchmarks.truth import SIZE, Truth

SECONDS = 30.0
TARGET = 0.002
NAMES = {"radiance": "full", "direct": "direct", "indirect": "indirect"}


def run(options: Options) -> list[Table]:
    """Render for 30 s and compare means over the pixels that see no lamp."""
    title = f"energy: mean light after {SECONDS:.0f} s against the reference, Cornell box, RGB"
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
