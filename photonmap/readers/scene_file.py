"""Load a scene: a mesh file, and the TOML file that adds a camera, materials and lights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.camera import check_camera
from photonmap.errors import InputError, naming
from photonmap.messages import shown
from photonmap.readers.meshes import SUFFIXES, read_mesh
from photonmap.readers.mtl import Missing
from photonmap.readers.obj import read_obj
from photonmap.readers.scene_lights import SECTION as LIGHT
from photonmap.readers.scene_lights import read_lights
from photonmap.readers.toml import Toml, as_text, read_toml
from photonmap.scene import Camera, Material, Mesh, Scene
from photonmap.spectra.curves import Color
from photonmap.spectra.text import emission, reflectance
from photonmap.vectors import finite

_MESHES: dict[str, Callable[[Path], list[Mesh]]] = {
    ".obj": read_obj,
    **dict.fromkeys(SUFFIXES, read_mesh),
}
_SECTIONS = ("mesh", "camera", "material", LIGHT)
_CAMERA, _REQUIRED = ("origin", "target", "up", "fov"), ("origin", "target")
_COLORS: dict[str, Callable[[str, Path], Color]] = {
    "reflectance": reflectance,
    "emission": emission,
    "mirror": reflectance,
    "tint": reflectance,
}
_IOR = "ior"
_BLACK = (0.0, (0.0, 0.0, 0.0))


def load_scene(path: str | PathLike[str], missing_textures: Missing = "error") -> Scene:
    """Load a scene file.

    A TOML file names its mesh, `mesh = "room.obj"`, or stands beside it under the same stem. It
    may hold a section `[camera]` with `origin` and `target` (scene units), and optionally `up`
    and `fov` (degrees, vertical); and sections `[material.NAME]` with attributes of
    `photonmap.scene.Material`, in place of those that the mesh file gives this material:
    `reflectance`, `emission`, `mirror` and `tint`, each a number, `[red, green, blue]`, or a text
    as `photonmap.spectra.text` describes it, and the number `ior`, which makes it glass; and any
    number of sections `[[light]]`, whose `type` is "point", "spot", "directional", "dome" or
    "environment", and whose other keys are the attributes of the light of this kind in
    `photonmap.lights`; the image of an environment is its `file`.

    Parameters
    ----------
    path : an OBJ, PLY, STL, GLB, glTF or TOML file
    missing_textures : "error", or "grey" in place of an MTL file's textures that cannot be read

    Returns
    -------
    Scene, named by the file's stem; its camera is None where no file describes one

    Raises
    ------
    InputError : the file is of no known kind, or it or one it refers to cannot be read
    """
    path = Path(path)
    if path.suffix.lower() == ".toml" and not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)
    toml = read_toml(path.with_suffix(".toml"))
    toml.check_known(_SECTIONS, "section")
    mesh = _mesh_path(path, toml)
    reader = _MESHES.get(mesh.suffix.lower())
    if reader is None:
        known = ", ".join((*_MESHES, ".toml"))
        raise InputError(f"is of no known kind; supported: {known}", mesh)
    camera = _read_camera(toml)
    meshes = read_obj(mesh, missing_textures) if reader is read_obj else reader(mesh)
    return Scene(_recolor(meshes, toml), read_lights(toml), camera, path.stem)


def _mesh_path(path: Path, toml: Toml) -> Path:
    """Return the mesh file that a scene names, or is."""
    named = toml.sections.get("mesh")
    if named is None:
        if path.suffix.lower() == ".toml":
            raise InputError('names no mesh; add mesh = "FILE.obj" at the top', path)
        return path
    if not isinstance(named, str):
        raise toml.error(f'mesh {shown(named)} is no name; write mesh = "FILE.obj"', "mesh")
    mesh = toml.path.parent / named
    if path.suffix.lower() != ".toml" and mesh.resolve() != path.resolve():
        raise toml.error(f"names another mesh than {path.name}; render {toml.path.name}", "mesh")
    return mesh


def _read_camera(toml: Toml) -> Camera | None:
    """Read `[camera]`; None where there is none."""
    if "camera" not in toml.sections:
        return None
    camera = _section(toml, "camera", _CAMERA, "[camera]")
    for key in _REQUIRED:
        if key not in camera:
            raise toml.error(f"[camera] lacks {key}; add {key} = [x, y, z]", "camera")
    lines = {key: toml.line("camera", key) for key in _CAMERA}
    return check_camera(Camera(**camera), toml.path, lines)


def _recolor(meshes: list[Mesh], toml: Toml) -> list[Mesh]:
    """Give the materials of `[material.NAME]` their attributes."""
    if "material" not in toml.sections:
        return meshes
    sections = toml.sections["material"]
    if not isinstance(sections, dict):
        raise toml.error("material is no section; write [material.NAME]", "material")
    used = {id(mesh.material): mesh.material for mesh in meshes}
    toml.check_known({material.name for material in used.values()}, "material", "material")
    changed = {
        key: _changed(material, toml) for key, material in used.items() if material.name in sections
    }
    return [replace(m, material=changed.get(id(m.material), m.material)) for m in meshes]


def _changed(material: Material, toml: Toml) -> Material:
    """Give a material the attributes of its section; what becomes glass keeps no reflectance."""
    label, way = f"[material.{material.name}]", ("material", material.name)
    known = (*_COLORS, _IOR)
    given: dict[str, Any] = {}
    for key, value in _section(toml, "material", known, label, material.name).items():
        with naming(f"{label} {key}", toml.path, toml.line(*way, key)):
            given[key] = _read_value(key, value, toml.path.parent)
    if _IOR in given:
        given = {"reflectance": 0.0, "mirror": 0.0, **given}
    changed = replace(material, **given)
    for key in given:
        if problem := _misplaced(changed, key):
            raise toml.error(f"{label} {key}: {problem}", *way, key)
    return changed


def _read_value(key: str, value: Any, folder: Path) -> Color:
    """Read a colour, or the index of refraction."""
    if key in _COLORS:
        return _COLORS[key](as_text(value), folder)
    number = finite(value)
    if number is None or number <= 0.0:
        message = f"{shown(value)} is no index of refraction; write a number above 0, such as 1.5"
        raise InputError(message)
    return number


def _misplaced(material: Material, key: str) -> str:
    """Say why a material cannot have what its section gives; nothing if it can."""
    is_glass = material.ior is not None
    if key == "tint" and not is_glass:
        return "only glass has one; add ior = 1.5"
    if key in ("reflectance", "mirror") and is_glass and getattr(material, key) not in _BLACK:
        return f"glass has none; leave out {key} or ior"
    return ""


def _section(
    toml: Toml, name: str, known: tuple[str, ...], label: str, inner: str | None = None
) -> dict[str, Any]:
    """Return a section whose keys are all known."""
    way = (name,) if inner is None else (name, inner)
    section = toml.sections[name] if inner is None else toml.sections[name][inner]
    if not isinstance(section, dict):
        raise toml.error(f"{'.'.join(way)} is no section; write {label} above its keys", *way)
    toml.check_known(known, f"{label} key", *way)
    return section
