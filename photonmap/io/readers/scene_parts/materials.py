"""Read what a TOML scene changes of a mesh file's materials, `[material.NAME]`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from photonmap.errors import InputError, naming, warn
from photonmap.io.readers.toml import Toml, parse_value
from photonmap.scene.material import BESIDE_GLASS, Material
from photonmap.scene.mesh import Mesh
from photonmap.scene.parameters import Colored, Part, parameters_of
from photonmap.scene.surfaces.layers import LayerError, check_layers
from photonmap.scene.surfaces.metallic import FRACTION, USUAL_COAT, metallic_gloss
from photonmap.scene.surfaces.relative_index import StrandedIndexError, check_relative_indices
from photonmap.scene.textures import Paint, Texture

SECTION = "material"
_METALLIC = "metallic"
"""Key of what becomes a base and a lobe, as glTF has it"""
_BLACK = (0.0, (0.0, 0.0, 0.0))
_GLOSSY = "add glossy = 0.04 for plastic, or glossy = 'metal:Au'"
_OF_BODIES = ("abbe", "dispersion", "priority", "outside")
"""Attributes that only solid glass has"""


def change_materials(meshes: list[Mesh], toml: Toml) -> list[Mesh]:
    """Return the meshes, with the attributes that `[material.NAME]` gives their materials.

    Raises
    ------
    InputError : a material or key that is unknown, or a value that is not valid
    """
    if SECTION not in toml.sections:
        return meshes
    sections = toml.sections[SECTION]
    if not isinstance(sections, dict):
        raise toml.error("material is not a section; write [material.NAME]", SECTION)
    used = {id(mesh.material): mesh.material for mesh in meshes}
    toml.check_known({material.name for material in used.values()}, "material", SECTION)
    changed = {
        key: _change(material, toml) for key, material in used.items() if material.name in sections
    }
    return [
        _repaint(mesh, changed[id(mesh.material)], sections[mesh.material.name])
        if id(mesh.material) in changed
        else mesh
        for mesh in meshes
    ]


def check_indices(meshes: list[Mesh], toml: Toml, path: Path) -> None:
    """Check that an index below 1 is relative to something.

    Parameters
    ----------
    path : the file of the meshes, at fault for what `[material.NAME]` does not give

    Raises
    ------
    InputError : a mesh has one that no glass surrounds
    """
    try:
        check_relative_indices(meshes)
    except StrandedIndexError as error:
        name = error.mesh.material.name
        section = toml.sections.get(SECTION, {}).get(name, {})
        for key in ("dispersion", "ior"):
            if key in section:
                raise toml.error(str(error), SECTION, name, key) from None
        raise InputError(str(error), path) from None


def _repaint(mesh: Mesh, material: Material, section: dict[str, Any]) -> Mesh:
    """Return a mesh of another material; a reflectance that is given replaces its colours."""
    colors = None if {"reflectance", "ior"} & section.keys() else mesh.colors
    return replace(mesh, material=material, colors=colors)


def _change(material: Material, toml: Toml) -> Material:
    """Return a material with the attributes of its section; new glass loses its reflectance."""
    label, at = f"[material.{material.name}]", (SECTION, material.name)
    parameters = parameters_of(Material)
    attributes = {parameter.key or name: name for name, parameter in parameters.items()}
    given: dict[str, Any] = {}
    section = toml.section(label, (*attributes, _METALLIC), *at)
    for key, value in section.items():
        if key == _METALLIC:
            continue
        with naming(f"{label} {key}", toml.path, toml.line(*at, key)):
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
        with naming(f"{label} {_METALLIC}", toml.path, toml.line(*at, _METALLIC)):
            share = parse_value(FRACTION, section[_METALLIC], toml.path.parent)
            changed = _partly_metal(changed, share, given.get("glossy", USUAL_COAT))
    _check_layers(changed, toml, section)
    for key in section:
        reason = _find_idle(changed, attributes[key]) if key in attributes else ""
        if reason and given[attributes[key]] != getattr(Material, attributes[key]):
            warn(str(toml.error(f"{label} {key} has no effect on {reason}", *at, key)))
    return changed


def _find_idle(material: Material, attribute: str) -> str:
    """Return on what an attribute has no effect, and what to do; nothing if it has one."""
    if attribute in ("roughness", "anisotropy") and not material.is_glossy:
        return "" if material.ior is not None else f"what is not glossy; {_GLOSSY}"
    if attribute == "glossy_edge" and not material.is_glossy:
        return f"what is not glossy; {_GLOSSY}"
    if attribute in ("coat_roughness", "coat_ior", "coat_relief") and not material.is_coated:
        return "what has no coat; add coat = 1"
    if attribute == "sheen_roughness" and not material.has_sheen:
        return "what has no sheen; add sheen = 0.5"
    if attribute in _OF_BODIES and material.thin:
        return "thin glass, which has no inside; leave out one of them"
    return ""


def _check_layers(material: Material, toml: Toml, section: dict[str, Any]) -> None:
    """Check that layers go together, where the section gives one of them."""
    try:
        check_layers(material)
    except LayerError as error:
        for key in reversed(error.attributes):
            if key in section:
                raise toml.error(str(error), SECTION, material.name, key) from None


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
