"""Rough metal and a glossy floor in the Cornell box: time to an error, mean, and honest errors."""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks.accuracy.cornell import LEVELS, shown, time_to
from benchmarks.accuracy.gloss_scenes import SCENES, write_scene
from benchmarks.accuracy.mitsuba_client import SCALAR, start_mitsuba
from benchmarks.accuracy.room_mitsuba import render_or_read
from benchmarks.accuracy.rooms import (
    LEAST,
    SCALAR_TO_LLVM,
    SOME,
    Settings,
    mean_difference,
    measure_photons,
    path_cost,
)
from benchmarks.harness.options import Options
from benchmarks.harness.table import Cell, Table

SIZE = (256, 256)
TRIALS, REFERENCE = 3, 12
"""Renders whose errors are checked, and how many times their passes the reference has."""
INTERVAL = 1.96
"""Standard errors on either side of what holds 95%."""
NAMES = ("radiance", "residual", "indirect")


def run(options: Options) -> list[Table]:
    """Measure each scene, one after the other."""
    size = options.size or SIZE
    times = Table("", [*_columns()], notes=_notes(options))
    calibrated = Table(
        "gloss: 95% intervals that hold the truth", ["scene", *NAMES],
        notes=[f"{TRIALS} renders of {SOME} passes, against {SOME * REFERENCE} of another seed"],
    )  # fmt: skip
    variant = ""
    for name in _choose(options.scenes):
        with tempfile.TemporaryDirectory() as folder:
            file = write_scene(name, size, Path(folder))
            settings: Settings = {"bands": "rgb", "size": size, "threads": options.threads}
            scene = pm.load_scene(file)
            row, variant = _compare(name, scene, file, settings, options)
            times.rows.append(row)
            calibrated.rows.append([name, *_calibration(scene, settings)])
        print(f"gloss: {', '.join(map(str, times.rows[-1] + calibrated.rows[-1][1:]))}", flush=True)
    times.title = f"gloss: processor seconds to a relMSE, {size[0]}×{size[1]}, RGB, {variant}"
    return [times, calibrated]


def _columns() -> list[str]:
    levels = [f"{level:.0e}" for level in LEVELS]
    ratios = [f"{who} / photon, {level}" for who in ("path", "Mitsuba") for level in levels]
    return ["scene", *levels, "bias / error", *ratios, "mean − Mitsuba's", "±"]


def _choose(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the scenes that are asked for, by the beginnings of their names."""
    for name in names:
        if not any(scene.startswith(name) for scene in SCENES):
            raise SystemExit(f"there is no scene {name!r}; choose from {', '.join(SCENES)}")
    return tuple(scene for scene in SCENES if not names or scene.startswith(names))


def _compare(
    name: str, scene: pm.Scene, file: Path, settings: Settings, options: Options
) -> tuple[list[Cell], str]:
    """Return a row of the first table, and Mitsuba's variant or why there is none."""
    own = measure_photons(scene, settings)
    spent = [time_to(level, own.points, LEAST) for level in LEVELS]

    def over(cost: float) -> list[float]:
        return [cost / level / each for level, (each, _) in zip(LEVELS, spent, strict=True)]

    row: list[Cell] = [name, *(shown(*each) for each in spent), f"{own.bias:.0%}"]
    row += over(path_cost(scene, settings))
    other = start_mitsuba(options, file)
    if isinstance(other, str):
        return [*row, *[None] * (len(LEVELS) + 2)], other
    with other:
        rendered = render_or_read(other, (file, 1.0), name, options.kept)
    row += [*over(rendered.cost(own.valid)), *mean_difference(own, rendered, "radiance")]
    return row, f"Mitsuba {other.version}, {other.variant} path"


def _calibration(scene: pm.Scene, settings: Settings) -> list[Cell]:
    """Return which share of the pixels and bands a reference has within their 95% intervals."""
    reference = pm.render(scene, passes=SOME * REFERENCE, seed=100, **settings)
    shares: dict[str, list[float]] = {name: [] for name in NAMES}
    for seed in range(TRIALS):
        result = pm.render(scene, passes=SOME, seed=seed, **settings)
        for name in NAMES:
            shares[name].append(_share(result, reference, name))
    return [f"{statistics.mean(found):.1%}" for found in shares.values()]


def _share(result: Any, reference: Any, name: str) -> float:
    """Return the share of one buffer's values that differ by no more than their errors say."""
    error = np.hypot(result.standard_error(name), reference.standard_error(name))
    difference: NDArray[Any] = np.abs(result[name].astype(float) - reference[name])
    counted = error > 0.0
    return float((difference[counted] <= INTERVAL * error[counted]).mean())


def _notes(options: Options) -> list[str]:
    return [
        f"{options.threads} threads; without loading and compiling; copper, and plastic of index"
        " 1.5, of the α of GGX in their names, read from Mitsuba's own file",
        "Mitsuba loses light that facets scatter several times: photonmap reads its surfaces with"
        " the reflectance by which they reflect as much light from all around, so that means are"
        " comparable, but not pixels",
        f"where {SCALAR} and llvm both ran, on the Cornell box, scalar took {SCALAR_TO_LLVM} times"
        " as long: divide by that to compare with llvm",
    ]
