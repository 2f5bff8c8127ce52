"""Read emitters that are not surfaces."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.mitsuba_parts.colors import combined
from photonmap.io.readers.mitsuba_parts.context import Context
from photonmap.io.readers.mitsuba_parts.environment import read_environment
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.textures import read_plain
from photonmap.io.readers.mitsuba_parts.values import plain
from photonmap.scene.lights import (
    DirectionalLight,
    DomeLight,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
    check_light,
)
from photonmap.spectra.curves import Color

_NARROW = 2.0
"""Width, degrees, of an edge so narrow that its falloff does not matter."""
_D65 = 1.0, 1.0, 1.0


def read_emitters(context: Context, nodes: Iterable[Node]) -> list[Light]:
    """Return the lights of emitters.

    Raises
    ------
    InputError : one is of an unknown type, a value is not valid, or two are all around
    """
    lights, around = [], None
    for node in nodes:
        if node.type in _AROUND:
            if around is not None:
                place = around.element.place(node.element.path)
                raise node.error(f"there is light all around from {place} too; remove one of them")
            around = node
        lights.append(_read_emitter(context, node))
    return lights


def _read_emitter(context: Context, node: Node) -> Light:
    """Return the light of an emitter."""
    if node.type not in _TYPES:
        raise node.unknown(_TYPES)
    name = context.name("light", node) if node.id else ""
    light = _TYPES[node.type](context, node, name)
    try:
        light = check_light(light)
    except InputError as invalid:
        raise node.error(str(invalid)) from None
    node.read.add("sampling_weight")
    context.lose_unread(node)
    return light


def _amount(context: Context, node: Node, name: str) -> Color:
    return read_plain(context, node, name, _D65, "emission")


def _point(context: Context, node: Node, name: str) -> Light:
    place = plain(node.transform()[:3, 3])
    return PointLight(node.vector("position", place), _amount(context, node, "intensity"), name)


def _spot(context: Context, node: Node, name: str) -> Light:
    """Return a spot, whose intensity falls linearly with the angle between its beam and its edge.

    As photonmap's own spots fall in another way, it is a table unless that range is narrow.
    """
    matrix = node.transform()
    origin, target = plain(matrix[:3, 3]), plain(matrix[:3, 3] + matrix[:3, 2])
    intensity = _amount(context, node, "intensity")
    edge = node.number("cutoff_angle", 20.0)
    beam = node.number("beam_width", 0.75 * edge)
    if edge - beam < _NARROW:
        return SpotLight(origin, target, intensity, beam, edge, name=name)
    angles = np.linspace(0.0, 180.0, 181)
    falloff = np.clip((edge - angles) / (edge - beam), 0.0, 1.0)
    mean = float(np.average(falloff, weights=np.sin(np.radians(angles))))
    mean_intensity = combined(lambda value: mean * value, intensity)
    direction, side = plain(matrix[:3, 2]), plain(matrix[:3, 0])
    table = np.stack([falloff, falloff], axis=1)
    return PhotometricLight(origin, table, mean_intensity, direction, side, name)


def _directional(context: Context, node: Node, name: str) -> Light:
    ahead = plain(node.transform()[:3, 2])
    return DirectionalLight(
        node.vector("direction", ahead), _amount(context, node, "irradiance"), name
    )


def _constant(context: Context, node: Node, name: str) -> Light:
    return DomeLight(_amount(context, node, "radiance"), name)


_TYPES: dict[str, Callable[[Context, Node, str], Light]] = {
    "point": _point,
    "spot": _spot,
    "directional": _directional,
    "constant": _constant,
    "envmap": read_environment,
}
_AROUND = ("constant", "envmap")
