"""Peak memory of large renders, and the estimate made beforehand."""

from __future__ import annotations

import tempfile
from pathlib import Path

import photonmap as pm
from benchmarks.harness.children import run_photonmap
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from benchmarks.speed.start import SCENE
from photonmap.integrators.memory_estimate import Work

CASES = ((1024, 6), (1024, 3), (512, 6), (512, 31))
TARGET = 1.5


def run(options: Options) -> list[Table]:
    """Render two passes with all buffers by the real command, including saving."""
    triangles = sum(len(mesh.faces) for mesh in pm.scenes.cornell_box().meshes)
    table = Table(
        "memory: peak of python -m photonmap scenes/cornell_box.obj, all buffers, 2 passes",
        ["size", "bands", "GB", "target: at most", "estimated, GB", "estimate / peak", "seconds"],
    )
    for side, bands in CASES:
        with tempfile.TemporaryDirectory() as folder:
            arguments = [str(SCENE), "--size", f"{side}x{side}", "--bands", str(bands)]
            arguments += ["--passes", "2", "--threads", str(options.threads)]
            done = run_photonmap([*arguments, "--output", str(Path(folder) / "image.exr")])
        estimate = sum(Work(side * side, bands, side * side, triangles).need)
        target = f"{TARGET}" if (side, bands) == CASES[0] else None
        peak = done.peak
        row = [f"{side}×{side}", bands, peak / 1e9, target, estimate / 1e9, estimate / peak]
        table.rows.append([*row, done.seconds])
    return [table]
