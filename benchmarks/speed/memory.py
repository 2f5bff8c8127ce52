"""Peak memory of large renders, the estimate made beforehand, and what statistics move."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import photonmap as pm
from benchmarks.harness.children import run_photonmap
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from photonmap.film.moments import BYTES_PER_VALUE, Accumulator
from photonmap.integrators.memory_estimate import Work
from photonmap.kernels.core.passes import FOUND, Pixels
from photonmap.runtime.workers import Workers

CASES = ((1024, 6), (1024, 3), (512, 6), (512, 31))
TARGET = 1.5
PIXELS, BANDS, REPEATS = 320 * 240, (3, 31, 81), 5
BUFFERS = 6
"""Band values of a pass that statistics read: float32, `Pixels`."""


def run(options: Options) -> list[Table]:
    """Render two passes with all buffers by the real command, including saving."""
    triangles = sum(len(mesh.faces) for mesh in pm.scenes.cornell_box().meshes)
    table = Table(
        "memory: peak of python -m photonmap scenes/cornell_box.obj, all buffers, 2 passes",
        ["size", "bands", "GB", "target: at most", "estimated, GB", "estimate / peak", "seconds"],
    )
    for side, bands in CASES:
        with tempfile.TemporaryDirectory() as folder:
            scene = str(Path(pm.scenes.FOLDER) / "cornell_box.obj")
            arguments = [scene, "--size", f"{side}x{side}", "--bands", str(bands)]
            arguments += ["--passes", "2", "--threads", str(options.threads)]
            done = run_photonmap([*arguments, "--output", str(Path(folder) / "image.exr")])
        estimate = sum(Work(side * side, bands, side * side, triangles).need)
        target = f"{TARGET}" if (side, bands) == CASES[0] else None
        peak = done.peak
        row = [f"{side}×{side}", bands, peak / 1e9, target, estimate / 1e9, estimate / peak]
        table.rows.append([*row, done.seconds])
    return [table, _traffic()]


def _traffic() -> Table:
    """Return how fast one core takes passes into the moments, which no cache holds."""
    table = Table(
        f"memory: statistics of a pass, {PIXELS} pixels, one core",
        ["bands", "bytes a pixel and band", "ns", "GB/s", "copying, GB/s"],
        notes=["read and written; processor time, the best of 5"],
    )
    bytes_moved = 2 * BYTES_PER_VALUE + 4 * BUFFERS
    for bands in BANDS:
        pixels = Pixels(
            *np.random.default_rng(0).random((BUFFERS, PIXELS, bands), np.float32),
            coverage=np.ones(PIXELS, np.float32),
            lookups=np.full(PIXELS, FOUND, np.uint8),
            plane=np.zeros((PIXELS, 7), np.float32),
        )
        with Workers(1) as workers:
            moments = Accumulator(PIXELS, bands, workers)
            spent = _best(lambda moments=moments, pixels=pixels: moments.add(pixels))
        source = np.ones(PIXELS * bands * BYTES_PER_VALUE, np.uint8)
        copied = np.zeros_like(source)
        copying = _best(lambda copied=copied, source=source: np.copyto(copied, source))
        count = PIXELS * bands
        rates = bytes_moved * count / spent / 1e9, 2 * source.nbytes / copying / 1e9
        table.rows.append([bands, bytes_moved, 1e9 * spent / count, *rates])
    return table


def _best(call: Callable[[], object]) -> float:
    """Return the least processor seconds of a call, the first of which does not count."""
    call()
    seconds = []
    for _ in range(REPEATS):
        start = time.process_time()
        call()
        seconds.append(time.process_time() - start)
    return min(seconds)
