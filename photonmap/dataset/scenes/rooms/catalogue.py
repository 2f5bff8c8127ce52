"""All rooms by name: their sizes, what stands in them, hangs on their walls and lights them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from photonmap.dataset.models.lamps import LAMP, ceiling_panel, ceiling_spot, pendant, shade_lamp
from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.wall_objects import WINDOW
from photonmap.dataset.scenes.random_lights import MOST_LIGHTS
from photonmap.dataset.scenes.rooms import groups as g
from photonmap.dataset.scenes.rooms import shell
from photonmap.dataset.scenes.rooms.room_builder import Dressing, RoomBuilder
from photonmap.dataset.scenes.rooms.shell import TURNS, Floor, plain, planks, tiles
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
    """A kind of room.

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
    lamps: Sequence[Callable[[Draw], SceneObject]]
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


# fmt: off
KINDS = {
    "living_room": RoomKind(
        ((4.0, 6.2), (3.8, 5.6), (2.4, 3.0)), WINDOW,
        [(g.seats, WALL, 1, 1), (g.bookcase, WALL, 1, 2), (g.sideboard, WALL, 0, 2),
         (g.reading_place, CORNER, 0, 1), (g.floor_lamp, CORNER, 1, 1), (g.plant, CORNER, 0, 2)],
        [(g.framed, (1.15, 1.5), 1, 4)], (pendant, shade_lamp),
        dressing=(g.framed, g.framed, g.row_of_pictures, g.wall_board)),
    "study": RoomKind(
        ((3.4, 4.8), (3.2, 4.8), (2.4, 2.9)), WINDOW,
        [(g.desk_place, WALL, 1, 1), (g.bookcase, WALL, 1, 3), (g.reading_place, CORNER, 0, 1),
         (g.sideboard, WALL, 0, 1), (g.books_on_floor, CORNER, 0, 2), (g.plant, CORNER, 0, 2)],
        [(g.framed, (1.15, 1.5), 1, 4), (g.clock, (1.6, 1.8), 0, 1),
         (g.wall_board, (1.2, 1.5), 0, 1)], (pendant, ceiling_panel),
        dressing=(g.framed, g.row_of_pictures, g.posters, g.wall_board)),
    "dining_room": RoomKind(
        ((3.8, 5.6), (3.8, 5.4), (2.5, 3.1)), LAMP,
        [(g.dining_table, FREE, 1, 1), (g.sideboard, WALL, 1, 2), (g.bookcase, WALL, 0, 1),
         (g.plant, CORNER, 0, 2), (g.tall_vases, CORNER, 0, 1)],
        [(g.framed, (1.15, 1.5), 1, 4), (g.mirror, (1.2, 1.4), 0, 1)], (shade_lamp, pendant)),
    "kitchen": RoomKind(
        ((3.4, 5.0), (3.2, 4.6), (2.4, 2.9)), LAMP,
        [(g.kitchen_run, WALL, 1, 1), (g.small_table, FREE, 1, 1), (g.kitchen_run, WALL, 0, 1),
         (g.sideboard, WALL, 0, 1), (g.stool, CORNER, 0, 2)],
        [(g.wall_board, (1.3, 1.7), 1, 3), (g.clock, (1.6, 1.9), 1, 1),
         (g.framed, (1.2, 1.5), 0, 1)], (ceiling_panel, shade_lamp), (tiles, planks),
        dressing=(g.framed, g.row_of_pictures, g.wall_board, g.wall_board)),
    "bedroom": RoomKind(
        ((3.6, 5.0), (3.4, 5.0), (2.4, 2.9)), WINDOW,
        [(g.bed_place, WALL, 1, 1), (g.wardrobe, WALL, 1, 1), (g.sideboard, WALL, 0, 1),
         (g.desk_place, WALL, 0, 1), (g.reading_place, CORNER, 0, 1), (g.stool, WALL, 0, 1),
         (g.plant, CORNER, 0, 2)],
        [(g.framed, (1.15, 1.5), 1, 4), (g.mirror, (1.2, 1.4), 0, 1)], (pendant, shade_lamp)),
    "playroom": RoomKind(
        ((3.6, 5.2), (3.4, 5.0), (2.4, 2.9)), WINDOW,
        [(g.toy_table, FREE, 1, 1), (g.toy_shelf, WALL, 1, 2), (g.toys_on_rug, FREE, 1, 1),
         (g.bookcase, WALL, 0, 1), (g.stool, CORNER, 0, 2)],
        [(g.framed, (1.15, 1.5), 1, 4)], (pendant, ceiling_panel), (plain, planks, tiles), (4, 8),
        dressing=(g.framed, g.row_of_pictures, g.posters, g.wall_board)),
    "gallery": RoomKind(
        ((4.6, 7.5), (4.4, 7.0), (2.9, 3.8)), LAMP,
        [(g.plinth_with_work, FREE, 4, 8), (g.plinth_with_work, CORNER, 1, 3),
         (g.tall_vases, WALL, 0, 2)],
        [(g.framed, (1.05, 1.35), 4, 9)], (ceiling_panel,), (planks, plain, tiles), (0, 0),
        dressing=(g.framed,)),
    "library": RoomKind(
        ((3.8, 5.6), (3.6, 5.4), (2.6, 3.3)), WINDOW,
        [(g.bookcase, WALL, 3, 5), (g.reading_place, CORNER, 1, 1), (g.floor_lamp, CORNER, 1, 1),
         (g.desk_place, WALL, 0, 1), (g.books_on_floor, CORNER, 1, 3),
         (g.plinth_with_work, CORNER, 0, 1)],
        [(g.framed, (1.2, 1.5), 0, 3)], (shade_lamp, pendant)),
    "pottery": RoomKind(
        ((3.8, 5.6), (3.6, 5.0), (2.5, 3.2)), WINDOW,
        [(g.work_bench, FREE, 1, 1), (g.vessel_shelf, WALL, 1, 2), (g.work_bench, WALL, 0, 1),
         (g.sideboard, WALL, 0, 1), (g.stool, FREE, 1, 3), (g.tall_vases, CORNER, 1, 2)],
        [(g.wall_board, (0.95, 1.8), 2, 5)], (pendant, ceiling_panel), (tiles, plain, planks),
        dressing=(g.wall_board, g.wall_board, g.posters)),
}
"""Kinds of rooms by name."""
FURTHER_KINDS = {
    "bathroom": RoomKind(
        ((2.8, 4.2), (2.8, 4.0), (2.4, 2.8)), LAMP,
        [(g.wash_place, WALL, 1, 2), (g.bath, WALL, 1, 1), (g.toilet, WALL, 1, 1),
         (g.towel_shelf, WALL, 0, 1), (g.basket, CORNER, 1, 1), (g.stool, CORNER, 0, 1),
         (g.plant, CORNER, 0, 1)],
        [(g.mirror, (1.25, 1.4), 1, 2), (g.towels, (0.75, 0.95), 1, 3),
         (g.wall_board, (1.3, 1.6), 0, 2)], (ceiling_panel, pendant), (tiles, plain), (2, 4),
        "tiles", (g.framed, g.wall_board)),
    "classroom": RoomKind(
        ((5.2, 7.2), (5.0, 7.0), (2.7, 3.3)), WINDOW,
        [(g.rows_of_desks, FREE, 1, 1), (g.teachers_desk, WALL, 1, 1), (g.bookcase, WALL, 1, 2),
         (g.sideboard, WALL, 0, 2), (g.plant, CORNER, 0, 2)],
        [(g.blackboard, (0.85, 0.95), 1, 1), (g.clock, (2.0, 2.3), 1, 1),
         (g.framed, (1.1, 1.5), 2, 6)], (ceiling_panel,), (plain, planks, tiles),
        dressing=(g.posters, g.posters, g.framed, g.row_of_pictures, g.wall_board)),
    "cafe": RoomKind(
        ((4.8, 7.0), (4.6, 6.6), (2.7, 3.4)), LAMP,
        [(g.bar, WALL, 1, 1), (g.cafe_table, FREE, 2, 4), (g.wall_seats, WALL, 1, 2),
         (g.plant, CORNER, 0, 2)],
        [(g.wall_board, (1.45, 1.8), 1, 2), (g.framed, (1.2, 1.6), 1, 4),
         (g.mirror, (1.3, 1.5), 0, 1)], (shade_lamp, pendant), (tiles, planks, plain),
        dressing=(g.framed, g.row_of_pictures, g.posters)),
    "workshop": RoomKind(
        ((4.2, 6.2), (4.0, 5.8), (2.7, 3.4)), WINDOW,
        [(g.tool_bench, WALL, 1, 1), (g.tool_bench, FREE, 1, 1), (g.tool_shelf, WALL, 1, 2),
         (g.timber, WALL, 1, 2), (g.crates, WALL, 0, 2), (g.stool, FREE, 0, 2)],
        [(g.tools, (1.1, 1.3), 1, 3), (g.wall_board, (1.3, 1.7), 0, 1),
         (g.clock, (1.8, 2.1), 0, 1)], (ceiling_panel, pendant), (plain, planks), (2, 4),
        dressing=(g.tools, g.tools, g.wall_board, g.posters)),
    "corridor": RoomKind(
        ((2.2, 2.9), (5.0, 7.5), (2.4, 3.0)), LAMP,
        [(g.coats, WALL, 1, 1), (g.sideboard, WALL, 1, 2), (g.umbrellas, CORNER, 1, 1),
         (g.bookcase, WALL, 0, 1), (g.tall_vases, CORNER, 0, 1), (g.plant, CORNER, 0, 2)],
        [(g.framed, (1.2, 1.5), 2, 6), (g.mirror, (1.25, 1.4), 0, 1),
         (g.clock, (1.8, 2.0), 0, 1)], (pendant, shade_lamp), (tiles, planks, plain)),
}
# fmt: on
_ALL_KINDS = {**KINDS, **FURTHER_KINDS}

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
    for index, (make, where, least, most) in enumerate(entries):
        count, placed = max(least, round(place.draw.whole(least, most) * scale)), 0
        for _ in range(count):
            group = make(place.draw)
            if where == FREE:
                placed += place.place_free(group)
            else:
                placed += place.place_at_wall(group, where == CORNER)
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
