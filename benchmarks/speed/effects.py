"""Time saved by leaving out effects that scenes do not call for."""

from __future__ import annotations

import statistics
from typing import Any

import numpy as np
import trimesh

import photonmap as pm
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from photonmap.compile.effects import EFFECTS

SIZE, PASSES, REPEATS = (256, 256), 8, 3


def run(options: Options) -> list[Table]:
    """Render each scene with its own plan and with an effect forced on, taking turns."""
    table = Table(
        f"effects: seconds for {PASSES} passes, 256×256 (medians of {REPEATS})",
        ["effect left out", "scene", "with it", "without", "saved, %", "rays with", "without"],
    )
    settings: dict[str, Any] = {"size": SIZE, "passes": PASSES, "threads": options.threads}
    for effect, name, scene, forced, more in _cases():
        spent: dict[str, list[float]] = {"auto": [], "forced": []}
        rays = {}
        for plan in ("auto", forced):
            pm.render(scene, **{**settings, **more, "passes": 1}, effects=plan)
        for _ in range(REPEATS):
            for label, plan in (("auto", "auto"), ("forced", forced)):
                result, seconds = ours.render(scene, **settings, **more, effects=plan)
                spent[label].append(seconds)
                rays[label] = float(result.record["rays"])
        without, with_it = (statistics.median(spent[label]) for label in ("auto", "forced"))
        saved = 100.0 * (1.0 - without / with_it)
        table.rows.append([effect, name, with_it, without, saved, rays["forced"], rays["auto"]])
    return [table]


def _cases() -> list[tuple[str, str, pm.Scene, str | list[str], dict[str, Any]]]:
    camera = pm.Camera((0.8, 1.2, 3.0), (0, 0, 0), fov=40)
    sun = pm.DirectionalLight((0.2, -1.0, -0.6), 3.0)
    ball = pm.Mesh.from_trimesh(trimesh.creation.icosphere(4), smooth=True)
    one = pm.Scene([ball], [sun], camera)
    floor = pm.Mesh(
        np.array([[-3, -1, -3], [-3, -1, 3], [3, -1, 3], [3, -1, -3]]), [[0, 1, 2], [0, 2, 3]]
    )
    grey = pm.Scene([ball, floor], [sun], camera)
    apart = [effect for effect in EFFECTS if effect != "band_merging"]
    return [
        ("indirect", "a ball in the sun", one, "all", {"bands": 6}),
        ("band_merging off", "grey ball and floor, 31 bands", grey, apart, {"bands": 31}),
        ("soft_shadows", "grey ball and floor in the sun", grey, "all", {"bands": "rgb"}),
        (
            "caustics, specular",
            "Cornell box",
            pm.scenes.cornell_box(),
            "all",
            {"bands": "rgb"},
        ),
    ]
