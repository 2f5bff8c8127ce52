"""All rooms by name: their sizes, what stands in them, hangs on their walls and lights them."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from photonmap.dataset.models import lamps
from photonmap.dataset.models.lamps import ceiling_spot, pendant, shade_lamp
from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.scenes.random_lights import MOST_LIGHTS
from photonmap.dataset.scenes.rooms import groups as g
from photonmap.dataset.scenes.rooms import shell
from photonmap.dataset.scenes.rooms.room_builder import Dressing, Group, RoomBuilder
from photonmap.dataset.scenes.rooms.shell import TURNS, Floor, plain, planks
from photonmap.dataset.scenes.unlit_scene import OpenSky, UnlitScene
from photonmap.errors import InputError
from photonmap.scene.material import Material

WALL, CORNER, FREE = "wall", "corner", "free"
"""Where groups stand."""
Entry = tuple[g.MakeGroup, str, int, int]
"""Makes a group of furniture; `WALL`, `CORNER` or `FREE`; lowest and highest number."""
Hung = tuple[g.MakeHung, Range, int, int]
"""Makes what hangs on a wall; its range of height, metres; lowest and highest number."""

_ATTEMPTS = 24  # places that are furnished until a camera sees enough of one
_LAMPS = MOST_LIGHTS - 1
"""Least number of lamps; with the windows or the sky, as many light groups as are drawn."""
_LOWEST = 2.3  # least height of a room, metres
_APART = 0.4
"""How far from the middle of the ceiling lamps hang that make up for missing ones, by its size."""


@dataclass(frozen=True)
class RoomKind:
    """A kind of room; its makers are named in `rooms.toml`.

    Parameters
    ----------
    size : ranges of width, depth and height, metres
    main : the light group that is on if the illumination has one colour
    entries : furniture, the most important first; what finds no room is left out
    hung : what hangs on walls
    lamps : makers of lamps for the ceiling, one of which is drawn
    floors : one of which is drawn
    chroma : range for the walls; 0 is grey
    wall : procedure that paints the first wall where materials are textured
    dressing : makers of what hangs where walls would be bare, drawn equally often
    """

    size: tuple[Range, Range, Range]
    main: str
    entries: Sequence[Entry]
    hung: Sequence[Hung]
    lamps: Sequence[Callable[[Draw], SceneObject]] = (pendant, shade_lamp)
    floors: Sequence[Floor] = (planks, plain)
    chroma: Range = (2, 6)
    wall: str = "print"
    dressing: Sequence[Dressing] = (g.framed, g.framed, g.row_of_pictures)

    def walls(self, draw: Draw) -> tuple[Material, Material]:
        """Draw the materials of one wall and of the others."""
        hue = draw.key if draw.chance(0.5) else None
        if not self.chroma[1]:
            return draw.patterned(self.wall, draw.grey(8)), draw.grey(8)
        first, kind = draw.chip(hue, (5, 8), self.chroma), draw.rng.random()
        others = draw.chip(hue, (5, 7), (2, 4)) if kind < 0.25 else draw.pale()
        return draw.patterned(self.wall, first), draw.grey(8) if kind > 0.75 else others


_MAKERS = {"entries": g, "hung": g, "dressing": g, "lamps": lamps, "floors": shell}
"""Where the makers are that a kind names, by its parameter."""


def _read_kinds(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, RoomKind]:
    """Return kinds of rooms by name from the tables of a TOML file."""

    def value_of(key: str, given: Any) -> Any:
        if key == "size":
            return tuple(map(tuple, given))
        if key not in _MAKERS:
            return tuple(given) if isinstance(given, list) else given
        return [
            getattr(_MAKERS[key], row)
            if isinstance(row, str)
            else (getattr(_MAKERS[key], row[0]), *row[1:])
            for row in given
        ]

    return {
        name: RoomKind(**{key: value_of(key, given) for key, given in table.items()})
        for name, table in tables.items()
    }


_TABLES = tomllib.loads(Path(__file__).with_name("rooms.toml").read_text(encoding="utf-8"))
KINDS, FURTHER_KINDS = _read_kinds(_TABLES["as_in_paper"]), _read_kinds(_TABLES["further"])
"""Kinds of rooms by name: as many as Beigpour et al. 2013 have, and others."""
_ALL_KINDS = KINDS | FURTHER_KINDS

Build = Callable[[str, Draw, float], UnlitScene | None]
"""Generates a place of a kind; None where no camera sees enough of it, or what matters most has no
room."""


def build_until_seen(build: Build, name: str, draw: Draw, scale: float = 1.0) -> UnlitScene:
    """Generate places of a kind and scale until a camera sees enough of one.

    Raises
    ------
    InputError : no camera sees enough of a place of this size
    """
    for _ in range(_ATTEMPTS):
        if made := build(name, draw, scale):
            return made
    raise InputError(
        f"no camera sees enough of any {name} of scale {scale:g} in {_ATTEMPTS} attempts; choose "
        "a scale nearer 1"
    )


def place_entries(place: RoomBuilder, entries: Sequence[Entry], scale: float) -> bool:
    """Fill a place, larger ones more; return whether there is room for the first entry at least."""
    in_corner = partial(place.place_at_wall, corner=True)
    ways: dict[str, Callable[[Group], bool]] = {
        FREE: place.place_free,
        WALL: place.place_at_wall,
        CORNER: in_corner,
    }
    for index, (make, where, least, most) in enumerate(entries):
        count = max(least, round(place.draw.whole(least, most) * scale))
        placed = sum(ways[where](make(place.draw)) for _ in range(count))
        if index == 0 and not placed:
            return False
    return True


def add_lamps(place: RoomBuilder, add: Callable[[], bool]) -> bool:
    """Add lamps until there are enough, or one finds no room; return whether there are enough."""
    while place.lamps < _LAMPS and add():
        pass
    return place.lamps >= _LAMPS


def _build(name: str, draw: Draw, scale: float) -> UnlitScene | None:
    """Generate a room of a kind: its size, openings, furniture, camera and colours."""
    kind = _ALL_KINDS[name]
    width, depth, height = (draw.number(*each) * scale for each in kind.size)
    room = RoomBuilder(draw, width, depth, max(height, _LOWEST))
    furnished = _furnish(room, kind, scale)
    floor = draw.one_of(kind.floors)
    if not furnished:
        return None
    walls = kind.walls(draw)
    surroundings = [
        floor(draw, room.size),
        shell.ceiling(draw, room.size),
        shell.walls(walls, room.size, room.windows),
        shell.skirting(draw, room.size),
    ]
    return room.build(
        name, kind.main, surroundings, lambda m: OpenSky.through_windows(m, draw.number(0.0, 360.0))
    )


def _furnish(room: RoomBuilder, kind: RoomKind, scale: float) -> bool:
    """Fill a room; return whether there is room for what matters most."""
    draw = room.draw
    walls = [list(TURNS)[int(i)] for i in draw.rng.permutation(len(TURNS))]
    lamp = draw.one_of(kind.lamps)
    if not (_open(room, walls) and room.suspend(lamp(draw))):
        return False
    if not place_entries(room, kind.entries, scale):
        return False
    for make, heights, least, most in kind.hung:
        for _ in range(draw.whole(least, most)):
            room.hang(make(draw), heights)
    room.dress(kind.dressing)
    spot = draw.number(0.09, 0.17)
    return add_lamps(room, lambda: room.suspend(ceiling_spot(draw, spot), _APART))


def _open(room: RoomBuilder, walls: list[str]) -> bool:
    """Add a door and two or three windows; return whether both have been added."""
    draw = room.draw
    curtains, count, sill = draw.chance(0.4), draw.whole(2, 3), draw.number(0.75, 1.05)
    tall = min(draw.number(1.1, 1.7), float(room.size[1]) - sill - 0.2)
    added = 0
    for index in range(count):
        added += room.add_window(walls[index % 2], (sill, draw.number(1.1, 2.4), tall), curtains)
    return room.add_door(walls[2]) and added > 0


ROOMS: dict[str, Callable[[Draw, float], UnlitScene]] = {
    name: partial(build_until_seen, _build, name) for name in _ALL_KINDS
}
"""Builders of rooms by name."""
