"""Lights and cameras in words and numbers."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from photonmap.compile.scene_arrays import CompiledScene
from photonmap.inspection.surfaces import describe_color
from photonmap.scene.camera import Camera
from photonmap.scene.lights import (
    EnvironmentLight,
    Light,
    PhotometricLight,
    SpotLight,
    check_light,
    name_lights,
)
from photonmap.scene.parameters import Direction, File, Number, Point, parameters_of
from photonmap.scene.scene import Scene
from photonmap.scene.vectors import unit


def describe_area_lights(scene: Scene, compiled: CompiledScene) -> list[dict[str, Any]]:
    """Return what the JSON says of each emitting surface: of an object, and of a material."""
    is_area = compiled.lights.triangle >= 0
    triangles = compiled.lights.triangle[is_area]
    if not len(triangles):
        return []
    pairs = np.stack([compiled.object_ids[triangles], compiled.material_ids[triangles]], axis=1)
    owners, owner = np.unique(pairs, axis=0, return_inverse=True)
    meshes = [mesh for mesh in scene.meshes if len(mesh.faces)]
    names = list(dict.fromkeys(mesh.name for mesh in meshes))
    total = compiled.light_powers.sum()
    described = []
    for number, (thing, _) in enumerate(owners):
        mine = np.flatnonzero(is_area)[owner.ravel() == number]
        power = float(compiled.light_powers[mine].sum())
        described.append(
            {
                "name": names[thing - 1],
                "material": compiled.light_names[mine[0]],
                "triangles": len(mine),
                "area": float(compiled.lights.area[mine].sum()) * compiled.size**2,
                "power": power,
                "share": power / total,
            }
        )
    return described


def describe_lights(scene: Scene, compiled: CompiledScene) -> list[dict[str, Any]]:
    """Return what the JSON says of the lights that are not surfaces; a dark one has no power.

    In a scene without light, this is the sky in its place.
    """
    powers: dict[str, float] = {}
    areas = []
    for name, triangle, power in zip(
        compiled.light_names, compiled.lights.triangle, compiled.light_powers.tolist(), strict=True
    ):
        if triangle >= 0:
            areas.append(name)
        else:
            powers[name] = power
    total = compiled.light_powers.sum()
    lights = name_lights([check_light(light) for light in scene.lights], areas)
    known = {light.name for light in lights}
    default = [name for name in powers if name not in known]
    return [
        {
            "name": light.name,
            "kind": light.kind,
            "group": light.group or light.name,
            "power": powers.get(light.name, 0.0),
            "share": powers.get(light.name, 0.0) / total,
            **_describe_light(light),
        }
        for light in lights
    ] + [
        {
            "name": name,
            "kind": EnvironmentLight.kind,
            "group": name,
            "power": powers[name],
            "share": 1.0,
        }
        for name in default
    ]


def _describe_light(light: Light) -> dict[str, Any]:
    """Return the amount of a light, where it stands, and in which direction it shines."""
    properties: dict[str, Any] = {}
    if light.color_attribute is not None:
        properties[light.color_attribute] = describe_color(light.color)
    for attribute, parameter in parameters_of(type(light)).items():
        value: Any = getattr(light, attribute)
        if isinstance(parameter, Point | Direction):
            properties[attribute] = list(value)
        elif isinstance(parameter, Number):
            properties[attribute] = value
        elif isinstance(parameter, File):
            is_name = isinstance(value, str | PathLike)
            properties[attribute] = str(value) if is_name else list(np.shape(value))
    if isinstance(light, SpotLight):
        properties["direction"] = list(light.emitter().axis)
    if isinstance(light, PhotometricLight):
        direction = unit(np.array(light.direction))
        assert direction is not None
        properties["direction"] = direction.tolist()
    return properties


def describe_camera(camera: Camera) -> dict[str, Any]:
    """Return what the JSON says of a checked camera."""
    return {
        "name": camera.name,
        "kind": camera.model.kind,
        "origin": list(camera.origin),
        "target": list(camera.target),
        "up": list(camera.up),
        **camera.model.describe(),
        "lens": None if camera.lens is None else camera.lens.describe(),
    }
