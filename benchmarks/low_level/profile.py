"""Where the time of a pass goes: its stages, and parts of the camera pass run on their own."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.options import ROOT, Options
from benchmarks.harness.table import Table
from benchmarks.harness.timing import interleave
from benchmarks.low_level import replay
from benchmarks.low_level.one_pass import BANDS, FILM, OnePass
from photonmap.kernels.core.passes import LANES
from photonmap.runtime.workers import Workers

REPEATS = 15
CHUNK = 16384
KEY = np.uint64(1)


def run(options: Options) -> list[Table]:
    """Time the stages of a pass, then its rays, look-ups and random numbers on their own."""
    rays = record_rays()
    with Workers(options.threads) as workers:
        one = OnePass(workers)
        stages = {
            "photons": one.photons,
            "camera pass": one.camera_pass,
            "sharing": one.sharing,
            "moments and error": one.averaging,
        }
        whole = Table(
            f"profile: the first pass on the Cornell box, RGB, 256×256, {options.threads} threads",
            ["stage", "ms", "share of the pass"],
        )
        _add_rows(whole, interleave(stages, REPEATS), None)
        calls = {"camera pass": one.camera_pass, **_parts(one, rays, workers)}
        inside = Table(
            f"profile: the camera pass, {len(rays)} rays",
            ["part, run on its own", "ms", "share of the camera pass"],
            notes=["random numbers: one direction about a normal per ray"],
        )
        _add_rows(inside, interleave(calls, REPEATS), "camera pass")
        kinds = Table(
            "profile: the rays of a pass, by kind",
            ["kind", "rays a pixel", "share"],
            notes=[
                "specular: along chains; walk: on from where gather rays end too near to look up"
            ],
        )
        counts = one.rays_by_kind()
        for kind, count in counts.items():
            share = f"{count / sum(counts.values()):.0%}"
            kinds.rows.append([kind, count / (FILM.width * FILM.height), share])
    return [whole, inside, kinds]


def record_rays() -> NDArray[np.float32]:
    """Return the camera pass's rays, (n, 8): see `record_rays`."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rays.npy"
        command = [sys.executable, "-m", "benchmarks.low_level.record_rays", str(file)]
        subprocess.run(command, check=True, cwd=ROOT)
        return np.load(file)


def _parts(
    one: OnePass, rays: NDArray[np.float32], workers: Workers
) -> dict[str, Callable[[], Any]]:
    """Return parts of the camera pass as calls."""
    geometry, cache = one.compiled.geometry, one.maps.cache
    eye = one.compiled.film_camera(FILM.width, FILM.height).origin
    eye = tuple(float(np.float32(x)) for x in eye)

    def ranges(task: Callable[[int, int], Any]) -> Callable[[], Any]:
        return lambda: workers.ranges(task, len(rays), CHUNK)

    def look_up(first: int, last: int) -> None:
        total = np.zeros(BANDS.count, np.float32)
        replay.cast_and_look_up(geometry, cache, eye, rays, first, last, total)

    def draw(first: int, last: int) -> None:
        replay.draw_samples(rays, KEY, first, last, np.empty((3, LANES)))

    return {
        "its rays": ranges(lambda a, b: replay.cast_rays(geometry.scene, rays, a, b)),
        "its rays and look-ups": ranges(look_up),
        "its random numbers": ranges(draw),
    }


def _add_rows(table: Table, seconds: dict[str, list[float]], base: str | None) -> None:
    """Add a row per series: its median, and its share of `base` or of the sum of all."""
    medians = {name: statistics.median(series) for name, series in seconds.items()}
    total = medians[base] if base else sum(medians.values())
    for name, median in medians.items():
        table.rows.append([name, 1e3 * median, f"{median / total:.0%}"])
