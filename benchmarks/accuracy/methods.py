"""Photon mapping compared with the plain path tracer, on scenes of every kind."""

from __future__ import annotations

import math
from collections.abc import Callable

import photonmap as pm
from benchmarks.accuracy.matter import CASES, make_scene
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.shapes import room_with_sphere
from benchmarks.harness.table import Table
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.dataset.scenes.illumination import Illumination

SIZE, PASSES = (128, 128), 32
TARGET = 1e-4
"""relMSE for which the times are compared."""


def run(options: Options) -> list[Table]:
    """Compare the times to a given error, from the error and bias that each render estimates."""
    table = Table(
        f"methods: seconds to relMSE {TARGET:g}, {SIZE[0]}×{SIZE[1]}, RGB",
        ["scene", "photon", "bias", "path", "path / photon"],
        notes=[
            f"from the errors estimated after {PASSES} passes, with variance inversely proportional"
            " to time and the bias of photon mapping taken as constant"
        ],
    )
    for name, make in _scenes().items():
        scene = make()
        photon, bias = _seconds(scene, "photon", options)
        path, _ = _seconds(scene, "path", options)
        table.rows.append([name, photon, f"{bias:.2%}", path, path / photon])
    return [table]


def _scenes() -> dict[str, Callable[[], pm.Scene]]:
    white = Illumination("white", ("D65",))
    return {
        "Cornell box": pm.scenes.cornell_box,
        **{f"Cornell box, {case}": (lambda case=case: make_scene(case)) for case in CASES},
        "a ball of 5120 faces": lambda: room_with_sphere(5000),
        "vase": lambda: build_unlit_scene("vase", 0, "lambertian").lit(white),
        "study": lambda: build_unlit_scene("study", 0, "lambertian").lit(white),
    }


def _seconds(scene: pm.Scene, method: str, options: Options) -> tuple[float, float]:
    """Return the seconds to `TARGET`, and the estimated bias."""
    settings = {"bands": "rgb", "size": SIZE, "threads": options.threads, "method": method}
    ours.warm_up(scene, **settings)
    result, seconds = ours.render(scene, **settings, passes=PASSES)
    variance, bias = result.record["standard_error"] ** 2, result.record["bias"] or 0.0
    left = TARGET - bias**2
    return (seconds * variance / left if left > 0.0 else math.inf), bias
