"""Single objects before a neutral backdrop."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from photonmap.dataset.lighting import radiance_of
from photonmap.dataset.palette import Palette
from photonmap.dataset.patterns import checks, divide, dots, levels, patches, rings, waves, zigzag
from photonmap.dataset.setting import Setting
from photonmap.dataset.shapes import (
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
from photonmap.dataset.solids import Random, knot, lump, superquadric
from photonmap.dataset.things import Part, Thing, painted, solid
from photonmap.dataset.toys import ring_tower
from photonmap.dataset.vessels import FINE, bowl_shape, cup_shapes, vase_shape
from photonmap.scene import Camera

FOV = 26.0
_FILLS = 0.74
"""Of a square image's width or height, that the object takes up."""
_LIGHTS = {"key light": (-48.0, 42.0, 0.9), "side light": (62.0, 24.0, 0.7)}
"""Azimuth from the camera and elevation, degrees, and side in metres, of the panels."""
_REACH = 1.9
"""Metres from the object to the panels."""


def vase(rng: Random, palette: Palette) -> Thing:
    """Return a vase of one colour."""
    shape = vase_shape(rng, 0.3, detail=FINE)
    return solid("vase", shape, palette.glazed(palette.chip(None, (5, 6), (6, 10))))


def bowl(rng: Random, palette: Palette) -> Thing:
    """Return a bowl, its inside in another colour, its rim in zigzag."""
    shape = bowl_shape(rng, 0.17, FINE)
    tall = float(shape.vertices[:, 1].max())
    low, high = divide(shape, zigzag(0.55 * tall, 16, 0.12 * tall))
    first, second = palette.colors(2, (5, 7))
    return painted("bowl", [low, high], [palette.glazed(first), palette.glazed(second)])


def jug(rng: Random, palette: Palette) -> Thing:
    """Return a tall cup with twisted stripes and a plain handle."""
    body, handle = cup_shapes(rng, 0.26, FINE, slim=0.8)
    low, high = levels(body, lambda points: points[:, 1], [0.215])
    first, second, third = palette.colors(3, (4, 8))
    stripes = divide(low, waves(7, 260.0))
    parts = [Part(s, palette.glazed(m)) for s, m in zip(stripes, (first, second), strict=True)]
    parts += [Part(joined([high, handle]), palette.glazed(third))]
    return Thing("jug", [Part(p.shape.turned(35.0), p.material) for p in parts])


def boulder(rng: Random, palette: Palette) -> Thing:
    """Return a lump in patches of four colours."""
    shape = lump(rng, 0.14, 0.15, 0.5)
    return painted("boulder", patches(rng, shape, 4, 0.13), palette.colors(4, (4, 8), 4.0))


def ribbon(rng: Random, palette: Palette) -> Thing:
    """Return a torus knot in sectors of two colours."""
    shape = knot(0.12, 0.034, 2, 3, 480).turned(float(rng.uniform(-35.0, 35.0)))
    colors = [palette.glazed(color) for color in palette.colors(2, (4, 7), 8.0)]
    return painted("ribbon", divide(shape, waves(5)), colors)


def cushion(rng: Random, palette: Palette) -> Thing:
    """Return a superquadric in checks of two colours with dots of a third."""
    north, east = rng.uniform(0.3, 0.7, 2)
    shape = superquadric((0.26, 0.26, 0.26), float(north), float(east), 160, 224)
    shape = shape.turned(float(rng.uniform(20.0, 50.0)))
    first, second, third = palette.colors(3, (4, 8))
    spots, rest = divide(shape, dots(rng, shape, 0.028, 46))
    pieces = checks(rest, waves(4), rings(0.13, 0.25))
    return painted("cushion", [spots, *pieces], [third, first, second])


def tower(rng: Random, palette: Palette) -> Thing:
    """Return a toy of stacked rings."""
    return ring_tower(palette, 0.12, int(rng.integers(5, 7)), 120)


def castle(rng: Random, palette: Palette) -> Thing:
    """Return a castle of toy blocks: pillars, beams, an upper storey and roofs."""
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
    return Thing("castle", parts)


OBJECTS: dict[str, Callable[[Random, Palette], Thing]] = {
    "vase": vase,
    "bowl": bowl,
    "jug": jug,
    "boulder": boulder,
    "ribbon": ribbon,
    "cushion": cushion,
    "tower": tower,
    "castle": castle,
}
"""Makers of single objects, about 0.3 m large, by name."""


def build_object(name: str, rng: Random, palette: Palette) -> Setting:
    """Set an object on a grey sweep between two panels of light, and frame it."""
    thing = OBJECTS[name](rng, palette)
    center = thing.bounds.mean(axis=0)
    view = _direction(float(rng.uniform(-8.0, 8.0)), 26.0 if name == "bowl" else 14.0)
    camera = frame(thing, center, view)
    backdrop = solid("backdrop", sweep(3.0, 1.1, 2.4), palette.grey(7))
    panels = []
    for group, (azimuth, elevation, side) in _LIGHTS.items():
        place = center + _REACH * _direction(azimuth, elevation)
        panels.append(Thing(group, [Part(panel(place, center, side), palette.grey(2), group)]))
    radiances = {group: radiance_of(panels, group, center[None]) for group in _LIGHTS}
    return Setting(name, [backdrop, thing, *panels], camera, radiances, ("backdrop", *_LIGHTS))


def frame(thing: Thing, center: np.ndarray, view: np.ndarray) -> Camera:
    """Look at a thing's centre from a direction, so that it fills its share of the image."""
    right = normalised(np.cross((0.0, 1.0, 0.0), view))
    axes = np.stack([right, np.cross(view, right), view])
    points = np.concatenate([part.shape.vertices for part in thing.parts]) - center
    x, y, z = axes @ points.T
    reach = _FILLS * math.tan(math.radians(FOV) / 2)
    away = float((z + np.maximum(np.abs(x), np.abs(y)) / reach).max())
    return Camera(tuple((center + away * view).tolist()), tuple(center.tolist()), fov=FOV)


def _direction(azimuth: float, elevation: float) -> np.ndarray:
    """Return a unit vector: azimuth from +z towards +x, elevation above the ground, degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])


def panel(place: np.ndarray, target: np.ndarray, side: float) -> Shape:
    """Return a square that faces a target."""
    front = normalised(target - place)
    right = normalised(np.cross((0.0, 1.0, 0.0), front))
    up = np.cross(front, right)
    corner = place - 0.5 * side * (right + up)
    vertices = corner + side * np.stack([0 * right, right, right + up, up])
    return Shape(vertices, np.array([[0, 1, 2], [0, 2, 3]]), np.tile(front, (4, 1)))


def sweep(width: float, behind: float, tall: float, bend: float = 0.5) -> Shape:
    """Return a floor that bends up into a wall behind the origin, metres."""
    turn = arc((-behind + bend, bend), bend, 270.0, 180.0, 24)
    line = np.concatenate([[(1.8, 0.0)], turn, [(-behind, tall)]])
    sides = [np.stack([np.full(len(line), x), line[:, 1], line[:, 0]], 1) for x in (width, -width)]
    vertices = np.stack(sides, axis=1).reshape(-1, 3)
    faces = lattice(len(line), 2)[:, ::-1]
    return Shape(vertices, faces, smooth_normals(vertices, faces))
