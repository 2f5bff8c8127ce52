"""Nine rooms: where their furniture stands, what is on it, and from where they are seen."""

from __future__ import annotations

from collections.abc import Callable

from photonmap.dataset import fixtures, furniture, seating, toys, vessels
from photonmap.dataset.fixtures import LAMP, WINDOW
from photonmap.dataset.furnished import (
    books,
    filled_shelf,
    laden,
    pile,
    playthings,
    sculptures,
    ware,
)
from photonmap.dataset.palette import Palette
from photonmap.dataset.placing import centered, in_row, scatter
from photonmap.dataset.room import BACK, FRONT, LEFT, RIGHT, Room, plain, planks, tiles
from photonmap.dataset.setting import Setting
from photonmap.dataset.solids import Random
from photonmap.dataset.things import Support


def living_room(rng: Random, palette: Palette) -> Setting:
    """Build a sofa and an armchair around a low table, in the light of two windows."""
    room = Room("living_room", rng, palette, 5.0, 4.6, 2.6)
    room.look((2.0, 1.45, 1.95), (-0.35, 0.72, -1.1), 55.0)
    room.window(LEFT, 0.1, 0.85, 1.7, 1.35)
    room.window(FRONT, 0.6, 0.85, 1.6, 1.35)
    for side in (-1.25, 1.25):
        room.hang([fixtures.curtain(palette, rng, 0.55, 2.35)], LEFT, 0.1 + side, 0.05)
    room.lay(furniture.rug(palette, 2.3, 1.7), -0.35, -0.25)
    room.against([seating.sofa(rng, palette, 3)], BACK, -0.5)
    room.put([seating.sofa(rng, palette, 1)], -1.95, -0.5, 90.0)
    table = furniture.round_table(palette, 0.48, 0.42)
    read = pile(rng, palette, table.supports[0], 2, [])
    ware_on_it = [lambda: vessels.bowl(rng, palette, 0.13), lambda: vessels.cup(rng, palette)]
    room.put(laden(rng, table, ware_on_it, first=read), -0.35, -0.25)
    shelf = furniture.shelf(palette, 1.05, 1.7, 5)
    room.against(filled_shelf(rng, palette, shelf, 0.5), BACK, 1.75)
    room.put([fixtures.floor_lamp(palette)], 0.93, -1.95)
    room.put([fixtures.plant(rng, palette, 0.95)], -2.05, -1.75)
    for along, wide, tall in ((-1.0, 0.8, 0.6), (0.05, 0.55, 0.7)):
        room.hang([fixtures.picture(rng, palette, wide, tall)], BACK, along, 1.4)
    walls = palette.chip(palette.key, (6, 7), (2, 6)), palette.grey(7)
    return room.finish(WINDOW, planks, walls)


def study(rng: Random, palette: Palette) -> Setting:
    """Build a desk with a lamp, and shelves of books."""
    room = Room("study", rng, palette, 4.2, 4.0, 2.6)
    room.look((-1.55, 1.5, 1.65), (0.42, 0.86, -1.0), 54.0)
    room.window(LEFT, 0.35, 0.9, 1.3, 1.3)
    room.lay(furniture.rug(palette, 1.5, 1.1, 5), -0.2, 0.35, float(rng.choice([0.0, 90.0])))
    desk = furniture.desk(palette)
    top = desk.supports[0]
    lamp = centered(top, fixtures.table_lamp(palette), 0.1, 0.3)
    row = books(rng, palette, Support((0.1, 0.6), (top.z[0], top.z[0] + 0.22), top.y))
    things = pile(rng, palette, top, 3, [lamp, *row])
    makers = [lambda: vessels.cup(rng, palette), lambda: toys.pebble(rng, palette, 0.06)]
    room.against(laden(rng, desk, makers, first=[lamp, *row, *things]), BACK, -0.5)
    room.put([seating.chair(palette)], -0.5, -0.85, 180.0 + float(rng.uniform(-30.0, 30.0)))
    for along in (-0.95, 0.0):
        shelf = furniture.shelf(palette, 0.9, 1.95, 6)
        room.against(filled_shelf(rng, palette, shelf), RIGHT, along)
    globe = laden(
        rng, furniture.round_table(palette, 0.26, 0.6), [lambda: toys.ball(rng, palette, 0.13)]
    )
    room.put(globe, 1.0, -1.6)
    room.hang([fixtures.clock(palette)], BACK, 0.6, 1.75)
    room.suspend(fixtures.pendant(palette, 0.17, 0.3), 0.9, 0.1)
    room.hang([fixtures.picture(rng, palette, 0.9, 0.62)], BACK, -0.5, 1.4)
    return room.finish(
        WINDOW,
        planks,
        (palette.chip(40.0, (6, 7), (2, 4), 12.0), palette.chip(22.0, (8, 8), (2, 2))),
    )


def dining_room(rng: Random, palette: Palette) -> Setting:
    """Build a laid table with chairs around it, below a lamp."""
    room = Room("dining_room", rng, palette, 4.8, 4.8, 2.7)
    room.look((-1.95, 1.6, 2.1), (0.12, 0.84, -0.6), 55.0)
    room.window(RIGHT, -0.2, 0.9, 1.8, 1.4)
    room.lay(furniture.rug(palette, 2.9, 2.5, 9), 0.1, -0.3)
    table = furniture.table(palette, 1.7, 0.95)
    level = table.supports[0]
    bowl = centered(level, vessels.bowl(rng, palette, 0.17))
    plates = [
        centered(level, vessels.plate(rng, palette), x, z) for x in (0.2, 0.8) for z in (0.13, 0.87)
    ]
    makers = [lambda: vessels.cup(rng, palette)] * 4 + [lambda: vessels.bottle(rng, palette)] * 2
    room.put(laden(rng, table, makers, first=[bowl, *plates]), 0.1, -0.3, 0.0, 0.0)
    for x, z, turn in (
        (-0.42, 0.55, 180),
        (0.48, 0.6, 180),
        (-0.42, -0.55, 0),
        (0.48, -0.55, 0),
        (-1.06, 0, 90),
        (1.06, 0, -90),
    ):
        near = float(rng.uniform(0.0, 0.06))
        x, z = x + near * (abs(x) > 1) * x, z + near * (1 if z > 0 else -1) * (z != 0)
        room.put(
            [seating.chair(palette)], 0.1 + x, -0.3 + z, turn + float(rng.uniform(-8.0, 8.0)), 0.02
        )
    room.suspend(fixtures.shade_lamp(palette, 0.32, 0.6), 0.1, -0.3)
    board = furniture.cabinet(palette, 1.8, 0.85, 4)
    room.against(laden(rng, board, ware(rng, palette, 7)), BACK, 0.0)
    room.hang([fixtures.picture(rng, palette, 1.25, 0.75)], BACK, 0.0, 1.4)
    room.put([fixtures.plant(rng, palette, 1.0)], 1.9, -1.95)
    room.put([fixtures.plant(rng, palette, 0.8)], -1.95, -1.95)
    return room.finish(
        LAMP, planks, (palette.chip(None, (6, 7), (4, 6)), palette.chip(22.0, (7, 7), (2, 2)))
    )


def kitchen(rng: Random, palette: Palette) -> Setting:
    """Build cupboards below a window, boards with ware, a round table with stools."""
    room = Room("kitchen", rng, palette, 4.2, 4.0, 2.6)
    room.look((1.5, 1.55, 1.65), (-0.35, 0.85, -1.0), 54.0)
    room.window(BACK, -0.5, 1.15, 1.2, 1.05)
    colors = palette.wood(), palette.chip(None, (5, 7), (4, 8))
    counter = furniture.cabinet(palette, 2.4, 0.9, 4, 0.6, colors)
    room.against(laden(rng, counter, ware(rng, palette, 8)), BACK, -0.6)
    tall = furniture.cabinet(palette, 0.75, 2.0, 1, 0.6, colors)
    room.against([tall], BACK, 1.1)
    for height in (1.25, 1.65):
        board = furniture.wall_board(palette, 1.5)
        group = in_row(rng, board.supports[0], ware(rng, palette, 7, small=True), (0.03, 0.1))
        room.hang([board, *group], LEFT, 0.7, height)
    low = furniture.cabinet(palette, 1.5, 0.9, 3, 0.5, colors)
    room.against(laden(rng, low, ware(rng, palette, 5)), LEFT, 0.7)
    table = furniture.round_table(palette, 0.5, 0.74)
    makers = [lambda: vessels.bowl(rng, palette, 0.16), lambda: vessels.plate(rng, palette)]
    makers += [lambda: vessels.cup(rng, palette), lambda: vessels.cup(rng, palette)]
    room.put(laden(rng, table, makers), 0.25, 0.1)
    for x, z in ((-0.5, 0.25), (0.3, -0.68), (0.95, -0.35)):
        room.put([seating.stool(palette)], x, z)
    room.suspend(fixtures.ceiling_panel(palette, 1.2, 0.5), 0.0, 0.0)
    room.hang([fixtures.clock(palette)], BACK, 0.42, 1.75)
    return room.finish(LAMP, tiles, (palette.chip(25.0, (7, 8), (2, 6), 10.0), palette.grey(7)))


def bedroom(rng: Random, palette: Palette) -> Setting:
    """Build a bed between two lamps."""
    room = Room("bedroom", rng, palette, 4.4, 4.6, 2.6)
    room.look((-1.75, 1.5, 2.0), (0.3, 0.62, -0.9), 52.0)
    room.window(LEFT, 0.9, 0.85, 1.5, 1.35)
    for side in (-1.1, 1.1):
        room.hang([fixtures.curtain(palette, rng, 0.5, 2.3)], LEFT, 0.9 + side, 0.05)
    room.against([furniture.bed(rng, palette)], BACK, 0.25)
    for along in (-0.88, 1.4):
        stand = furniture.cabinet(palette, 0.45, 0.5, 1, 0.4)
        lamp = centered(stand.supports[0], fixtures.table_lamp(palette), 0.45, 0.45)
        room.against(
            laden(rng, stand, [lambda: vessels.cup(rng, palette)], first=[lamp]), BACK, along
        )
    room.lay(furniture.rug(palette, 1.5, 0.9, 9), 0.0, 0.95)
    room.put([toys.ball(rng, palette, 0.12)], 0.35, 0.95)
    chest = furniture.cabinet(palette, 1.1, 0.85, 2)
    room.against(laden(rng, chest, ware(rng, palette, 5)), RIGHT, -0.35)
    room.hang([fixtures.looking_glass(palette, 0.34)], RIGHT, -0.35, 1.25)
    room.hang([fixtures.picture(rng, palette, 1.1, 0.6)], BACK, 0.25, 1.45)
    room.put([fixtures.plant(rng, palette, 0.9)], -1.75, -1.85)
    room.put([seating.stool(palette)], -1.2, -0.2)
    return room.finish(
        WINDOW,
        planks,
        (palette.chip(palette.key, (6, 7), (2, 4)), palette.chip(22.0, (8, 8), (2, 2))),
    )


def playroom(rng: Random, palette: Palette) -> Setting:
    """Scatter toys on a rug, a low table and a shelf."""
    room = Room("playroom", rng, palette, 4.4, 4.0, 2.6)
    room.look((1.45, 1.3, 1.65), (-0.25, 0.42, -0.75), 52.0)
    room.window(RIGHT, -0.5, 0.85, 1.5, 1.25)
    rug = furniture.rug(palette, 2.2, 1.6, 11)
    room.lay(rug, -0.1, 0.1)
    table = furniture.table(palette, 0.9, 0.6, 0.48, 0.045)
    room.put(
        laden(rng, table, playthings(rng, palette, 6)), -0.35, -0.15, float(rng.uniform(-8.0, 8.0))
    )
    for x, z in ((-1.55, 0.05), (0.75, -0.95)):
        room.put([seating.stool(palette)], x, z)
    shelf = furniture.shelf(palette, 1.7, 1.05, 4, 0.34)
    group = [shelf]
    for level in shelf.supports:
        group += in_row(rng, level, playthings(rng, palette, 9), (0.03, 0.09))
    room.against(group, BACK, -0.35)
    low = furniture.cabinet(palette, 1.0, 0.6, 2, 0.4)
    room.against(laden(rng, low, playthings(rng, palette, 5)), LEFT, 0.5)
    for make in playthings(rng, palette, 11):
        place = rng.uniform((-0.95, -0.45), (0.85, 0.8))
        room.put([make().turned(float(rng.uniform(0.0, 360.0)))], *map(float, place))
    for along, wide in ((-0.8, 0.6), (0.25, 0.8)):
        room.hang([fixtures.picture(rng, palette, wide, 0.55)], BACK, along, 1.5)
    room.hang([fixtures.picture(rng, palette, 0.7, 0.5)], LEFT, 0.5, 1.35)
    room.suspend(fixtures.pendant(palette, 0.2, 0.35), 0.35, -0.5)
    return room.finish(WINDOW, plain, (palette.chip(palette.key, (7, 8), (4, 6)), palette.pale()))


def gallery(rng: Random, palette: Palette) -> Setting:
    """Stand sculpture on plinths before pictures on white walls."""
    room = Room("gallery", rng, palette, 6.0, 5.0, 3.0)
    room.look((0.45, 1.6, 2.2), (0.08, 1.1, -1.0), 54.0)
    room.window(LEFT, 0.2, 0.9, 2.2, 1.7)
    spots = (
        (-1.6, -0.75, 0.9),
        (-0.7, -1.35, 1.1),
        (0.3, -0.5, 0.8),
        (1.15, -1.4, 1.15),
        (1.3, -0.3, 0.95),
    )
    for make, (x, z, tall) in zip(sculptures(rng, palette, 5, 0.34), spots, strict=True):
        plinth = furniture.plinth(palette, 0.44, tall * float(rng.uniform(0.92, 1.08)))
        work = centered(plinth.supports[0], make().turned(float(rng.uniform(0.0, 360.0))))
        room.put([plinth, work], x, z, float(rng.uniform(-15.0, 15.0)))
    for along, wide, tall in ((-1.75, 1.1, 1.3), (0.0, 1.5, 1.0), (1.8, 1.1, 1.2)):
        room.hang([fixtures.picture(rng, palette, wide, tall)], BACK, along, 1.2)
    for along in (-1.2, 0.6):
        room.hang([fixtures.picture(rng, palette, 1.0, 1.2)], RIGHT, along, 1.1)
    for x in (-1.5, 1.5):
        room.suspend(fixtures.ceiling_panel(palette, 0.5, 2.6), x, -0.3)
    return room.finish(LAMP, planks, (palette.grey(8), palette.grey(8)))


def library(rng: Random, palette: Palette) -> Setting:
    """Line walls with books around an armchair and a lamp to read by."""
    room = Room("library", rng, palette, 4.4, 4.2, 2.8)
    room.look((1.5, 1.5, 1.75), (-0.4, 0.9, -1.0), 54.0)
    room.window(RIGHT, 0.1, 0.8, 1.6, 1.6)
    for along in (-1.65, -0.6, 0.45):
        shelf = furniture.shelf(palette, 1.0, 1.92, 6, 0.28)
        room.against(filled_shelf(rng, palette, shelf, 0.85), BACK, along)
    shelf = furniture.shelf(palette, 1.0, 1.92, 6, 0.28)
    room.against(filled_shelf(rng, palette, shelf, 0.85), LEFT, 0.85)
    room.lay(furniture.rug(palette, 2.2, 1.6, 9), -0.35, -0.1)
    room.put([seating.sofa(rng, palette, 1)], -0.85, -0.3, 48.0)
    table = furniture.round_table(palette, 0.3, 0.55)
    stack = pile(rng, palette, table.supports[0], 3, [])
    room.put(laden(rng, table, [lambda: vessels.cup(rng, palette)], first=stack), 0.3, 0.05)
    room.put([fixtures.floor_lamp(palette)], 0.2, -1.05)
    room.put([fixtures.plant(rng, palette, 1.0)], 1.55, -1.55)
    room.hang([fixtures.picture(rng, palette, 0.6, 0.8)], BACK, 1.5, 1.4)
    floor = Support((-0.2, 0.2), (-0.2, 0.2), 0.0)
    room.put(pile(rng, palette, floor, 4, []), 0.55, 0.45, 20.0)
    room.put(
        laden(rng, furniture.plinth(palette, 0.36, 0.9), sculptures(rng, palette, 1, 0.2)),
        -1.7,
        -0.12,
    )
    return room.finish(WINDOW, planks, (palette.grey(7), palette.chip(palette.key, (6, 7), (2, 4))))


def pottery(rng: Random, palette: Palette) -> Setting:
    """Build a workshop: ware on a bench, on boards and on the floor."""
    room = Room("pottery", rng, palette, 4.8, 4.2, 2.7)
    room.look((-1.6, 1.55, 1.75), (0.25, 0.85, -0.9), 52.0)
    room.window(LEFT, 0.5, 0.9, 1.8, 1.3)
    bench = furniture.trestle(palette, 2.0, 0.8)
    group = laden(rng, bench, ware(rng, palette, 14))
    group += scatter(rng, bench.supports[1], ware(rng, palette, 6))
    room.put(group, 0.35, -0.35, float(rng.uniform(-6.0, 6.0)))
    for height in (0.95, 1.4, 1.85):
        board = furniture.wall_board(palette, 3.0, 0.26)
        row = in_row(rng, board.supports[0], ware(rng, palette, 18), (0.07, 0.2))
        room.hang([board, *row], BACK, 0.2, height)
    shelf = furniture.shelf(palette, 1.2, 1.8, 4, 0.36)
    room.against(filled_shelf(rng, palette, shelf, 0.0), RIGHT, -0.4)
    low = furniture.cabinet(palette, 2.0, 0.75, 4, 0.4)
    room.against(laden(rng, low, ware(rng, palette, 4)), BACK, 0.2)
    for x, z in ((-0.55, 0.5), (0.6, 0.55)):
        room.put([seating.stool(palette)], x, z)
    tall = [
        vessels.decorate(rng, palette, "vase", vessels.vase_shape(rng, 0.55, detail=vessels.MEDIUM))
        for _ in range(3)
    ]
    for thing, (x, z) in zip(tall, ((-1.45, -1.4), (-1.75, -0.9), (-1.1, -1.05)), strict=True):
        room.put([thing], x, z)
    room.suspend(fixtures.pendant(palette, 0.2, 0.5), 0.3, -0.2)
    return room.finish(WINDOW, tiles, (palette.chip(20.0, (7, 8), (2, 4), 8.0), palette.grey(8)))


ROOMS: dict[str, Callable[[Random, Palette], Setting]] = {
    make.__name__: make
    for make in (
        living_room,
        study,
        dining_room,
        kitchen,
        bedroom,
        playroom,
        gallery,
        library,
        pottery,
    )
}
"""Builders of rooms by name."""
