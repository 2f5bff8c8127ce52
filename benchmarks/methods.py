"""Photon mapping against the plain path tracer, on scenes of every kind."""

from __future__ import annotations

import math
from collections.abc import Callable

import photonmap as pm
from benchmarks import ours
from benchmarks.matter import make_scene
from benchmarks.options import Options
from benchmarks.shapes import room_with_sphere
from benchmarks.table import Table
from photonmap.dataset.build import build_setting
from photonmap.dataset.lighting import Illumination

SIZE, PASSES = (128, 128), 32
TARGET = 1e-4
"""relMSE to whose time both are compared."""
INSIDE = ("mirror", "glass", "both", "point", "spot", "sun", "dome", "sky")


def run(options: Options) -> list[Table]:
    """Compare the seconds to an error, by the error and the bias that each render states."""
    table = Table(
        f"methods: seconds to relMSE {TARGET:g}, {SIZE[0]}×{SIZE[1]}, RGB",
        ["scene", "photon", "of it bias", "path", "path / photon"],
        notes=[
            f"by the errors stated after {PASSES} passes: variance falls with time, the bias of"
            " photon mapping, as stated then, is taken to stay"
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
        **{f"Cornell box, {case}": (lambda case=case: make_scene(case)) for case in INSIDE},
        "a ball of 5120 faces": lambda: room_with_sphere(5000),
        "vase": lambda: build_setting("vase", 0, "lambertian").lit(white),
        "study": lambda: build_setting("study", 0, "lambertian").lit(white),
    }


def _seconds(scene: pm.Scene, method: str, options: Options) -> tuple[float, float]:
    """Return the seconds to `TARGET`, and the bias that was stated."""
    settings = {"bands": "rgb", "size": SIZE, "threads": options.threads, "method": method}
    ours.warm_up(scene, **settings)
    result, seconds = ours.render(scene, **settings, passes=PASSES)
    variance, bias = result.record["standard_error"] ** 2, result.record["bias"] or 0.0
    left = TARGET - bias**2
    return (seconds * variance / left if left > 0.0 else math.inf), bias
