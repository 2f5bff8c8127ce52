"""Read the lights of a TOML scene, `[[light]]`."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any

from photonmap.errors import InputError, naming
from photonmap.lights import LIGHTS, Light, check_light
from photonmap.messages import shown, suggest
from photonmap.readers.panorama import read_panorama
from photonmap.readers.toml import Toml, as_text
from photonmap.spectra.text import emission

SECTION = "light"
_LABEL = "[[light]]"
_COLORS = ("intensity", "irradiance", "radiance")
_FILE = "file"
"""The key of an environment's image."""
_HINTS = {"position": "[x, y, z]", "target": "[x, y, z]", "direction": "[x, y, z]"}


def read_lights(toml: Toml) -> list[Light]:
    """Read all sections `[[light]]`.

    Raises
    ------
    InputError : a type or key that is not known or missing, a value that describes no light, or
        two lights of one name
    """
    sections = toml.sections.get(SECTION, [])
    if not isinstance(sections, list) or not all(isinstance(s, dict) for s in sections):
        raise toml.error(f"light is no section; write {_LABEL} above its keys", SECTION)
    lights = [_read(toml, index, section) for index, section in enumerate(sections)]
    for index, light in enumerate(lights):
        if light.name and light.name in (other.name for other in lights[:index]):
            problem = f"two lights are named {light.name!r}; give each its own name"
            raise toml.error(problem, SECTION, index, "name")
    return lights


def _read(toml: Toml, index: int, section: dict[str, Any]) -> Light:
    """Read one section."""
    way = (SECTION, index)
    if "type" not in section:
        types = ", ".join(f'"{name}"' for name in LIGHTS)
        raise toml.error(f"{_LABEL} lacks type; add one of {types}", *way)
    kind = section["type"]
    if not isinstance(kind, str) or kind not in LIGHTS:
        remedy = suggest(str(kind), LIGHTS)
        raise toml.error(f"{_LABEL} type {shown(kind)} is not known; {remedy}", *way, "type")
    light: Any = LIGHTS[kind]
    attribute_of = {_FILE if f.name == "image" else f.name: f for f in fields(light)}
    toml.check_known(("type", *attribute_of), f"{kind} light key", *way)
    for key, field in attribute_of.items():
        if field.default is MISSING and key not in section:
            hint = _HINTS.get(key, '"FILE.exr"')
            raise toml.error(f"the {kind} light lacks {key}; add {key} = {hint}", *way)
    lines = {field.name: toml.line(*way, key) for key, field in attribute_of.items()}
    values = {
        attribute_of[key].name: _value(toml, key, value, lines[attribute_of[key].name])
        for key, value in section.items()
        if key != "type"
    }
    return check_light(light(**values), toml.path, lines)


def _value(toml: Toml, key: str, value: Any, line: int | None) -> Any:
    """Return what a key describes: a colour, a map, or the value itself."""
    with naming(f"{_LABEL} {key}", toml.path, line):
        if key in _COLORS:
            return emission(as_text(value), toml.path.parent)
        if key != _FILE:
            return value
        if not isinstance(value, str):
            raise InputError(f'{shown(value)} is no name; write file = "FILE.exr"')
        return read_panorama(toml.path.parent / value)
