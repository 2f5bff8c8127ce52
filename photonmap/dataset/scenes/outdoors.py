"""Gardens, terraces and streets: what encloses them, what stands there, and the sky above."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from photonmap.dataset.models import furniture, lamps, plants, small_objects
from photonmap.dataset.models.arrangements import furnish
from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import Row, SceneObject, Table, model, placed, sized
from photonmap.dataset.models.shapes import Noise, box, grid, level, upright
from photonmap.dataset.models.small_objects import bowl, cup, vase
from photonmap.dataset.scenes.exposure import SKY
from photonmap.dataset.scenes.rooms import groups, shell
from photonmap.dataset.scenes.rooms.catalogue import (
    CORNER,
    FREE,
    WALL,
    Entry,
    add_lamps,
    build_until_seen,
    place_entries,
)
from photonmap.dataset.scenes.rooms.groups import alone, seats_facing, shifted, side_by_side
from photonmap.dataset.scenes.rooms.room_builder import Group, RoomBuilder
from photonmap.dataset.scenes.rooms.shell import BACK, TURNS, Floor, Size
from photonmap.dataset.scenes.unlit_scene import OpenSky, UnlitScene

MakeSide = Callable[[Draw, float], Iterable[Row]]
"""Makes one side of a place, of a length, its inner face at z = 0 and around x = 0."""
_BRACKET, _ATTEMPTS = (1.8, 2.2), 24
"""Heights of wall lanterns, metres, and places that are tried for one."""


def hedge(draw: Draw, length: float) -> Iterable[Row]:
    """Yield a trimmed hedge."""
    tall, rows, columns = draw.number(1.4, 2.2), 24, max(8, round(length / 0.08))
    across, up = np.meshgrid(
        np.linspace(-0.5 * length, 0.5 * length, columns), np.linspace(0.0, tall, rows)
    )
    points = np.stack([across, up, np.zeros_like(up)], axis=-1)
    depth = 0.035 * Noise(draw.rng, 1.3, octaves=4)(points.reshape(-1, 3))
    points[..., 2] = np.minimum(depth - 0.08, -0.005).reshape(rows, columns)
    yield grid(points), 0.0, draw.leaf()
    yield box(length, 0.04, 0.6, 0.01), (0.0, tall - 0.05, -0.36), draw.leaf()


def fence(draw: Draw, length: float) -> Iterable[Row]:
    """Yield a fence of boards, every other one set back, on two rails."""
    tall, count = draw.number(1.5, 2.0), max(6, round(length / 0.14))
    wide, woods = length / count, [draw.wood(), draw.wood()]
    board = box(wide - 0.008, tall, 0.02, 0.003, 1)
    for index in range(count):
        place = (index + 0.5) * wide - 0.5 * length, 0.0, -0.012 - 0.022 * (index % 2)
        yield board, place, woods[index % 2]
    yield box(length, tall - 0.04, 0.02, 0.003, 1), (0.0, 0.0, -0.06), woods[0]


def brick_wall(draw: Draw, length: float) -> Iterable[Row]:
    """Yield a wall of courses of bricks in three similar colours, joints painted like them."""
    tall, hue = draw.number(1.5, 2.4), draw.number(8.0, 16.0)
    colors = [draw.chip(hue, (4, 6), (4, 6), 3.0) for _ in range(3)]
    wide, half, rows = 0.3, 0.5 * length, round(tall / 0.12)
    for row in range(rows):
        ends = np.arange(-half + 0.5 * wide * (row % 2), half, wide)
        ends = np.unique(np.clip([-half, *ends, half], -half, half))
        for left, right in pairwise(ends.tolist()):
            brick = upright(left, row * tall / rows, right - left, tall / rows)
            yield brick, 0.0, draw.material_among(colors)


@model("ground")
def lawn(draw: Draw, size: Size) -> Table:
    """Return a lawn with a path of slabs that leads across."""
    width, _, depth = size
    path, x = draw.number(0.8, 1.2), draw.number(-0.2, 0.2) * width
    green, stone = draw.leaf(), [draw.grey(6), draw.chip(None, (6, 7), (2, 2))]
    for low, high in ((-0.5 * width, x - 0.5 * path), (x + 0.5 * path, 0.5 * width)):
        yield level(low, 0.5 * depth, high - low, depth), 0.0, green
    count = math.ceil(depth / 0.6)
    for index in range(count):
        slab = level(x - 0.5 * path, 0.5 * depth - index * depth / count, path, depth / count)
        yield slab, 0.0, stone[index % 2]


@model("ground")
def paving(draw: Draw, size: Size) -> Table:
    """Return slabs in three similar colours."""
    side, hue = draw.number(0.35, 0.6), draw.number(0.0, 100.0)
    colors = [draw.chip(hue, (5, 7), (2, 2), 8.0) for _ in range(2)] + [draw.grey(6)]
    for slab in shell.slabs_of(size, side)[2]:
        yield slab, 0.0, draw.material_among(colors)


@model("ground")
def road(draw: Draw, size: Size) -> Table:
    """Return a road along x with a broken line, between two pavements with kerbs."""
    width, _, depth = size
    edge, kerb, wide = 0.5 * depth - draw.number(1.6, 2.2), 0.14, 0.12
    stone, rim, asphalt = draw.chip(None, (5, 7), (2, 2)), draw.grey(7), draw.grey(3)
    half = 0.5 * depth
    lines = [-half, -edge - kerb, -edge, -0.5 * wide, 0.5 * wide, edge, edge + kerb, half]
    strips = [stone, rim, asphalt, None, asphalt, rim, stone]
    for (low, high), material in zip(pairwise(lines), strips, strict=True):
        count = 1 if material else max(2, round(width / 0.9))
        for index in range(count):
            piece = level((index / count - 0.5) * width, high, width / count, high - low)
            yield piece, 0.0, material or (draw.grey(9) if index % 2 else asphalt)


@model("walls")
def _walls(yard: RoomBuilder, sides: Sequence[MakeSide]) -> Table:
    """Return the front of a house around its windows, and what encloses the place otherwise."""
    width, height, _ = yard.size.tolist()
    pieces = shell.wall_pieces(width, height, yard.windows.get(BACK, ()))
    paint = yard.draw.pale()
    makers: Sequence[MakeSide] = (lambda *_: ((each, 0.0, paint) for each in pieces), *sides)
    for (wall, turn), make in zip(TURNS.items(), makers, strict=True):
        x, z = shell.in_front_of(wall, yard.size, 0.0, 0.0)
        for part in placed(make(yard.draw, shell.length_of(wall, yard.size))):
            yield part.shape.turned(turn), (x, 0.0, z), part.material


@model("eaves")
def _eaves(yard: RoomBuilder) -> Table:
    """Return the edge of the roof, on top of the house front."""
    x, z = shell.in_front_of(BACK, yard.size, 0.0, 0.1)
    place = x, float(yard.size[1]), z
    yield box(float(yard.size[0]), 0.14, 0.45, 0.01), place, yard.draw.chip(12.0, (3, 5), (2, 6))


@dataclass(frozen=True)
class YardKind:
    """A kind of place outdoors.

    Parameters
    ----------
    size : ranges of width, depth and height, metres; the height is that of the house
    entries : what stands there, the most important first
    ground : makes it
    sides : one of which is drawn for each of the three sides
    """

    size: tuple[Range, Range, Range]
    entries: Sequence[Entry]
    ground: Floor
    sides: Sequence[MakeSide] = (hedge, fence, brick_wall)


def shrub(draw: Draw) -> Group:
    """Return one to three shrubs side by side."""
    made = ((plants.shrub(draw, draw.number(0.25, 0.5)), 0.02) for _ in range(draw.whole(1, 3)))
    return Group(side_by_side(made))


def garden_seats(draw: Draw) -> Group:
    """Return a laid table with chairs on both sides."""
    table = furniture.garden_table(draw)
    makers = [*[cup] * draw.whole(1, 3), sized(bowl, 0.13), sized(vase, 0.2)]
    group = furnish(draw, table, makers)
    return Group(group + seats_facing(draw, (-0.32, 0.32), 0.4, (0.22, 0.4), 12.0))


def parasol_seats(draw: Draw) -> Group:
    """Return a cafe table beside a parasol."""
    seats, parasol = groups.cafe_table(draw).objects, furniture.parasol(draw)
    return Group([*seats, *shifted([parasol], draw.number(1.0, 1.1), 1.0)])


def park_bench(draw: Draw) -> Group:
    """Return a bench, perhaps with a litter bin beside it."""
    wide = draw.number(1.2, 1.7)
    group = [furniture.bench(draw, wide)]
    if draw.chance(0.6):
        group += shifted([small_objects.litter_bin(draw)], 0.5 * wide + 0.4, 0.0)
    return Group(group, 0.4)


tree = alone(lambda draw: plants.tree(draw, draw.number(2.4, 3.6)))
planter = alone(lambda draw: plants.planter(draw, draw.number(0.8, 1.6)))
street_lamp, bollard = alone(lamps.street_lamp), alone(lamps.bollard)

# fmt: off
YARDS = {
    "garden": YardKind(
        ((6.5, 9.0), (6.0, 8.5), (3.6, 5.0)),
        [(garden_seats, FREE, 1, 1), (tree, CORNER, 1, 2), (tree, FREE, 0, 1),
         (shrub, WALL, 3, 7), (planter, WALL, 0, 2), (park_bench, WALL, 0, 1),
         (bollard, FREE, 1, 3)], lawn),
    "terrace": YardKind(
        ((5.5, 8.0), (5.0, 7.0), (3.4, 4.6)),
        [(parasol_seats, FREE, 1, 2), (groups.cafe_table, FREE, 1, 3), (planter, WALL, 2, 4),
         (groups.plant, CORNER, 1, 3), (park_bench, WALL, 0, 1), (bollard, WALL, 1, 2)], paving),
    "street": YardKind(
        ((7.0, 9.5), (6.4, 7.6), (4.2, 5.6)),
        [(tree, WALL, 2, 4), (park_bench, WALL, 1, 2), (street_lamp, WALL, 2, 3),
         (planter, WALL, 2, 4), (groups.crates, WALL, 0, 2), (bollard, WALL, 1, 3),
         (shrub, WALL, 1, 3)], road),
}
"""Kinds of places outdoors by name."""
# fmt: on


def _build(name: str, draw: Draw, scale: float) -> UnlitScene | None:
    """Generate a place outdoors: its size, sides, what stands there, camera and colours."""
    kind = YARDS[name]
    width, depth, height = (draw.number(*each) * scale for each in kind.size)
    yard = RoomBuilder(draw, width, depth, height)
    furnished = _furnish(yard, kind, scale)
    sides = draw.several(kind.sides, 3)
    if not furnished:
        return None
    surroundings = [kind.ground(draw, yard.size), _walls(yard, sides), _eaves(yard)]
    # The sun stands in front of the house, or to a side of it.
    return yard.build(
        name, SKY, surroundings, lambda meter: OpenSky.over(meter, draw.number(105.0, 255.0))
    )


def _furnish(yard: RoomBuilder, kind: YardKind, scale: float) -> bool:
    """Fill a place; return whether there is room for what matters most."""
    draw = yard.draw
    if not yard.add_door(BACK):
        return False
    for _ in range(draw.whole(2, 4)):
        yard.add_window(BACK, (0.9, draw.number(0.8, 1.6), draw.number(1.1, 1.5)), False)
    return place_entries(yard, kind.entries, scale) and add_lamps(
        yard, lambda: _add_lantern(yard, lamps.wall_lantern(draw))
    )


def _add_lantern(yard: RoomBuilder, made: SceneObject) -> bool:
    """Hang a lantern on the house; return whether there was room."""
    for _ in range(_ATTEMPTS):
        along, height = yard.along(BACK, 0.4), yard.draw.number(*_BRACKET)
        if along is not None and yard.hang_at([made], BACK, along, height):
            return True
    return False


OUTDOORS: dict[str, Callable[[Draw, float], UnlitScene]] = {
    name: partial(build_until_seen, _build, name) for name in YARDS
}
"""Builders of places outdoors by name."""
