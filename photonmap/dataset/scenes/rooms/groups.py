"""Functional groups: seats around a table, a desk with its chair, a bed between two lamps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np

from photonmap.dataset.models import (
    bathroom,
    furniture,
    lamps,
    public_rooms,
    small_objects,
    vessels,
    workshop,
)
from photonmap.dataset.models.arrangements import (
    Maker,
    draw_makers,
    draw_sculptures,
    draw_toys,
    draw_vessels,
    fill_shelf,
    furnish,
    in_row,
    place_at,
    row_of_books,
    scatter,
    stack_books,
)
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import SceneObject, Support, bounds_of
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.rooms.room_builder import Group

MakeGroup = Callable[[Random, Palette], Group]

_PASSAGE = 0.6
"""Depth of the floor that is kept free in front of seats, shelves and cupboards, metres."""
_RUG = 0.008
"""Thickness of a rug, metres."""


def draw(rng: Random, low: float, high: float) -> float:
    """Draw a number from a range."""
    return float(rng.uniform(low, high))


def shifted(
    objects: Sequence[SceneObject], x: float, z: float, y: float = 0.0
) -> list[SceneObject]:
    """Return objects moved by x, y and z, metres."""
    return [obj.moved((x, y, z)) for obj in objects]


def side_by_side(objects: Iterable[tuple[SceneObject, float]]) -> list[SceneObject]:
    """Return objects in a row along x that is centred; each with the gap behind it, metres."""
    row, at = list[SceneObject](), 0.0
    for obj, gap in objects:
        row.append(obj.moved((at - float(obj.bounds[0, 0]), 0.0, 0.0)))
        at += float(np.ptp(obj.bounds[:, 0])) + gap
    return shifted(row, -0.5 * at, 0.0)


def seats_around(
    rng: Random, radius: float, gap: tuple[float, float], makers: Sequence[Maker]
) -> list[SceneObject]:
    """Return seats, two or all of three, that face a round table in the middle.

    Parameters
    ----------
    radius : of the table, metres
    gap : least and greatest distance from its edge to the middle of a seat, metres
    makers : of the first, second and third seat
    """
    placed = list[SceneObject]()
    start, count = draw(rng, 0.0, 360.0), int(rng.integers(2, 1 + len(makers)))
    for index, make in enumerate(makers[:count]):
        turn = start + 360.0 * index / count
        reach, angle = radius + draw(rng, *gap), np.radians(turn)
        spot = float(reach * np.sin(angle)), float(reach * np.cos(angle))
        placed += shifted([make().turned(turn + 180.0)], *spot)
    return placed


def stocked(
    rng: Random,
    shelf: SceneObject,
    draw_things: Callable[[], Sequence[Maker]],
    gap: tuple[float, float],
) -> Group:
    """Return a shelf with a row of things on every board.

    Parameters
    ----------
    draw_things : draws makers of what stands on a board
    gap : least and greatest distance between neighbours, metres
    """
    group = [shelf]
    for level in shelf.supports:
        group += in_row(rng, level, draw_things(), gap)
    return Group(group, _PASSAGE)


def on_rug(rng: Random, palette: Palette, objects: Sequence[SceneObject]) -> list[SceneObject]:
    """Return objects that stand on a rug somewhat larger than they are."""
    low, high = bounds_of(objects)
    (wide, _, deep), (x, _, z) = high - low, 0.5 * (low + high)
    margin = draw(rng, 0.12, 0.35)
    rug = furniture.rug(palette, wide + margin, deep + margin, int(rng.integers(3, 12)))
    return [*shifted([rug], float(x), float(z)), *shifted(objects, 0.0, 0.0, _RUG)]


def low_table(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a round or a rectangular low table with books, bowls and cups."""
    if rng.random() < 0.5:
        table = furniture.round_table(palette, draw(rng, 0.32, 0.55), draw(rng, 0.36, 0.5))
    else:
        size = draw(rng, 0.7, 1.2), draw(rng, 0.45, 0.65)
        table = furniture.table(palette, *size, draw(rng, 0.36, 0.48), 0.045)
    books = stack_books(rng, palette, table.supports[0], int(rng.integers(1, 5)), [])
    makers = [
        lambda: vessels.bowl(rng, palette, 0.13),
        lambda: vessels.cup(rng, palette),
        lambda: vessels.vase(rng, palette, 0.2),
        lambda: small_objects.pebble(rng, palette, 0.06),
    ]
    chosen = draw_makers(rng, makers, int(rng.integers(1, 5)))
    return furnish(rng, table, chosen, first=books)


def seats(rng: Random, palette: Palette) -> Group:
    """Return a sofa behind a low table, perhaps on a rug, perhaps with an armchair beside it."""
    sofa = furniture.sofa(rng, palette, int(rng.integers(2, 4)))
    table = low_table(rng, palette)
    if rng.random() < 0.7:
        table = on_rug(rng, palette, table)
    z = float(sofa.bounds[1, 2] + 0.32 - bounds_of(table)[0, 2])
    group = [sofa, *shifted(table, draw(rng, -0.15, 0.15), z)]
    if rng.random() < 0.6:
        side = 1.0 if rng.random() < 0.5 else -1.0
        armchair = furniture.sofa(rng, palette, 1).turned(-90.0 * side)
        reach = float(bounds_of(group)[1 if side > 0 else 0, 0])
        x = reach + side * (
            draw(rng, 0.15, 0.4) - side * float(armchair.bounds[0 if side > 0 else 1, 0])
        )
        group.append(armchair.moved((x, 0.0, z)))
    return Group(group, 0.3)


def reading_place(rng: Random, palette: Palette) -> Group:
    """Return an armchair with a small table, a lamp or a plant at its side."""
    armchair = furniture.sofa(rng, palette, 1)
    side = 1.0 if rng.random() < 0.5 else -1.0
    table = furniture.round_table(palette, draw(rng, 0.2, 0.3), draw(rng, 0.48, 0.62))
    books = stack_books(rng, palette, table.supports[0], int(rng.integers(1, 4)), [])
    aside = furnish(rng, table, [lambda: vessels.cup(rng, palette)], first=books)
    x = side * (float(armchair.bounds[1, 0]) + float(table.bounds[1, 0]) + draw(rng, 0.05, 0.2))
    return Group([armchair, *shifted(aside, x, draw(rng, 0.0, 0.2))], _PASSAGE)


def bookcase(rng: Random, palette: Palette) -> Group:
    """Return one to three shelves side by side, with books and vessels."""
    tall, boards, deep = draw(rng, 1.3, 2.1), int(rng.integers(4, 7)), draw(rng, 0.26, 0.36)
    group, at, count = list[SceneObject](), 0.0, int(rng.integers(1, 3))
    widths = [draw(rng, 0.7, 1.15) for _ in range(count)]
    for wide in widths:
        shelf = furniture.shelf(palette, wide, tall, boards, deep)
        filled = fill_shelf(rng, palette, shelf, draw(rng, 0.4, 0.95))
        group += shifted(filled, at + 0.5 * wide - 0.5 * sum(widths), 0.0)
        at += wide + 0.004
    return Group(group, _PASSAGE)


def desk_place(rng: Random, palette: Palette) -> Group:
    """Return a desk with a lamp, books and small things, and a chair in front of it."""
    desk = furniture.desk(palette, draw(rng, 1.1, 1.6), draw(rng, 0.6, 0.8))
    top = desk.supports[0]
    placed = [place_at(top, lamps.table_lamp(palette), *rng.choice([[0.12, 0.3], [0.88, 0.3]]))]
    placed += stack_books(rng, palette, top, int(rng.integers(1, 5)), placed)
    makers = [
        lambda: vessels.cup(rng, palette),
        lambda: small_objects.pebble(rng, palette, 0.06),
        lambda: small_objects.ball(rng, palette, 0.06),
    ]
    group = furnish(rng, desk, makers[: int(rng.integers(1, 4))], first=placed)
    chair = furniture.chair(palette).turned(180.0 + draw(rng, -35.0, 35.0))
    gap = float(desk.bounds[1, 2] - chair.bounds[0, 2]) + draw(rng, 0.03, 0.25)
    return Group([*group, chair.moved((draw(rng, -0.25, 0.1), 0.0, gap))], 0.2)


def sideboard(rng: Random, palette: Palette) -> Group:
    """Return a low cupboard with vessels, books or a lamp on it."""
    doors = int(rng.integers(2, 5))
    size = doors * draw(rng, 0.38, 0.52), draw(rng, 0.55, 0.95)
    board = furniture.cabinet(palette, *size, doors, draw(rng, 0.36, 0.5))
    top = board.supports[0]
    placed = stack_books(rng, palette, top, int(rng.integers(1, 4)), [])
    makers = draw_vessels(rng, palette, int(rng.integers(2, 8)))
    return Group(furnish(rng, board, makers, first=placed), _PASSAGE)


def wardrobe(rng: Random, palette: Palette) -> Group:
    """Return a tall cupboard."""
    doors = int(rng.integers(2, 4))
    size = doors * draw(rng, 0.42, 0.55), draw(rng, 1.7, 2.1)
    return Group([furniture.cabinet(palette, *size, doors, draw(rng, 0.5, 0.6))], _PASSAGE)


def dining_table(rng: Random, palette: Palette) -> Group:
    """Return a laid table with chairs on both sides, perhaps on a rug."""
    wide, deep = draw(rng, 1.1, 2.0), draw(rng, 0.8, 1.0)
    table = furniture.table(palette, wide, deep, draw(rng, 0.72, 0.77), draw(rng, 0.05, 0.09))
    top, seats_a_side = table.supports[0], max(1, round(wide / 0.7))
    spots = (np.arange(seats_a_side) + 0.5) / seats_a_side
    placed = [place_at(top, vessels.bowl(rng, palette, 0.16))]
    placed += [
        place_at(top, vessels.plate(rng, palette), float(x), z)
        for x in spots
        for z in (0.13, 0.87)
        if abs(x - 0.5) > 0.01 or deep > 0.92
    ]
    makers = draw_vessels(rng, palette, int(rng.integers(3, 9)), small=True)
    group = furnish(rng, table, makers, first=placed)
    for x in spots:
        for side in (-1.0, 1.0):
            turn = (180.0 if side > 0 else 0.0) + draw(rng, -10.0, 10.0)
            chair = furniture.chair(palette).turned(turn)
            z = side * (0.5 * deep + draw(rng, 0.24, 0.42))
            group.append(chair.moved(((float(x) - 0.5) * wide, 0.0, z)))
    return Group(on_rug(rng, palette, group) if rng.random() < 0.6 else group)


def small_table(rng: Random, palette: Palette) -> Group:
    """Return a round table with stools or chairs around it."""
    radius = draw(rng, 0.38, 0.58)
    table = furniture.round_table(palette, radius, draw(rng, 0.7, 0.76))
    makers = [lambda: vessels.bowl(rng, palette, 0.14), lambda: vessels.plate(rng, palette)]
    makers += [lambda: vessels.cup(rng, palette)] * int(rng.integers(1, 4))
    group = furnish(rng, table, makers)
    seats = [partial(make, palette) for make in (furniture.chair, furniture.stool, furniture.chair)]
    return Group([*group, *seats_around(rng, radius, (0.3, 0.42), seats)])


def kitchen_run(rng: Random, palette: Palette) -> Group:
    """Return kitchen cupboards side by side with vessels on top, and a tall one at an end."""
    doors = int(rng.integers(3, 6))
    wide, deep = doors * draw(rng, 0.5, 0.6), draw(rng, 0.55, 0.65)
    colors = palette.wood(), palette.chip(None, (5, 8), (2, 8))
    counter = furniture.cabinet(palette, wide, draw(rng, 0.86, 0.94), doors, deep, colors)
    group = furnish(rng, counter, draw_vessels(rng, palette, int(rng.integers(5, 11))))
    if rng.random() < 0.7:
        tall = furniture.cabinet(palette, draw(rng, 0.55, 0.75), 2.0, 1, deep, colors)
        gap = 0.5 * (wide + float(np.ptp(tall.bounds[:, 0]))) + 0.025
        group.append(tall.moved((gap if rng.random() < 0.5 else -gap, 0.0, 0.0)))
    return Group(group, 0.8)


def bed_place(rng: Random, palette: Palette) -> Group:
    """Return a bed between two bedside cupboards with lamps, or with one."""
    wide = draw(rng, 0.95, 1.8)
    bed = furniture.bed(rng, palette, wide)
    back = float(bed.bounds[0, 2])
    group, tall = [bed], draw(rng, 0.42, 0.6)
    for side in (-1.0, 1.0) if rng.random() < 0.7 else (1.0,):
        stand = furniture.cabinet(palette, draw(rng, 0.38, 0.5), tall, 1, 0.4)
        lamp = place_at(stand.supports[0], lamps.table_lamp(palette), 0.5, 0.42)
        held = furnish(rng, stand, [lambda: vessels.cup(rng, palette)], first=[lamp])
        x = side * (float(bed.bounds[1, 0] + stand.bounds[1, 0]) + draw(rng, 0.05, 0.2))
        group += shifted(held, x, back - float(stand.bounds[0, 2]))
    return Group(group, 0.4)


def plinth_with_work(rng: Random, palette: Palette) -> Group:
    """Return a sculpture on a plinth."""
    side = draw(rng, 0.36, 0.55)
    plinth = furniture.plinth(palette, side, draw(rng, 0.5, 1.2))
    make = draw_sculptures(rng, palette, 1, 0.78 * side)[0]
    work = place_at(plinth.supports[0], make().turned(draw(rng, 0.0, 360.0)))
    return Group([plinth, work])


def work_bench(rng: Random, palette: Palette) -> Group:
    """Return a bench with vessels on it and on the shelf below."""
    bench = furniture.trestle(
        palette, draw(rng, 1.3, 2.2), draw(rng, 0.6, 0.9), draw(rng, 0.74, 0.9)
    )
    group = furnish(rng, bench, draw_vessels(rng, palette, int(rng.integers(8, 16))))
    below = scatter(rng, bench.supports[1], draw_vessels(rng, palette, 6))
    return Group([*group, *below], 0.3)


def vessel_shelf(rng: Random, palette: Palette) -> Group:
    """Return a shelf of vessels."""
    shelf = furniture.shelf(palette, draw(rng, 0.9, 1.5), draw(rng, 1.3, 2.0), 4, 0.36)
    return Group(fill_shelf(rng, palette, shelf, 0.0), _PASSAGE)


def tall_vases(rng: Random, palette: Palette) -> Group:
    """Return one to three tall vases that stand on the floor."""
    group = list[SceneObject]()
    for index in range(int(rng.integers(1, 4))):
        shape = vessels.vase_shape(rng, draw(rng, 0.4, 0.65), detail=vessels.MEDIUM)
        made = vessels.decorate(rng, palette, "vase", shape)
        x = float(bounds_of(group)[1, 0] - made.bounds[0, 0]) + 0.05 if index else 0.0
        group.append(made.moved((x, 0.0, draw(rng, -0.1, 0.1))))
    return Group(group)


def toy_shelf(rng: Random, palette: Palette) -> Group:
    """Return a low shelf of toys."""
    size = draw(rng, 0.9, 1.8), draw(rng, 0.8, 1.2)
    shelf = furniture.shelf(palette, *size, int(rng.integers(3, 5)), 0.34)
    return stocked(rng, shelf, lambda: draw_toys(rng, palette, 9), (0.03, 0.12))


def toy_table(rng: Random, palette: Palette) -> Group:
    """Return a low table with toys, and stools beside it."""
    wide = draw(rng, 0.7, 1.1)
    table = furniture.table(palette, wide, draw(rng, 0.5, 0.7), 0.48, 0.045)
    group = furnish(rng, table, draw_toys(rng, palette, int(rng.integers(4, 9))))
    for side in (-1.0, 1.0)[: int(rng.integers(1, 3))]:
        x = side * (0.5 * wide + draw(rng, 0.28, 0.45))
        group += shifted([furniture.stool(palette)], x, draw(rng, -0.15, 0.15))
    return Group(group)


def toys_on_rug(rng: Random, palette: Palette) -> Group:
    """Return a rug with toys scattered on it."""
    wide, deep = draw(rng, 1.2, 2.2), draw(rng, 0.9, 1.6)
    rug = furniture.rug(palette, wide, deep, int(rng.integers(4, 12)))
    return Group(furnish(rng, rug, draw_toys(rng, palette, int(rng.integers(6, 14)))))


def books_on_floor(rng: Random, palette: Palette) -> Group:
    """Return a pile of books."""
    floor = Support((-0.2, 0.2), (-0.2, 0.2), 0.0)
    return Group(stack_books(rng, palette, floor, int(rng.integers(3, 8)), []))


def wall_board(rng: Random, palette: Palette, wide: float | None = None) -> list[SceneObject]:
    """Return a wall shelf with vessels or books, its back at z = 0, of some width or any."""
    wide = wide or draw(rng, 0.8, 2.2)
    board = furniture.wall_board(palette, wide, draw(rng, 0.2, 0.28))
    level = board.supports[0]
    if rng.random() < 0.3:
        return [board, *row_of_books(rng, palette, level, draw(rng, 0.4, 0.9))]
    return [board, *in_row(rng, level, draw_vessels(rng, palette, 14, small=True), (0.03, 0.16))]


def bath(rng: Random, palette: Palette) -> Group:
    """Return a bathtub, perhaps with a mat in front."""
    tub = bathroom.bathtub(rng, palette)
    group = [tub]
    if rng.random() < 0.6:
        mat = furniture.rug(palette, draw(rng, 0.6, 0.9), 0.45, int(rng.integers(3, 8)))
        group.append(mat.moved((draw(rng, -0.3, 0.3), 0.0, float(tub.bounds[1, 2]) + 0.3)))
    return Group(group, 0.2)


def wash_place(rng: Random, palette: Palette) -> Group:
    """Return a cupboard with a basin, a tap and small things."""
    stand, placed = bathroom.washstand(rng, palette)
    things = bathroom.toiletries(rng, palette, int(rng.integers(2, 6)))
    return Group(furnish(rng, stand, things, first=placed), _PASSAGE)


def toilet(rng: Random, palette: Palette) -> Group:
    """Return a toilet, perhaps with rolls of paper beside it."""
    group = [bathroom.toilet(palette)]
    if rng.random() < 0.5:
        group += shifted([bathroom.paper_roll(palette)], 0.36, draw(rng, -0.2, 0.0))
    return Group(group, _PASSAGE)


def towel_shelf(rng: Random, palette: Palette) -> Group:
    """Return a narrow shelf with towels and bottles."""
    shelf = furniture.shelf(palette, draw(rng, 0.5, 0.8), draw(rng, 1.2, 1.8), 5, 0.34)
    return stocked(rng, shelf, lambda: bathroom.toiletries(rng, palette, 5), (0.02, 0.08))


def rows_of_desks(rng: Random, palette: Palette) -> Group:
    """Return tables in rows with chairs that face one way, and books and pens on them."""
    rows, columns = int(rng.integers(2, 4)), int(rng.integers(1, 3))
    across, along = 1.2 + draw(rng, 0.6, 0.8), 0.5 + draw(rng, 0.75, 0.95)
    group = list[SceneObject]()
    for row in range(rows):
        for column in range(columns):
            x, z = (column - 0.5 * (columns - 1)) * across, (row - 0.5 * (rows - 1)) * along
            table = public_rooms.pupils_table(palette)
            books = stack_books(rng, palette, table.supports[0], int(rng.integers(0, 3)) + 1, [])
            things = [lambda: vessels.cup(rng, palette)] * int(rng.integers(0, 2))
            group += shifted(furnish(rng, table, things, first=books), x, z)
            for side in (-0.26, 0.26)[: int(rng.integers(1, 3))]:
                chair = furniture.chair(palette).turned(180.0 + draw(rng, -6.0, 6.0))
                group += shifted([chair], x + side, z + draw(rng, 0.4, 0.52))
    return Group(group)


def teachers_desk(rng: Random, palette: Palette) -> Group:
    """Return a desk with a globe and books, and a chair behind it."""
    desk = furniture.desk(palette, draw(rng, 1.2, 1.6), draw(rng, 0.6, 0.75))
    top = desk.supports[0]
    placed = [
        place_at(top, public_rooms.globe(rng, palette), *rng.choice([[0.15, 0.4], [0.8, 0.4]]))
    ]
    placed += stack_books(rng, palette, top, int(rng.integers(2, 6)), placed)
    group = furnish(rng, desk, [lambda: vessels.cup(rng, palette)], first=placed)
    chair = furniture.chair(palette).turned(180.0 + draw(rng, -25.0, 25.0))
    gap = float(desk.bounds[1, 2] - chair.bounds[0, 2]) + draw(rng, 0.05, 0.2)
    return Group([*group, chair.moved((draw(rng, -0.2, 0.1), 0.0, gap))], 0.2)


def cafe_table(rng: Random, palette: Palette) -> Group:
    """Return a small round table with cups and plates, and two or three chairs around it."""
    radius = draw(rng, 0.3, 0.42)
    table = furniture.round_table(palette, radius, draw(rng, 0.7, 0.75))
    makers = [lambda: vessels.cup(rng, palette)] * int(rng.integers(1, 4))
    makers += [lambda: vessels.plate(rng, palette), lambda: vessels.vase(rng, palette, 0.14)]
    group = furnish(rng, table, makers)
    seats = [lambda: furniture.chair(palette)] * 3
    return Group([*group, *seats_around(rng, radius, (0.24, 0.36), seats)])


def bar(rng: Random, palette: Palette) -> Group:
    """Return a counter with vessels, a cupboard behind it and stools in front."""
    wide = draw(rng, 1.7, 2.6)
    counter = public_rooms.counter(rng, palette, wide)
    group = furnish(rng, counter, draw_vessels(rng, palette, int(rng.integers(5, 10)), small=True))
    back = furniture.cabinet(palette, wide * 0.8, draw(rng, 0.8, 1.0), 3, 0.4)
    held = furnish(rng, back, draw_vessels(rng, palette, int(rng.integers(3, 7))))
    lane = float(back.bounds[1, 2] - counter.bounds[0, 2]) + draw(rng, 0.75, 0.95)
    group = shifted(group, 0.0, lane)
    front, count = float(bounds_of(group)[1, 2]), max(1, int(wide / 0.7))
    for index in range(count):
        if rng.random() < 0.75:
            x = ((index + 0.5) / count - 0.5) * wide + draw(rng, -0.08, 0.08)
            group += shifted([public_rooms.bar_stool(palette)], x, front + draw(rng, 0.22, 0.34))
    return Group([*held, *group], 0.2)


def wall_seats(rng: Random, palette: Palette) -> Group:
    """Return an upholstered bench along a wall, with a table in front."""
    wide = draw(rng, 1.3, 2.2)
    bench = public_rooms.sofa_bench(palette, wide)
    table = furniture.table(palette, draw(rng, 0.6, 0.75), 0.6, 0.73, 0.045)
    makers = [lambda: vessels.cup(rng, palette)] * int(rng.integers(1, 3))
    laid = furnish(rng, table, [*makers, lambda: vessels.plate(rng, palette)])
    z = float(bench.bounds[1, 2] - table.bounds[0, 2]) + 0.12
    x = draw(rng, -0.25, 0.25) * wide
    chair = furniture.chair(palette).turned(180.0 + draw(rng, -20.0, 20.0))
    gap = z + float(table.bounds[1, 2]) + draw(rng, 0.24, 0.36)
    return Group([bench, *shifted(laid, x, z), chair.moved((x, 0.0, gap))], 0.2)


def tool_bench(rng: Random, palette: Palette) -> Group:
    """Return a workbench with tins, boxes and crates on it and below."""
    bench = furniture.trestle(
        palette, draw(rng, 1.4, 2.2), draw(rng, 0.6, 0.8), draw(rng, 0.82, 0.92)
    )
    things = workshop.shop_things(rng, palette, int(rng.integers(4, 9)))
    group = furnish(rng, bench, things)
    below = scatter(rng, bench.supports[1], workshop.shop_things(rng, palette, 5))
    return Group([*group, *below], _PASSAGE)


def tool_shelf(rng: Random, palette: Palette) -> Group:
    """Return a shelf of tins, boxes and crates."""
    shelf = furniture.shelf(palette, draw(rng, 0.9, 1.4), draw(rng, 1.5, 2.0), 5, 0.42)
    return stocked(rng, shelf, lambda: workshop.shop_things(rng, palette, 7), (0.02, 0.1))


def crates(rng: Random, palette: Palette) -> Group:
    """Return one to three crates beside each other, some with things in them."""
    made = (
        (workshop.crate(rng, palette, draw(rng, 0.35, 0.5)), draw(rng, 0.02, 0.1))
        for _ in range(int(rng.integers(1, 4)))
    )
    return Group(side_by_side(made))


def coats(rng: Random, palette: Palette) -> Group:
    """Return a coat rack on the wall with a bench and shoes below."""
    wide = draw(rng, 0.9, 1.6)
    bench = public_rooms.bench(palette, wide)
    rack = public_rooms.coat_rack(rng, palette, wide).moved((0.0, 0.55, 0.0))
    shoes = [public_rooms.shoes(rng, palette) for _ in range(int(rng.integers(1, 4)))]
    group = [bench]
    for index, pair in enumerate(shoes):
        x = ((index + 0.5) / len(shoes) - 0.5) * 0.75 * wide
        group += shifted([pair], x, draw(rng, -0.02, 0.02))
    back = float(bench.bounds[0, 2]) - 0.03
    return Group([*group, *shifted([rack], 0.0, back, 0.0)], _PASSAGE)


def alone(make: Callable[[Random, Palette], SceneObject]) -> MakeGroup:
    """Return a maker of groups of a single object."""
    return lambda rng, palette: Group([make(rng, palette)])


floor_lamp = alone(lambda rng, palette: lamps.floor_lamp(palette))
plant = alone(lambda rng, palette: small_objects.plant(rng, palette, draw(rng, 0.55, 1.25)))
stool = alone(lambda rng, palette: furniture.stool(palette))
basket = alone(bathroom.basket)
timber = alone(workshop.timber)
umbrellas = alone(public_rooms.umbrella_stand)
