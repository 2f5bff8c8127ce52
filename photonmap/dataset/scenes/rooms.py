"""Nine rooms: their furniture, what is on it, windows, lamps, and the camera."""

from __future__ import annotations

from collections.abc import Callable

from photonmap.dataset.models import (
    accessories,
    furniture,
    lamps,
    sculptures,
    toys,
    vessels,
    wall_fixtures,
)
from photonmap.dataset.models.arrangements import (
    draw_sculptures,
    draw_toys,
    draw_vessels,
    fill_shelf,
    furnish,
    row_of_books,
    stack_books,
)
from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.palette import Palette
from photonmap.dataset.models.placement import in_row, place_at, scatter
from photonmap.dataset.models.scene_object import Support
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.models.wall_fixtures import WINDOW
from photonmap.dataset.scenes.room_builder import (
    BACK,
    FRONT,
    LEFT,
    RIGHT,
    RoomBuilder,
    plain,
    planks,
    tiles,
)
from photonmap.dataset.scenes.unlit_scene import UnlitScene


def living_room(rng: Random, palette: Palette) -> UnlitScene:
    """Build a room with a sofa and an armchair around a low table, lit by two windows."""
    room = RoomBuilder("living_room", rng, palette, 5.0, 4.6, 2.6)
    room.set_camera((2.0, 1.45, 1.95), (-0.35, 0.72, -1.1), 55.0)
    room.add_window(LEFT, 0.1, 0.85, 1.7, 1.35)
    room.add_window(FRONT, 0.6, 0.85, 1.6, 1.35)
    for side in (-1.25, 1.25):
        room.hang([wall_fixtures.curtain(palette, rng, 0.55, 2.35)], LEFT, 0.1 + side, 0.05)
    room.lay_rug(furniture.rug(palette, 2.3, 1.7), -0.35, -0.25)
    room.place_against([furniture.sofa(rng, palette, 3)], BACK, -0.5)
    room.place([furniture.sofa(rng, palette, 1)], -1.95, -0.5, 90.0)
    table = furniture.round_table(palette, 0.48, 0.42)
    read = stack_books(rng, palette, table.supports[0], 2, [])
    makers = [lambda: vessels.bowl(rng, palette, 0.13), lambda: vessels.cup(rng, palette)]
    room.place(furnish(rng, table, makers, first=read), -0.35, -0.25)
    shelf = furniture.shelf(palette, 1.05, 1.7, 5)
    room.place_against(fill_shelf(rng, palette, shelf, 0.5), BACK, 1.75)
    room.place([lamps.floor_lamp(palette)], 0.93, -1.95)
    room.place([accessories.plant(rng, palette, 0.95)], -2.05, -1.75)
    for along, wide, tall in ((-1.0, 0.8, 0.6), (0.05, 0.55, 0.7)):
        room.hang([wall_fixtures.picture(rng, palette, wide, tall)], BACK, along, 1.4)
    walls = palette.chip(palette.key, (6, 7), (2, 6)), palette.grey(7)
    return room.build(WINDOW, planks, walls)


def study(rng: Random, palette: Palette) -> UnlitScene:
    """Build a room with a desk, a desk lamp and bookshelves."""
    room = RoomBuilder("study", rng, palette, 4.2, 4.0, 2.6)
    room.set_camera((-1.55, 1.5, 1.65), (0.42, 0.86, -1.0), 54.0)
    room.add_window(LEFT, 0.35, 0.9, 1.3, 1.3)
    room.lay_rug(furniture.rug(palette, 1.5, 1.1, 5), -0.2, 0.35, float(rng.choice([0.0, 90.0])))
    desk = furniture.desk(palette)
    top = desk.supports[0]
    lamp = place_at(top, lamps.table_lamp(palette), 0.1, 0.3)
    row = row_of_books(rng, palette, Support((0.1, 0.6), (top.z[0], top.z[0] + 0.22), top.y))
    objects = stack_books(rng, palette, top, 3, [lamp, *row])
    makers = [lambda: vessels.cup(rng, palette), lambda: sculptures.pebble(rng, palette, 0.06)]
    room.place_against(furnish(rng, desk, makers, first=[lamp, *row, *objects]), BACK, -0.5)
    room.place([furniture.chair(palette)], -0.5, -0.85, 180.0 + float(rng.uniform(-30.0, 30.0)))
    for along in (-0.95, 0.0):
        shelf = furniture.shelf(palette, 0.9, 1.95, 6)
        room.place_against(fill_shelf(rng, palette, shelf), RIGHT, along)
    globe = furnish(
        rng, furniture.round_table(palette, 0.26, 0.6), [lambda: toys.ball(rng, palette, 0.13)]
    )
    room.place(globe, 1.0, -1.6)
    room.hang([wall_fixtures.clock(palette)], BACK, 0.6, 1.75)
    room.suspend(lamps.pendant(palette, 0.17, 0.3), 0.9, 0.1)
    room.hang([wall_fixtures.picture(rng, palette, 0.9, 0.62)], BACK, -0.5, 1.4)
    return room.build(
        WINDOW,
        planks,
        (palette.chip(40.0, (6, 7), (2, 4), 12.0), palette.chip(22.0, (8, 8), (2, 2))),
    )


def dining_room(rng: Random, palette: Palette) -> UnlitScene:
    """Build a room with chairs around a laid table, below a lamp."""
    room = RoomBuilder("dining_room", rng, palette, 4.8, 4.8, 2.7)
    room.set_camera((-1.95, 1.6, 2.1), (0.12, 0.84, -0.6), 55.0)
    room.add_window(RIGHT, -0.2, 0.9, 1.8, 1.4)
    room.lay_rug(furniture.rug(palette, 2.9, 2.5, 9), 0.1, -0.3)
    table = furniture.table(palette, 1.7, 0.95)
    level = table.supports[0]
    bowl = place_at(level, vessels.bowl(rng, palette, 0.17))
    plates = [
        place_at(level, vessels.plate(rng, palette), x, z) for x in (0.2, 0.8) for z in (0.13, 0.87)
    ]
    makers = [lambda: vessels.cup(rng, palette)] * 4 + [lambda: vessels.bottle(rng, palette)] * 2
    room.place(furnish(rng, table, makers, first=[bowl, *plates]), 0.1, -0.3, 0.0, 0.0)
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
        room.place(
            [furniture.chair(palette)],
            0.1 + x,
            -0.3 + z,
            turn + float(rng.uniform(-8.0, 8.0)),
            0.02,
        )
    room.suspend(lamps.shade_lamp(palette, 0.32, 0.6), 0.1, -0.3)
    board = furniture.cabinet(palette, 1.8, 0.85, 4)
    room.place_against(furnish(rng, board, draw_vessels(rng, palette, 7)), BACK, 0.0)
    room.hang([wall_fixtures.picture(rng, palette, 1.25, 0.75)], BACK, 0.0, 1.4)
    room.place([accessories.plant(rng, palette, 1.0)], 1.9, -1.95)
    room.place([accessories.plant(rng, palette, 0.8)], -1.95, -1.95)
    return room.build(
        LAMP, planks, (palette.chip(None, (6, 7), (4, 6)), palette.chip(22.0, (7, 7), (2, 2)))
    )


def kitchen(rng: Random, palette: Palette) -> UnlitScene:
    """Build a kitchen: cupboards below a window, wall shelves with vessels, a round table."""
    room = RoomBuilder("kitchen", rng, palette, 4.2, 4.0, 2.6)
    room.set_camera((1.5, 1.55, 1.65), (-0.35, 0.85, -1.0), 54.0)
    room.add_window(BACK, -0.5, 1.15, 1.2, 1.05)
    colors = palette.wood(), palette.chip(None, (5, 7), (4, 8))
    counter = furniture.cabinet(palette, 2.4, 0.9, 4, 0.6, colors)
    room.place_against(furnish(rng, counter, draw_vessels(rng, palette, 8)), BACK, -0.6)
    tall = furniture.cabinet(palette, 0.75, 2.0, 1, 0.6, colors)
    room.place_against([tall], BACK, 1.1)
    for height in (1.25, 1.65):
        board = furniture.wall_board(palette, 1.5)
        group = in_row(
            rng, board.supports[0], draw_vessels(rng, palette, 7, small=True), (0.03, 0.1)
        )
        room.hang([board, *group], LEFT, 0.7, height)
    low = furniture.cabinet(palette, 1.5, 0.9, 3, 0.5, colors)
    room.place_against(furnish(rng, low, draw_vessels(rng, palette, 5)), LEFT, 0.7)
    table = furniture.round_table(palette, 0.5, 0.74)
    makers = [lambda: vessels.bowl(rng, palette, 0.16), lambda: vessels.plate(rng, palette)]
    makers += [lambda: vessels.cup(rng, palette), lambda: vessels.cup(rng, palette)]
    room.place(furnish(rng, table, makers), 0.25, 0.1)
    for x, z in ((-0.5, 0.25), (0.3, -0.68), (0.95, -0.35)):
        room.place([furniture.stool(palette)], x, z)
    room.suspend(lamps.ceiling_panel(palette, 1.2, 0.5), 0.0, 0.0)
    room.hang([wall_fixtures.clock(palette)], BACK, 0.42, 1.75)
    return room.build(LAMP, tiles, (palette.chip(25.0, (7, 8), (2, 6), 10.0), palette.grey(7)))


def bedroom(rng: Random, palette: Palette) -> UnlitScene:
    """Build a bedroom: a bed between two lamps."""
    room = RoomBuilder("bedroom", rng, palette, 4.4, 4.6, 2.6)
    room.set_camera((-1.75, 1.5, 2.0), (0.3, 0.62, -0.9), 52.0)
    room.add_window(LEFT, 0.9, 0.85, 1.5, 1.35)
    for side in (-1.1, 1.1):
        room.hang([wall_fixtures.curtain(palette, rng, 0.5, 2.3)], LEFT, 0.9 + side, 0.05)
    room.place_against([furniture.bed(rng, palette)], BACK, 0.25)
    for along in (-0.88, 1.4):
        stand = furniture.cabinet(palette, 0.45, 0.5, 1, 0.4)
        lamp = place_at(stand.supports[0], lamps.table_lamp(palette), 0.45, 0.45)
        room.place_against(
            furnish(rng, stand, [lambda: vessels.cup(rng, palette)], first=[lamp]), BACK, along
        )
    room.lay_rug(furniture.rug(palette, 1.5, 0.9, 9), 0.0, 0.95)
    room.place([toys.ball(rng, palette, 0.12)], 0.35, 0.95)
    chest = furniture.cabinet(palette, 1.1, 0.85, 2)
    room.place_against(furnish(rng, chest, draw_vessels(rng, palette, 5)), RIGHT, -0.35)
    room.hang([wall_fixtures.wall_mirror(palette, 0.34)], RIGHT, -0.35, 1.25)
    room.hang([wall_fixtures.picture(rng, palette, 1.1, 0.6)], BACK, 0.25, 1.45)
    room.place([accessories.plant(rng, palette, 0.9)], -1.75, -1.85)
    room.place([furniture.stool(palette)], -1.2, -0.2)
    return room.build(
        WINDOW,
        planks,
        (palette.chip(palette.key, (6, 7), (2, 4)), palette.chip(22.0, (8, 8), (2, 2))),
    )


def playroom(rng: Random, palette: Palette) -> UnlitScene:
    """Build a room with toys scattered on a rug, a low table and a shelf."""
    room = RoomBuilder("playroom", rng, palette, 4.4, 4.0, 2.6)
    room.set_camera((1.45, 1.3, 1.65), (-0.25, 0.42, -0.75), 52.0)
    room.add_window(RIGHT, -0.5, 0.85, 1.5, 1.25)
    rug = furniture.rug(palette, 2.2, 1.6, 11)
    room.lay_rug(rug, -0.1, 0.1)
    table = furniture.table(palette, 0.9, 0.6, 0.48, 0.045)
    room.place(
        furnish(rng, table, draw_toys(rng, palette, 6)), -0.35, -0.15, float(rng.uniform(-8.0, 8.0))
    )
    for x, z in ((-1.55, 0.05), (0.75, -0.95)):
        room.place([furniture.stool(palette)], x, z)
    shelf = furniture.shelf(palette, 1.7, 1.05, 4, 0.34)
    group = [shelf]
    for level in shelf.supports:
        group += in_row(rng, level, draw_toys(rng, palette, 9), (0.03, 0.09))
    room.place_against(group, BACK, -0.35)
    low = furniture.cabinet(palette, 1.0, 0.6, 2, 0.4)
    room.place_against(furnish(rng, low, draw_toys(rng, palette, 5)), LEFT, 0.5)
    for make in draw_toys(rng, palette, 11):
        place = rng.uniform((-0.95, -0.45), (0.85, 0.8))
        room.place([make().turned(float(rng.uniform(0.0, 360.0)))], *map(float, place))
    for along, wide in ((-0.8, 0.6), (0.25, 0.8)):
        room.hang([wall_fixtures.picture(rng, palette, wide, 0.55)], BACK, along, 1.5)
    room.hang([wall_fixtures.picture(rng, palette, 0.7, 0.5)], LEFT, 0.5, 1.35)
    room.suspend(lamps.pendant(palette, 0.2, 0.35), 0.35, -0.5)
    return room.build(WINDOW, plain, (palette.chip(palette.key, (7, 8), (4, 6)), palette.pale()))


def gallery(rng: Random, palette: Palette) -> UnlitScene:
    """Build a gallery: sculptures on plinths in front of pictures on white walls."""
    room = RoomBuilder("gallery", rng, palette, 6.0, 5.0, 3.0)
    room.set_camera((0.45, 1.6, 2.2), (0.08, 1.1, -1.0), 54.0)
    room.add_window(LEFT, 0.2, 0.9, 2.2, 1.7)
    spots = (
        (-1.6, -0.75, 0.9),
        (-0.7, -1.35, 1.1),
        (0.3, -0.5, 0.8),
        (1.15, -1.4, 1.15),
        (1.3, -0.3, 0.95),
    )
    for make, (x, z, tall) in zip(draw_sculptures(rng, palette, 5, 0.34), spots, strict=True):
        plinth = furniture.plinth(palette, 0.44, tall * float(rng.uniform(0.92, 1.08)))
        work = place_at(plinth.supports[0], make().turned(float(rng.uniform(0.0, 360.0))))
        room.place([plinth, work], x, z, float(rng.uniform(-15.0, 15.0)))
    for along, wide, tall in ((-1.75, 1.1, 1.3), (0.0, 1.5, 1.0), (1.8, 1.1, 1.2)):
        room.hang([wall_fixtures.picture(rng, palette, wide, tall)], BACK, along, 1.2)
    for along in (-1.2, 0.6):
        room.hang([wall_fixtures.picture(rng, palette, 1.0, 1.2)], RIGHT, along, 1.1)
    for x in (-1.5, 1.5):
        room.suspend(lamps.ceiling_panel(palette, 0.5, 2.6), x, -0.3)
    return room.build(LAMP, planks, (palette.grey(8), palette.grey(8)))


def library(rng: Random, palette: Palette) -> UnlitScene:
    """Build a library: walls lined with books around an armchair and a reading lamp."""
    room = RoomBuilder("library", rng, palette, 4.4, 4.2, 2.8)
    room.set_camera((1.5, 1.5, 1.75), (-0.4, 0.9, -1.0), 54.0)
    room.add_window(RIGHT, 0.1, 0.8, 1.6, 1.6)
    for along in (-1.65, -0.6, 0.45):
        shelf = furniture.shelf(palette, 1.0, 1.92, 6, 0.28)
        room.place_against(fill_shelf(rng, palette, shelf, 0.85), BACK, along)
    shelf = furniture.shelf(palette, 1.0, 1.92, 6, 0.28)
    room.place_against(fill_shelf(rng, palette, shelf, 0.85), LEFT, 0.85)
    room.lay_rug(furniture.rug(palette, 2.2, 1.6, 9), -0.35, -0.1)
    room.place([furniture.sofa(rng, palette, 1)], -0.85, -0.3, 48.0)
    table = furniture.round_table(palette, 0.3, 0.55)
    stack = stack_books(rng, palette, table.supports[0], 3, [])
    room.place(furnish(rng, table, [lambda: vessels.cup(rng, palette)], first=stack), 0.3, 0.05)
    room.place([lamps.floor_lamp(palette)], 0.2, -1.05)
    room.place([accessories.plant(rng, palette, 1.0)], 1.55, -1.55)
    room.hang([wall_fixtures.picture(rng, palette, 0.6, 0.8)], BACK, 1.5, 1.4)
    floor = Support((-0.2, 0.2), (-0.2, 0.2), 0.0)
    room.place(stack_books(rng, palette, floor, 4, []), 0.55, 0.45, 20.0)
    room.place(
        furnish(rng, furniture.plinth(palette, 0.36, 0.9), draw_sculptures(rng, palette, 1, 0.2)),
        -1.7,
        -0.12,
    )
    return room.build(WINDOW, planks, (palette.grey(7), palette.chip(palette.key, (6, 7), (2, 4))))


def pottery(rng: Random, palette: Palette) -> UnlitScene:
    """Build a workshop with vessels on a bench, on wall shelves and on the floor."""
    room = RoomBuilder("pottery", rng, palette, 4.8, 4.2, 2.7)
    room.set_camera((-1.6, 1.55, 1.75), (0.25, 0.85, -0.9), 52.0)
    room.add_window(LEFT, 0.5, 0.9, 1.8, 1.3)
    bench = furniture.trestle(palette, 2.0, 0.8)
    group = furnish(rng, bench, draw_vessels(rng, palette, 14))
    group += scatter(rng, bench.supports[1], draw_vessels(rng, palette, 6))
    room.place(group, 0.35, -0.35, float(rng.uniform(-6.0, 6.0)))
    for height in (0.95, 1.4, 1.85):
        board = furniture.wall_board(palette, 3.0, 0.26)
        row = in_row(rng, board.supports[0], draw_vessels(rng, palette, 18), (0.07, 0.2))
        room.hang([board, *row], BACK, 0.2, height)
    shelf = furniture.shelf(palette, 1.2, 1.8, 4, 0.36)
    room.place_against(fill_shelf(rng, palette, shelf, 0.0), RIGHT, -0.4)
    low = furniture.cabinet(palette, 2.0, 0.75, 4, 0.4)
    room.place_against(furnish(rng, low, draw_vessels(rng, palette, 4)), BACK, 0.2)
    for x, z in ((-0.55, 0.5), (0.6, 0.55)):
        room.place([furniture.stool(palette)], x, z)
    tall = [
        vessels.decorate(rng, palette, "vase", vessels.vase_shape(rng, 0.55, detail=vessels.MEDIUM))
        for _ in range(3)
    ]
    for obj, (x, z) in zip(tall, ((-1.45, -1.4), (-1.75, -0.9), (-1.1, -1.05)), strict=True):
        room.place([obj], x, z)
    room.suspend(lamps.pendant(palette, 0.2, 0.5), 0.3, -0.2)
    return room.build(WINDOW, tiles, (palette.chip(20.0, (7, 8), (2, 4), 8.0), palette.grey(8)))


ROOMS: dict[str, Callable[[Random, Palette], UnlitScene]] = {
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
