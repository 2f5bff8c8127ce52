"""The scene of a job, procedural or the user's, relit and recoloured; the files it is made from."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.capture.sensor import Sensor
from photonmap.dataset.files.derived_buffers import Mask, one_piece
from photonmap.dataset.files.inside import inside
from photonmap.dataset.files.manifest import CURVES, SENSOR, kept_as, reason_of, role_of_light
from photonmap.dataset.jobs.plan import CommonSettings, Job, UserScene
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.dataset.scenes.illumination import Illumination, check_unchanged
from photonmap.dataset.scenes.recolor import light_groups, recolor, relight
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.dataset.scenes.view_search import find_camera
from photonmap.dataset.scenes.views import View
from photonmap.errors import InputError, naming, only_heard
from photonmap.io.readers.scene_file import load_scene
from photonmap.results.record import describe_measured_sets
from photonmap.runtime.writing import replacing
from photonmap.scene.lights import EnvironmentLight
from photonmap.scene.scene import Scene
from photonmap.scene.textures import mean_color
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import SPACES, check_space
from photonmap.spectra.sensitivities import table_of

_DIGITS = 16  # digits of a digest
KEPT = 4
"""Generated scenes that stay in memory, 5 to 50 MB each: images of a scene follow each other."""
_PIECES = 16  # masks of surfaces in pixels that stay in memory

_pieces: dict[Any, Mask] = {}


def make_scene(job: Job) -> Scene:
    """Return the scene of a job, lit, with its camera; reject files that changed since the plan."""
    for color, digest in job.light_files():
        check_unchanged(color, digest)
    scene = _light(replace(job, view=View()))
    return replace(scene, camera=find_camera(job.view, scene, job.geometry))


@lru_cache(maxsize=4)
def _light(job: Job) -> Scene:
    """Return the scene of a job, lit; cached, as its views follow each other."""
    illumination = Illumination(job.illumination, job.colors, job.shares)
    if job.is_procedural:
        looks = job.common.materials, job.common.lightness, job.common.scale
        return _build(job.scene, job.seed, looks, job.common.munsell).lit(illumination)
    with only_heard():  # `read_user_scenes` has issued them
        scene = _load(job.scene)
    if _digest(scene) != job.content:
        raise InputError("has changed since the data set was begun; restore it", job.scene)
    scene = relight(scene, illumination, job.seed)
    return recolor(scene, job.seed) if job.common.recolor else scene


def pieces_in(job: Job, scene: Scene) -> Mask:
    """Return `one_piece` of an image; found once for all lights that it is rendered under.

    The lights do not matter to it, but for which surfaces are one material and which emit.
    """
    size, centre = job.common.size, job.common.pixel == "center"
    numbers: dict[int, int] = {}
    surfaces = tuple(
        (mesh.name, mesh.faces.shape, numbers.setdefault(id(mesh.material), len(numbers)),
         mean_color(mesh.material.emission) != 0.0)
        for mesh in scene.meshes
    )  # fmt: skip
    key = job.geometry, replace(job.common, error=""), scene.camera, surfaces
    if key not in _pieces:
        while len(_pieces) >= _PIECES:
            del _pieces[next(iter(_pieces))]
        _pieces[key] = one_piece(scene, size, centre)
    return _pieces[key]


def read_user_scenes(
    paths: Iterable[str], bands: Bands | None = None
) -> tuple[list[UserScene], dict[str, str]]:
    """Load scene files; return them with digests and, by path, why others cannot be rendered.

    Such as reflectances that are not known in all bands, if these are given.
    """
    scenes, faults = [], {}
    for path in paths:
        try:
            scene = _load(path)
            if bands is not None:
                _check_reflectances(scene, bands)
            groups = len(light_groups(scene))
            scenes.append(UserScene(str(Path(path).resolve()), digest_of(path), groups))
        except InputError as error:
            faults[path] = reason_of(path, error)
    return scenes, faults


def _check_reflectances(scene: Scene, bands: Bands) -> None:
    for material in {id(mesh.material): mesh.material for mesh in scene.meshes}.values():
        with naming(f"material {material.name!r}"):
            bands.reflectance(mean_color(material.reflectance))


def digest_of(path: str | os.PathLike[str]) -> str:
    """Return the digest of the scene in a file."""
    return _digest(_load(str(path)))


def describe_inputs(common: CommonSettings) -> CommonSettings:
    """Return the settings with the digest of the band curves and of the measured sets."""
    check_space(common.rgb)
    digest = hashlib.sha256(json.dumps(Bands.parse(common.bands).describe()).encode())
    if common.rgb not in SPACES:
        digest.update(json.dumps(Bands.parse(common.rgb).describe()).encode())
    for name in (common.munsell, common.illuminants):
        if name is not None:  # a file, or a folder of files
            path = Path(name)
            is_folder = path.is_dir()
            for file in sorted(filter(Path.is_file, path.iterdir())) if is_folder else [path]:
                named = not common.is_by_content or file != path
                digest.update((file.name.encode() if named else b"") + b"\0" + file.read_bytes())
        digest.update(b";")
    return replace(common, inputs=digest.hexdigest()[:_DIGITS])


@lru_cache(maxsize=KEPT)
def _build(
    name: str, seed: int, looks: tuple[str, float | None, float], munsell: str | None
) -> UnlitScene:
    """Build a scene with its lights off; cached by what it depends on, the chips among them."""
    del munsell
    return build_unlit_scene(name, seed, *looks)


@lru_cache(maxsize=2)
def _load(path: str) -> Scene:
    """Load a user's scene, with its camera; cached, as images of one scene follow each other."""
    scene = load_scene(path)
    if scene.camera is None:
        raise InputError("has no camera; add [camera] to its TOML file", path)
    return scene


def _digest(scene: Scene) -> str:
    digest = hashlib.sha256()
    _feed(digest, replace(scene, name=""))
    return digest.hexdigest()[:_DIGITS]


def _feed(digest: Any, value: Any) -> None:
    """Feed a value to a digest, arrays and images by their elements."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode() + np.ascontiguousarray(value).data)
    elif isinstance(value, EnvironmentLight) and isinstance(value.image, str | os.PathLike):
        digest.update(Path(value.image).read_bytes())
        _feed(digest, replace(value, image=np.zeros(0)))
    elif is_dataclass(value):
        digest.update(type(value).__name__.encode() + b"(")
        for each in fields(value):
            if each.compare:  # where a scene was loaded from does not make it another
                _feed(digest, getattr(value, each.name))
    elif isinstance(value, list | tuple):
        digest.update(f"{len(value)}[".encode())
        for part in value:
            _feed(digest, part)
    else:
        digest.update(f"{value!r};".encode())


Find = Callable[[Job], Job]
"""Returns a job of the manifest with its files where they are on this machine."""


def copy_inputs(folder: Path, jobs: Sequence[Job], sensor: Sensor | None) -> None:
    """Copy the curves of bands, of RGB, of lights and of a sensor into the folder of a data set."""
    common = jobs[0].common
    texts = {(role, getattr(common, role)) for role in CURVES if common.is_by_content}
    texts |= {(role_of_light(digest), path) for job in jobs for path, digest in job.light_files()}
    if sensor is not None:
        texts.add((SENSOR, sensor.camera))
    for role, text in sorted(texts):
        if (path := table_of(text)) is not None:
            target = inside(folder, kept_as(role, path))
            if not target.is_file() or target.read_bytes() != path.read_bytes():
                with replacing(target, path.stat().st_size) as draft:
                    shutil.copyfile(path, draft)


def input_finder(folder: Path, scenes: str | os.PathLike[str] | None = None) -> Find:
    """Return what finds the files of the jobs in a data set's manifest.

    Measured sets that are not where the manifest says are those that are chosen now, if they are
    the same. Scene files that are not there are looked for in the folder `scenes`.
    """
    chosen = describe_measured_sets()
    places: dict[str, str] = {}

    def find(job: Job) -> Job:
        job = job.located(folder)
        if not job.is_procedural and not Path(job.scene).is_file():
            if job.content not in places:
                places[job.content] = _find_scene(job, scenes)
            job = replace(job, scene=places[job.content])
        return replace(job, common=_find_sets(job.common, chosen))

    return find


def _find_scene(job: Job, scenes: str | os.PathLike[str] | None) -> str:
    """Return the scene file of a job's content, or raise an `InputError`."""
    name = Path(job.scene).name
    if scenes is None:
        raise InputError(f"the scene {name} is not there; say where with --scenes DIR")
    for path in sorted(Path(scenes).rglob(name)):
        if path.is_file() and digest_of(path) == job.content:
            return str(path)
    raise InputError(f"holds no scene {name} that the set was made from; choose another", scenes)


def _find_sets(common: CommonSettings, chosen: dict[str, str | None]) -> CommonSettings:
    """Return settings with measured sets that are there, or raise an `InputError`."""
    sets = {"munsell": common.munsell, "illuminants": common.illuminants}
    missing = [role for role, path in sets.items() if path is not None and not Path(path).exists()]
    for role in missing:
        if chosen[role] is None:
            name = Path(sets[role] or "").name
            raise InputError(f"{name} of {role} is not there; say where with --{role} PATH")
    sets |= {role: chosen[role] for role in missing}
    found = replace(common, munsell=sets["munsell"], illuminants=sets["illuminants"])
    if missing and describe_inputs(found).inputs != common.inputs:
        raise InputError(f"{', '.join(missing)}: others than those that the set was made with")
    return found
