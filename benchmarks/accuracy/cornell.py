"""Time to a given error on the Cornell box: photon mapping, path tracing, Mitsuba 3."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks.accuracy.mitsuba_client import LLVM, SCALAR, Mitsuba
from benchmarks.accuracy.truth import SIZE, Truth
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Cell, Table, skipped

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
    """Render with growing budgets, the renderers taking turns, and interpolate the times."""
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
    """Return the points of each renderer at growing budgets: best time, mean error over seeds."""
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
    """Return the seconds to a relMSE, and whether they lie outside the measured range.

    Between two points they follow a power law, and points above that of two others do not count.
    Outside, variance is taken to be inversely proportional to time, starting from the most
    efficient point; but if the smallest budget, `least`, is a single pass, it cannot be divided.
    """
    ordered: list[Point] = []
    for point in sorted(points):
        if not ordered or point[1] < ordered[-1][1]:
            while len(ordered) > 1 and _slope(ordered[-2], point) < _slope(*ordered[-2:]):
                ordered.pop()
            ordered.append(point)
    if level > ordered[0][1]:
        if least == 1:
            return ordered[0][0], False
        return ordered[0][0] * ordered[0][1] / level, True
    for (t0, e0), (t1, e1) in pairwise(ordered):
        if e1 <= level <= e0:
            return t0 * (t1 / t0) ** (math.log(level / e0) / math.log(e1 / e0)), False
    return min(seconds * error for seconds, error in ordered) / level, True


def _slope(first: Point, second: Point) -> float:
    """Return the exponent of the power law between two points."""
    return math.log(second[1] / first[1]) / math.log(second[0] / first[0])


def shown(seconds: float, outside: bool) -> str:
    """Return seconds as text, marked if they are extrapolated."""
    return (
        f"{seconds:.2f}{MARK if outside else ''}"
        if seconds < 10
        else (f"{seconds:.0f}{MARK if outside else ''}")
    )


def _notes(options: Options) -> list[str]:
    return [
        f"{options.threads} threads each, taking turns; without loading and compiling;"
        f" {MARK} extrapolated, with variance inversely proportional to time",
        "photonmap's time is all of render() except loading and compiling: photons, sampling"
        " pre-pass, camera passes, moments, standard errors",
    ]


def _curve(points: dict[str, list[Point]]) -> Table:
    """Return the measured points."""
    table = Table("cornell: measured points", ["renderer", "budget", "seconds", "relMSE"])
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
