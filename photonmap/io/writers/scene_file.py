"""Save a scene as OBJ, MTL and TOML, with its spectra and images in a folder beside them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.errors import InputError, naming
from photonmap.io.writers.assets import Assets, check_name
from photonmap.io.writers.mtl import write_mtl
from photonmap.io.writers.obj import write_obj
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.parameters import Colored, File, Numbers, Part, Whole, parameters_of
from photonmap.scene.scene import Scene, check_names


def save_scene(scene: Scene, path: str | PathLike[str]) -> None:
    """Write FILE.obj, FILE.mtl, FILE.toml and the folder FILE_files; all of them or none.

    `photonmap.load_scene` reads the same arrays, spectra, cameras and lights from it, with
    these exceptions: meshes of one name and material become one, vertices that no face uses are
    left out, and textures become linear floats multiplied by their factor.

    Parameters
    ----------
    scene : what to write
    path : FILE.obj, in a folder that exists

    Raises
    ------
    InputError
        if the path is not of this kind, the scene has no faces, or a name cannot be written
    OSError
        if writing fails
    """
    path = Path(path)
    if path.suffix != ".obj":
        raise InputError("does not end in .obj; scenes are saved as OBJ, MTL and TOML", path)
    if not path.parent.is_dir():
        raise InputError(f"there is no folder {path.parent}; create it first", path)
    with naming("the file", path):
        check_name(path.stem)
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as folder:
        draft = Path(folder) / path.name
        assets = Assets(draft.with_name(f"{path.stem}_files"))
        names = write_mtl(scene, draft.with_suffix(".mtl"), assets)
        write_obj(scene, draft, names)
        draft.with_suffix(".toml").write_text("\n".join(_toml(scene, assets)), "utf-8")
        folder_of_assets = path.with_name(assets.folder.name)
        folder_of_assets.mkdir(exist_ok=True)
        for file in assets.folder.iterdir():
            file.replace(folder_of_assets / file.name)
        for suffix in (".mtl", ".toml", ".obj"):
            draft.with_suffix(suffix).replace(path.with_suffix(suffix))


def _toml(scene: Scene, assets: Assets) -> Iterator[str]:
    """Yield the lines of the TOML file: the cameras and the lights."""
    cameras = scene.every_camera
    if len(cameras) > 1:
        check_names(cameras)
    for camera in cameras:
        yield "[camera]" if len(cameras) == 1 else "[[camera]]"
        yield from _camera_keys(camera, assets)
        yield ""
    for light in scene.lights:
        yield "[[light]]"
        yield f'type = "{light.kind}"'
        yield from _light_keys(light, assets)
        yield ""


def _camera_keys(camera: Camera, assets: Assets) -> Iterator[str]:
    """Yield the attributes of a camera as lines `key = value`."""
    for attribute, parameter in parameters_of(Camera).items():
        value = getattr(camera, attribute)
        if isinstance(parameter, Part) and value is not None:
            table = _table(parameter, value, assets, camera.name or attribute)
            yield f"{attribute} = {table}"
        elif value not in (None, "") and not (attribute == "fov" and camera.projection):
            yield f"{attribute} = {_text(value)}"


def _table(part: Part, value: Any, assets: Assets, label: str) -> str:
    """Write an object with parameters of its own as a table in one line."""
    pairs = [f"type = {_text(value.kind)}"] * (len(part.kinds) > 1)
    for attribute, parameter in parameters_of(type(value)).items():
        held, key = getattr(value, attribute), parameter.key or attribute
        match parameter:
            case _ if held is None:
                continue
            case File():
                text = _text(assets.file(parameter, held, label))
            case Whole() | Numbers(each=Whole()):
                text = json.dumps(held)
            case _:
                text = _text(held)
        pairs.append(f"{key} = {text}")
    return f"{{ {', '.join(pairs)} }}"


def _light_keys(light: Light, assets: Assets) -> Iterator[str]:
    """Yield the attributes of a light as lines `key = value`."""
    for attribute, parameter in parameters_of(type(light)).items():
        value, key = getattr(light, attribute), parameter.key or attribute
        match parameter:
            case Colored():
                yield f"{key} = {_text(assets.color(value, f'light {light.name!r}'))}"
            case File():
                yield f"{key} = {_text(assets.file(parameter, value, light.name or light.kind))}"
            case _ if value != "":
                yield f"{key} = {_text(value)}"


def _text(value: Any) -> str:
    """Write a text, a number or a vector as TOML."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(float(value))
    return f"[{', '.join(repr(float(number)) for number in value)}]"
