"""The kinds of rooms: their sizes, what stands in them, hangs on their walls and lights them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from photonmap.dataset.models import lamps
from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import SceneObject
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.models.wall_fixtures import WINDOW
from photonmap.dataset.scenes.rooms import groups
from photonmap.dataset.scenes.rooms.groups import MakeGroup, draw
from photonmap.dataset.scenes.rooms.hangings import (
    MakeHung,
    blackboard,
    board,
    clock,
    framed,
    mirror,
    picture,
    posters,
    row_of_pictures,
    tool_wall,
    tools,
    towels,
)
from photonmap.dataset.scenes.rooms.room_builder import Dressing
from photonmap.dataset.scenes.rooms.shell import Floor, plain, planks, tiles
from photonmap.scene.material import Material

WALL, CORNER, FREE = "wall", "corner", "free"
Range = tuple[float, float]
MakeLamp = Callable[[Random, Palette], SceneObject]


@dataclass(frozen=True)
class Entry:
    """A group of furniture of a kind of room.

    Parameters
    ----------
    make : makes the group
    where : `WALL`, `CORNER` or `FREE`
    count : lowest and highest number
    """

    make: MakeGroup
    where: str
    count: tuple[int, int] = (1, 1)


@dataclass(frozen=True)
class RoomKind:
    """A kind of room.

    Parameters
    ----------
    size : ranges of width, depth and height, metres
    main : the light group that is on if the illumination has one colour
    entries : furniture, the most important first; what finds no room is left out
    hung : makers of what hangs on walls, with ranges of height, metres, and of number
    lamps : makers of lamps for the ceiling, one of which is drawn
    floors : one of which is drawn
    hue : of the walls, as `Palette.chip` takes it; None draws one
    chroma : range for the walls; 0 is grey
    wall : procedure that paints the first wall where materials are textured
    dressing : makers of what hangs where walls would be bare, drawn equally often
    """

    size: tuple[Range, Range, Range]
    main: str
    entries: tuple[Entry, ...]
    hung: tuple[tuple[MakeHung, Range, tuple[int, int]], ...]
    lamps: tuple[MakeLamp, ...]
    floors: tuple[Floor, ...] = (planks, plain)
    chroma: Range = (2, 6)
    wall: str = "print"
    dressing: tuple[Dressing, ...] = (framed, framed, row_of_pictures)

    def walls(self, rng: Random, palette: Palette) -> tuple[Material, Material]:
        """Draw the materials of one wall and of the others."""
        hue = palette.key if rng.random() < 0.5 else None
        if not self.chroma[1]:
            return palette.patterned(self.wall, palette.grey(8)), palette.grey(8)
        first = palette.chip(hue, (5, 8), self.chroma)
        kind = rng.random()
        others = palette.chip(hue, (5, 7), (2, 4)) if kind < 0.25 else palette.pale()
        others = palette.grey(8) if kind > 0.75 else others
        return palette.patterned(self.wall, first), others


def pendant(rng: Random, palette: Palette) -> SceneObject:
    """Return a paper lantern."""
    return lamps.pendant(palette, draw(rng, 0.15, 0.26), draw(rng, 0.15, 0.4))


def shade(rng: Random, palette: Palette) -> SceneObject:
    """Return a lamp with a shade."""
    return lamps.shade_lamp(palette, draw(rng, 0.22, 0.36), draw(rng, 0.2, 0.5))


def panel(rng: Random, palette: Palette) -> SceneObject:
    """Return a flat lamp."""
    return lamps.ceiling_panel(palette, draw(rng, 0.6, 1.4), draw(rng, 0.3, 0.7))


_PICTURES = (picture, (1.15, 1.5), (1, 4))
_TALL_PLANT = Entry(groups.plant, CORNER, (0, 2))

KINDS = {
    "living_room": RoomKind(
        ((4.0, 6.2), (3.8, 5.6), (2.4, 3.0)),
        WINDOW,
        (
            Entry(groups.seats, WALL),
            Entry(groups.bookcase, WALL, (1, 2)),
            Entry(groups.sideboard, WALL, (0, 2)),
            Entry(groups.reading_place, CORNER, (0, 1)),
            Entry(groups.floor_lamp, CORNER, (1, 1)),
            _TALL_PLANT,
        ),
        (_PICTURES,),
        (pendant, shade),
        dressing=(framed, framed, row_of_pictures, board),
    ),
    "study": RoomKind(
        ((3.4, 4.8), (3.2, 4.8), (2.4, 2.9)),
        WINDOW,
        (
            Entry(groups.desk_place, WALL),
            Entry(groups.bookcase, WALL, (1, 3)),
            Entry(groups.reading_place, CORNER, (0, 1)),
            Entry(groups.sideboard, WALL, (0, 1)),
            Entry(groups.books_on_floor, CORNER, (0, 2)),
            _TALL_PLANT,
        ),
        (_PICTURES, (clock, (1.6, 1.8), (0, 1)), (groups.wall_board, (1.2, 1.5), (0, 1))),
        (pendant, panel),
        dressing=(framed, row_of_pictures, posters, board),
    ),
    "dining_room": RoomKind(
        ((3.8, 5.6), (3.8, 5.4), (2.5, 3.1)),
        LAMP,
        (
            Entry(groups.dining_table, FREE),
            Entry(groups.sideboard, WALL, (1, 2)),
            Entry(groups.bookcase, WALL, (0, 1)),
            _TALL_PLANT,
            Entry(groups.tall_vases, CORNER, (0, 1)),
        ),
        (_PICTURES, (mirror, (1.2, 1.4), (0, 1))),
        (shade, pendant),
    ),
    "kitchen": RoomKind(
        ((3.4, 5.0), (3.2, 4.6), (2.4, 2.9)),
        LAMP,
        (
            Entry(groups.kitchen_run, WALL),
            Entry(groups.small_table, FREE),
            Entry(groups.kitchen_run, WALL, (0, 1)),
            Entry(groups.sideboard, WALL, (0, 1)),
            Entry(groups.stool, CORNER, (0, 2)),
        ),
        (
            (groups.wall_board, (1.3, 1.7), (1, 3)),
            (clock, (1.6, 1.9), (1, 1)),
            (picture, (1.2, 1.5), (0, 1)),
        ),
        (panel, shade),
        (tiles, planks),
        dressing=(framed, row_of_pictures, board, board),
    ),
    "bedroom": RoomKind(
        ((3.6, 5.0), (3.4, 5.0), (2.4, 2.9)),
        WINDOW,
        (
            Entry(groups.bed_place, WALL),
            Entry(groups.wardrobe, WALL, (1, 1)),
            Entry(groups.sideboard, WALL, (0, 1)),
            Entry(groups.desk_place, WALL, (0, 1)),
            Entry(groups.reading_place, CORNER, (0, 1)),
            Entry(groups.stool, WALL, (0, 1)),
            _TALL_PLANT,
        ),
        (_PICTURES, (mirror, (1.2, 1.4), (0, 1))),
        (pendant, shade),
    ),
    "playroom": RoomKind(
        ((3.6, 5.2), (3.4, 5.0), (2.4, 2.9)),
        WINDOW,
        (
            Entry(groups.toy_table, FREE),
            Entry(groups.toy_shelf, WALL, (1, 2)),
            Entry(groups.toys_on_rug, FREE),
            Entry(groups.bookcase, WALL, (0, 1)),
            Entry(groups.stool, CORNER, (0, 2)),
        ),
        (_PICTURES,),
        (pendant, panel),
        (plain, planks, tiles),
        (4, 8),
        dressing=(framed, row_of_pictures, posters, board),
    ),
    "gallery": RoomKind(
        ((4.6, 7.5), (4.4, 7.0), (2.9, 3.8)),
        LAMP,
        (
            Entry(groups.plinth_with_work, FREE, (4, 8)),
            Entry(groups.plinth_with_work, CORNER, (1, 3)),
            Entry(groups.tall_vases, WALL, (0, 2)),
        ),
        ((picture, (1.05, 1.35), (4, 9)),),
        (panel,),
        (planks, plain, tiles),
        (0, 0),
        dressing=(framed,),
    ),
    "library": RoomKind(
        ((3.8, 5.6), (3.6, 5.4), (2.6, 3.3)),
        WINDOW,
        (
            Entry(groups.bookcase, WALL, (3, 5)),
            Entry(groups.reading_place, CORNER),
            Entry(groups.floor_lamp, CORNER, (1, 1)),
            Entry(groups.desk_place, WALL, (0, 1)),
            Entry(groups.books_on_floor, CORNER, (1, 3)),
            Entry(groups.plinth_with_work, CORNER, (0, 1)),
        ),
        ((picture, (1.2, 1.5), (0, 3)),),
        (shade, pendant),
    ),
    "pottery": RoomKind(
        ((3.8, 5.6), (3.6, 5.0), (2.5, 3.2)),
        WINDOW,
        (
            Entry(groups.work_bench, FREE),
            Entry(groups.vessel_shelf, WALL, (1, 2)),
            Entry(groups.work_bench, WALL, (0, 1)),
            Entry(groups.sideboard, WALL, (0, 1)),
            Entry(groups.stool, FREE, (1, 3)),
            Entry(groups.tall_vases, CORNER, (1, 2)),
        ),
        ((groups.wall_board, (0.95, 1.8), (2, 5)),),
        (pendant, panel),
        (tiles, plain, planks),
        dressing=(board, board, posters),
    ),
}
"""Kinds of rooms by name."""


FURTHER_KINDS = {
    "bathroom": RoomKind(
        ((2.8, 4.2), (2.8, 4.0), (2.4, 2.8)),
        LAMP,
        (
            Entry(groups.wash_place, WALL, (1, 2)),
            Entry(groups.bath, WALL),
            Entry(groups.toilet, WALL),
            Entry(groups.towel_shelf, WALL, (0, 1)),
            Entry(groups.basket, CORNER, (1, 1)),
            Entry(groups.stool, CORNER, (0, 1)),
            Entry(groups.plant, CORNER, (0, 1)),
        ),
        (
            (mirror, (1.25, 1.4), (1, 2)),
            (towels, (0.75, 0.95), (1, 3)),
            (groups.wall_board, (1.3, 1.6), (0, 2)),
        ),
        (panel, pendant),
        (tiles, plain),
        (2, 4),
        "tiles",
        (framed, board),
    ),
    "classroom": RoomKind(
        ((5.2, 7.2), (5.0, 7.0), (2.7, 3.3)),
        WINDOW,
        (
            Entry(groups.rows_of_desks, FREE),
            Entry(groups.teachers_desk, WALL),
            Entry(groups.bookcase, WALL, (1, 2)),
            Entry(groups.sideboard, WALL, (0, 2)),
            _TALL_PLANT,
        ),
        (
            (blackboard, (0.85, 0.95), (1, 1)),
            (clock, (2.0, 2.3), (1, 1)),
            (picture, (1.1, 1.5), (2, 6)),
        ),
        (panel,),
        (plain, planks, tiles),
        dressing=(posters, posters, framed, row_of_pictures, board),
    ),
    "cafe": RoomKind(
        ((4.8, 7.0), (4.6, 6.6), (2.7, 3.4)),
        LAMP,
        (
            Entry(groups.bar, WALL),
            Entry(groups.cafe_table, FREE, (2, 4)),
            Entry(groups.wall_seats, WALL, (1, 2)),
            _TALL_PLANT,
        ),
        (
            (groups.wall_board, (1.45, 1.8), (1, 2)),
            (picture, (1.2, 1.6), (1, 4)),
            (mirror, (1.3, 1.5), (0, 1)),
        ),
        (shade, pendant),
        (tiles, planks, plain),
        dressing=(framed, row_of_pictures, posters),
    ),
    "workshop": RoomKind(
        ((4.2, 6.2), (4.0, 5.8), (2.7, 3.4)),
        WINDOW,
        (
            Entry(groups.tool_bench, WALL),
            Entry(groups.tool_bench, FREE),
            Entry(groups.tool_shelf, WALL, (1, 2)),
            Entry(groups.timber, WALL, (1, 2)),
            Entry(groups.crates, WALL, (0, 2)),
            Entry(groups.stool, FREE, (0, 2)),
        ),
        (
            (tool_wall, (1.1, 1.3), (1, 3)),
            (groups.wall_board, (1.3, 1.7), (0, 1)),
            (clock, (1.8, 2.1), (0, 1)),
        ),
        (panel, pendant),
        (plain, planks),
        (2, 4),
        dressing=(tools, tools, board, posters),
    ),
    "corridor": RoomKind(
        ((2.2, 2.9), (5.0, 7.5), (2.4, 3.0)),
        LAMP,
        (
            Entry(groups.coats, WALL),
            Entry(groups.sideboard, WALL, (1, 2)),
            Entry(groups.umbrellas, CORNER, (1, 1)),
            Entry(groups.bookcase, WALL, (0, 1)),
            Entry(groups.tall_vases, CORNER, (0, 1)),
            _TALL_PLANT,
        ),
        ((picture, (1.2, 1.5), (2, 6)), (mirror, (1.25, 1.4), (0, 1)), (clock, (1.8, 2.0), (0, 1))),
        (pendant, shade),
        (tiles, planks, plain),
    ),
}
"""Kinds of rooms by name."""
