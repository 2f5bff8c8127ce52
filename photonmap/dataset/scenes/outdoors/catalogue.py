"""Gardens, terraces and streets by name, generated from a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from photonmap.dataset.models import furniture, outdoors, public_rooms, vessels
from photonmap.dataset.models.arrangements import furnish
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.outdoors.yard_builder import (
    MakeGround,
    MakeSide,
    YardBuilder,
    brick_wall,
    fence,
    hedge,
    lawn,
    paving,
    road,
)
from photonmap.dataset.scenes.rooms import groups
from photonmap.dataset.scenes.rooms.catalogue import (
    add_lamps,
    build_until_seen,
    place_entries,
)
from photonmap.dataset.scenes.rooms.groups import alone, draw, shifted, side_by_side
from photonmap.dataset.scenes.rooms.kinds import CORNER, FREE, WALL, Entry, Range
from photonmap.dataset.scenes.rooms.room_builder import Group
from photonmap.dataset.scenes.rooms.shell import BACK
from photonmap.dataset.scenes.unlit_scene import UnlitScene


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
