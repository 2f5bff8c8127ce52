"""Cost of hard cases relative to the plain Cornell box: time per pass and peak memory."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import trimesh

import photonmap as pm
from benchmarks.harness.children import run_python
from benchmarks.harness.options import Options
from benchmarks.harness.table import Table
from benchmarks.harness.timing import interleave, ratio

SIZE, PASSES, REPEATS = (128, 128), 8, 3
TARGET = 3.0
GREY = pm.Material("grey", 0.5)
BOX = pm.scenes.cornell_box()
VIEW = pm.Camera((0.3, 0.2, 0.8), (-0.2, -0.1, -1.0), fov=70.0)

CHILD = """
import sys, warnings
warnings.simplefilter("ignore")
import photonmap as pm
from benchmarks.speed.hard import CASES, SETTINGS
pm.render(CASES[sys.argv[1]](), threads=int(sys.argv[2]), **SETTINGS)
"""
SETTINGS = {"bands": "rgb", "size": SIZE, "passes": PASSES, "photons": 16384}


def _room(reflectance: float, low: float = -1.0, high: float = 1.0, name: str = "room") -> pm.Mesh:
    box = trimesh.creation.box(bounds=[[low] * 3, [high] * 3])
    material = pm.Material(name, reflectance)
    return pm.Mesh(box.vertices, box.faces[:, ::-1], material, name)


def _slivers() -> pm.Scene:
    """Lay the box on a floor of 500 strips, every other one a millionth wide."""
    edges = np.sort(np.concatenate([x := np.linspace(-1.0, 1.0, 251), x[1:-1] + 1e-6]))
    vertices = np.array([(a, -1.0, z) for a in edges for z in (-1.0, 1.0)])
    first = np.arange(0, 2 * len(edges) - 2, 2)[:, None]
    faces = np.concatenate([first + [0, 1, 3], first + [0, 3, 2]])
    others = [mesh for mesh in BOX.meshes if mesh.name != "floor"]
    return replace(BOX, meshes=[*others, pm.Mesh(vertices, faces, GREY, "floor")])


def _doubled() -> pm.Scene:
    return replace(BOX, meshes=[*BOX.meshes, *BOX.meshes])


def _far() -> pm.Scene:
    """Put the box among blocks at a distance of 10⁷ times its size."""
    blocks = []
    for x in (-1e7, 1e7):
        block = trimesh.creation.box((1e6, 1e6, 1e6))
        blocks.append(pm.Mesh(block.vertices + [x, 0, x], block.faces, GREY, "block"))
    return replace(BOX, meshes=[*BOX.meshes, *blocks])


def _white() -> pm.Scene:
    return pm.Scene([_room(0.99)], [pm.PointLight((0, 0.5, 0))], VIEW)


def _rooms() -> pm.Scene:
    """Build two closed rooms; the one in view is lit 10¹⁰ times less brightly."""
    meshes = [_room(0.5), _room(0.5, 4.0, 7.0, "elsewhere")]
    lights = [pm.PointLight((0, 0.5, 0), 1e-10), pm.PointLight((5, 5.5, 5), 1.0)]
    return pm.Scene(meshes, lights, VIEW)


def _thousand() -> pm.Scene:
    """Put 999 lights in a closed room elsewhere, and one in view."""
    places = np.random.default_rng(0).uniform(5, 6, (999, 3))
    lights = [pm.PointLight(tuple(place)) for place in places]
    meshes = [_room(0.5), _room(0.5, 4.0, 7.0, "elsewhere")]
    return pm.Scene(meshes, [*lights, pm.PointLight((0, 0.5, 0))], VIEW)


def _pit() -> pm.Scene:
    """Dig a shaft 1000 times as deep as wide under the sky: paths take the place of photons."""
    shaft = trimesh.creation.box(bounds=[[-0.5, -1000.0, -0.5], [0.5, 0.0, 0.5]])
    faces = shaft.faces[shaft.face_normals[:, 1] < 0.5][:, ::-1]
    camera = pm.Camera((0.1, 3.0, 0.2), (0, -900, 0), (1, 0, 0), fov=20)
    return pm.Scene([pm.Mesh(shaft.vertices, faces, GREY)], [pm.DomeLight()], camera)


CASES: dict[str, Callable[[], pm.Scene]] = {
    "plain": lambda: BOX,
    "slivers": _slivers,
    "duplicated surfaces": _doubled,
    "objects 10⁷ scene sizes away": _far,
    "reflectance 0.99": _white,
    "light of 1e-10 beside 1": _rooms,
    "1000 lights, one matters": _thousand,
    "pit 1000 times as deep as wide": _pit,
}


def run(options: Options) -> list[Table]:
    """Render all cases, taking turns; measure the memory of each in a process of its own."""
    calls = {name: _renderer(make(), options.threads) for name, make in CASES.items()}
    rays = {name: call().record["rays"] for name, call in calls.items()}
    seconds = interleave(calls, REPEATS)
    table = Table(
        f"hard: {SIZE[0]}×{SIZE[1]}, RGB, {PASSES} passes of 16384 photons, relative to the box",
        ["case", "seconds", "time", "time per ray", "memory, MB", "memory"],
        notes=[f"rays of paths are not counted; target: ratios of at most {TARGET:g}"],
    )
    peaks = {name: _peak(name, options.threads) for name in CASES}
    for name, spent in seconds.items():
        median, times = float(np.median(spent)), ratio(spent, seconds["plain"])
        memory = peaks[name] / peaks["plain"]
        each = times * rays["plain"] / rays[name]
        table.rows.append([name, median, times, each, peaks[name] / 1e6, memory])
    return [table]


def _renderer(scene: pm.Scene, threads: int) -> Callable[[], pm.Result]:
    def render() -> pm.Result:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pm.SceneWarning)
            return pm.render(scene, threads=threads, **SETTINGS)  # type: ignore[arg-type]

    return render


def _peak(name: str, threads: int) -> int:
    return run_python(["-c", CHILD, name, str(threads)]).peak
