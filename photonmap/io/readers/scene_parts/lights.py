"""Read the lights of a TOML scene, `[[light]]`."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any

from photonmap.errors import naming
from photonmap.io.readers.toml import Toml, parse_value
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.lights import LIGHTS, Light, check_light
from photonmap.scene.parameters import parameters_of

SECTION = "light"
_LABEL = "[[light]]"


def read_lights(toml: Toml) -> list[Light]:
    """Read all sections `[[light]]`.

    Raises
    ------
    InputError : a type or key that is unknown or missing, a value that is not valid, or two lights
        of one name
    """
    sections = toml.sections.get(SECTION, [])
    if not isinstance(sections, list) or not all(isinstance(s, dict) for s in sections):
        raise toml.error(f"light is not a section; write {_LABEL} above its keys", SECTION)
    lights = [_read(toml, index, section) for index, section in enumerate(sections)]
    for index, light in enumerate(lights):
        if light.name and light.name in (other.name for other in lights[:index]):
            problem = f"two lights are named {light.name!r}; give each its own name"
            raise toml.error(problem, SECTION, index, "name")
    return lights


def _read(toml: Toml, index: int, section: dict[str, Any]) -> Light:
    """Read one section."""
    at = (SECTION, index)
    if "type" not in section:
        types = ", ".join(f'"{name}"' for name in LIGHTS)
        raise toml.error(f"{_LABEL} lacks type; add one of {types}", *at)
    kind = section["type"]
    if not isinstance(kind, str) or kind not in LIGHTS:
        remedy = suggest(str(kind), LIGHTS)
        raise toml.error(f"{_LABEL} type {shown(kind)} is not known; {remedy}", *at, "type")
    light: Any = LIGHTS[kind]
    parameters = parameters_of(light)
    attributes = {parameter.key or name: name for name, parameter in parameters.items()}
    required = {field.name for field in fields(light) if field.default is MISSING}
    toml.check_known(("type", *attributes), f"{kind} light key", *at)
    values: dict[str, Any] = {}
    lines: dict[str, int | None] = dict.fromkeys(parameters, toml.line(*at))
    for key, attribute in attributes.items():
        if key in section:
            lines[attribute] = toml.line(*at, key)
            with naming(f"{_LABEL} {key}", toml.path, lines[attribute]):
                values[attribute] = parse_value(
                    parameters[attribute], section[key], toml.path.parent
                )
        elif attribute in required:
            hint = f"add {key} = {parameters[attribute].example}"
            raise toml.error(f"the {kind} light lacks {key}; {hint}", *at)
    return check_light(light(**values), toml.path, lines)
