"""Read scenes of Mitsuba, versions 2 and 3, and those of 0.x whose names differ."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from photonmap.errors import InputError
from photonmap.io.readers.decoding import Losses, decode_file, plain, point_ahead
from photonmap.io.readers.environment_maps import turned_map
from photonmap.io.readers.mitsuba_colors import combined, read_plain
from photonmap.io.readers.mitsuba_nodes import Context, Node, load_nodes
from photonmap.io.readers.mitsuba_shapes import read_shapes
from photonmap.io.readers.registry import ReadOptions
from photonmap.runtime.files import allowed_folder
from photonmap.runtime.wording import shown, suggest
from photonmap.scene.camera import NOT_IN_FILES, Camera, Lens, check_camera
from photonmap.scene.lights import (
    DirectionalLight,
    DomeLight,
    EnvironmentLight,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
    check_light,
)
from photonmap.scene.parameters import unit
from photonmap.scene.projections import Intrinsics
from photonmap.scene.scene import Scene
from photonmap.spectra.curves import Color

SUFFIXES = (".xml",)

_NARROW = 2.0  # Width, degrees, of an edge so narrow that its falloff does not matter
_AROUND = ("constant", "envmap")
_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC = "perspective", "thinlens", "orthographic"
_SENSORS = (_PERSPECTIVE, _THIN_LENS, _ORTHOGRAPHIC)
_IGNORED = ("near_clip", "far_clip", "shutter_open", "shutter_close", "srf")
_FULL_FRAME = math.hypot(36.0, 24.0)  # Diagonal of the film, mm, to which focal lengths refer


def read(path: Path, options: ReadOptions) -> Scene:
    """Read a scene with its shapes, emitters and sensors.

    Each shape becomes a mesh, called by its id or else its type. Files that the scene names are
    looked up in its folder, and not outside of it.
    """
    return decode_file(path, partial(_decode, options))


def _decode(options: ReadOptions, path: Path, data: bytes, losses: Losses) -> Scene:
    context = Context(path, allowed_folder(path), options.missing_textures, losses)
    scene = load_nodes(path, data, context)
    meshes = [mesh for shape in scene.parts("shape") for mesh in read_shapes(shape)]
    lights = read_emitters(scene.parts("emitter"))
    cameras = [read_sensor(sensor) for sensor in scene.parts("sensor")]
    return Scene(meshes, lights, name=path.stem, cameras=cameras)


def read_emitters(nodes: Iterable[Node]) -> list[Light]:
    """Return the lights of emitters."""
    lights, around = [], None
    for node in nodes:
        if node.type in _AROUND:
            if around is not None:
                place = around.element.place(node.element.path)
                problem = f"the scene has an environment already, in {place}"
                raise node.error(f"{problem}; remove one of them")
            around = node
        lights.append(_read_emitter(node))
    return lights


def _read_emitter(node: Node) -> Light:
    if node.type not in _EMITTERS:
        raise node.unknown(_EMITTERS)
    name = node.unique_name("light") if node.id else ""
    try:
        light = check_light(_EMITTERS[node.type](node, name))
    except InputError as invalid:
        raise node.error(str(invalid)) from None
    node.read.add("sampling_weight")
    node.lose_unread()
    return light


def _amount(node: Node, name: str) -> Color:
    return read_plain(node, name, (1.0, 1.0, 1.0), "emission")


def _point(node: Node, name: str) -> Light:
    place = node.vector("position", plain(node.transform()[:3, 3]))
    return PointLight(place, _amount(node, "intensity"), name)


def _spot(node: Node, name: str) -> Light:
    """Return a spot, whose intensity falls linearly with the angle between its beam and its edge.

    As photonmap's own spots fall in another way, it is a table unless that range is narrow.
    """
    matrix = node.transform()
    origin, target = plain(matrix[:3, 3]), plain(matrix[:3, 3] + matrix[:3, 2])
    intensity = _amount(node, "intensity")
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


def _directional(node: Node, name: str) -> Light:
    ahead = node.vector("direction", plain(node.transform()[:3, 2]))
    return DirectionalLight(ahead, _amount(node, "irradiance"), name)


def _environment(node: Node, name: str) -> EnvironmentLight:
    scale = node.number("scale", 1.0)
    return turned_map(node.file(), node.transform()[:3, :3], scale, name)


_EMITTERS: dict[str, Callable[[Node, str], Light]] = {
    "point": _point,
    "spot": _spot,
    "directional": _directional,
    "constant": lambda node, name: DomeLight(_amount(node, "radiance"), name),
    "envmap": _environment,
}


def read_sensor(node: Node) -> Camera:
    """Return the camera of a sensor; near and far planes cut nothing off."""
    if node.type not in _SENSORS:
        raise node.unknown(_SENSORS)
    matrix = node.transform()
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        node.lose("mirrored view")
    ahead = unit(matrix[:3, 2])
    assert ahead is not None  # transformations do not flatten
    origin, target, up = matrix[:3, 3], point_ahead(matrix[:3, 3], ahead), matrix[:3, 1]
    size = _film_size(node)
    look: dict[str, Any]
    if node.type == _ORTHOGRAPHIC:
        look = {"height": 2.0 * float(np.linalg.norm(matrix[:3, 1])) * size[1] / size[0]}
    else:
        look = _perspective(node, size)
    if node.type == _THIN_LENS and (radius := node.number("aperture_radius", 0.0)) != 0.0:
        if (focus := node.number("focus_distance", 0.0)) == 0.0:
            raise node.error("aperture_radius is given without focus_distance; add one above 0")
        look["lens"] = Lens(focus, radius)
    node.read.update(("", *_IGNORED))
    node.lose_unread()
    name = re.sub(f"[{re.escape(NOT_IN_FILES)}]", "_", node.unique_name("camera"))
    try:
        return check_camera(Camera(plain(origin), target, plain(up), name=name, **look))
    except InputError as invalid:
        raise node.error(str(invalid)) from None


def _film_size(node: Node) -> tuple[int, int]:
    """Return width and height of the film: only their ratio, and a crop, matter."""
    films = node.parts("film")
    if not films:
        return 768, 576
    size = films[-1].whole("width", 768), films[-1].whole("height", 576)
    if not 0 < min(size) <= max(size) <= 1 << 20:
        raise films[-1].error(f"a film of {size[0]}x{size[1]} is not possible; correct its size")
    if any(films[-1].find(f"crop_{what}") for what in ("width", "height")):
        node.lose("crop")
    return size


def _perspective(node: Node, size: tuple[int, int]) -> dict[str, Any]:
    """Return the vertical angle of view; or intrinsics, if the principal point is not central."""
    width, height = size
    sides = {"x": width, "y": height, "diagonal": math.hypot(width, height)}
    sides |= {"smaller": min(size), "larger": max(size)}
    axis = node.text("fov_axis", "x").lower()
    if axis not in sides:
        raise node.error(f"fov_axis {shown(axis)} is not known; {suggest(axis, sides)}")
    if node.find("fov"):
        fov = node.number("fov", 0.0)
    else:
        millimetres = node.element.number(node.text("focal_length", "50mm").removesuffix("mm"))
        fov = 2.0 * math.degrees(math.atan2(0.5 * _FULL_FRAME, millimetres))
        axis = "diagonal"
    if not 0.0 < fov < 180.0:
        raise node.error(f"an angle of view of {fov:g} degrees is not within 0 and 180; correct it")
    focal = 0.5 * sides[axis] / math.tan(math.radians(fov) / 2.0)
    right, down = (node.number(f"principal_point_offset_{axis}", 0.0) for axis in "xy")
    if right == down == 0.0:
        return {"fov": 2.0 * math.degrees(math.atan(0.5 * height / focal))}
    center = (0.5 - right) * width, (0.5 - down) * height
    return {"projection": Intrinsics(focal, size, cx=center[0], cy=center[1])}
