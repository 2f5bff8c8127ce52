"""Save a scene as OBJ, MTL and TOML, with its spectra and images in a folder beside them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.errors import InputError, naming
from photonmap.lights import EnvironmentLight
from photonmap.scene import Scene
from photonmap.writers.assets import Assets, check_name
from photonmap.writers.mtl import write_mtl
from photonmap.writers.obj import write_obj

_COLORS = ("intensity", "irradiance", "radiance")


def save_scene(scene: Scene, path: str | PathLike[str]) -> None:
    """Write FILE.obj, FILE.mtl, FILE.toml and the folder FILE_files; all of them or none.

    `photonmap.load_scene` reads the same arrays, spectra, camera and lights from it, but for
    what a file does not say: meshes of one name and material become one, vertices in no face are
    left out, and textures become linear floats, their factor multiplied in.

    Parameters
    ----------
    scene : what to write
    path : FILE.obj, in a folder that exists

    Raises
    ------
    InputError
        if it is no such path, the scene has no faces, or a name or colour cannot be written
    OSError
        if writing fails
    """
    path = Path(path)
    if path.suffix != ".obj":
        raise InputError("is no place for a scene; name a file that ends in .obj", path)
    if not path.parent.is_dir():
        raise InputError(f"there is no folder {path.parent}; make it first", path)
    with naming("the file", path):
        check_name(path.stem)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as folder:
        draft = Path(folder) / path.name
        assets = Assets(draft.with_name(f"{path.stem}_files"))
        names = write_mtl(scene, draft.with_suffix(".mtl"), assets)
        write_obj(scene, draft, names)
        draft.with_suffix(".toml").write_text("\n".join(_toml(scene, assets)), "utf-8")
        place = path.with_name(assets.folder.name)
        place.mkdir(exist_ok=True)
        for file in assets.folder.iterdir():
            file.replace(place / file.name)
        for suffix in (".mtl", ".toml", ".obj"):
            draft.with_suffix(suffix).replace(path.with_suffix(suffix))


def _toml(scene: Scene, assets: Assets) -> Iterator[str]:
    """Give the lines of the TOML file: the camera and the lights."""
    if scene.camera:
        yield "[camera]"
        yield from _keys(scene.camera)
        yield ""
    for light in scene.lights:
        yield "[[light]]"
        yield f'type = "{light.kind}"'
        yield from _keys(light, assets)
        yield ""


def _keys(described: Any, assets: Assets | None = None) -> Iterator[str]:
    """Give the attributes of a camera or a light as lines `key = value`."""
    for field in fields(described):
        value = getattr(described, field.name)
        if assets and field.name in _COLORS:
            label = f"light {getattr(described, 'name', '')!r}"
            yield f"{field.name} = {_text(assets.color(value, label))}"
        elif assets and isinstance(described, EnvironmentLight) and field.name == "image":
            yield f"file = {_text(assets.panorama(value, described.name or described.kind))}"
        elif value != "":
            yield f"{field.name} = {_text(value)}"


def _text(value: Any) -> str:
    """Write a text, a number or a vector as TOML."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(float(value))
    return f"[{', '.join(repr(float(number)) for number in value)}]"
