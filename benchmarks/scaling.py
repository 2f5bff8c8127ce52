"""How time grows with pixels, with photons and with triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import photonmap as pm
from benchmarks import ours
from benchmarks.options import ROOT, Options
from benchmarks.shapes import room_with_sphere
from benchmarks.table import Table
from benchmarks.timing import exponent

SIDES = (128, 256, 512, 1024)
PHOTONS = (1 << 15, 1 << 17, 1 << 19, 1 << 21)
TRIANGLES = (1_000, 10_000, 100_000, 1_000_000, 5_000_000)
STAGES = ("load", "compile", "photons", "camera")
PASSES = 2
CURVES = ROOT / "out" / "scaling.png"

Case = tuple[float, pm.Scene, dict[str, Any]]


def run(options: Options) -> list[Table]:
    """Render with one quantity growing and all else fixed."""
    box = pm.scenes.cornell_box()
    pixels: list[Case] = [
        (side * side, box, {"size": (side, side), "photons": 1 << 16}) for side in SIDES
    ]
    photons: list[Case] = [
        (count, box, {"size": (256, 256), "photons": count}) for count in PHOTONS
    ]
    tables = [
        _series("pixels", "65 536 photons a pass", pixels, "camera", options),
        _series("photons", "256×256", photons, "photons", options),
        _series("triangles", "256×256, 65 536 photons", map(_case, TRIANGLES), "load", options),
    ]
    _draw(tables, CURVES)
    return tables


def _case(triangles: int) -> Case:
    scene = room_with_sphere(triangles)
    count = sum(len(mesh.faces) for mesh in scene.meshes)
    return count, scene, {"size": (256, 256), "photons": 1 << 16}


def _series(unit: str, fixed: str, cases: Any, stage: str, options: Options) -> Table:
    """Time the stages of renders of growing size; `stage` is what should grow with it."""
    table = Table(
        f"scaling with {unit}: seconds of {PASSES} passes, RGB, {fixed}",
        [unit, *STAGES, f"{stage}, µs a {unit[:-1]}"],
    )
    ours.warm_up(pm.scenes.cornell_box(), bands="rgb", size=(8, 8), threads=options.threads)
    for size, scene, settings in cases:
        result, _ = ours.render(
            scene, bands="rgb", passes=PASSES, threads=options.threads, **settings
        )
        spent = result.record["seconds"]
        table.rows.append([size, *(spent[s] for s in STAGES), 1e6 * spent[stage] / size])
    powers = []
    for column, name in enumerate(STAGES, start=1):
        slope = exponent([row[0] for row in table.rows], [row[column] for row in table.rows])
        powers.append(f"{name} {slope:.2f}")
    last = table.rows[-2:]
    local = exponent([row[0] for row in last], [row[1 + STAGES.index(stage)] for row in last])
    table.notes = [
        f"seconds ~ {unit}^p, p fitted: {', '.join(powers)}; {stage} between the last two rows:"
        f" {local:.2f} ({'linear or better' if local < 1.1 else 'worse than linear'})"
    ]
    return table


def _draw(tables: list[Table], path: Path) -> None:
    """Draw the curves where Matplotlib is installed."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        return
    figure, axes = plt.subplots(1, len(tables), figsize=(4 * len(tables), 3.5), sharey=True)
    for axis, table in zip(axes, tables, strict=True):
        for column, name in enumerate(STAGES, start=1):
            axis.loglog(
                [row[0] for row in table.rows],
                [row[column] for row in table.rows],
                marker="o",
                label=name,
            )
        axis.set_xlabel(table.columns[0])
    axes[0].set_ylabel(f"seconds, {PASSES} passes")
    axes[0].legend()
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
