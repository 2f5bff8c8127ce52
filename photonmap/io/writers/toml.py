"""Write what TOML scenes hold: materials, cameras and lights."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from photonmap.io.writers.assets import Assets
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, File, Numbers, Part, Whole, parameters_of
from photonmap.scene.scene import check_names


def write_materials(changes: Mapping[str, Mapping[str, Any]], assets: Assets) -> Iterator[str]:
    """Yield the lines that give materials attributes.

    Parameters
    ----------
    changes : by the name of a material, values by attribute
    """
    parameters = parameters_of(Material)
    for name, values in changes.items():
        yield f"[material.{_text(name)}]"
        for attribute, value in values.items():
            parameter = parameters[attribute]
            key, label = parameter.key or attribute, f"{name} {attribute}"
            if isinstance(parameter, Part):
                yield f"{key} = {_table(parameter, value, assets, label)}"
                continue
            text = assets.color(value, label) if isinstance(parameter, Colored) else value
            yield f"{key} = {_text(text)}"
        yield ""


def write_cameras(cameras: Sequence[Camera], assets: Assets) -> Iterator[str]:
    """Yield the lines that describe cameras.

    Raises
    ------
    InputError
        if several cameras do not have different names
    """
    if len(cameras) > 1:
        check_names(cameras)
    for camera in cameras:
        yield "[camera]" if len(cameras) == 1 else "[[camera]]"
        yield from _camera_keys(camera, assets)
        yield ""


def write_lights(lights: Sequence[Light], assets: Assets) -> Iterator[str]:
    """Yield the lines that describe lights."""
    for light in lights:
        yield "[[light]]"
        yield f'type = "{light.kind}"'
        yield from _light_keys(light, assets)
        yield ""


def _camera_keys(camera: Camera, assets: Assets) -> Iterator[str]:
    """Yield the attributes of a camera as lines `key = value`."""
    is_pinhole = camera.projection is None and camera.height is None
    for attribute, parameter in parameters_of(Camera).items():
        value = getattr(camera, attribute)
        if isinstance(parameter, Part) and value is not None:
            table = _table(parameter, value, assets, camera.name or attribute)
            yield f"{attribute} = {table}"
        elif value not in (None, "") and (attribute != "fov" or is_pinhole):
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
