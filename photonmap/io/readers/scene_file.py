"""Load a scene: a mesh file, and the TOML file that adds a camera, materials and lights."""

from __future__ import annotations

from glob import escape
from os import PathLike
from pathlib import Path

from photonmap.errors import InputError, naming
from photonmap.io.readers.registry import (
    SCENE_SUFFIX,
    MissingTextures,
    ReadOptions,
    find_reader,
    mesh_suffixes,
)
from photonmap.io.readers.scene_parts.cameras import SECTION as CAMERA
from photonmap.io.readers.scene_parts.cameras import read_cameras
from photonmap.io.readers.scene_parts.lights import SECTION as LIGHT
from photonmap.io.readers.scene_parts.lights import read_lights
from photonmap.io.readers.scene_parts.materials import SECTION as MATERIAL
from photonmap.io.readers.scene_parts.materials import change_materials, check_indices
from photonmap.io.readers.scene_parts.objects import SECTION as OBJECT
from photonmap.io.readers.scene_parts.objects import assign_materials
from photonmap.io.readers.toml import Toml, read_toml
from photonmap.runtime.named_files import named_file, reading_below
from photonmap.runtime.wording import listed, shown
from photonmap.scene.scene import Scene

SUFFIXES = (".toml",)

_MESH = "mesh"
_SECTIONS = (_MESH, CAMERA, MATERIAL, OBJECT, LIGHT)


def load_scene(
    path: str | PathLike[str],
    missing_textures: MissingTextures = "error",
    root: str | PathLike[str] | None = None,
) -> Scene:
    """Load a scene file.

    A TOML file names its mesh, `mesh = "room.obj"`, or stands beside it under the same stem. It
    may hold

    - a section `[camera]` with `origin` and `target` (scene units), and optionally the other
      attributes of `photonmap.Camera`, where `projection` and `lens` are tables; or sections
      `[[camera]]` with a `name` each. A `baseline` (scene units) makes a stereo pair of a camera;
    - sections `[material.NAME]` with attributes of `photonmap.Material`, in place of those that
      the mesh file gives this material. A colour is a number, `[red, green, blue]`, or a text as
      `photonmap.spectra.color_text` describes it; the number `ior` makes the material glass;
    - sections `[object.NAME]` with the `material` of an object, in place of what the mesh file
      gives it: the name of one of its materials, or of a new one with a section `[material.NAME]`;
    - sections `[[light]]`, whose `type` is "point", "spot", "photometric", "directional",
      "dome", "environment", "sun", "sky" or "area", and whose other keys are the attributes of the
      light of this kind in `photonmap.scene`; an area light becomes a mesh; the image of an
      environment is its `file`. A light replaces the one that has its name in the mesh file.

    Parameters
    ----------
    path : a file of any suffix that `photonmap.io.readers.registry.scene_suffixes` lists
    missing_textures : "error", or "grey" in place of textures that cannot be read
    root : folder below which all files lie that the scene names; None for its own. Others are not
        opened

    Returns
    -------
    Scene, named after the file; its camera is the first, None where no file describes one

    Raises
    ------
    InputError : the file is of an unknown kind, or it or one it refers to cannot be read
    """
    path = Path(path)
    with reading_below(root, path):
        return read(path, ReadOptions(missing_textures))


def read(path: Path, options: ReadOptions) -> Scene:
    """Read a TOML scene with its mesh, or a mesh with the TOML file beside it if there is one.

    Raises
    ------
    InputError : as `load_scene`
    """
    _check_name(path)
    toml = read_toml(path.with_suffix(SCENE_SUFFIX))
    toml.check_known(_SECTIONS, "section")
    mesh = _mesh_path(path, toml)
    read_mesh = find_reader(mesh)
    cameras = read_cameras(toml)
    try:
        bare = read_mesh(mesh, options)
    except InputError as error:
        if _MESH not in toml.sections or mesh.is_file():
            raise
        raise toml.error(f"mesh: {error}", _MESH) from None
    scene = assign_materials(bare, toml)
    meshes = change_materials(scene.meshes, toml)
    check_indices(meshes, toml, mesh)
    camera = cameras[0] if cameras else scene.camera
    several = (cameras or scene.cameras) if len(cameras) != 1 else []
    lights = read_lights(toml)
    named = {light.name for light in lights if light.name}
    others = [light for light in scene.lights if light.name not in named]
    return Scene(meshes, others + lights, camera, path.stem, several, file=str(path))


def scene_files(path: str | PathLike[str]) -> list[Path]:
    """Return the files that describe a scene: that of its mesh, and its TOML file if there is one.

    Raises
    ------
    InputError : as `load_scene`
    """
    path = Path(path)
    _check_name(path)
    toml = read_toml(path.with_suffix(SCENE_SUFFIX))
    mesh = _mesh_path(path, toml)
    return [mesh, toml.path] if toml.path.is_file() else [mesh]


def _check_name(path: Path) -> None:
    """Refuse folders, and TOML files that are not there."""
    if path.is_dir():
        raise InputError("is a folder; name a file in it", path)
    if path.suffix.lower() == SCENE_SUFFIX and not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)


def _mesh_path(path: Path, toml: Toml) -> Path:
    """Return the mesh file that a scene names, or is."""
    named = toml.sections.get(_MESH)
    if named is None:
        return _mesh_beside(path) if path.suffix.lower() == SCENE_SUFFIX else path
    if not isinstance(named, str):
        raise toml.error(f'mesh {shown(named)} is not a name; write mesh = "FILE.obj"', _MESH)
    with naming(_MESH, toml.path, toml.line(_MESH)):
        mesh = named_file(toml.path.parent, named)
    if mesh.suffix.lower() == SCENE_SUFFIX:
        raise toml.error(f"mesh {shown(named)} is a scene file; name the file of its mesh", _MESH)
    if path.suffix.lower() != SCENE_SUFFIX and mesh.resolve() != path.resolve():
        raise toml.error(f"names another mesh than {path.name}; render {toml.path.name}", _MESH)
    return mesh


def _mesh_beside(path: Path) -> Path:
    """Return the one mesh file that has the stem of a TOML file, and lies beside it."""
    others = sorted(path.parent.glob(f"{escape(path.stem)}.*"))
    found = [other for other in others if other.suffix.lower() in mesh_suffixes()]
    if len(found) != 1:
        names = f", and beside it are {listed(each.name for each in found)}" if found else ""
        raise InputError(f'names no mesh{names}; add mesh = "FILE.obj" at the top', path)
    return found[0]
