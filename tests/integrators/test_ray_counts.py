"""The rays that passes count are those that Embree is asked for, and the record says so."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
COUNTED = """
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import trimesh

import photonmap as pm
from photonmap.compile.scene_arrays import compile_scene
from photonmap.integrators.base import PassSetup
from photonmap.integrators.choice import make_integrator
from photonmap.integrators.photon_mapping import cache_cells, caustics, pilot
from photonmap.kernels.caustics import photon_map
from photonmap.kernels.core.passes import Film
from photonmap.kernels.geometry import ray
from photonmap.runtime.workers import Workers
from photonmap.spectra.bands import Bands

caustics.PILOT = cache_cells.PILOT = 128
caustics.LINGER_PILOT_PHOTONS = pilot.PILOT = 64
photon_map.LONGEST_CHAIN = 2  # glass lets photons through in two steps: their chains are cut
calls = {"rtcIntersect1": 0, "rtcOccluded1": 0}


def counted(name):
    function = getattr(library, name)

    def call(*arguments):
        calls[name] += 1
        return function(*arguments)

    return call


library = ray.LIBRARY
ray.LIBRARY = SimpleNamespace(**{name: counted(name) for name in calls})
room = pm.scenes.cornell_box()
shape = trimesh.creation.icosphere(1, 0.3)
looks = pm.Material.glass(), pm.Material.polished(), pm.Material.metal("metal", 0.9, 0.3)
balls = [
    pm.Mesh(shape.vertices + [x, 0.3, 0.2], shape.faces, look, f"ball {x}")
    for x, look in zip((-0.6, 0.1, 0.6), looks)
]
room = replace(room, meshes=[*room.meshes, *balls])
compiled = compile_scene(room, Bands.parse("rgb"))
with Workers(1) as workers, np.errstate(over="ignore"):
    setup = PassSetup(compiled, Film(3, 2, True), 3, 100, 1, workers)
    for method in ("photon", "path"):
        integrator = make_integrator(method, setup)
        integrator.estimate(0)
        before = dict(integrator.counters.rays_by_kind)
        calls.update(dict.fromkeys(calls, 0))
        integrator.estimate(1)
        rays = {kind: n - before[kind] for kind, n in integrator.counters.rays_by_kind.items()}
        shadow = rays.pop("shadow")
        assert calls["rtcOccluded1"] == shadow > 0, (calls, shadow)
        assert calls["rtcIntersect1"] == sum(rays.values()), (calls, rays)
        print(*sorted(rays))
"""


def test_every_ray_is_counted_once():
    """Run as plain Python, where calls of Embree can be counted."""
    done = subprocess.run(
        [sys.executable, "-c", COUNTED],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    photon, path = done.stdout.splitlines()
    assert photon == "camera caustic gather photon specular walk"
    assert path == "camera path specular"
