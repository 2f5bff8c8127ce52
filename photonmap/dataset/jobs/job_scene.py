"""The scene of a job: procedural, or the user's, relit and recoloured."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Iterable
from dataclasses import fields, is_dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.dataset.files.derived_buffers import Mask, one_piece
from photonmap.dataset.files.inputs import reason_of
from photonmap.dataset.jobs.plan import CommonSettings, Job, UserScene
from photonmap.dataset.scenes.build import build_unlit_scene
from photonmap.dataset.scenes.illumination import Illumination
from photonmap.dataset.scenes.light_files import check_unchanged
from photonmap.dataset.scenes.recolor import light_groups, recolor, relight
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.dataset.scenes.view_search import find_camera
from photonmap.errors import InputError, SceneWarning
from photonmap.io.readers.scene_file import load_scene
from photonmap.scene.lights import EnvironmentLight
from photonmap.scene.scene import Scene
from photonmap.scene.textures import mean_color
from photonmap.spectra.bands import Bands
from photonmap.spectra.projection import SPACES, check_space

_DIGITS = 16
"""Digits of a digest."""
KEPT = 4
"""Generated scenes that stay in memory, 5 to 50 MB each: images of a scene follow each other."""
_PIECES = 16
"""Masks of surfaces in pixels that stay in memory."""

_pieces: dict[Any, Mask] = {}


def make_scene(job: Job) -> Scene:
    """Return the scene of an image under its illumination, with the camera of its view.

    Raises
    ------
    InputError : the scene cannot be built or loaded, a file of the user has changed since the plan,
        or no camera near the view sees the scene
    """
    for color, digest in job.light_files():
        check_unchanged(color, digest)
    illumination = Illumination(job.illumination, job.colors, job.shares)
    if job.is_procedural:
        common = job.common
        looks = common.materials, common.lightness, common.scale
        scene = _build(job.scene, job.seed, looks, common.munsell).lit(illumination)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)  # `read_user_scenes` has issued them
            scene = _load(job.scene)
        if _digest(scene) != job.content:
            raise InputError("has changed since the data set was begun; restore it", job.scene)
        scene = relight(scene, illumination, job.seed)
        scene = recolor(scene, job.seed) if job.common.recolor else scene
    return replace(scene, camera=find_camera(job.view, scene, job.geometry))


def pieces_in(job: Job, scene: Scene) -> Mask:
    """Return `one_piece` of an image; found once for all lights that it is rendered under.

    The lights do not matter to it, but for which surfaces are one material and which emit.
    """
    size, centre = job.common.size, job.common.pixel == "center"
    numbers: dict[int, int] = {}
    surfaces = tuple(
        (
            mesh.name,
            mesh.faces.shape,
            numbers.setdefault(id(mesh.material), len(numbers)),
            mean_color(mesh.material.emission) != 0.0,
        )
        for mesh in scene.meshes
    )
    key = job.geometry, replace(job.common, error=""), scene.camera, surfaces
    if key not in _pieces:
        while len(_pieces) >= _PIECES:
            del _pieces[next(iter(_pieces))]
        _pieces[key] = one_piece(scene, size, centre)
    return _pieces[key]


def read_user_scenes(paths: Iterable[str]) -> tuple[list[UserScene], dict[str, str]]:
    """Load scene files; return them with digests of their scenes.

    Returns
    -------
    Those that can be read; and why others cannot, by path, as `reason_of` says it
    """
    scenes, faults = [], {}
    for path in paths:
        try:
            groups = len(light_groups(_load(path)))
            scenes.append(UserScene(str(Path(path).resolve()), digest_of(path), groups))
        except InputError as error:
            faults[path] = reason_of(path, error)
    return scenes, faults


def digest_of(path: str | os.PathLike[str]) -> str:
    """Return the digest of the scene in a file.

    Raises
    ------
    InputError : it cannot be read
    """
    return _digest(_load(str(path)))


def describe_inputs(common: CommonSettings) -> CommonSettings:
    """Return the settings with the digest of the band curves and of the measured sets.

    Raises
    ------
    InputError : the bands or the RGB are not understood
    """
    check_space(common.rgb)
    digest = hashlib.sha256(json.dumps(Bands.parse(common.bands).describe()).encode())
    if common.rgb not in SPACES:
        digest.update(json.dumps(Bands.parse(common.rgb).describe()).encode())
    for name in (common.munsell, common.illuminants):
        for file in _files_of(name):
            named = not common.is_by_content or file != Path(name or "")
            digest.update((file.name.encode() if named else b"") + b"\0" + file.read_bytes())
        digest.update(b";")
    return replace(common, inputs=digest.hexdigest()[:_DIGITS])


def _files_of(name: str | None) -> list[Path]:
    """Return the files of a measured set: a single file, or those of a folder."""
    if name is None:
        return []
    path = Path(name)
    return sorted(p for p in path.iterdir() if p.is_file()) if path.is_dir() else [path]


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
