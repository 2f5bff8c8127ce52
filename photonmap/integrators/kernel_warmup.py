"""Compile the kernels that a render needs, before it."""

from __future__ import annotations

import gc
import hashlib
import itertools
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

import numba
import numpy as np

from photonmap.buffers import BUFFERS
from photonmap.compile.scene_arrays import CompiledScene, compile_scene, variant_of
from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.errors import InputError
from photonmap.film.light_filter import FILTERED, LEAST_PASSES, LightFilter
from photonmap.film.light_groups import LightGroups
from photonmap.integrators.base import PassSetup
from photonmap.integrators.choice import make_integrator
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.integrators.missing_light import find_hidden_lights
from photonmap.kernels.core.code_cache import CODE_FOLDER, SHIPPED_FOLDER, is_lost, processors
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.kernels.core.passes import Film
from photonmap.kernels.core.streams import Domain
from photonmap.runtime.workers import Workers
from photonmap.scene.camera import Camera
from photonmap.scene.lights import PointLight
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands
from photonmap.spectra.curves import Spectrum
from photonmap.spectra.fluorescence import Fluorescence

_FILM = Film(1, 1, True)
_NEAR = (0.4, 0.4, -0.6)
"""So near the triangle that half of the photons hit it: else paths would take their place."""
_APART = 2.0
"""Between the triangles, so that neither lies in the glass of the other."""
_PHOTONS = 1024
"""Photons: enough that some hit, as paths would take their place."""
_RARELY = (100_000, 50, 100)
"""Thresholds of the garbage collector: compiling makes millions of objects that stay alive, and
scanning them over and over took a seventh of its time."""


_in_memory: set[str] = set()
"""Marks of what this process compiled, wherever it could not be kept."""


def is_compiled(wanted: CompiledScene, method: str) -> bool:
    """Return whether all kernels that a scene needs were compiled before on this machine."""
    places = itertools.product((CODE_FOLDER, SHIPPED_FOLDER), processors())
    return any((folder / _mark(wanted, method, name)).exists() for folder, (name, _) in places)


@contextmanager
def _rare_collections() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(*_RARELY)
    try:
        yield
    finally:
        gc.set_threshold(*before)


@_rare_collections()
def compile_kernels(wanted: CompiledScene, bands: Bands, workers: Workers, method: str) -> None:
    """Call every kernel that `wanted` needs, if that was never done on this machine.

    A second process compiles what comes before and after the camera pass.
    """
    mark = _mark(wanted, method, processors()[0][0])
    if mark in _in_memory or is_compiled(wanted, method):
        return
    small = _smallest(variant_of(wanted.arrays))
    if workers.threads > 1:
        with _aside(small, bands, method):
            _compile_camera_pass(small, bands, workers, method)
    _compile_all(small, bands, workers, method)
    _in_memory.add(mark)
    if not is_lost.is_set():
        with suppress(OSError):  # a cache that cannot be written is no reason to stop
            CODE_FOLDER.mkdir(parents=True, exist_ok=True)
            (CODE_FOLDER / mark).touch()


def _compile_all(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    _compile_other_kernels(small, bands, workers, method)
    _compile_camera_pass(small, bands, workers, method)


def _setup(small: Scene, bands: Bands, workers: Workers) -> PassSetup:
    return PassSetup(compile_scene(small, bands), _FILM, bands.count, _PHOTONS, 0, workers)


def _compile_camera_pass(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    """Compile the kernel of the camera pass."""
    make_integrator(method, _setup(small, bands, workers)).compile_camera_pass()


def _compile_other_kernels(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    """Compile all other kernels."""
    setup = _setup(small, bands, workers)
    columns = SpectralColumns(np.arange(bands.count))
    compiled = setup.compiled
    integrator, plane = make_integrator(method, setup), np.zeros((1, 7), np.float32)
    light_filter = LightFilter(FILTERED, _FILM, workers, lambda: plane)
    moments = LightGroups(
        columns,
        _FILM,
        workers,
        compiled.has_residual,
        fluorescent=compiled.fluorescence is not None,
        light_filter=light_filter if integrator.shares else None,
    )
    estimate = integrator.compile_other_kernels()
    for _ in range(LEAST_PASSES):
        moments.add(estimate.pixels, estimate.via_specular)
    for percentile in (None, 50.0):
        moments.whole.error(percentile=percentile)
    moments.finish(1.0)
    key = setup.key(0, Domain.LIGHT_VISIBILITY)
    find_hidden_lights(setup.compiled, setup.view, key)
    first_hit_buffers(setup.compiled, _FILM, workers, BUFFERS)


@contextmanager
def _aside(small: Scene, bands: Bands, method: str) -> Iterator[None]:
    """Do `_compile_other_kernels` in another process; what fails there is done again afterwards."""
    code = (
        "import sys; sys.path[:] = %r;"
        "import photonmap.integrators.kernel_warmup as warmup; warmup.serve()"
    )
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


@_rare_collections()
def serve() -> None:
    """Compile what `_aside` sends to standard input."""
    small, bands, method = pickle.load(sys.stdin.buffer)
    with Workers(1) as workers:
        _compile_other_kernels(small, bands, workers, method)


def _smallest(variant: str) -> Scene:
    """Return a scene of few triangles that needs a variant of kernels."""
    triangle = Mesh(np.eye(3) - [0.0, 0.0, 1.0], np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    grey = Texture.of(np.full((1, 1), 0.4))
    meshes = [replace(triangle, material=Material(reflectance=0.4 if variant == "plain" else grey))]
    if variant in ("full", "fluorescent"):
        glass = Material.glass()
        meshes.append(replace(triangle, vertices=triangle.vertices - _APART, material=glass))
    if variant == "fluorescent":
        violet, red = (Spectrum([450.0, 650.0], values) for values in ((1.0, 0.0), (0.0, 1.0)))
        glowing = Material(fluorescence=Fluorescence(violet, red, 0.5))
        meshes.append(replace(triangle, vertices=triangle.vertices + _APART, material=glowing))
    return Scene(meshes, [PointLight(_NEAR)], Camera((1.0, 1.0, 1.0), (0.3, 0.3, -0.7)))


def _mark(wanted: CompiledScene, method: str, processor: str) -> str:
    """Return the name of the empty file that says what is compiled: types of records decide it."""
    what = CACHE_FOLDER.name, processor, str(numba.typeof(wanted.arrays))
    return f"{method}-{hashlib.sha256(repr(what).encode()).hexdigest()[:16]}"


def compile_variant(variant: str, method: str) -> None:
    """Compile, in one process, all kernels of a variant and an integrator.

    An `InputError` says that the folder does not take them.
    """
    bands = Bands.rgb()
    with Workers(1) as workers:
        compile_kernels(compile_scene(_smallest(variant), bands), bands, workers, method)
    if is_lost.is_set():
        problem = "does not take the compiled kernels"
        raise InputError(f"{problem}; make room on its disk, or choose another", CODE_FOLDER)


def describe_compiled() -> str:
    """Return a line about the machine code that was compiled here: for what, how much, where."""
    size = sum(file.stat().st_size for file in CODE_FOLDER.iterdir()) / 1e6
    return f"kernels for {processors()[0][0]}, {size:.1f} MB: {CODE_FOLDER}"
