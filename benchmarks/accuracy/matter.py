"""Kinds of material, light and lens compared with Mitsuba 3, each in its own Cornell box."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray
from scipy import stats

import photonmap as pm
from benchmarks.accuracy.gloss_scenes import MATTER, write_scene
from benchmarks.accuracy.mitsuba_client import Mitsuba, start_mitsuba
from benchmarks.harness import ours
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table, skipped
from photonmap.film.relative_error import squared_norm

Floats = NDArray[np.float64]

CASES = (
    "mirror",
    "glass",
    "both",
    "rough-glass",
    "rough-metal",
    "point",
    "spot",
    "sun",
    "dome",
    "sky",
)
"""No coat: the blend of a diffuse surface and a mirror in Mitsuba 3.9 fails the white furnace. And
roughness only of α 0.01: what is scattered more than once is lost there, 0.9% of what a ball of
glass of α 0.05 sends in a furnace, 3.8% at 0.1 and 23% at 0.3; of metal 0.4%, 1.8% and 15%."""
SIZE, PASSES = 256, 48
SAMPLES, RENDERS = 128, 8
"""Samples per pixel of one Mitsuba render, and number of renders."""
BLOCK = 16
TARGET = 1e-2
"""relMSE for which the times are compared."""


def run(options: Options) -> list[Table]:
    """Compare mean radiance, blocks of pixels, and the time to a given error."""
    size = options.size[0] if options.size else SIZE
    table = Table(
        "",
        [
            "case",
            "difference in mean radiance, %",
            "its error %",
            f"{BLOCK}×{BLOCK} blocks, worst z",
            "expected",
            f"processor seconds to relMSE {TARGET:g}",
            "Mitsuba",
            "ratio",
        ],
        notes=[
            "relMSE from each renderer's own variance, extrapolated as 1 / time",
            f"{', '.join(MATTER)}: read from Mitsuba's file, with the reflectance by which surfaces"
            " reflect as much light from all around as there, where facets lose some",
        ],
    )
    variant = ""
    for case in _choose(options.scenes):
        with tempfile.TemporaryDirectory() as folder:
            file = write_scene(case, (size, size), Path(folder)) if case in MATTER else None
            scene = make_scene(case) if file is None else pm.load_scene(file)
            other = start_mitsuba(options, file or case, None if file else size)
            if isinstance(other, str):
                table.notes.append(f"{case}: {other}")
                continue
            with other:
                table.rows.append([case, *_compare(scene, other, size, options)])
                variant = f"Mitsuba {other.version}, {other.variant} path"
        print(f"matter: {', '.join(map(str, table.rows[-1]))}", flush=True)
    if not table.rows:
        return [skipped("matter", table.notes[-1])]
    table.title = f"matter: Cornell box with one thing changed, {size}×{size}, RGB, and {variant}"
    return [table]


def _choose(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the cases that are asked for."""
    every = (*CASES, *MATTER)
    unknown = [name for name in names if name not in every]
    if unknown:
        raise SystemExit(f"there is no case {unknown[0]!r}; choose from {', '.join(every)}")
    return names or every


def make_scene(case: str) -> pm.Scene:
    """Return the scene that has this name in `mitsuba_server`."""
    box = pm.scenes.cornell_box()
    meshes = [mesh for mesh in box.meshes if "box" not in mesh.name]
    things = {
        "mirror": [pm.scenes.ball((-0.3, -0.65, -0.2), pm.Material.polished("mirror", 0.9))],
        "glass": [pm.scenes.ball((0.3, -0.65, 0.1), pm.Material.glass())],
        "rough-glass": [pm.scenes.ball((0.3, -0.65, 0.1), pm.Material.glass(roughness=0.1))],
        "rough-metal": [pm.scenes.ball((-0.3, -0.65, -0.2), pm.Material.metal("metal", 1.0, 0.1))],
    }
    lights: dict[str, pm.Light] = {
        "point": pm.PointLight((0.3, 0.2, 0.4), (1.0, 1.0, 1.0)),
        "spot": pm.SpotLight((0.3, 0.8, 0.5), (-0.2, -1, -0.2), (2.0, 2.0, 2.0), 39.9, 40.0),
        "sun": pm.DirectionalLight((0.3, -0.5, -1.0), (2.0, 2.0, 2.0)),
        "dome": pm.DomeLight((1.0, 1.0, 1.0)),
        "sky": pm.EnvironmentLight(_sky()),
    }
    if case == "both":
        return pm.scenes.cornell_balls()
    if case in lights:
        meshes = [mesh for mesh in meshes if mesh.name != "light"]
        return replace(box, meshes=meshes, lights=[lights[case]])
    return replace(box, meshes=[*meshes, *things[case]])


def _sky() -> NDArray[np.float32]:
    rows, columns = np.mgrid[0:8, 0:16]
    return (np.stack([rows + 1.0, columns + 1.0, 9.0 - rows], axis=-1) / 8.0).astype(np.float32)


def _compare(
    scene: pm.Scene, other: Mitsuba, size: int, options: Options
) -> list[float | str | None]:
    ours.warm_up(scene, bands="rgb", size=(size, size), threads=options.threads)
    start = process_time()
    result, _ = ours.render(
        scene, bands="rgb", size=(size, size), passes=PASSES, threads=options.threads
    )
    seconds = process_time() - start
    images, times = [], []
    for seed in range(RENDERS):
        images.append(other.render(SAMPLES, seed + 1)[0])
        times.append(other.processor)
    truth = np.mean(images, axis=0, dtype=np.float64)
    variance = np.var(images, axis=0, ddof=1, dtype=np.float64)
    mean = float(result.radiance.mean(dtype=np.float64)) / float(truth.mean()) - 1.0
    error = np.sqrt((variance / RENDERS).sum()) / truth.sum()

    difference = _blocks(result.radiance - truth)
    spread = np.sqrt(
        _blocks(result.standard_error("radiance") ** 2.0 + variance / RENDERS) / BLOCK**2
    )
    z = float(np.abs(difference / np.maximum(spread, 1e-12)).max())
    expected = float(stats.t.isf(0.5 / difference.size, RENDERS - 1))

    norm = squared_norm(truth, truth.mean(axis=(0, 1)))
    own = seconds * float((result.standard_error("radiance") ** 2.0 / norm).mean()) / TARGET
    theirs = float(np.mean(times)) * float((variance / norm).mean()) / TARGET
    return [100.0 * mean, 100.0 * error, z, expected, own, theirs, theirs / own]


def _blocks(image: Floats) -> Floats:
    """Return means over blocks of pixels."""
    height, width, bands = image.shape
    shape = height // BLOCK, BLOCK, width // BLOCK, BLOCK, bands
    return image.astype(np.float64).reshape(shape).mean(axis=(1, 3))
