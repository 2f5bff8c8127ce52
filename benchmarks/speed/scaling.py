"""How time scales with pixels, bands, photons, triangles, lights and cores."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import photonmap as pm
from benchmarks.harness import ours
from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.shapes import room_with_sphere
from benchmarks.harness.table import Table
from benchmarks.speed.cores import cores_tables
from photonmap.study.convergence import fit_power

SIDES = (128, 256, 512, 1024)
PHOTONS = (1 << 15, 1 << 17, 1 << 19, 1 << 21)
BANDS = (3, 6, 9, 31, 81)
LIGHTS = (1, 10, 100, 1000)
TRIANGLES = (1_000, 10_000, 100_000, 1_000_000, 5_000_000)
STAGES = ("load", "photons", "camera")
PASSES, REPEATS = 2, 3
VERDICTS = ((1.05, "linear or better"), (1.2, "nearly linear"), (9.9, "worse than linear"))
CURVES = ROOT / "out" / "scaling.png"

Case = tuple[float, pm.Scene, dict[str, Any]]


def run(options: Options) -> list[Table]:
    """Render with one quantity growing and everything else fixed."""
    box = pm.scenes.cornell_box()
    pixels: list[Case] = [
        (side * side, box, {"size": (side, side), "photons": 1 << 16}) for side in SIDES
    ]
    photons: list[Case] = [
        (count, box, {"size": (256, 256), "photons": count}) for count in PHOTONS
    ]
    tables = [
        _series("pixels", "65 536 photons per pass", pixels, "camera", options),
        _series("photons", "256×256", photons, "photons", options),
        _series("triangles", "256×256, 65 536 photons", map(_case, TRIANGLES), "load", options),
        _series("bands", "128×128", map(_banded, BANDS), "camera", options),
        _series("lights", "128×128", map(_lit, LIGHTS), "camera", options),
    ]
    _draw(tables, CURVES)
    return [*tables, *cores_tables()]


def _case(triangles: int) -> Case:
    scene = room_with_sphere(triangles)
    count = sum(len(mesh.faces) for mesh in scene.meshes)
    return count, scene, {"size": (256, 256), "photons": 1 << 16}


def _banded(bands: int) -> Case:
    return bands, pm.scenes.cornell_box(), {"size": (128, 128), "bands": bands}


def _lit(lights: int) -> Case:
    """Return the Cornell box lit by point lights of the same total power."""
    box = pm.scenes.cornell_box()
    places = np.random.default_rng(4).uniform((-0.9, 0.3, -0.9), 0.9, (lights, 3))
    points = [pm.PointLight(tuple(place), 1.0 / lights) for place in places]
    walls = [mesh for mesh in box.meshes if mesh.name != "light"]
    return lights, pm.Scene(walls, points, box.camera), {"size": (128, 128)}


def _series(unit: str, fixed: str, cases: Iterable[Case], stage: str, options: Options) -> Table:
    """Time the stages of renders of growing size; `stage` is the one expected to grow."""
    table = Table(
        f"scaling with {unit}: seconds of {PASSES} passes, {fixed} (medians of {REPEATS})",
        [unit, *STAGES, f"{stage}, µs per {unit[:-1]}"],
    )
    settings = {"bands": "rgb", "passes": PASSES, "threads": options.threads}
    ours.render(pm.scenes.cornell_box(), size=(8, 8), **settings)
    for size, scene, own in cases:
        records = [ours.render(scene, **{**settings, **own})[0].record for _ in range(REPEATS)]
        spent = {s: statistics.median(record["seconds"][s] for record in records) for s in STAGES}
        table.rows.append([size, *spent.values(), 1e6 * spent[stage] / size])
    table.notes = [_describe(table, unit, stage)]
    return table


def _describe(table: Table, unit: str, stage: str) -> str:
    """Return the exponents of power laws fitted to the columns of a table."""
    columns = list(zip(*table.rows, strict=True))
    place = 1 + STAGES.index(stage)
    powers = [
        f"{name} {_exponent(columns[0], column):.2f}"
        for name, column in zip(STAGES, columns[1:-1], strict=True)
    ]
    last = _exponent(columns[0][-2:], columns[place][-2:])
    verdict = next(text for limit, text in VERDICTS if last <= limit)
    return (
        f"seconds ~ {unit}^p, fitted p: {', '.join(powers)}; {stage} between the last two rows:"
        f" {last:.2f}, {verdict}"
    )


def _exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """Return p of the power law seconds ~ size^p that fits best."""
    law = fit_power(sizes, seconds)
    assert law is not None
    return law.exponent


def _draw(tables: list[Table], path: Path) -> None:
    """Draw the curves if Matplotlib is installed."""
    try:
        import matplotlib.pyplot as plt
        from matplotlib.ticker import EngFormatter
    except ImportError:
        return
    figure, axes = plt.subplots(2, 3, figsize=(10, 6), sharey=True, layout="constrained")
    *panels, corner = axes.flat
    for panel, table in zip(panels, tables, strict=True):
        sizes, *columns, _ = zip(*table.rows, strict=True)
        for name, seconds in zip(STAGES, columns, strict=True):
            panel.loglog(sizes, seconds, marker="o", label=name)
        first = columns[STAGES.index(table.columns[-1].split(",")[0])][0]
        linear = [first * size / sizes[0] for size in sizes]
        panel.loglog(sizes, linear, "--", color="0.6", zorder=0, label="linear")
        panel.set_xticks(sizes)
        panel.xaxis.set_major_formatter(EngFormatter(places=0, sep=""))
        panel.minorticks_off()
        panel.set_title(table.columns[0])
        panel.grid(alpha=0.3)
    axes[0, 0].set_ylim(1e-3, 30.0)
    for left in axes[:, 0]:
        left.set_ylabel(f"seconds, {PASSES} passes")
    corner.axis("off")
    corner.legend(*panels[0].get_legend_handles_labels(), loc="center", fontsize=12)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
