"""Write what TOML scenes hold: materials, cameras and lights."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from photonmap.io.writers.assets import Assets
from photonmap.scene.camera import Camera
from photonmap.scene.lights import Light
from photonmap.scene.material import Material
from photonmap.scene.parameters import Colored, File, Numbers, Parameter, Part, Whole, parameters_of
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
            text = _value(parameter, value, assets, f"{name} {attribute}")
            yield f"{parameter.key or attribute} = {text}"
        yield ""


def write_cameras(cameras: Sequence[Camera], assets: Assets) -> Iterator[str]:
    """Yield the lines that describe cameras."""
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
        if value not in (None, "") and (attribute != "fov" or is_pinhole):
            text = _value(parameter, value, assets, camera.name or attribute)
            yield f"{attribute} = {text}"


def _table(part: Part, value: Any, assets: Assets, label: str) -> str:
    """Write an object with parameters of its own as a table in one line."""
    pairs = [f"type = {_text(value.kind)}"] * (len(part.kinds) > 1)
    for attribute, parameter in parameters_of(type(value)).items():
        if (held := getattr(value, attribute)) is not None:
            text = _value(parameter, held, assets, label)
            pairs.append(f"{parameter.key or attribute} = {text}")
    return f"{{ {', '.join(pairs)} }}"


def _value(parameter: Parameter, value: Any, assets: Assets, label: str) -> str:
    """Write a value as its parameter declares; files are named after a label."""
    match parameter:
        case Part():
            return _table(parameter, value, assets, label)
        case Colored():
            return _text(assets.color(value, label))
        case File():
            return _text(assets.file(parameter, value, label))
        case Whole() | Numbers(each=Whole()):
            return json.dumps(value)
    return _text(value)


def _light_keys(light: Light, assets: Assets) -> Iterator[str]:
    """Yield the attributes of a light as lines `key = value`."""
    for attribute, parameter in parameters_of(type(light)).items():
        value = getattr(light, attribute)
        if isinstance(parameter, Colored | File) or value != "":
            is_color = isinstance(parameter, Colored)
            label = f"light {light.name!r}" if is_color else light.name or light.kind
            yield f"{parameter.key or attribute} = {_value(parameter, value, assets, label)}"


def _text(value: Any) -> str:
    """Write a text, a number or a vector as TOML."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float | int):
        return repr(float(value))
    return f"[{', '.join(repr(float(number)) for number in value)}]"
