"""Load a scene: a mesh file, and the TOML file that adds a camera, materials and lights."""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from functools import partial
from glob import escape
from os import PathLike
from pathlib import Path
from typing import Any

from photonmap.errors import InputError, Line, naming, warn
from photonmap.io.readers import registry
from photonmap.io.readers.toml import Toml, parse_value, read_toml
from photonmap.runtime.bounds import naming_large
from photonmap.runtime.files import named_file, reading_below
from photonmap.runtime.wording import listed, shown, suggest
from photonmap.scene.camera import Camera, check_camera
from photonmap.scene.lights import LIGHTS, Light, check_light
from photonmap.scene.material import BESIDE_GLASS, LOBES, Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, Part, parameters_of
from photonmap.scene.projections import RayMap
from photonmap.scene.scene import Scene, check_names
from photonmap.scene.surfaces.layers import (
    LayerError,
    StrandedIndexError,
    check_layers,
    check_relative_indices,
)
from photonmap.scene.surfaces.metallic import FRACTION, USUAL_COAT, metallic_gloss
from photonmap.scene.textures import Paint, Texture

SUFFIXES = (".toml",)

_CAMERA = "camera"
_REQUIRED = ("origin", "target")
_UNMOVED = {"origin": (0.0, 0.0, 0.0), "target": (0.0, 0.0, -1.0)}
"""Of a ray map, which holds its rays in world space"""
_BASELINE = "baseline"
_CAMERA_KEYS = (*parameters_of(Camera), _BASELINE)
_LIGHT = "light"
_LIGHT_LABEL = "[[light]]"
_MATERIAL = "material"
_METALLIC = "metallic"  # Key of what becomes a base and a lobe, as glTF has it
_BLACK = (0.0, (0.0, 0.0, 0.0))
_OF_BODIES = ("abbe", "dispersion", "priority", "outside")  # Attributes that only solid glass has
_OBJECT = "object"
_MESH = "mesh"
_NAMED = 20  # Keys without effect that are named one by one
_SECTIONS = (_MESH, _CAMERA, _MATERIAL, _OBJECT, _LIGHT)


def load_scene(
    path: str | PathLike[str],
    missing_textures: registry.MissingTextures = "error",
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
    with reading_below(root, path), naming_large(path):
        return read(path, registry.ReadOptions(missing_textures))


def read(path: Path, options: registry.ReadOptions) -> Scene:
    """Read a TOML scene with its mesh, or a mesh with the TOML file beside it if there is one."""
    _check_name(path)
    toml = read_toml(path.with_suffix(registry.SCENE_SUFFIX))
    toml.check_known(_SECTIONS, "section")
    mesh = _mesh_path(path, toml)
    registry.find_reader(mesh)  # refuses a file of an unknown kind before all else
    cameras = read_cameras(toml)
    try:
        bare = registry.read_file(mesh, options)
    except InputError as error:
        if _MESH not in toml.sections or mesh.is_file():
            raise
        raise toml.error(f"mesh: {error}", _MESH) from None
    scene = assign_materials(bare, toml)
    meshes = change_materials(scene.meshes, toml)
    _check_indices(meshes, toml, mesh)
    camera = cameras[0] if cameras else scene.camera
    several = (cameras or scene.cameras) if len(cameras) != 1 else []
    lights = read_lights(toml)
    named = {light.name for light in lights if light.name}
    others = [light for light in scene.lights if light.name not in named]
    scene = Scene(meshes, others + lights, camera, path.stem, several, file=str(path))
    scene.lights_file = str(toml.path) if lights else None
    return scene


def scene_files(path: str | PathLike[str]) -> list[Path]:
    """Return the files that describe a scene: that of its mesh, and its TOML file if any."""
    path = Path(path)
    _check_name(path)
    toml = read_toml(path.with_suffix(registry.SCENE_SUFFIX))
    mesh = _mesh_path(path, toml)
    return [mesh, toml.path] if toml.path.is_file() else [mesh]


def _check_name(path: Path) -> None:
    if path.is_dir():
        raise InputError("is a folder; name a file in it", path)
    if path.suffix.lower() == registry.SCENE_SUFFIX and not path.is_file():
        raise InputError("cannot be read (no such file); check the name", path)


def _mesh_path(path: Path, toml: Toml) -> Path:
    named = toml.sections.get(_MESH)
    if named is None:
        return _mesh_beside(path) if path.suffix.lower() == registry.SCENE_SUFFIX else path
    if not isinstance(named, str):
        raise toml.error(f'mesh {shown(named)} is not a name; write mesh = "FILE.obj"', _MESH)
    with naming(_MESH, toml.path, lambda: toml.line(_MESH)):
        mesh = named_file(toml.path.parent, named)
    if mesh.suffix.lower() == registry.SCENE_SUFFIX:
        raise toml.error(f"mesh {shown(named)} is a scene file; name the file of its mesh", _MESH)
    if path.suffix.lower() != registry.SCENE_SUFFIX and mesh.resolve() != path.resolve():
        raise toml.error(f"names another mesh than {path.name}; render {toml.path.name}", _MESH)
    return mesh


def _mesh_beside(path: Path) -> Path:
    """Return the one mesh file that has the stem of a TOML file, and lies beside it."""
    others = sorted(path.parent.glob(f"{escape(path.stem)}.*"))
    found = [other for other in others if other.suffix.lower() in registry.mesh_suffixes()]
    if len(found) != 1:
        names = f", and beside it are {listed(each.name for each in found)}" if found else ""
        raise InputError(f'names no mesh{names}; add mesh = "FILE.obj" at the top', path)
    return found[0]


def read_cameras(toml: Toml) -> list[Camera]:
    """Read `[camera]`, or all sections `[[camera]]`, in their order."""
    if _CAMERA not in toml.sections:
        return []
    sections = toml.sections[_CAMERA]
    if not isinstance(sections, list):
        section = toml.section("[camera]", _CAMERA_KEYS, _CAMERA)
        return _read_camera(toml, "[camera]", section, _CAMERA)
    cameras: list[Camera] = []
    owners: list[tuple[str | int, ...]] = []
    for index, section in enumerate(sections):
        at = (_CAMERA, index)
        if not isinstance(section, dict):
            raise toml.error("camera is not a section; write [[camera]] above its keys", _CAMERA)
        toml.check_known(_CAMERA_KEYS, "[[camera]] key", *at)
        cameras += _read_camera(toml, "[[camera]]", section, *at)
        owners += [(*at, *(["name"] * ("name" in section)))] * (len(cameras) - len(owners))
    if len(sections) > 1:
        _check_names(toml, cameras, owners)
    return cameras


def _check_names(toml: Toml, cameras: list[Camera], owners: list[tuple[str | int, ...]]) -> None:
    """Refuse cameras without names of their own; the error names the line of the first."""
    try:
        check_names(cameras)
    except InputError:
        for count, owner in enumerate(owners, start=1):
            with toml.naming(*owner):
                check_names(cameras[:count])


def _read_camera(toml: Toml, label: str, section: dict[str, Any], *at: str | int) -> list[Camera]:
    """Read one section; two cameras where it has a baseline."""
    lines: dict[str, Line] = {key: partial(toml.line, *at, key) for key in section}
    values = {key: value for key, value in section.items() if key != _BASELINE}
    for key, parameter in parameters_of(Camera).items():
        if isinstance(parameter, Part) and key in values:
            try:
                values[key] = parse_value(parameter, values[key], toml.path.parent)
            except InputError as error:
                raise InputError(f"camera {key} {error}", toml.path, lines[key]) from None
    pose = _UNMOVED if isinstance(values.get("projection"), RayMap) else {}
    values = {**pose, **values}
    for key in _REQUIRED:
        if key not in values:
            raise toml.error(f"{label} lacks {key}; add {key} = [x, y, z]", *at)
    camera = check_camera(Camera(**values), toml.path, lines)
    if _BASELINE not in section:
        return [camera]
    try:
        return list(camera.stereo(section[_BASELINE]))
    except InputError as error:
        problem = f"camera {_BASELINE} {error}"
        raise InputError(problem, toml.path, lines[_BASELINE]) from None


def read_lights(toml: Toml) -> list[Light]:
    """Read all sections `[[light]]`."""
    sections = toml.sections.get(_LIGHT, [])
    if not isinstance(sections, list) or not all(isinstance(s, dict) for s in sections):
        raise toml.error(f"light is not a section; write {_LIGHT_LABEL} above its keys", _LIGHT)
    lights = [_read_light(toml, index, section) for index, section in enumerate(sections)]
    names: set[str] = set()
    for index, light in enumerate(lights):
        if light.name in names:
            problem = f"two lights are named {light.name!r}; give each its own name"
            raise toml.error(problem, _LIGHT, index, "name")
        names.update([light.name] * bool(light.name))
    return lights


def _read_light(toml: Toml, index: int, section: dict[str, Any]) -> Light:
    at = (_LIGHT, index)
    if "type" not in section:
        types = ", ".join(f'"{name}"' for name in LIGHTS)
        raise toml.error(f"{_LIGHT_LABEL} lacks type; add one of {types}", *at)
    kind = section["type"]
    if not isinstance(kind, str) or kind not in LIGHTS:
        remedy = suggest(str(kind), LIGHTS)
        raise toml.error(f"{_LIGHT_LABEL} type {shown(kind)} is not known; {remedy}", *at, "type")
    light: Any = LIGHTS[kind]
    parameters = parameters_of(light)
    attributes = {parameter.key or name: name for name, parameter in parameters.items()}
    required = {field.name for field in fields(light) if field.default is MISSING}
    toml.check_known(("type", *attributes), f"{kind} light key", *at)
    values: dict[str, Any] = {}
    lines: dict[str, Line] = dict.fromkeys(parameters, partial(toml.line, *at))
    for key, attribute in attributes.items():
        if key in section:
            lines[attribute] = partial(toml.line, *at, key)
            with naming(f"{_LIGHT_LABEL} {key}", toml.path, lines[attribute]):
                values[attribute] = parse_value(
                    parameters[attribute], section[key], toml.path.parent
                )
        elif attribute in required:
            hint = f"add {key} = {parameters[attribute].example}"
            raise toml.error(f"the {kind} light lacks {key}; {hint}", *at)
    return check_light(light(**values), toml.path, lines)


def change_materials(meshes: list[Mesh], toml: Toml) -> list[Mesh]:
    """Return the meshes, with the attributes that `[material.NAME]` gives their materials."""
    if _MATERIAL not in toml.sections:
        return meshes
    sections = toml.sections[_MATERIAL]
    if not isinstance(sections, dict):
        raise toml.error("material is not a section; write [material.NAME]", _MATERIAL)
    used = {id(mesh.material): mesh.material for mesh in meshes}
    toml.check_known({material.name for material in used.values()}, "material", _MATERIAL)
    changed = {
        key: _change(material, toml) for key, material in used.items() if material.name in sections
    }
    _warn_of_idle(toml, {material.name: material for material in changed.values()})
    result = []
    for mesh in meshes:
        if id(mesh.material) in changed:
            is_painted = {"reflectance", "ior"} & sections[mesh.material.name].keys()
            colors = None if is_painted else mesh.colors
            mesh = replace(mesh, material=changed[id(mesh.material)], colors=colors)
        result.append(mesh)
    return result


def _check_indices(meshes: list[Mesh], toml: Toml, path: Path) -> None:
    """Check that an index below 1 is relative to something.

    path : the file of the meshes, at fault for what `[material.NAME]` does not give
    """
    try:
        check_relative_indices(meshes)
    except StrandedIndexError as error:
        name = error.mesh.material.name
        section = toml.sections.get(_MATERIAL, {}).get(name, {})
        for key in ("dispersion", "ior"):
            if key in section:
                raise toml.error(str(error), _MATERIAL, name, key) from None
        raise InputError(str(error), path) from None


def _change(material: Material, toml: Toml) -> Material:
    """Return a material with the attributes of its section; new glass loses its reflectance."""
    label, at = f"[material.{material.name}]", (_MATERIAL, material.name)
    parameters = parameters_of(Material)
    attributes = {parameter.key or name: name for name, parameter in parameters.items()}
    given: dict[str, Any] = {}
    section = toml.section(label, (*attributes, _METALLIC), *at)
    for key, value in section.items():
        if key == _METALLIC:
            continue
        with naming(f"{label} {key}", toml.path, partial(toml.line, *at, key)):
            parameter = parameters[attributes[key]]
            parsed = parse_value(parameter, value, toml.path.parent)
            given[attributes[key]] = parameter.check(parsed) if type(parameter) is Part else parsed
    if "dispersion" in given:
        given = {"ior": None, "abbe": None, **given}  # it gives them, unless the section does
    if "glossy" in given:
        given = {"glossy_edge": None, **given}
    if "ior" in given:
        opaque = {name for name, parameter in parameters.items() if parameter.only == "opaque"}
        opaque -= set(BESIDE_GLASS if given.get("transmission", 1.0) != 1.0 else ())
        black = {name: _neutral(name) for name in opaque}
        smooth = {"roughness": 0.0, "anisotropy": 0.0} if material.ior is None else {}
        given = {**black, **smooth, **given}
    changed = replace(material, **given)
    for attribute in given:
        if problem := _find_misplaced(changed, attribute):
            key = parameters[attribute].key or attribute
            raise toml.error(f"{label} {key}: {problem}", *at, key)
    if _METALLIC in section:
        with naming(f"{label} {_METALLIC}", toml.path, partial(toml.line, *at, _METALLIC)):
            share = parse_value(FRACTION, section[_METALLIC], toml.path.parent)
            changed = _partly_metal(changed, share, given.get("glossy", USUAL_COAT))
    _check_layers(changed, toml, section)
    return changed


def _warn_of_idle(toml: Toml, changed: dict[str, Material]) -> None:
    """Warn of keys that have no effect on their material: the first few with their lines."""
    parameters = parameters_of(Material)
    attributes = {parameter.key or name: name for name, parameter in parameters.items()}
    found = [
        (name, key, reason)
        for name, material in changed.items()
        for key in toml.sections[_MATERIAL][name]
        if (attribute := attributes.get(key)) and (reason := _find_idle(material, attribute))
        if getattr(material, attribute) != getattr(Material, attribute)
    ]
    for name, key, reason in found[:_NAMED]:
        message = f"[material.{name}] {key} has no effect on {reason}"
        warn(str(toml.error(message, _MATERIAL, name, key)))
    if len(found) > _NAMED:
        warn(f"{toml.path}: {len(found) - _NAMED} more keys have no effect on their material")


def _find_idle(material: Material, attribute: str) -> str:
    """Return on what an attribute has no effect, and what to do; nothing if it has one."""
    owners = [name for name, lobe in LOBES.items() if attribute in lobe.parameters]
    if owners and not any(material.has(name) for name in owners):
        return LOBES[owners[-1]].without
    if attribute in _OF_BODIES and material.thin:
        return "thin glass, which has no inside; leave out one of them"
    return ""


def _check_layers(material: Material, toml: Toml, section: dict[str, Any]) -> None:
    try:
        check_layers(material)
    except LayerError as error:
        for key in reversed(error.attributes):
            if key in section:
                raise toml.error(str(error), _MATERIAL, material.name, key) from None


def _partly_metal(material: Material, share: float | Texture, coat: Paint) -> Material:
    """Return a material of which a share is metal of its reflectance, and the rest has a coat."""
    if material.ior is not None:
        raise InputError("glass has none; leave out metallic or ior")
    gloss = metallic_gloss(material.reflectance, share, coat, material.roughness)
    return replace(material, **gloss._asdict(), glossy_edge=None)


def _neutral(attribute: str) -> float | None:
    """Return the value by which an attribute of opaque surfaces has no effect on glass."""
    default = getattr(Material, attribute)
    if default is None:
        return None
    is_color = isinstance(parameters_of(Material)[attribute], Colored)
    return 0.0 if is_color else float(default)


def _find_misplaced(material: Material, attribute: str) -> str:
    """Return why a material of its kind cannot have the attribute; nothing if it can."""
    if material.takes(attribute):
        return ""
    if material.ior is None:
        return "only glass has one; add ior = 1.5"
    if getattr(material, attribute) in (*_BLACK, _neutral(attribute)):
        return ""
    return f"glass has none; leave out {attribute} or ior"


def assign_materials(scene: Scene, toml: Toml) -> Scene:
    """Return a scene whose objects have the materials that `[object.NAME]` names.

    A material is one of the scene, or a new one that has a section `[material.NAME]`.
    """
    if _OBJECT not in toml.sections:
        return scene
    names = {mesh.name for mesh in scene.meshes}
    sections = toml.sections[_OBJECT]
    if not isinstance(sections, dict):
        raise toml.error("object is not a section; write [object.NAME]", _OBJECT)
    toml.check_known(names, "object", _OBJECT)
    described = toml.sections.get(_MATERIAL)
    known = {name: Material(name) for name in (described if isinstance(described, dict) else ())}
    known |= {mesh.material.name: mesh.material for mesh in reversed(scene.meshes)}
    return scene.with_materials({name: _named(toml, name, known) for name in sections})


def _named(toml: Toml, name: str, known: dict[str, Material]) -> Material:
    at = (_OBJECT, name)
    section = toml.section(f"[object.{name}]", (_MATERIAL,), *at)
    if _MATERIAL not in section:
        raise toml.error(f'[object.{name}] lacks material; add material = "NAME"', *at)
    wanted = section[_MATERIAL]
    if not isinstance(wanted, str):
        message = f"[object.{name}] material: {shown(wanted)} is not a name"
        raise toml.error(f'{message}; write material = "NAME"', *at, _MATERIAL)
    if wanted not in known:
        remedy = f"{suggest(wanted, known)} (a new one needs a section [material.{wanted}])"
        message = f"[object.{name}] material {shown(wanted)} is not known; {remedy}"
        raise toml.error(message, *at, _MATERIAL)
    return known[wanted]
