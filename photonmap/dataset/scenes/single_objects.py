"""Single objects in front of a neutral backdrop, between four area lights."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from photonmap.dataset.models.curved_shapes import knot, lump, superquadric
from photonmap.dataset.models.materials.lightness import with_lightness
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import (
    checkerboard,
    dots,
    height,
    patches,
    rings,
    sections,
    split,
    split_at_levels,
    waves,
    zigzag,
)
from photonmap.dataset.models.scene_object import Part, SceneObject, multi_part, single_part
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    arc,
    box,
    cone,
    cylinder,
    joined,
    lattice,
    normalised,
    smooth_normals,
)
from photonmap.dataset.models.small_objects import ring_tower
from photonmap.dataset.models.vessels import FINE, bowl_shape, cup_shapes, vase_shape
from photonmap.dataset.scenes.exposure import LightMeter
from photonmap.dataset.scenes.unlit_scene import UnlitScene
from photonmap.scene.camera import Camera

FOV = 26.0
"""Field of view of the camera, degrees."""
_FILLS = 0.74
"""Fraction of a square image's width or height that the object takes up."""
_RIBBONS = ((2, 3, 0.034), (3, 2, 0.0228), (2, 5, 0.0228))
"""Windings of ribbons around the axis and the ring, and radii at which they stay apart, metres."""
_STEPS = 480
"""Steps along a ribbon."""
_LIGHTS = {
    "key light": (-48.0, 42.0, 0.9),
    "side light": (62.0, 24.0, 0.7),
    "top light": (20.0, 72.0, 0.6),
    "low light": (-14.0, 30.0, 0.35),
}
"""Square area lights: azimuth from +z and elevation, degrees, and side, metres."""
_LIGHT_DISTANCE = 1.9
"""Distance of the area lights from the object, metres."""


def vase(rng: Random, palette: Palette) -> SceneObject:
    """Return a vase whose foot and neck have another colour than its belly."""
    shape = vase_shape(rng, 0.3, detail=FINE)
    tall = float(shape.vertices[:, 1].max())
    low, high = float(rng.uniform(0.12, 0.35)) * tall, float(rng.uniform(0.6, 0.85)) * tall
    belly, rest = (palette.glazed(color) for color in palette.colors(2, (4, 8)))
    return multi_part("vase", split_at_levels(shape, height, [low, high]), [rest, belly])


def bowl(rng: Random, palette: Palette) -> SceneObject:
    """Return a bowl in two colours that meet in a zigzag line."""
    shape = bowl_shape(rng, 0.17, FINE)
    tall = float(shape.vertices[:, 1].max())
    low, high = split(shape, zigzag(0.55 * tall, 16, 0.12 * tall))
    first, second = palette.colors(2, (5, 7))
    return multi_part("bowl", [low, high], [palette.glazed(first), palette.glazed(second)])


def jug(rng: Random, palette: Palette) -> SceneObject:
    """Return a jug with twisted stripes and a plain rim and handle."""
    body, handle = cup_shapes(rng, 0.26, FINE, slim=0.8)
    low, high = split_at_levels(body, lambda points: points[:, 1], [0.215])
    first, second, third = palette.colors(3, (4, 8))
    stripes = split(low, waves(7, 260.0))
    parts = [Part(s, palette.glazed(m)) for s, m in zip(stripes, (first, second), strict=True)]
    parts += [Part(joined([high, handle]), palette.glazed(third))]
    return SceneObject("jug", [Part(p.shape.turned(35.0), p.material) for p in parts])


def boulder(rng: Random, palette: Palette) -> SceneObject:
    """Return a lump in patches of four colours."""
    shape = lump(rng, 0.14, 0.15, 0.5)
    return multi_part("boulder", patches(rng, shape, 4, 0.13), palette.colors(4, (4, 8), 4.0))


def ribbon(rng: Random, palette: Palette) -> SceneObject:
    """Return a torus knot in sections of two colours."""
    p, q, thickest = _RIBBONS[int(rng.integers(len(_RIBBONS)))]
    thick = thickest * float(rng.uniform(0.75, 1.0))
    shape = knot(0.12, thick, p, q, _STEPS).turned(float(rng.uniform(-35.0, 35.0)))
    colors = [palette.glazed(color) for color in palette.colors(2, (4, 7), 8.0)]
    return multi_part("ribbon", sections(shape, int(rng.integers(4, 10)), _STEPS), colors)


def cushion(rng: Random, palette: Palette) -> SceneObject:
    """Return a superquadric, checked in two colours, with dots of a third."""
    north, east = rng.uniform(0.3, 0.7, 2)
    shape = superquadric((0.26, 0.26, 0.26), float(north), float(east), 160, 224)
    shape = shape.turned(float(rng.uniform(20.0, 50.0)))
    first, second, third = palette.colors(3, (4, 8))
    spots, rest = split(shape, dots(rng, shape, 0.028, 46))
    pieces = checkerboard(rest, waves(4), rings(0.13, 0.25))
    return multi_part("cushion", [spots, *pieces], [third, first, second])


def tower(rng: Random, palette: Palette) -> SceneObject:
    """Return a toy tower of stacked rings."""
    return ring_tower(palette, 0.12, int(rng.integers(5, 7)), 120)


def castle(rng: Random, palette: Palette) -> SceneObject:
    """Return a castle of toy blocks: pillars, a beam, an upper storey and roofs."""
    colors = iter(palette.colors(11, (4, 8)))

    def part(shape: Shape, x: float, y: float, z: float = 0.0) -> Part:
        return Part(shape.moved((x, y, z)), palette.glazed(next(colors)))

    s = 0.06
    lean = rng.uniform(-7.0, 7.0, 4)
    parts = [
        part(box(s, 1.4 * s, s).turned(float(lean[0])), -1.5 * s, 0.0),
        part(box(s, 1.4 * s, s).turned(float(lean[1])), 1.5 * s, 0.0),
        part(cylinder(0.5 * s, 1.4 * s), 0.0, 0.0, 0.1 * s),
        part(box(4.3 * s, 0.5 * s, 1.1 * s).turned(float(0.3 * lean[2])), 0.0, 1.4 * s),
        part(box(s, s, s).turned(float(2 * lean[3])), -1.3 * s, 1.9 * s),
        part(cylinder(0.45 * s, s), 1.4 * s, 1.9 * s),
        part(box(1.2 * s, 1.6 * s, 0.9 * s), 0.05 * s, 1.9 * s),
        part(cone(0.6 * s, 0.03 * s, 1.1 * s), -1.3 * s, 2.9 * s),
        part(cone(0.55 * s, 0.03 * s, 1.3 * s), 1.4 * s, 2.9 * s),
        part(superquadric((1.3 * s, 0.7 * s, s), 1.0, 0.4, 48, 64), 0.05 * s, 3.5 * s),
        part(box(1.6 * s, 0.6 * s, s).turned(25.0), -0.6 * s, 0.0, 1.9 * s),
    ]
    return SceneObject("castle", parts)


OBJECTS: dict[str, Callable[[Random, Palette], SceneObject]] = {
    "vase": vase,
    "bowl": bowl,
    "jug": jug,
    "boulder": boulder,
    "ribbon": ribbon,
    "cushion": cushion,
    "tower": tower,
    "castle": castle,
}
"""Makers of single objects, about 0.3 m in size, by name."""


def build_object(name: str, rng: Random, palette: Palette) -> UnlitScene:
    """Build an object on a grey sweep between two area lights, framed by the camera."""
    obj = OBJECTS[name](rng, palette)
    center = obj.bounds.mean(axis=0)
    view = _direction(float(rng.uniform(-8.0, 8.0)), 26.0 if name == "bowl" else 14.0)
    camera = frame(obj, center, view)
    backdrop = single_part("backdrop", sweep(3.0, 1.1, 2.4), palette.grey(7))
    panels = []
    for group, (azimuth, elevation, side) in _LIGHTS.items():
        position = center + _LIGHT_DISTANCE * _direction(azimuth, elevation)
        panels.append(
            SceneObject(group, [Part(panel(position, center, side), palette.grey(2), group)])
        )
    objects = with_lightness([backdrop, obj, *panels], palette.lightness)
    meter = LightMeter(objects, camera, closed=False)
    received = {group: meter.irradiance(group) for group in _LIGHTS}
    return UnlitScene(name, objects, camera, received, ("backdrop", *_LIGHTS))


def frame(obj: SceneObject, center: np.ndarray, view: np.ndarray) -> Camera:
    """Return a camera that looks at the centre of an object and fits it into the image.

    Parameters
    ----------
    center : (3,) the target, metres
    view : (3,) unit vector from the target towards the camera
    """
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
    """Return a photographer's sweep: a floor that curves up into a wall behind the origin.

    Parameters
    ----------
    width : half the width, metres
    behind : distance of the wall from the origin, metres
    tall : height of the wall, metres
    bend : radius of the curve, metres
    """
    turn = arc((-behind + bend, bend), bend, 270.0, 180.0, 24)
    line = np.concatenate([[(1.8, 0.0)], turn, [(-behind, tall)]])
    sides = [np.stack([np.full(len(line), x), line[:, 1], line[:, 0]], 1) for x in (width, -width)]
    vertices = np.stack(sides, axis=1).reshape(-1, 3)
    faces = lattice(len(line), 2)[:, ::-1]
    return Shape(vertices, faces, smooth_normals(vertices, faces))
