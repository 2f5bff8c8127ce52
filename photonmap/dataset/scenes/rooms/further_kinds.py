"""Kinds of rooms beyond the nine of Beigpour et al. 2013."""

from __future__ import annotations

from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.wall_fixtures import WINDOW
from photonmap.dataset.scenes.rooms import further_groups, groups
from photonmap.dataset.scenes.rooms.hangings import (
    board,
    clock,
    framed,
    mirror,
    picture,
    posters,
    row_of_pictures,
    tools,
)
from photonmap.dataset.scenes.rooms.kinds import (
    CORNER,
    FREE,
    WALL,
    Entry,
    RoomKind,
    panel,
    pendant,
    shade,
)
from photonmap.dataset.scenes.rooms.shell import plain, planks, tiles

_TALL_PLANT = Entry(groups.plant, CORNER, (0, 2))

FURTHER_KINDS = {
    "bathroom": RoomKind(
        (2.8, 4.2),
        (2.8, 4.0),
        (2.4, 2.8),
        LAMP,
        (
            Entry(further_groups.wash_place, WALL, (1, 2)),
            Entry(further_groups.bath, WALL),
            Entry(further_groups.toilet, WALL),
            Entry(further_groups.towel_shelf, WALL, (0, 1)),
            Entry(further_groups.basket, CORNER, (1, 1)),
            Entry(groups.stool, CORNER, (0, 1)),
            Entry(groups.plant, CORNER, (0, 1)),
        ),
        (
            (mirror, (1.25, 1.4), (1, 2)),
            (further_groups.towels, (0.75, 0.95), (1, 3)),
            (groups.wall_board, (1.3, 1.6), (0, 2)),
        ),
        (panel, pendant),
        (tiles, plain),
        (2, 4),
        "tiles",
        (framed, board),
    ),
    "classroom": RoomKind(
        (5.2, 7.2),
        (5.0, 7.0),
        (2.7, 3.3),
        WINDOW,
        (
            Entry(further_groups.rows_of_desks, FREE),
            Entry(further_groups.teachers_desk, WALL),
            Entry(groups.bookcase, WALL, (1, 2)),
            Entry(groups.sideboard, WALL, (0, 2)),
            _TALL_PLANT,
        ),
        (
            (further_groups.blackboard, (0.85, 0.95), (1, 1)),
            (clock, (2.0, 2.3), (1, 1)),
            (picture, (1.1, 1.5), (2, 6)),
        ),
        (panel,),
        (plain, planks, tiles),
        dressing=(posters, posters, framed, row_of_pictures, board),
    ),
    "cafe": RoomKind(
        (4.8, 7.0),
        (4.6, 6.6),
        (2.7, 3.4),
        LAMP,
        (
            Entry(further_groups.bar, WALL),
            Entry(further_groups.cafe_table, FREE, (2, 4)),
            Entry(further_groups.wall_seats, WALL, (1, 2)),
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
        (4.2, 6.2),
        (4.0, 5.8),
        (2.7, 3.4),
        WINDOW,
        (
            Entry(further_groups.tool_bench, WALL),
            Entry(further_groups.tool_bench, FREE),
            Entry(further_groups.tool_shelf, WALL, (1, 2)),
            Entry(further_groups.timber, WALL, (1, 2)),
            Entry(further_groups.crates, WALL, (0, 2)),
            Entry(groups.stool, FREE, (0, 2)),
        ),
        (
            (further_groups.tool_wall, (1.1, 1.3), (1, 3)),
            (groups.wall_board, (1.3, 1.7), (0, 1)),
            (clock, (1.8, 2.1), (0, 1)),
        ),
        (panel, pendant),
        (plain, planks),
        (2, 4),
        dressing=(tools, tools, board, posters),
    ),
    "corridor": RoomKind(
        (2.2, 2.9),
        (5.0, 7.5),
        (2.4, 3.0),
        LAMP,
        (
            Entry(further_groups.coats, WALL),
            Entry(groups.sideboard, WALL, (1, 2)),
            Entry(further_groups.umbrellas, CORNER, (1, 1)),
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
