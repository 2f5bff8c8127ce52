"""Time to a given error on the Cornell box: photon mapping, path tracing, Mitsuba 3."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks import ours
from benchmarks.mitsuba_client import LLVM, SCALAR, Mitsuba
from benchmarks.options import Options
from benchmarks.table import Cell, Table, skipped
from benchmarks.truth import SIZE, Truth

LEVELS = (1e-2, 1e-3, 1e-4)
PHOTON_PASSES = (1, 4, 16, 48)
PATH_PASSES = (1, 4, 16, 32)
MITSUBA_SAMPLES = (64, 128, 256, 512)
SCALAR_SAMPLES = (16, 32, 64, 128)
SEEDS = (3, 3, 3, 2)
MARK = "*"

Renderer = Callable[[int, int], tuple[NDArray[np.float32], float]]
Point = tuple[float, float]
"""seconds and relMSE"""


def run(options: Options) -> list[Table]:
    """Render at growing budgets, all renderers taking turns, and read off the times."""
    title = "cornell: seconds to a relMSE on the Cornell box, 256×256, RGB, box pixels"
    truth = Truth(options.reference)
    if truth.reason:
        return [skipped(title, truth.reason)]
    with (
        Mitsuba(options.mitsuba, options.threads, variant=LLVM) as mitsuba,
        Mitsuba(options.mitsuba, options.threads, variant=SCALAR) as scalar,
    ):
        renderers: dict[str, tuple[Renderer, tuple[int, ...]]] = {
            "photon": (_photonmap("photon", options.threads), PHOTON_PASSES),
            "path": (_photonmap("path", options.threads), PATH_PASSES),
        }
        if not mitsuba.reason:
            mitsuba.render(MITSUBA_SAMPLES[0], 99)
            renderers["mitsuba"] = (mitsuba.render, MITSUBA_SAMPLES)
            renderers["scalar"] = (scalar.render, SCALAR_SAMPLES)
        points = _measure(renderers, truth)
    times = {
        name: [time_to(level, series, renderers[name][1][0]) for level in LEVELS]
        for name, series in points.items()
    }
    names = {
        "photon": "photonmap, photon",
        "path": "photonmap, path",
        "mitsuba": f"Mitsuba {mitsuba.version}, llvm path",
        "scalar": f"Mitsuba {mitsuba.version}, scalar path",
    }
    table = Table(title, ["renderer", *(f"{level:.0e}" for level in LEVELS)], notes=_notes(options))
    for name, label in names.items():
        cells: list[Cell] = [shown(*time) for time in times.get(name, [])]
        table.rows.append([label, *(cells or [mitsuba.reason, None, None])])
    if "mitsuba" in times:
        pairs = zip(times["mitsuba"], times["photon"], strict=True)
        table.rows.append(["Mitsuba / photon", *(above[0] / below[0] for above, below in pairs)])
    return [table, _curve(points)]


def _photonmap(method: str, threads: int) -> Renderer:
    scene = pm.scenes.cornell_box()
    settings: dict[str, Any] = {"bands": "rgb", "size": SIZE, "method": method, "threads": threads}
    ours.warm_up(scene, **settings)

    def render(passes: int, seed: int) -> tuple[NDArray[np.float32], float]:
        result, seconds = ours.render(scene, passes=passes, seed=seed, **settings)
        return result.radiance, seconds

    return render


def _measure(
    renderers: dict[str, tuple[Renderer, tuple[int, ...]]], truth: Truth
) -> dict[str, list[Point]]:
    """Return each renderer's points at growing budgets: best time, mean error over seeds."""
    points: dict[str, list[Point]] = {name: [] for name in renderers}
    for step, seeds in enumerate(SEEDS):
        found: dict[str, list[Point]] = {name: [] for name in renderers}
        for seed in range(seeds):
            for name, (render, budgets) in renderers.items():
                image, seconds = render(budgets[step], 1 + 10 * step + seed)
                found[name].append((seconds, truth.relative_mse(image)))
        for name, pairs in found.items():
            seconds, errors = zip(*pairs, strict=True)
            points[name].append((min(seconds), float(np.mean(errors))))
    return points


def time_to(level: float, points: list[Point], least: int) -> tuple[float, bool]:
    """Return the seconds to a relMSE, and whether they lie outside of what was measured.

    Between two points by a power law; outside of all as variance falls with time, from the point
    that did best. Of `least`, the smallest budget, a single pass cannot be divided.
    """
    ordered = sorted(points)
    if level > ordered[0][1]:
        if least == 1:
            return ordered[0][0], False
        return ordered[0][0] * ordered[0][1] / level, True
    for (t0, e0), (t1, e1) in pairwise(ordered):
        if e1 <= level <= e0:
            return t0 * (t1 / t0) ** (math.log(level / e0) / math.log(e1 / e0)), False
    return min(seconds * error for seconds, error in ordered) / level, True


def shown(seconds: float, outside: bool) -> str:
    """Return seconds, marked where they were not measured."""
    return (
        f"{seconds:.2f}{MARK if outside else ''}"
        if seconds < 10
        else (f"{seconds:.0f}{MARK if outside else ''}")
    )


def _notes(options: Options) -> list[str]:
    return [
        f"{options.threads} threads each, taking turns; without loading and compiling;"
        f" {MARK} extrapolated, variance falling with time",
        "photonmap's time is all of render() but what its record calls load and compile: photons,"
        " survey, camera passes, moments, standard errors",
    ]


def _curve(points: dict[str, list[Point]]) -> Table:
    """Return what was measured."""
    table = Table("cornell: the points measured", ["renderer", "budget", "seconds", "relMSE"])
    budgets = {
        "photon": PHOTON_PASSES,
        "path": PATH_PASSES,
        "mitsuba": MITSUBA_SAMPLES,
        "scalar": SCALAR_SAMPLES,
    }
    units = {"photon": "passes", "path": "passes", "mitsuba": "samples", "scalar": "samples"}
    for name, series in points.items():
        for budget, (seconds, error) in zip(budgets[name], series, strict=True):
            table.rows.append([name, f"{budget} {units[name]}", seconds, f"{error:.2e}"])
    return table
