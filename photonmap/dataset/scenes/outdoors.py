"""Gardens, terraces and streets: what encloses them, what stands there, and the sky above."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from photonmap.dataset.models import furniture, outdoors, public_rooms, vessels
from photonmap.dataset.models.arrangements import furnish
from photonmap.dataset.models.curved_shapes import Noise
from photonmap.dataset.models.lamps import LAMP, numbered
from photonmap.dataset.models.materials.lightness import with_lightness
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.outdoors import leaf_green, wall_lantern
from photonmap.dataset.models.scene_object import Part, SceneObject
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    lattice,
    parallelogram,
    smooth_normals,
)
from photonmap.dataset.scenes.exposure import SKY, LightMeter
from photonmap.dataset.scenes.open_sky import OpenSky
from photonmap.dataset.scenes.rooms import groups, shell
from photonmap.dataset.scenes.rooms.catalogue import add_lamps, build_until_seen, place_entries
from photonmap.dataset.scenes.rooms.groups import alone, draw, shifted, side_by_side
from photonmap.dataset.scenes.rooms.kinds import CORNER, FREE, WALL, Entry, Range
from photonmap.dataset.scenes.rooms.room_builder import Group, RoomBuilder
from photonmap.dataset.scenes.rooms.shell import BACK, TURNS, Size
from photonmap.dataset.scenes.unlit_scene import UnlitScene

MakeGround = Callable[[Random, Palette, Size], list[Part]]
"""Makes the ground of a place of a size along x, y and z, metres."""
MakeSide = Callable[[Random, Palette, float], list[Part]]
"""Makes one side of a place, of a length, its inner face at z = 0 and around x = 0."""


def hedge(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a trimmed hedge."""
    tall, rows = float(rng.uniform(1.4, 2.2)), 24
    columns = max(8, round(length / 0.08))
    across, up = np.meshgrid(
        np.linspace(-0.5 * length, 0.5 * length, columns), np.linspace(0.0, tall, rows)
    )
    points = np.stack([across, up, np.zeros_like(up)], axis=-1).reshape(-1, 3)
    depth = 0.035 * Noise(rng, 1.3, octaves=4)(points)
    points[:, 2] = np.minimum(depth - 0.08, -0.005)
    faces = lattice(rows, columns)
    front = Shape(points, faces, smooth_normals(points, faces))
    top = box(length, 0.04, 0.6, 0.01).moved((0.0, tall - 0.05, -0.36))
    return [Part(front, leaf_green(palette)), Part(top, leaf_green(palette))]


def fence(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a fence of boards, every other one set back, on two rails."""
    tall, count = float(rng.uniform(1.5, 2.0)), max(6, round(length / 0.14))
    wide, woods = length / count, [palette.wood(), palette.wood()]
    parts = []
    for index in range(count):
        x = (index + 0.5) * wide - 0.5 * length
        board = box(wide - 0.008, tall, 0.02, 0.003, 1)
        parts.append(Part(board.moved((x, 0.0, -0.012 - 0.022 * (index % 2))), woods[index % 2]))
    back = box(length, tall - 0.04, 0.02, 0.003, 1).moved((0.0, 0.0, -0.06))
    return [*parts, Part(back, woods[0])]


def brick_wall(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a wall of courses of bricks in three similar colours, joints painted like them."""
    tall = float(rng.uniform(1.5, 2.4))
    hue = float(rng.uniform(8.0, 16.0))
    colors = [palette.chip(hue, (4, 6), (4, 6), 3.0) for _ in range(3)]
    wide, high = 0.3, 0.12
    parts, rows = [], round(tall / high)
    for row in range(rows):
        shift = 0.5 * wide * (row % 2)
        ends = np.arange(-0.5 * length + shift, 0.5 * length, wide)
        ends = np.unique(np.clip([-0.5 * length, *ends, 0.5 * length], -0.5 * length, 0.5 * length))
        for left, right in pairwise(ends.tolist()):
            brick = parallelogram(
                (left, row * tall / rows, 0.0), (right - left, 0.0, 0.0), (0.0, tall / rows, 0.0)
            )
            parts.append(Part(brick, palette.choice(colors)))
    return parts


def lawn(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return a lawn with a path of slabs that leads across."""
    width, _, depth = size
    path, parts = float(rng.uniform(0.8, 1.2)), list[Part]()
    x = float(rng.uniform(-0.2, 0.2)) * width
    green, stone = leaf_green(palette), [palette.grey(6), palette.chip(None, (6, 7), (2, 2))]
    for low, high in ((-0.5 * width, x - 0.5 * path), (x + 0.5 * path, 0.5 * width)):
        grass = parallelogram((low, 0.0, 0.5 * depth), (high - low, 0.0, 0.0), (0.0, 0.0, -depth))
        parts.append(Part(grass, green))
    count = math.ceil(depth / 0.6)
    for index in range(count):
        start = 0.5 * depth - index * depth / count
        slab = parallelogram(
            (x - 0.5 * path, 0.0, start), (path, 0.0, 0.0), (0.0, 0.0, -depth / count)
        )
        parts.append(Part(slab, stone[index % 2]))
    return parts


def paving(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return slabs in three similar colours."""
    width, _, depth = size
    side = float(rng.uniform(0.35, 0.6))
    columns, rows = round(width / side), round(depth / side)
    hue = float(rng.uniform(0.0, 100.0))
    colors = [palette.chip(hue, (5, 7), (2, 2), 8.0) for _ in range(2)] + [palette.grey(6)]
    wide, deep = width / columns, depth / rows
    parts = []
    for i in range(columns):
        for k in range(rows):
            corner = (i * wide - 0.5 * width, 0.0, (k + 1) * deep - 0.5 * depth)
            slab = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, -deep))
            parts.append(Part(slab, palette.choice(colors)))
    return parts


def road(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return a road along x with a broken line, between two pavements with kerbs."""
    width, _, depth = size
    edge, kerb = 0.5 * depth - float(rng.uniform(1.6, 2.2)), 0.14
    stone, rim, asphalt = palette.chip(None, (5, 7), (2, 2)), palette.grey(7), palette.grey(3)
    paint, wide = palette.grey(9), 0.12
    lines = [-0.5 * depth, -edge - kerb, -edge, -0.5 * wide, 0.5 * wide, edge, edge + kerb]
    strips = [stone, rim, asphalt, None, asphalt, rim, stone]
    parts = []
    for low, high, material in zip(lines, [*lines[1:], 0.5 * depth], strips, strict=True):
        count = 1 if material else max(2, round(width / 0.9))
        for index in range(count):
            start, long = (index / count - 0.5) * width, width / count
            piece = parallelogram((start, 0.0, high), (long, 0.0, 0.0), (0.0, 0.0, low - high))
            parts.append(Part(piece, material or (paint if index % 2 else asphalt)))
    return parts


BACKDROP = ("ground", "walls", "eaves", "window")
"""Names of the objects that enclose a place."""
_BRACKET = (1.8, 2.2)
"""Heights of wall lanterns, metres."""


class YardBuilder(RoomBuilder):
    """Builds a place like a room without a ceiling; its back is the front of a house."""

    def add_lantern(self) -> bool:
        """Hang a lantern on the house."""
        made = wall_lantern(self._palette)
        for _ in range(24):
            along = self._along(BACK, 0.4)
            height = float(self._rng.uniform(*_BRACKET))
            if along is not None and self._hang([made], BACK, along, height):
                return True
        return False

    def build_yard(
        self, name: str, ground: MakeGround, sides: Sequence[MakeSide]
    ) -> UnlitScene | None:
        """Return the place with its lights off, or None if no camera sees enough of it.

        Parameters
        ----------
        name : of the scene
        ground : makes the ground
        sides : makers of the left, the front and the right side
        """
        surroundings = [
            SceneObject("ground", ground(self._rng, self._palette, self._size)),
            SceneObject("walls", [*self._house(), *self._sides(sides)]),
            self._eaves(),
        ]
        camera = self._find_camera(surroundings)
        if camera is None:
            return None
        made = [*surroundings, *self._frames, *numbered(self._objects)]
        objects = with_lightness(made, self._palette.lightness)
        meter = LightMeter(objects, camera, closed=False)
        # The sun stands in front of the house, or to a side of it.
        sky = OpenSky.over(meter, float(self._rng.uniform(105.0, 255.0)))
        lamps = [LAMP, *(f"{LAMP} {number}" for number in range(2, self.lamps + 1))]
        received = {SKY: sky.overcast, **{group: meter.irradiance(group) for group in lamps}}
        return UnlitScene(name, objects, camera, received, BACKDROP, sky)

    def _house(self) -> list[Part]:
        """Return the front of a house around its windows, on a base of another colour."""
        x, z = shell.in_front_of(BACK, self._size, 0.0, 0.0)
        length, paint = shell.length_of(BACK, self._size), self._palette.pale()
        pieces = shell.wall_pieces(length, float(self._size[1]), self._windows.get(BACK, ()))
        return [Part(piece.moved((x, 0.0, z)), paint) for piece in pieces]

    def _eaves(self) -> SceneObject:
        """Return the edge of the roof, on top of the house front."""
        x, z = shell.in_front_of(BACK, self._size, 0.0, 0.1)
        edge = box(float(self._size[0]), 0.14, 0.45, 0.01)
        roof = edge.moved((x, float(self._size[1]), z))
        return SceneObject("eaves", [Part(roof, self._palette.chip(12.0, (3, 5), (2, 6)))])

    def _sides(self, sides: Sequence[MakeSide]) -> list[Part]:
        parts = list[Part]()
        for wall, make in zip([w for w in TURNS if w != BACK], sides, strict=True):
            x, z = shell.in_front_of(wall, self._size, 0.0, 0.0)
            made = make(self._rng, self._palette, shell.length_of(wall, self._size))
            parts += [
                Part(p.shape.turned(TURNS[wall]).moved((x, 0.0, z)), p.material) for p in made
            ]
        return parts


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
    entries: tuple[Entry, ...]
    ground: MakeGround
    sides: tuple[MakeSide, ...] = (hedge, fence, brick_wall)


def shrub(rng: Random, palette: Palette) -> Group:
    """Return one to three shrubs side by side."""
    made = (
        (outdoors.shrub(rng, palette, draw(rng, 0.25, 0.5)), 0.02)
        for _ in range(int(rng.integers(1, 4)))
    )
    return Group(side_by_side(made))


def garden_seats(rng: Random, palette: Palette) -> Group:
    """Return a laid table with chairs on both sides."""
    table = outdoors.garden_table(palette)
    makers = [lambda: vessels.cup(rng, palette)] * int(rng.integers(1, 4))
    makers += [lambda: vessels.bowl(rng, palette, 0.13), lambda: vessels.vase(rng, palette, 0.2)]
    group = furnish(rng, table, makers)
    for x in (-0.32, 0.32):
        for side in (-1.0, 1.0):
            turn = (180.0 if side > 0 else 0.0) + draw(rng, -12.0, 12.0)
            chair = furniture.chair(palette).turned(turn)
            group.append(chair.moved((x, 0.0, side * (0.4 + draw(rng, 0.22, 0.4)))))
    return Group(group)


def parasol_seats(rng: Random, palette: Palette) -> Group:
    """Return a cafe table beside a parasol."""
    seats = list(groups.cafe_table(rng, palette).objects)
    return Group([*seats, outdoors.parasol(rng, palette).moved((draw(rng, 1.0, 1.1), 0.0, 1.0))])


def park_bench(rng: Random, palette: Palette) -> Group:
    """Return a bench, perhaps with a litter bin beside it."""
    wide = draw(rng, 1.2, 1.7)
    group = [public_rooms.bench(palette, wide)]
    if rng.random() < 0.6:
        group += shifted([outdoors.litter_bin(rng, palette)], 0.5 * wide + 0.4, 0.0)
    return Group(group, 0.4)


tree = alone(lambda rng, palette: outdoors.tree(rng, palette, draw(rng, 2.4, 3.6)))
planter = alone(lambda rng, palette: outdoors.planter(rng, palette, draw(rng, 0.8, 1.6)))
street_lamp = alone(lambda rng, palette: outdoors.street_lamp(palette, draw(rng, 2.6, 3.4)))
bollard = alone(lambda rng, palette: outdoors.bollard(palette))

YARDS = {
    "garden": YardKind(
        ((6.5, 9.0), (6.0, 8.5), (3.6, 5.0)),
        (
            Entry(garden_seats, FREE),
            Entry(tree, CORNER, (1, 2)),
            Entry(tree, FREE, (0, 1)),
            Entry(shrub, WALL, (3, 7)),
            Entry(planter, WALL, (0, 2)),
            Entry(park_bench, WALL, (0, 1)),
            Entry(bollard, FREE, (1, 3)),
        ),
        lawn,
    ),
    "terrace": YardKind(
        ((5.5, 8.0), (5.0, 7.0), (3.4, 4.6)),
        (
            Entry(parasol_seats, FREE, (1, 2)),
            Entry(groups.cafe_table, FREE, (1, 3)),
            Entry(planter, WALL, (2, 4)),
            Entry(groups.plant, CORNER, (1, 3)),
            Entry(park_bench, WALL, (0, 1)),
            Entry(bollard, WALL, (1, 2)),
        ),
        paving,
    ),
    "street": YardKind(
        ((7.0, 9.5), (6.4, 7.6), (4.2, 5.6)),
        (
            Entry(tree, WALL, (2, 4)),
            Entry(park_bench, WALL, (1, 2)),
            Entry(street_lamp, WALL, (2, 3)),
            Entry(planter, WALL, (2, 4)),
            Entry(groups.crates, WALL, (0, 2)),
            Entry(bollard, WALL, (1, 3)),
            Entry(shrub, WALL, (1, 3)),
        ),
        road,
    ),
}
"""Kinds of places outdoors by name."""


def _build(name: str, rng: Random, palette: Palette, scale: float) -> UnlitScene | None:
    """Generate a place outdoors: its size, sides, what stands there, camera and colours."""
    kind = YARDS[name]
    yard = _furnished(kind, rng, palette, scale)
    sides = [kind.sides[int(i)] for i in rng.integers(0, len(kind.sides), 3)]
    return yard.build_yard(name, kind.ground, sides) if yard else None


def _furnished(kind: YardKind, rng: Random, palette: Palette, scale: float) -> YardBuilder | None:
    """Return a place with what stands in it; None if what matters most has no room."""
    width, depth, height = (float(rng.uniform(*each)) * scale for each in kind.size)
    yard = YardBuilder(rng, palette, width, depth, height)
    if not yard.add_door(BACK):
        return None
    for _ in range(int(rng.integers(2, 5))):
        size = 0.9, float(rng.uniform(0.8, 1.6)), float(rng.uniform(1.1, 1.5))
        yard.add_window(BACK, size, False)
    if not place_entries(yard, kind.entries, rng, palette, scale):
        return None
    return yard if add_lamps(yard, yard.add_lantern) else None


OUTDOORS: dict[str, Callable[[Random, Palette, float], UnlitScene]] = {
    name: partial(build_until_seen, _build, name) for name in YARDS
}
"""Builders of places outdoors by name."""
