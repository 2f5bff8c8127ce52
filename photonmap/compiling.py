"""Compile the kernels that a render needs, before it."""

from __future__ import annotations

import pickle
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from photonmap.bands import Bands
from photonmap.caustics import no_caustics
from photonmap.columns import Columns
from photonmap.errors import warn
from photonmap.first_hits import first_hit_buffers
from photonmap.hidden_lights import warn_of_hidden_lights
from photonmap.kernels.jit import CACHE_FOLDER
from photonmap.kernels.records import Film, Plan
from photonmap.ledger import Ledger
from photonmap.light_tree import FEW
from photonmap.lights import EnvironmentLight, Light, PointLight
from photonmap.passes import PROBE, Passes, empty_pixels, empty_store, stream_key
from photonmap.prepare import Prepared, prepare
from photonmap.scene import Camera, Material, Mesh, Scene
from photonmap.textures import stand_ins
from photonmap.workers import Workers

Method = Literal["photon", "path"]

_FILM = Film(1, 1, True)
_at_hand: set[Path] = set()
"""Markers of the kernels that this process has called"""
_PHOTONS = 1024
"""Enough that some land: otherwise paths would take their place."""


def is_compiled(wanted: Prepared, method: Method) -> bool:
    """Tell whether all kernels that a scene needs were compiled before on this machine."""
    return _marker(wanted, method).exists()


def compile_kernels(wanted: Prepared, bands: Bands, workers: Workers, method: Method) -> None:
    """Call every kernel that `wanted` needs; anew where the cache of before cannot be read.

    The first time, a second process compiles what comes before and after the camera pass; in a
    process that has called them, they are there.
    """
    marker = _marker(wanted, method)
    if marker in _at_hand:
        return
    small = _smallest(wanted)
    if workers.threads > 1 and not is_compiled(wanted, method):
        with _aside(small, bands, method):
            _look(small, bands, workers, method)
    try:
        _call_kernels(small, bands, workers, method)
    except (pickle.UnpicklingError, EOFError):
        warn(f"the cache of compiled kernels, {CACHE_FOLDER}, is damaged, and made anew")
        shutil.rmtree(CACHE_FOLDER, ignore_errors=True)
        _call_kernels(small, bands, workers, method)
    with suppress(OSError):  # a cache that cannot be written is no reason to stop
        CACHE_FOLDER.mkdir(parents=True, exist_ok=True)
        marker.touch()
    _at_hand.add(marker)


def _call_kernels(small: Scene, bands: Bands, workers: Workers, method: Method) -> None:
    _call_around(small, bands, workers, method)
    _look(small, bands, workers, method)


def _look(small: Scene, bands: Bands, workers: Workers, method: Method) -> None:
    """Call the kernel of the camera pass."""
    prepared = prepare(small, bands)
    run = Passes(prepared, _FILM, bands.count, _PHOTONS, 0, workers, method)
    run.plan = Plan(*np.ones((3, 1), np.uint8), np.ones(1, np.float32))
    caustics = None if prepared.optics is None else no_caustics(bands.count)
    run.look(0, empty_store(bands.count), caustics)


def _call_around(small: Scene, bands: Bands, workers: Workers, method: Method) -> None:
    """Call all other kernels."""
    prepared = prepare(small, bands)
    run = Passes(prepared, _FILM, bands.count, _PHOTONS, 0, workers, method)
    moments = Ledger(Columns(np.arange(bands.count)), _FILM, workers, prepared.optics is not None)
    for index in range(2):
        run.illuminate(index)
        moments.add(run.finish(index, empty_pixels(1, bands.count)), run.seen)
    for percentile in (None, 50.0):
        moments.whole.error(percentile=percentile)
    moments.finish(1.0)
    warn_of_hidden_lights(prepared, _FILM, stream_key(0, 0, PROBE))
    first_hit_buffers(prepared, _FILM, workers)


@contextmanager
def _aside(small: Scene, bands: Bands, method: Method) -> Iterator[None]:
    """Compile in a process of its own what `_call_around` calls; wait for it at the end.

    What it fails to do is done afterwards in this process.
    """
    code = "import sys; sys.path[:] = %r; from photonmap.compiling import serve; serve()"
    process = subprocess.Popen(
        [sys.executable, "-c", code % sys.path],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert process.stdin is not None
        with suppress(OSError), process.stdin as pipe:
            pickle.dump((small, bands, method), pipe)
        yield
        process.wait()
    finally:
        process.kill()
        process.wait()


def serve() -> None:
    """Compile what `_aside` sends to standard input."""
    small, bands, method = pickle.load(sys.stdin.buffer)
    with Workers(1) as workers:
        _call_around(small, bands, workers, method)


def _smallest(wanted: Prepared) -> Scene:
    """Return a scene of one triangle that needs the same kernels."""
    triangle = Mesh(np.eye(3) - [0.0, 0.0, 1.0], np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    lights: list[Light] = [PointLight((1.0, 1.0, 1.0))]
    if wanted.lights.tree is not None:
        lights *= FEW
    if wanted.lights.environment is not None:
        lights.append(EnvironmentLight(np.ones((1, 2, 3))))
    material = Material(reflectance=0.4, mirror=0.4) if wanted.optics is not None else Material()
    triangle = replace(triangle, material=replace(material, **stand_ins(wanted)))
    return Scene([triangle], lights, Camera((1.0, 1.0, 1.0), (0.3, 0.3, -0.7)))


def _marker(wanted: Prepared, method: Method) -> Path:
    """Return the empty file that tells of what is in the cache."""
    parts = [method, *sorted(stand_ins(wanted))]
    parts += ["sky"] * (wanted.lights.environment is not None)
    parts += ["tree"] * (wanted.lights.tree is not None)
    parts += ["smooth"] * (wanted.optics is not None)
    return CACHE_FOLDER / ("compiled-" + "-".join(parts))
