"""Save a scene as OBJ, MTL and TOML, or as glTF, with spectra and images in a folder beside."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError, naming, warn
from photonmap.io.writers.gltf import write_gltf
from photonmap.io.writers.obj import beyond_mtl, name_materials, write_mtl, write_obj
from photonmap.io.writers.toml import (
    Assets,
    check_name,
    write_cameras,
    write_lights,
    write_materials,
)
from photonmap.runtime.wording import listed
from photonmap.scene.scene import Scene

_TOML = ".toml"
_COMPANIONS = {".obj": (".mtl", _TOML), ".glb": (_TOML,), ".gltf": (".bin", _TOML)}
"""Suffixes of files that scenes are saved as, and of those that may be written beside them."""


def companions(path: Path) -> list[Path]:
    """Return the files that may be written beside a file, and the folder."""
    suffix = path.suffix.lower()
    if suffix not in _COMPANIONS:
        known = ", ".join(_COMPANIONS)
        raise InputError(f"does not end in one of {known}, which scenes are saved as", path)
    return [*map(path.with_suffix, _COMPANIONS[suffix]), path.with_name(_folder(path))]


def _folder(path: Path) -> str:
    return f"{path.stem}_files"


def save_scene(scene: Scene, path: str | PathLike[str]) -> list[Path]:
    """Write FILE.obj with FILE.mtl and FILE.toml, or FILE.glb, or FILE.gltf with FILE.bin.

    Beside glTF, FILE.toml is written only for what glTF cannot hold, or in place of one that is
    there. Spectra and other files that these name are in the folder FILE_files. All of them are
    written, or none.

    `photonmap.load_scene` reads the same arrays, spectra, cameras and lights from OBJ, with these
    exceptions: tangents are left out, with a warning, meshes of one name and material become one,
    vertices that no face uses are left out, textures become linear floats multiplied by their
    factor, and colours of faces become colours of vertices. In glTF, coordinates are float32, about
    the middle of the scene unless they are so already, and textures have 8 bits, or 16 if they are
    not 8-bit sRGB in the scene.

    Parameters
    ----------
    scene : what to write
    path : FILE.obj, FILE.glb or FILE.gltf; its folder is made if it is missing

    Returns
    -------
    The files that were written, this one first, and the folder FILE_files if there is one

    Raises
    ------
    InputError
        if the path is not of this kind, the scene has no faces, or a name cannot be written
    OSError
        if writing fails
    """
    path = Path(path)
    companions(path)
    with naming("the file", path):
        check_name(path.stem)
    if not any(len(mesh.faces) for mesh in scene.meshes):
        raise InputError(f"scene {scene.name!r} has no faces: there is nothing to write")
    path.parent.mkdir(parents=True, exist_ok=True)
    is_obj = path.suffix.lower() == ".obj"
    write: Callable[[Scene, Path, Assets], None] = _write_obj if is_obj else write_gltf
    with tempfile.TemporaryDirectory(prefix=".photonmap-", dir=path.parent) as folder:
        draft = Path(folder) / path.name
        with Assets(draft.with_name(_folder(path))) as assets:
            write(scene, draft, assets)
        toml = draft.with_suffix(_TOML)
        if path.with_suffix(_TOML).exists() and not toml.exists():
            toml.write_text(f'mesh = "{path.name}"\n', "utf-8")
        return _publish(Path(folder), path)


def _write_obj(scene: Scene, path: Path, assets: Assets) -> None:
    names = write_mtl(scene, path.with_suffix(".mtl"), assets)
    write_obj(scene, path, names)
    kept = {name: beyond_mtl(material) for name, material in name_materials(scene).items()}
    kept = {name: values for name, values in kept.items() if values}
    lost = [mesh.name for mesh in scene.meshes if mesh.tangents is not None]
    if lost:
        warn(f"OBJ holds no tangents: those of {listed(lost)} will follow from coordinates")
    lines = [*write_materials(kept, assets)]
    lines += [*write_cameras(scene.every_camera, assets), *write_lights(scene.lights, assets)]
    path.with_suffix(_TOML).write_text("\n".join(lines), "utf-8")


def _publish(folder: Path, path: Path) -> list[Path]:
    """Move what a folder holds to where it belongs, the file that is asked for last."""
    written = [path]
    for draft in sorted(folder.iterdir()):
        place = path.with_name(draft.name)
        if draft.is_dir():
            place.mkdir(exist_ok=True)
            for file in draft.iterdir():
                file.replace(place / file.name)
        elif place != path:
            draft.replace(place)
        if place != path:
            written.append(place)
    (folder / path.name).replace(path)
    return written
