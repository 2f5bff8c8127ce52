"""Read which materials a TOML scene gives objects of a mesh file, `[object.NAME]`."""

from __future__ import annotations

from photonmap.io.readers.scene_parts.materials import SECTION as MATERIAL
from photonmap.io.readers.toml import Toml
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.material import Material
from photonmap.scene.scene import Scene

SECTION = "object"
_KEY = "material"


def assign_materials(scene: Scene, toml: Toml) -> Scene:
    """Return a scene whose objects have the materials that `[object.NAME]` names.

    A material is one of the scene, or a new one that has a section `[material.NAME]`.

    Raises
    ------
    InputError : an object, key or material that is unknown
    """
    if SECTION not in toml.sections:
        return scene
    names = {mesh.name for mesh in scene.meshes}
    sections = toml.sections[SECTION]
    if not isinstance(sections, dict):
        raise toml.error("object is not a section; write [object.NAME]", SECTION)
    toml.check_known(names, "object", SECTION)
    described = toml.sections.get(MATERIAL)
    known = {name: Material(name) for name in (described if isinstance(described, dict) else ())}
    known |= {mesh.material.name: mesh.material for mesh in reversed(scene.meshes)}
    return scene.with_materials({name: _named(toml, name, known) for name in sections})


def _named(toml: Toml, name: str, known: dict[str, Material]) -> Material:
    """Return the material that the section of an object names."""
    at = (SECTION, name)
    section = toml.section(f"[object.{name}]", (_KEY,), *at)
    if _KEY not in section:
        raise toml.error(f'[object.{name}] lacks {_KEY}; add {_KEY} = "NAME"', *at)
    wanted = section[_KEY]
    if not isinstance(wanted, str):
        message = f'[object.{name}] {_KEY}: {shown(wanted)} is not a name; write {_KEY} = "NAME"'
        raise toml.error(message, *at, _KEY)
    if wanted not in known:
        remedy = f"{suggest(wanted, known)} (a new one needs a section [material.{wanted}])"
        message = f"[object.{name}] {_KEY} {shown(wanted)} is not known; {remedy}"
        raise toml.error(message, *at, _KEY)
    return known[wanted]
