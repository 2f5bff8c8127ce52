"""What many views of a scene cost by `render_views`, against so many renders."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

import photonmap as pm
from benchmarks.accuracy.room_scenes import scenes
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table

NAMES, SIZES = ("box", "kitchen", "living_room", "box-balls"), ((160, 120), (320, 240))
BUDGETS: dict[str, dict[str, Any]] = {"10%": {"error": 0.1}, "16 passes": {"passes": 16}}
VIEWS = 16
YAWS = (-6.0, 0.0, 6.0)
"""Degrees by which the cameras that are measured turn about the scene."""


def run(options: Options) -> list[Table]:
    """Render three views together, in turns with each alone, with one thread; extrapolate to 16."""
    columns = ["scene", "size", "budget", "alone, s", "first view", "later views", "16 views"]
    table = Table("views: processor time against renders one by one, RGB", columns)
    for name in options.scenes or NAMES:
        scene = scenes()[name][0]()
        for size in (options.size,) if options.size else SIZES:
            for budget, given in BUDGETS.items():
                together, alone = _measure(scene, {"size": size, **given})
                first = together[0] / alone[0]
                later = together[1:].sum() / alone[1:].sum()
                ratios = first, later, (first + (VIEWS - 1) * later) / VIEWS
                table.rows.append([name, f"{size[0]}×{size[1]}", budget, alone.mean(), *ratios])
    return [table]


def _measure(scene: pm.Scene, given: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the processor seconds of each view together with others, and alone."""
    settings = {"bands": "rgb", "threads": 1, **given}
    cameras = [_turned(scene.camera, yaw) for yaw in YAWS]
    next(pm.render_views(scene, cameras, bands="rgb", threads=1, size=(16, 12), passes=1))
    views, spent = pm.render_views(scene, cameras, **settings), []
    for camera in cameras:
        start = time.process_time()
        view = next(views)
        between = time.process_time()
        alone = pm.render(replace(scene, camera=camera), **settings)
        spent.append((between - start, time.process_time() - between))
        if not np.array_equal(view.radiance, alone.radiance):
            raise RuntimeError("a view differs from its own render")
    together, apart = np.array(spent).T
    return together, apart


def _turned(camera: pm.Camera, yaw: float) -> pm.Camera:
    """Return a camera that is turned by degrees about its target."""
    sine, cosine = np.sin(np.radians(yaw)), np.cos(np.radians(yaw))
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    target = np.array(camera.target)
    origin = target + turn @ (np.array(camera.origin) - target)
    return replace(camera, origin=tuple(origin.tolist()))
