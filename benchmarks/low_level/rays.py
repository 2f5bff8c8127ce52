"""The renderer's ray call, relative to bare loops over rtcIntersect1."""

from __future__ import annotations

import statistics
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

import photonmap as pm
from benchmarks.harness.options import Options
from benchmarks.harness.shapes import bumpy_sphere
from benchmarks.harness.table import Cell, Table
from benchmarks.harness.timing import interleave, ratio
from benchmarks.low_level import ray_loops
from photonmap.compile.scene_arrays import compile_scene
from photonmap.kernels.geometry.embree import EmbreeScene
from photonmap.spectra.bands import Bands

TARGET = 0.85
RAYS = 1 << 17
REPEATS = 21


def run(options: Options) -> list[Table]:
    """Cast the same random rays with all loops, on one thread and on all threads."""
    table = Table(
        f"rays: {RAYS} random closest-hit rays, millions per second (medians of {REPEATS})",
        [
            "triangles",
            "threads",
            "bare, Numba",
            "bare, C",
            "renderer",
            "relative to Numba",
            "relative to C",
        ],
        notes=[f"target: at least {TARGET:.0%} of a bare loop; results are the same bit for bit"],
    )
    room = compile_scene(pm.scenes.cornell_box(), Bands.parse("rgb"))
    corners = room.geometry.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    origins = np.random.default_rng(1).uniform(low, high, (RAYS, 3))
    _measure(table, len(room.geometry.triangles), room.embree, origins, options)
    for triangles in (80_000, 1_000_000):
        vertices, faces = bumpy_sphere(triangles)
        origins = np.random.default_rng(2).uniform(-0.55, 0.55, (RAYS, 3))
        scene = EmbreeScene(vertices.astype(np.float32), faces.astype(np.uint32))
        _measure(table, len(faces), scene, origins, options)
    return [table]


def _measure(
    table: Table, triangles: int, scene: EmbreeScene, origins: NDArray[np.float64], options: Options
) -> None:
    """Add a row for one thread, and one for all threads."""
    rng = np.random.default_rng(3)
    directions = rng.standard_normal(origins.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
    fresh, records = ray_loops.make_records(rays), ray_loops.make_records(rays)
    found, places = np.empty(RAYS, np.int32), np.empty((RAYS, 2), np.float32)
    address = scene.address
    loops = {
        "numba": lambda a, b: ray_loops.bare_loop(address, records.ctypes.data, a, b),
        "c": ray_loops.c_loop(address, records),
        "renderer": lambda a, b: ray_loops.renderer_loop(address, rays, a, b, found, places),
    }
    loops = {name: loop for name, loop in loops.items() if loop}
    for threads in sorted({1, options.threads}):
        seconds = _time(loops, threads, fresh, records)
        ray_loops.check_same(records, found, places)
        rates: list[Cell] = [
            RAYS / statistics.median(seconds[name]) / 1e6 if name in seconds else "no compiler"
            for name in ("numba", "c", "renderer")
        ]
        shares: list[Cell] = [
            ratio(seconds[name], seconds["renderer"]) if name in seconds else None
            for name in ("numba", "c")
        ]
        table.rows.append([triangles, threads, *rates, *shares])


def _time(
    loops: dict, threads: int, fresh: NDArray[np.uint32], records: NDArray[np.uint32]
) -> dict[str, list[float]]:
    """Time the loops over all rays, taking turns, with one equal part per thread."""
    ends = [RAYS * part // threads for part in range(threads + 1)]
    with ThreadPoolExecutor(threads) as pool:

        def everywhere(loop):
            return lambda: list(pool.map(loop, ends[:-1], ends[1:]))

        def restore():
            records[:] = fresh

        calls = {name: everywhere(loop) for name, loop in loops.items()}
        return interleave(calls, REPEATS, restore)
