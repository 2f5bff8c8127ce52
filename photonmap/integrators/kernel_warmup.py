"""Compile the kernels that a render needs, before it."""

from __future__ import annotations

import gc
import hashlib
import pickle
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np

from photonmap.buffers import BUFFERS
from photonmap.compile.camera import has_optics
from photonmap.compile.lights.light_tree import TREE_FROM
from photonmap.compile.scene_arrays import CompiledScene, compile_scene
from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.errors import warn
from photonmap.film.light_groups import LightGroups
from photonmap.integrators.base import PassSetup
from photonmap.integrators.choice import make_integrator
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.integrators.light_visibility import find_hidden_lights
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.kernels.core.passes import Film
from photonmap.kernels.core.records import Scattering, SceneArrays, Specular
from photonmap.kernels.core.streams import Domain
from photonmap.runtime.workers import Workers
from photonmap.scene.camera import Camera
from photonmap.scene.lens import Lens
from photonmap.scene.lights import (
    DirectionalLight,
    EnvironmentLight,
    Light,
    PhotometricLight,
    PointLight,
)
from photonmap.scene.material import Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.scene import Scene
from photonmap.scene.surfaces.relief import BumpMap
from photonmap.scene.surfaces.spectral_texture import SpectralTexture
from photonmap.scene.textures import Texture
from photonmap.spectra.bands import Bands

_FILM = Film(1, 1, True)
_NEAR = (0.4, 0.4, -0.6)
"""So near the triangle that half of the photons hit it: else paths would take their place."""
_APART = 2.0
"""Between stand-ins, so that none lies in the glass of another."""
_GREY, _BLACK = Texture.of(np.full((1, 1), 0.4)), Texture.of(np.zeros((1, 1)))
_PALETTE = SpectralTexture.from_palette(np.zeros((1, 1), np.int32), [0.4])
_LIGHTS: dict[str, Light] = {
    "environment": EnvironmentLight(np.ones((1, 2, 3))),
    "profiles": PhotometricLight(_NEAR, np.ones((2, 2))),
    "portals": DirectionalLight((-1.0, -1.0, -1.0)),
}
"""Lights that need the same code as those of a scene, by the field of `Lights` that holds theirs"""
_at_hand: set[Path] = set()
"""Markers of the kernels that this process has called"""
_PHOTONS = 1024
"""Photons: enough that some hit, as paths would take their place."""
_RARELY = (100_000, 50, 100)
"""Thresholds of the garbage collector: compiling makes millions of objects that stay alive, and
scanning them over and over took a seventh of its time."""


def is_compiled(wanted: CompiledScene, method: str) -> bool:
    """Return whether all kernels that a scene needs were compiled before on this machine."""
    return _marker(wanted, method).exists()


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
    """Call every kernel that `wanted` needs; once more if the cache cannot be read.

    The first time, a second process compiles what comes before and after the camera pass.
    """
    marker = _marker(wanted, method)
    if marker in _at_hand:
        return
    small = _smallest(wanted)
    if workers.threads > 1 and not is_compiled(wanted, method):
        with _aside(small, bands, method):
            _compile_camera_pass(small, bands, workers, method)
    try:
        _compile_all(small, bands, workers, method)
    except (pickle.UnpicklingError, EOFError):
        warn(f"the cache of compiled kernels, {CACHE_FOLDER}, is damaged and will be rebuilt")
        shutil.rmtree(CACHE_FOLDER, ignore_errors=True)
        _compile_all(small, bands, workers, method)
    with suppress(OSError):  # a cache that cannot be written is no reason to stop
        CACHE_FOLDER.mkdir(parents=True, exist_ok=True)
        marker.touch()
    _at_hand.add(marker)


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
    moments = LightGroups(columns, _FILM, workers, setup.compiled.has_residual)
    estimate = make_integrator(method, setup).compile_other_kernels()
    for _ in range(2):
        moments.add(estimate.pixels, estimate.via_specular)
    for percentile in (None, 50.0):
        moments.whole.error(percentile=percentile)
    moments.finish(1.0)
    key = setup.key(0, Domain.LIGHT_VISIBILITY)
    find_hidden_lights(setup.compiled, setup.view, key)
    first_hit_buffers(setup.compiled, _FILM, workers, BUFFERS)


@contextmanager
def _aside(small: Scene, bands: Bands, method: str) -> Iterator[None]:
    """Compile in a process of its own what `_compile_other_kernels` does; wait for it at the end.

    What it fails to do is done afterwards in this process.
    """
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


def _smallest(wanted: CompiledScene) -> Scene:
    """Return a scene of few triangles that needs the same kernels."""
    triangle = Mesh(np.eye(3) - [0.0, 0.0, 1.0], np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    lights: list[Light] = [PointLight(_NEAR)]
    if wanted.lights.tree is not None:
        lights *= TREE_FROM
    lights += [light for name, light in _LIGHTS.items() if getattr(wanted.lights, name) is not None]
    lens = Lens(1.0, 0.01) if has_optics(wanted.camera) else None
    meshes = [
        replace(triangle, vertices=triangle.vertices - _APART * place, material=material)
        for place, material in enumerate(_stand_ins(wanted))
    ]
    if wanted.lights.portals is not None:
        meshes.append(_portal(triangle))
    return Scene(meshes, lights, Camera((1.0, 1.0, 1.0), (0.3, 0.3, -0.7), lens=lens))


def _portal(triangle: Mesh) -> Mesh:
    """Return a portal that lets light onto the front of a triangle: hidden light is warned of."""
    opening = Material("portal", 0.0, portal=True)
    return replace(
        triangle,
        vertices=triangle.vertices + _APART,
        faces=triangle.faces[:, ::-1],
        material=opening,
    )


def _stand_ins(wanted: CompiledScene) -> Iterator[Material]:
    """Yield materials that together need the records that those of a scene need."""
    yield _painted(wanted)
    alpha, specular, scattering = wanted.geometry.alpha, wanted.specular, wanted.scattering
    if alpha is not None and alpha.panes is not None:
        yield replace(Material.pane(), tint=0.5 if alpha.panes.maps is None else _GREY)
    if specular is not None:
        yield from _chained(specular)
    if scattering is not None:
        yield from _glossy(scattering)


def _painted(wanted: CompiledScene) -> Material:
    """Return one for all that any surface may have.

    It is not an emitter, none of whose own light could be seen.
    """
    textures, geometry = wanted.textures, wanted.geometry
    has_palettes = textures is not None and textures.palettes is not None
    needs: tuple[tuple[str, Any, object], ...] = (
        ("reflectance", textures, _PALETTE if has_palettes else _GREY),
        ("emission", wanted.lights.emission_textures, _BLACK),
        ("alpha", geometry.alpha, 0.5),
        ("diffuse_roughness", wanted.scattering, 0.5),
        ("relief", geometry.relief, BumpMap(_GREY)),
        ("mirror", wanted.specular, 0.4),
    )
    values: dict[str, Any] = {name: value for name, record, value in needs if record is not None}
    return replace(Material(reflectance=0.4), **values)


def _chained(specular: Specular) -> Iterator[Material]:
    """Yield one for each record of glass and of metals that are nearly mirrors."""
    if specular.alpha is not None:
        anisotropy = 0.0 if specular.anisotropy is None else 0.5
        yield replace(Material.glass(roughness=0.5), anisotropy=anisotropy)
    if specular.dip is not None:
        yield replace(Material.metal(glossy=0.4, roughness=0.1), glossy_edge=0.5)
    if specular.grazing is not None:
        yield Material.metal(glossy=0.4, roughness=0.0)
    if specular.maps is not None:
        yield replace(Material.glass(), tint=_GREY)
    if specular.share is not None:
        share = 0.5 if specular.share.maps is None else _GREY
        yield replace(Material.glass(), reflectance=0.4, transmission=share)
    if (media := specular.media) is not None:
        glass = replace(Material.glass(), outside=1.2)
        if media.absorption is not None:
            glass = replace(glass, attenuation_color=0.5, attenuation_distance=1.0)
        yield glass if media.dispersion is None else replace(glass, abbe=50.0)


def _glossy(scattering: Scattering) -> Iterator[Material]:
    """Yield one each for lobes by image, clear coats and sheen, and one for the other records."""
    plastic = Material.plastic(reflectance=0.4)
    if scattering.maps is not None:
        yield replace(plastic, glossy=_GREY)
    if (coats := scattering.coats) is not None:
        yield replace(
            plastic,
            coat=0.5,
            coat_roughness=0.5 if coats.maps is None else _GREY,
            coat_relief=None if coats.relief is None else BumpMap(_GREY),
        )
    if (sheens := scattering.sheens) is not None:
        yield Material(reflectance=0.4, sheen=0.5 if sheens.maps is None else _GREY)
    yield replace(
        plastic,
        glossy_edge=None if scattering.dip is None else 0.5,
        anisotropy=0.0 if scattering.anisotropy is None else 0.5,
    )


def _marker(wanted: CompiledScene, method: str) -> Path:
    """Return the empty file that says what is in the cache: the types of all records name it."""
    kinds = [str(numba.typeof(getattr(wanted, record))) for record in SceneArrays._fields]
    digest = hashlib.sha256(f"{kinds} {has_optics(wanted.camera)}".encode()).hexdigest()
    return CACHE_FOLDER / f"compiled-{method}-{digest[:16]}"
