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
from typing import Any

import numpy as np

from photonmap.compile.camera import has_optics
from photonmap.compile.lights.light_tree import FEW
from photonmap.compile.scene_arrays import CompiledScene, compile_scene
from photonmap.compile.spectral_columns import SpectralColumns
from photonmap.errors import warn
from photonmap.film.light_groups import LightGroups
from photonmap.integrators.base import PassSetup
from photonmap.integrators.choice import make_integrator
from photonmap.integrators.first_hits import first_hit_buffers
from photonmap.integrators.light_visibility import warn_of_hidden_lights
from photonmap.kernels.core.jit import CACHE_FOLDER
from photonmap.kernels.core.passes import Film
from photonmap.kernels.core.streams import Domain
from photonmap.runtime.workers import Workers
from photonmap.scene.camera import Camera
from photonmap.scene.lens import Lens
from photonmap.scene.lights import EnvironmentLight, Light, PhotometricLight, PointLight
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
_GREY, _BLACK = Texture.of(np.full((1, 1), 0.4)), Texture.of(np.zeros((1, 1)))
_PALETTE = SpectralTexture.from_palette(np.zeros((1, 1), np.int32), [0.4])
_LIGHTS: dict[str, Light] = {
    "environment": EnvironmentLight(np.ones((1, 2, 3))),
    "profiles": PhotometricLight(_NEAR, np.ones((2, 2))),
}
"""Lights that need the same code as those of a scene, by the field of `Lights` that holds theirs"""
_at_hand: set[Path] = set()
"""Markers of the kernels that this process has called"""
_PHOTONS = 1024
"""Photons: enough that some hit, as paths would take their place."""


def is_compiled(wanted: CompiledScene, method: str) -> bool:
    """Return whether all kernels that a scene needs were compiled before on this machine."""
    return _marker(wanted, method).exists()


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
            _gather(small, bands, workers, method)
    try:
        _call_kernels(small, bands, workers, method)
    except (pickle.UnpicklingError, EOFError):
        warn(f"the cache of compiled kernels, {CACHE_FOLDER}, is damaged and will be rebuilt")
        shutil.rmtree(CACHE_FOLDER, ignore_errors=True)
        _call_kernels(small, bands, workers, method)
    with suppress(OSError):  # a cache that cannot be written is no reason to stop
        CACHE_FOLDER.mkdir(parents=True, exist_ok=True)
        marker.touch()
    _at_hand.add(marker)


def _call_kernels(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    _call_around(small, bands, workers, method)
    _gather(small, bands, workers, method)


def _setup(small: Scene, bands: Bands, workers: Workers) -> PassSetup:
    return PassSetup(compile_scene(small, bands), _FILM, bands.count, _PHOTONS, 0, workers)


def _gather(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    """Call the kernel of the camera pass."""
    make_integrator(method, _setup(small, bands, workers)).call_camera_pass()


def _call_around(small: Scene, bands: Bands, workers: Workers, method: str) -> None:
    """Call all other kernels."""
    setup = _setup(small, bands, workers)
    columns = SpectralColumns(np.arange(bands.count))
    moments = LightGroups(columns, _FILM, workers, setup.compiled.has_residual)
    estimate = make_integrator(method, setup).call_other_kernels()
    for _ in range(2):
        moments.add(estimate.pixels, estimate.via_specular)
    for percentile in (None, 50.0):
        moments.whole.error(percentile=percentile)
    moments.finish(1.0)
    key = setup.key(0, Domain.LIGHT_VISIBILITY)
    warn_of_hidden_lights(setup.compiled, setup.view, key)
    first_hit_buffers(setup.compiled, _FILM, workers)


@contextmanager
def _aside(small: Scene, bands: Bands, method: str) -> Iterator[None]:
    """Compile in a process of its own what `_call_around` calls; wait for it at the end.

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


def serve() -> None:
    """Compile what `_aside` sends to standard input."""
    small, bands, method = pickle.load(sys.stdin.buffer)
    with Workers(1) as workers:
        _call_around(small, bands, workers, method)


def _smallest(wanted: CompiledScene) -> Scene:
    """Return a scene of one triangle, or two, that needs the same kernels."""
    triangle = Mesh(np.eye(3) - [0.0, 0.0, 1.0], np.array([[0, 1, 2]]), uv=np.zeros((3, 2)))
    lights: list[Light] = [PointLight(_NEAR)]
    if wanted.lights.tree is not None:
        lights *= FEW
    lights += [light for name, light in _LIGHTS.items() if getattr(wanted.lights, name) is not None]
    material = Material(reflectance=0.4, mirror=0.4) if wanted.specular is not None else Material()
    triangle = replace(triangle, material=replace(material, **_stand_ins(wanted)))
    lens = Lens(1.0, 0.01) if has_optics(wanted.camera) else None
    meshes = [triangle]
    if _has_rough_chains(wanted):
        meshes.append(Mesh(triangle.vertices + 0.5, triangle.faces, Material.glass(roughness=0.5)))
    if lobes := _kinds_of_lobes(wanted):
        glossy = Material(
            glossy=_GREY if "maps" in lobes else 0.4,
            roughness=0.5,
            anisotropy=0.5 if "anisotropy" in lobes else 0.0,
            coat=0.5 if "coats" in lobes else 0.0,
            coat_roughness=_GREY if "coat-maps" in lobes else 0.5,
            coat_relief=BumpMap(_GREY) if "coat-relief" in lobes else None,
        )
        meshes.append(replace(triangle, vertices=triangle.vertices - 0.5, material=glossy))
    return Scene(meshes, lights, Camera((1.0, 1.0, 1.0), (0.3, 0.3, -0.7), lens=lens))


def _has_rough_chains(compiled: CompiledScene) -> bool:
    """Return whether specular chains meet rough surfaces."""
    return compiled.specular is not None and compiled.specular.alpha is not None


def _kinds_of_lobes(compiled: CompiledScene) -> list[str]:
    """Return which fields of `Scattering` glossy lobes need that are not the same all over."""
    kinds = ("maps", "anisotropy", "coats")
    found = [kind for kind in kinds if getattr(compiled.scattering, kind, None) is not None]
    coats = getattr(compiled.scattering, "coats", None)
    if coats is None:
        return found
    return found + [f"coat-{kind}" for kind in ("maps", "relief") if getattr(coats, kind)]


def _has_palettes(compiled: CompiledScene) -> bool:
    """Return whether texels are spectra."""
    return compiled.textures is not None and compiled.textures.palettes is not None


def _marker(wanted: CompiledScene, method: str) -> Path:
    """Return the empty file that says what is in the cache."""
    parts = [method, *sorted(_stand_ins(wanted))]
    parts += [name for name in ("tree", *_LIGHTS) if getattr(wanted.lights, name) is not None]
    parts += ["specular"] * (wanted.specular is not None) + ["optics"] * has_optics(wanted.camera)
    parts += ["rough-chains"] * _has_rough_chains(wanted)
    parts += _kinds_of_lobes(wanted)
    parts += ["palettes"] * _has_palettes(wanted)
    return CACHE_FOLDER / ("compiled-" + "-".join(parts))


def _stand_ins(compiled: CompiledScene) -> dict[str, Any]:
    """Return attributes of a material that needs the same code as a scene's textures.

    It is not an emitter, none of whose own light could be seen.
    """
    needs: tuple[tuple[str, Any, object], ...] = (
        ("reflectance", compiled.textures, _PALETTE if _has_palettes(compiled) else _GREY),
        ("emission", compiled.lights.emission_textures, _BLACK),
        ("alpha", compiled.geometry.alpha, 0.5),
        ("diffuse_roughness", compiled.scattering, 0.5),
        ("relief", compiled.geometry.relief, BumpMap(_GREY)),
    )
    return {name: value for name, record, value in needs if record is not None}
