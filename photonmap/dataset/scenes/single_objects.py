"""Single objects in front of a neutral backdrop, between four area lights."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.patterns import (
    banded,
    checkerboard,
    dots,
    patches,
    rings,
    sections,
    split,
    waves,
    zigzag,
)
from photonmap.dataset.models.scene_object import (
    Part,
    SceneObject,
    Table,
    model,
    multi_part,
    with_lightness,
)
from photonmap.dataset.models.shapes import (
    Shape,
    arc,
    box,
    cone,
    cylinder,
    joined,
    knot,
    lattice,
    lump,
    normalised,
    superquadric,
)
from photonmap.dataset.models.small_objects import (
    FINE,
    bowl_shape,
    cup_shapes,
    ring_tower,
    vase_shape,
)
from photonmap.dataset.scenes.exposure import LightMeter
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.scene.camera import Camera

FOV = 26.0
"""Field of view of the camera, degrees."""
_FILLS = 0.74  # fraction of a square image's width or height that the object takes up
_RIBBONS = ((2, 3, 0.034), (3, 2, 0.0228), (2, 5, 0.0228))
"""Windings of ribbons around the axis and the ring, and radii at which they stay apart, metres."""
_STEPS = 480  # steps along a ribbon
_LIGHTS = {
    "key light": (-48.0, 42.0, 0.9),
    "side light": (62.0, 24.0, 0.7),
    "top light": (20.0, 72.0, 0.6),
    "low light": (-14.0, 30.0, 0.35),
}
"""Square area lights: azimuth from +z and elevation, degrees, and side, metres."""
_LIGHT_DISTANCE = 1.9  # distance of the area lights from the object, metres


def vase(draw: Draw) -> SceneObject:
    """Return a vase whose foot and neck have another colour than its belly."""
    shape = vase_shape(draw.rng, 0.3, detail=FINE)
    tall = float(shape.vertices[:, 1].max())
    low, high = draw.number(0.12, 0.35) * tall, draw.number(0.6, 0.85) * tall
    belly, rest = map(draw.glazed, draw.colors(2, (4, 8)))
    return multi_part("vase", banded(shape, low, high), [rest, belly])


def bowl(draw: Draw) -> SceneObject:
    """Return a bowl in two colours that meet in a zigzag line."""
    shape = bowl_shape(draw.rng, 0.17, FINE)
    tall = float(shape.vertices[:, 1].max())
    halves = split(shape, zigzag(0.55 * tall, 16, 0.12 * tall))
    return multi_part("bowl", halves, [*map(draw.glazed, draw.colors(2, (5, 7)))])


def jug(draw: Draw) -> SceneObject:
    """Return a jug with twisted stripes and a plain rim and handle."""
    body, handle = cup_shapes(draw.rng, 0.26, FINE, slim=0.8)
    low, high = banded(body, 0.215)
    shapes = [*split(low, waves(7, 260.0)), joined([high, handle])]
    colors = [*map(draw.glazed, draw.colors(3, (4, 8)))]
    return multi_part("jug", [shape.turned(35.0) for shape in shapes], colors)


def boulder(draw: Draw) -> SceneObject:
    """Return a lump in patches of four colours."""
    pieces = patches(draw.rng, lump(draw.rng, 0.14, 0.15, 0.5), 4, 0.13)
    return multi_part("boulder", pieces, draw.colors(4, (4, 8), 4.0))


def ribbon(draw: Draw) -> SceneObject:
    """Return a torus knot in sections of two colours."""
    p, q, thickest = draw.one_of(_RIBBONS)
    thick = thickest * draw.number(0.75, 1.0)
    shape = knot(0.12, thick, p, q, _STEPS).turned(draw.number(-35.0, 35.0))
    colors = [*map(draw.glazed, draw.colors(2, (4, 7), 8.0))]
    return multi_part("ribbon", sections(shape, draw.whole(4, 9), _STEPS), colors)


def cushion(draw: Draw) -> SceneObject:
    """Return a superquadric, checked in two colours, with dots of a third."""
    exponents = draw.number(0.3, 0.7), draw.number(0.3, 0.7)
    shape = superquadric((0.26, 0.26, 0.26), *exponents, rows=160, columns=224)
    shape = shape.turned(draw.number(20.0, 50.0))
    first, second, third = draw.colors(3, (4, 8))
    spots, rest = split(shape, dots(draw.rng, shape, 0.028, 46))
    pieces = checkerboard(rest, waves(4), rings(0.13, 0.25))
    return multi_part("cushion", [spots, *pieces], [third, first, second])


def tower(draw: Draw) -> SceneObject:
    """Return a toy tower of stacked rings."""
    return ring_tower(draw, 0.12, draw.whole(5, 6), 120)


@model("castle")
def castle(draw: Draw) -> Table:
    """Return a castle of toy blocks: pillars, a beam, an upper storey and roofs."""
    s, lean, colors = 0.06, draw.rng.uniform(-7.0, 7.0, 4), draw.colors(11, (4, 8))
    blocks = (
        (box(s, 1.4 * s, s).turned(float(lean[0])), (-1.5 * s, 0.0, 0.0)),
        (box(s, 1.4 * s, s).turned(float(lean[1])), (1.5 * s, 0.0, 0.0)),
        (cylinder(0.5 * s, 1.4 * s), (0.0, 0.0, 0.1 * s)),
        (box(4.3 * s, 0.5 * s, 1.1 * s).turned(float(0.3 * lean[2])), (0.0, 1.4 * s, 0.0)),
        (box(s, s, s).turned(float(2 * lean[3])), (-1.3 * s, 1.9 * s, 0.0)),
        (cylinder(0.45 * s, s), (1.4 * s, 1.9 * s, 0.0)),
        (box(1.2 * s, 1.6 * s, 0.9 * s), (0.05 * s, 1.9 * s, 0.0)),
        (cone(0.6 * s, 0.03 * s, 1.1 * s), (-1.3 * s, 2.9 * s, 0.0)),
        (cone(0.55 * s, 0.03 * s, 1.3 * s), (1.4 * s, 2.9 * s, 0.0)),
        (superquadric((1.3 * s, 0.7 * s, s), 1.0, 0.4, 48, 64), (0.05 * s, 3.5 * s, 0.0)),
        (box(1.6 * s, 0.6 * s, s).turned(25.0), (-0.6 * s, 0.0, 1.9 * s)),
    )
    for (shape, place), color in zip(blocks, colors, strict=True):
        yield shape, place, draw.glazed(color)


_MAKERS = (vase, bowl, jug, boulder, ribbon, cushion, tower, castle)
OBJECTS: dict[str, Callable[[Draw], SceneObject]] = {make.__name__: make for make in _MAKERS}
"""Makers of single objects, about 0.3 m in size, by name."""


def build_object(name: str, draw: Draw) -> UnlitScene:
    """Build an object on a grey sweep between four area lights, framed by the camera."""
    obj = OBJECTS[name](draw)
    center = obj.bounds.mean(axis=0)
    view = _direction(draw.number(-8.0, 8.0), 26.0 if name == "bowl" else 14.0)
    camera = frame(obj, center, view)
    panels = []
    for group, (azimuth, elevation, side) in _LIGHTS.items():
        position = center + _LIGHT_DISTANCE * _direction(azimuth, elevation)
        part = Part(panel(position, center, side), draw.grey(2), group)
        panels.append(SceneObject(group, [part]))
    backdrop = multi_part("backdrop", [sweep(3.0, 1.1, 2.4)], [draw.grey(7)])
    objects = with_lightness([backdrop, obj, *panels], draw.lightness)
    meter = LightMeter(objects, camera, closed=False)
    received = {group: meter.irradiance(group) for group in _LIGHTS}
    return UnlitScene(name, objects, camera, received, ("backdrop", *_LIGHTS))


def frame(obj: SceneObject, center: np.ndarray, view: np.ndarray) -> Camera:
    """Return a camera, in a direction from its target, into whose image an object fits."""
    right = normalised(np.cross((0.0, 1.0, 0.0), view))
    axes = np.stack([right, np.cross(view, right), view])
    points = np.concatenate([part.shape.vertices for part in obj.parts]) - center
    x, y, z = axes @ points.T
    reach = _FILLS * math.tan(math.radians(FOV) / 2)
    away = float((z + np.maximum(np.abs(x), np.abs(y)) / reach).max())
    return Camera(tuple((center + away * view).tolist()), tuple(center.tolist()), fov=FOV)


def _direction(azimuth: float, elevation: float) -> np.ndarray:
    """Return a unit vector: azimuth from +z towards +x, elevation above the ground, degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])


def panel(position: np.ndarray, target: np.ndarray, side: float) -> Shape:
    """Return a square around a position that faces a target."""
    front = normalised(target - position)
    right = normalised(np.cross((0.0, 1.0, 0.0), front))
    up = np.cross(front, right)
    corner = position - 0.5 * side * (right + up)
    vertices = corner + side * np.stack([0 * right, right, right + up, up])
    return Shape(vertices, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(front, (4, 1)))


def sweep(width: float, behind: float, tall: float, bend: float = 0.5) -> Shape:
    """Return a photographer's sweep: a floor that curves up into a wall `behind` the origin.

    Its width is given by half, its bend by the radius, metres.
    """
    turn = arc((-behind + bend, bend), bend, 270.0, 180.0, 24)
    line = np.concatenate([[(1.8, 0.0)], turn, [(-behind, tall)]])
    sides = [np.stack([np.full(len(line), x), line[:, 1], line[:, 0]], 1) for x in (width, -width)]
    faces = lattice(len(line), 2)[:, ::-1]
    return Shape.smooth(np.stack(sides, axis=1).reshape(-1, 3), faces)
