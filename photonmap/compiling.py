"""Compile the kernels that a render needs, before it."""

from __future__ import annotations

import pickle
import shutil
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from photonmap.bands import Bands
from photonmap.columns import Columns
from photonmap.errors import warn
from photonmap.first_hits import first_hit_buffers
from photonmap.hidden_lights import warn_of_hidden_lights
from photonmap.kernels.jit import CACHE_FOLDER
from photonmap.kernels.records import Film
from photonmap.ledger import Ledger
from photonmap.lights import EnvironmentLight, Light, PointLight
from photonmap.passes import PROBE, Passes, stream_key
from photonmap.prepare import Prepared, prepare
from photonmap.scene import Camera, Material, Mesh, Scene
from photonmap.textures import stand_ins
from photonmap.workers import Workers

Method = Literal["photon", "path"]

_FILM = Film(1, 1, True)
_PHOTONS = 1024
"""Enough that some land: otherwise paths would take their place."""


def is_compiled(wanted: Prepared, method: Method) -> bool:
    """Tell whether all kernels that a scene needs were compiled before on this machine."""
    return _marker(wanted, method).exists()


def compile_kernels(wanted: Prepared, bands: Bands, workers: Workers, method: Method) -> None:
    """Call every kernel that `wanted` needs; anew where the cache of before cannot be read."""
    try:
        _call_kernels(wanted, bands, workers, method)
    except (pickle.UnpicklingError, EOFError):
        warn(f"the cache of compiled kernels, {CACHE_FOLDER}, is damaged, and made anew")
        shutil.rmtree(CACHE_FOLDER, ignore_errors=True)
        _call_kernels(wanted, bands, workers, method)
    with suppress(OSError):  # a cache that cannot be written is no reason to stop
        CACHE_FOLDER.mkdir(parents=True, exist_ok=True)
        _marker(wanted, method).touch()


def _call_kernels(wanted: Prepared, bands: Bands, workers: Workers, method: Method) -> None:
    """Call every kernel that `wanted` needs, on one pixel of a scene of one triangle."""
    prepared = prepare(_smallest(wanted), bands)
    run = Passes(prepared, _FILM, bands.count, _PHOTONS, 0, workers, method)
    columns = Columns(np.arange(bands.count))
    moments = Ledger(columns, 1, workers, prepared.optics is not None)
    moments.add(run.run(0), run.seen)
    moments.add(run.run(1), run.seen)
    moments.whole.error()
    moments.finish(1.0)
    warn_of_hidden_lights(prepared, _FILM, stream_key(0, 0, PROBE))
    first_hit_buffers(prepared, _FILM, workers)


def _smallest(wanted: Prepared) -> Scene:
    """Return a scene of one triangle that needs the same kernels."""
    triangle = Mesh(np.eye(3) - [0.0, 0.0, 1.0], np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    light: Light = PointLight((1.0, 1.0, 1.0))
    if wanted.lights.environment is not None:
        light = EnvironmentLight(np.ones((1, 2, 3)))
    material = Material(reflectance=0.4, mirror=0.4) if wanted.optics is not None else Material()
    triangle = replace(triangle, material=replace(material, **stand_ins(wanted)))
    return Scene([triangle], [light], Camera((1.0, 1.0, 1.0), (0.3, 0.3, -0.7)))


def _marker(wanted: Prepared, method: Method) -> Path:
    """Return the empty file that tells of what is in the cache."""
    parts = [method, *sorted(stand_ins(wanted))]
    parts += ["sky"] * (wanted.lights.environment is not None)
    parts += ["smooth"] * (wanted.optics is not None)
    return CACHE_FOLDER / ("compiled-" + "-".join(parts))
