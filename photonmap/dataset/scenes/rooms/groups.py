"""Functional groups: seats around a table, a desk with its chair, a bed between two lamps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from photonmap.dataset.models import furniture, lamps, plants, small_objects, wall_objects
from photonmap.dataset.models.arrangements import (
    fill_shelf,
    furnish,
    in_row,
    place_at,
    row_of_books,
    scatter,
    stack_books,
)
from photonmap.dataset.models.furniture import chair
from photonmap.dataset.models.garments import coat_rack
from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import Maker, SceneObject, Support, bounds_of, sized
from photonmap.dataset.models.small_objects import (
    SHOP_THINGS,
    TOILETRIES,
    TOYS,
    bowl,
    cup,
    draw_sculpture,
    draw_vessels,
    plate,
    vase,
)
from photonmap.dataset.scenes.rooms.room_builder import Group, Objects

MakeGroup = Callable[[Draw], Group]

_PASSAGE = 0.6
"""Depth of the floor that is kept free in front of seats, shelves and cupboards, metres."""
_RUG = 0.008  # thickness of a rug, metres


def shifted(objects: Objects, x: float, z: float, y: float = 0.0) -> Objects:
    """Return objects moved by x, y and z, metres."""
    return [obj.moved((x, y, z)) for obj in objects]


def side_by_side(objects: Iterable[tuple[SceneObject, float]]) -> Objects:
    """Return objects in a row along x that is centred; each with the gap behind it, metres."""
    row, at = list[SceneObject](), 0.0
    for obj, gap in objects:
        row.append(obj.moved((at - float(obj.bounds[0, 0]), 0.0, 0.0)))
        at += float(np.ptp(obj.bounds[:, 0])) + gap
    return shifted(row, -0.5 * at, 0.0)


def alone(make: Maker) -> MakeGroup:
    """Return a maker of groups of a single object."""
    return lambda draw: Group([make(draw)])


def _seats_around(draw: Draw, radius: float, gap: Range, makers: Sequence[Maker]) -> Objects:
    """Return seats, two or all of three, in a range of distances around a table of a radius."""
    placed = list[SceneObject]()
    start, count = draw.number(0.0, 360.0), draw.whole(2, len(makers))
    for index, make in enumerate(makers[:count]):
        turn = start + 360.0 * index / count
        reach, angle = radius + draw.number(*gap), np.radians(turn)
        spot = float(reach * np.sin(angle)), float(reach * np.cos(angle))
        placed += shifted([make(draw).turned(turn + 180.0)], *spot)
    return placed


def seats_facing(draw: Draw, x: Iterable[float], reach: float, gap: Range, lean: float) -> Objects:
    """Return chairs on both sides of a table, at places x, turned by at most `lean` degrees.

    The middle of a chair is farther than the edge of the table, `reach`, by a gap from a range.
    """
    placed = list[SceneObject]()
    for at in x:
        for side in (-1.0, 1.0):
            turn = (180.0 if side > 0 else 0.0) + draw.number(-lean, lean)
            made = chair(draw).turned(turn)
            placed += shifted([made], at, side * (reach + draw.number(*gap)))
    return placed


def _chair_at(draw: Draw, desk: SceneObject, lean: float, x: Range, gap: Range) -> SceneObject:
    """Return a chair that faces a desk, turned by at most `lean` degrees, at a distance `gap`."""
    made = chair(draw).turned(180.0 + draw.number(-lean, lean))
    z = float(desk.bounds[1, 2] - made.bounds[0, 2]) + draw.number(*gap)
    return made.moved((draw.number(*x), 0.0, z))


def _on_rug(draw: Draw, objects: Objects) -> Objects:
    """Return objects that stand on a rug somewhat larger than they are."""
    low, high = bounds_of(objects)
    (wide, _, deep), (x, _, z) = high - low, 0.5 * (low + high)
    margin = draw.number(0.12, 0.35)
    rug = furniture.rug(draw, wide + margin, deep + margin, draw.whole(3, 11))
    return [*shifted([rug], float(x), float(z)), *shifted(objects, 0.0, 0.0, _RUG)]


def _low_table(draw: Draw) -> Objects:
    """Return a round or a rectangular low table with books, bowls and cups."""
    if draw.chance(0.5):
        table = furniture.round_table(draw, draw.number(0.32, 0.55), draw.number(0.36, 0.5))
    else:
        size = draw.number(0.7, 1.2), draw.number(0.45, 0.65), draw.number(0.36, 0.48)
        table = furniture.table(draw, *size, 0.045)
    books = stack_books(draw, table.supports[0], draw.whole(1, 4))
    makers = [sized(bowl, 0.13), cup, sized(vase, 0.2), sized(small_objects.pebble, 0.06)]
    return furnish(draw, table, draw.several(makers, draw.whole(1, 4)), books)


def seats(draw: Draw) -> Group:
    """Return a sofa behind a low table, perhaps on a rug, perhaps with an armchair beside it."""
    sofa, table = furniture.sofa(draw, draw.whole(2, 3)), _low_table(draw)
    if draw.chance(0.7):
        table = _on_rug(draw, table)
    z = float(sofa.bounds[1, 2] + 0.32 - bounds_of(table)[0, 2])
    group = [sofa, *shifted(table, draw.number(-0.15, 0.15), z)]
    if draw.chance(0.6):
        side = 1.0 if draw.chance(0.5) else -1.0
        armchair = furniture.armchair(draw).turned(-90.0 * side)
        right = side > 0
        reach = float(bounds_of(group)[int(right), 0])
        gap = draw.number(0.15, 0.4) - side * float(armchair.bounds[int(not right), 0])
        group += shifted([armchair], reach + side * gap, z)
    return Group(group, 0.3)


def reading_place(draw: Draw) -> Group:
    """Return an armchair with a small table, a lamp or a plant at its side."""
    armchair, side = furniture.armchair(draw), 1.0 if draw.chance(0.5) else -1.0
    table = furniture.round_table(draw, draw.number(0.2, 0.3), draw.number(0.48, 0.62))
    books = stack_books(draw, table.supports[0], draw.whole(1, 3))
    aside = furnish(draw, table, [cup], books)
    x = float(armchair.bounds[1, 0]) + float(table.bounds[1, 0]) + draw.number(0.05, 0.2)
    return Group([armchair, *shifted(aside, side * x, draw.number(0.0, 0.2))], _PASSAGE)


def bookcase(draw: Draw) -> Group:
    """Return one or two shelves side by side, with books and vessels."""
    tall, boards, deep = draw.number(1.3, 2.1), draw.whole(4, 6), draw.number(0.26, 0.36)
    group, at = list[SceneObject](), 0.0
    widths = [draw.number(0.7, 1.15) for _ in range(draw.whole(1, 2))]
    for wide in widths:
        shelf = furniture.shelf(draw, wide, tall, boards, deep)
        filled = fill_shelf(draw, shelf, draw.number(0.4, 0.95))
        group += shifted(filled, at + 0.5 * wide - 0.5 * sum(widths), 0.0)
        at += wide + 0.004
    return Group(group, _PASSAGE)


def desk_place(draw: Draw) -> Group:
    """Return a desk with a lamp, books and small things, and a chair in front of it."""
    desk = furniture.desk(draw, draw.number(1.1, 1.6), draw.number(0.6, 0.8))
    top = desk.supports[0]
    placed = [place_at(top, lamps.table_lamp(draw), *draw.rng.choice([[0.12, 0.3], [0.88, 0.3]]))]
    placed += stack_books(draw, top, draw.whole(1, 4), placed)
    pebble, ball = (sized(make, 0.06) for make in (small_objects.pebble, small_objects.ball))
    group = furnish(draw, desk, [cup, pebble, ball][: draw.whole(1, 3)], placed)
    return Group([*group, _chair_at(draw, desk, 35.0, (-0.25, 0.1), (0.03, 0.25))], 0.2)


def sideboard(draw: Draw) -> Group:
    """Return a low cupboard with vessels, books or a lamp on it."""
    doors = draw.whole(2, 4)
    size = doors * draw.number(0.38, 0.52), draw.number(0.55, 0.95)
    board = furniture.cabinet(draw, *size, doors, draw.number(0.36, 0.5))
    books = stack_books(draw, board.supports[0], draw.whole(1, 3))
    return Group(furnish(draw, board, draw_vessels(draw, draw.whole(2, 7)), books), _PASSAGE)


def wardrobe(draw: Draw) -> Group:
    """Return a tall cupboard."""
    doors = draw.whole(2, 3)
    size = doors * draw.number(0.42, 0.55), draw.number(1.7, 2.1)
    return Group([furniture.cabinet(draw, *size, doors, draw.number(0.5, 0.6))], _PASSAGE)


def dining_table(draw: Draw) -> Group:
    """Return a laid table with chairs on both sides, perhaps on a rug."""
    wide, deep = draw.number(1.1, 2.0), draw.number(0.8, 1.0)
    table = furniture.table(draw, wide, deep, draw.number(0.72, 0.77), draw.number(0.05, 0.09))
    top, seats_a_side = table.supports[0], max(1, round(wide / 0.7))
    spots = ((np.arange(seats_a_side) + 0.5) / seats_a_side).tolist()
    placed = [place_at(top, bowl(draw, 0.16))]
    placed += [
        place_at(top, plate(draw), x, z)
        for x in spots
        for z in (0.13, 0.87)
        if abs(x - 0.5) > 0.01 or deep > 0.92
    ]
    group = furnish(draw, table, draw_vessels(draw, draw.whole(3, 8), small=True), placed)
    places = [(x - 0.5) * wide for x in spots]
    group += seats_facing(draw, places, 0.5 * deep, (0.24, 0.42), 10.0)
    return Group(_on_rug(draw, group) if draw.chance(0.6) else group)


def small_table(draw: Draw) -> Group:
    """Return a round table with stools or chairs around it."""
    radius = draw.number(0.38, 0.58)
    table = furniture.round_table(draw, radius, draw.number(0.7, 0.76))
    makers = [sized(bowl, 0.14), plate, *[cup] * draw.whole(1, 3)]
    group = furnish(draw, table, makers)
    return Group(group + _seats_around(draw, radius, (0.3, 0.42), [chair, furniture.stool, chair]))


def cafe_table(draw: Draw) -> Group:
    """Return a small round table with cups and plates, and two or three chairs around it."""
    radius = draw.number(0.3, 0.42)
    table = furniture.round_table(draw, radius, draw.number(0.7, 0.75))
    group = furnish(draw, table, [*[cup] * draw.whole(1, 3), plate, sized(vase, 0.14)])
    return Group(group + _seats_around(draw, radius, (0.24, 0.36), [chair] * 3))


def kitchen_run(draw: Draw) -> Group:
    """Return kitchen cupboards side by side with vessels on top, and a tall one at an end."""
    doors = draw.whole(3, 5)
    wide, deep = doors * draw.number(0.5, 0.6), draw.number(0.55, 0.65)
    colors = draw.wood(), draw.chip(None, (5, 8), (2, 8))
    counter = furniture.cabinet(draw, wide, draw.number(0.86, 0.94), doors, deep, colors)
    group = furnish(draw, counter, draw_vessels(draw, draw.whole(5, 10)))
    if draw.chance(0.7):
        tall = furniture.cabinet(draw, draw.number(0.55, 0.75), 2.0, 1, deep, colors)
        gap = 0.5 * (wide + float(np.ptp(tall.bounds[:, 0]))) + 0.025
        group += shifted([tall], gap if draw.chance(0.5) else -gap, 0.0)
    return Group(group, 0.8)


def bed_place(draw: Draw) -> Group:
    """Return a bed between two bedside cupboards with lamps, or with one."""
    bed = furniture.bed(draw, draw.number(0.95, 1.8))
    group, tall = [bed], draw.number(0.42, 0.6)
    for side in (-1.0, 1.0) if draw.chance(0.7) else (1.0,):
        stand = furniture.cabinet(draw, draw.number(0.38, 0.5), tall, 1, 0.4)
        lamp = place_at(stand.supports[0], lamps.table_lamp(draw), 0.5, 0.42)
        held = furnish(draw, stand, [cup], [lamp])
        x = side * (float(bed.bounds[1, 0] + stand.bounds[1, 0]) + draw.number(0.05, 0.2))
        group += shifted(held, x, float(bed.bounds[0, 2]) - float(stand.bounds[0, 2]))
    return Group(group, 0.4)


def plinth_with_work(draw: Draw) -> Group:
    """Return a sculpture on a plinth."""
    side = draw.number(0.36, 0.55)
    plinth = furniture.plinth(draw, side, draw.number(0.5, 1.2))
    work = draw_sculpture(draw, 0.78 * side)(draw).turned(draw.number(0.0, 360.0))
    return Group([plinth, place_at(plinth.supports[0], work)])


def work_bench(draw: Draw) -> Group:
    """Return a bench with vessels on it and on the shelf below."""
    size = draw.number(1.3, 2.2), draw.number(0.6, 0.9), draw.number(0.74, 0.9)
    bench = furniture.trestle(draw, *size)
    group = furnish(draw, bench, draw_vessels(draw, draw.whole(8, 15)))
    return Group(group + scatter(draw, bench.supports[1], draw_vessels(draw, 6)), 0.3)


def tool_bench(draw: Draw) -> Group:
    """Return a workbench with tins, boxes and crates on it and below."""
    size = draw.number(1.4, 2.2), draw.number(0.6, 0.8), draw.number(0.82, 0.92)
    bench = furniture.trestle(draw, *size)
    group = furnish(draw, bench, draw.several(SHOP_THINGS, draw.whole(4, 8)))
    return Group(group + scatter(draw, bench.supports[1], draw.several(SHOP_THINGS, 5)), _PASSAGE)


def vessel_shelf(draw: Draw) -> Group:
    """Return a shelf of vessels."""
    shelf = furniture.shelf(draw, draw.number(0.9, 1.5), draw.number(1.3, 2.0), 4, 0.36)
    return Group(fill_shelf(draw, shelf, 0.0), _PASSAGE)


def _shelf_of(
    things: Sequence[Maker], count: int, boards: tuple[int, int], depth: float, *ranges: Range
) -> MakeGroup:
    """Return a maker of shelves with a row of a number of things, or fewer, on every board.

    The ranges are those of the width, of the height, and of the gaps between things, metres.
    """
    wide, tall, gap = ranges

    def make(draw: Draw) -> Group:
        size = draw.number(*wide), draw.number(*tall), draw.whole(*boards)
        shelf = furniture.shelf(draw, *size, depth)
        rows = [in_row(draw, level, draw.several(things, count), gap) for level in shelf.supports]
        return Group([shelf, *(obj for row in rows for obj in row)], _PASSAGE)

    return make


toy_shelf = _shelf_of(TOYS, 9, (3, 4), 0.34, (0.9, 1.8), (0.8, 1.2), (0.03, 0.12))
towel_shelf = _shelf_of(TOILETRIES, 5, (5, 5), 0.34, (0.5, 0.8), (1.2, 1.8), (0.02, 0.08))
tool_shelf = _shelf_of(SHOP_THINGS, 7, (5, 5), 0.42, (0.9, 1.4), (1.5, 2.0), (0.02, 0.1))


def tall_vases(draw: Draw) -> Group:
    """Return one to three tall vases that stand on the floor."""
    group = list[SceneObject]()
    for index in range(draw.whole(1, 3)):
        shape = small_objects.vase_shape(
            draw.rng, draw.number(0.4, 0.65), detail=small_objects.MEDIUM
        )
        made = small_objects.decorate(draw, "vase", shape)
        x = float(bounds_of(group)[1, 0] - made.bounds[0, 0]) + 0.05 if index else 0.0
        group += shifted([made], x, draw.number(-0.1, 0.1))
    return Group(group)


def toy_table(draw: Draw) -> Group:
    """Return a low table with toys, and stools beside it."""
    wide = draw.number(0.7, 1.1)
    table = furniture.table(draw, wide, draw.number(0.5, 0.7), 0.48, 0.045)
    group = furnish(draw, table, draw.several(TOYS, draw.whole(4, 8)))
    for side in (-1.0, 1.0)[: draw.whole(1, 2)]:
        x = side * (0.5 * wide + draw.number(0.28, 0.45))
        group += shifted([furniture.stool(draw)], x, draw.number(-0.15, 0.15))
    return Group(group)


def toys_on_rug(draw: Draw) -> Group:
    """Return a rug with toys scattered on it."""
    size = draw.number(1.2, 2.2), draw.number(0.9, 1.6), draw.whole(4, 11)
    rug = furniture.rug(draw, *size)
    return Group(furnish(draw, rug, draw.several(TOYS, draw.whole(6, 13))))


def books_on_floor(draw: Draw) -> Group:
    """Return a pile of books."""
    floor = Support((-0.2, 0.2), (-0.2, 0.2), 0.0)
    return Group(stack_books(draw, floor, draw.whole(3, 7)))


def bath(draw: Draw) -> Group:
    """Return a bathtub, perhaps with a mat in front."""
    tub = furniture.bathtub(draw)
    group = [tub]
    if draw.chance(0.6):
        mat = furniture.rug(draw, draw.number(0.6, 0.9), 0.45, draw.whole(3, 7))
        group += shifted([mat], draw.number(-0.3, 0.3), float(tub.bounds[1, 2]) + 0.3)
    return Group(group, 0.2)


def wash_place(draw: Draw) -> Group:
    """Return a cupboard with a basin, a tap behind it and small things."""
    doors = draw.whole(1, 3)
    wide = max(0.62, doors * draw.number(0.38, 0.5))
    stand = furniture.cabinet(draw, wide, draw.number(0.7, 0.8), doors, 0.5)
    top = stand.supports[0]
    washbowl, tap = place_at(top, small_objects.basin(draw), 0.5, 0.62), small_objects.tap(draw)
    behind = float(washbowl.bounds[0, 2]) - float(tap.bounds[1, 2]) - 0.005
    placed = [washbowl, tap.moved((0.0, top.y, behind))]
    things = draw.several(TOILETRIES, draw.whole(2, 5))
    return Group(furnish(draw, stand, things, placed), _PASSAGE)


def toilet(draw: Draw) -> Group:
    """Return a toilet, perhaps with rolls of paper beside it."""
    group = [furniture.toilet(draw)]
    if draw.chance(0.5):
        group += shifted([small_objects.paper_roll(draw)], 0.36, draw.number(-0.2, 0.0))
    return Group(group, _PASSAGE)


def rows_of_desks(draw: Draw) -> Group:
    """Return tables in rows with chairs that face one way, and books and pens on them."""
    rows, columns = draw.whole(2, 3), draw.whole(1, 2)
    across, along = 1.2 + draw.number(0.6, 0.8), 0.5 + draw.number(0.75, 0.95)
    group = list[SceneObject]()
    for row in range(rows):
        for column in range(columns):
            x, z = (column - 0.5 * (columns - 1)) * across, (row - 0.5 * (rows - 1)) * along
            table = furniture.pupils_table(draw)
            books = stack_books(draw, table.supports[0], draw.whole(1, 3))
            laid = furnish(draw, table, [cup] * draw.whole(0, 1), books)
            group += shifted(laid, x, z)
            for side in (-0.26, 0.26)[: draw.whole(1, 2)]:
                made = chair(draw).turned(180.0 + draw.number(-6.0, 6.0))
                group += shifted([made], x + side, z + draw.number(0.4, 0.52))
    return Group(group)


def teachers_desk(draw: Draw) -> Group:
    """Return a desk with a globe and books, and a chair behind it."""
    desk = furniture.desk(draw, draw.number(1.2, 1.6), draw.number(0.6, 0.75))
    top = desk.supports[0]
    placed = [place_at(top, small_objects.globe(draw), *draw.rng.choice([[0.15, 0.4], [0.8, 0.4]]))]
    placed += stack_books(draw, top, draw.whole(2, 5), placed)
    group = furnish(draw, desk, [cup], placed)
    return Group([*group, _chair_at(draw, desk, 25.0, (-0.2, 0.1), (0.05, 0.2))], 0.2)


def bar(draw: Draw) -> Group:
    """Return a counter with vessels, a cupboard behind it and stools in front."""
    wide = draw.number(1.7, 2.6)
    counter = furniture.counter(draw, wide)
    group = furnish(draw, counter, draw_vessels(draw, draw.whole(5, 9), small=True))
    back = furniture.cabinet(draw, wide * 0.8, draw.number(0.8, 1.0), 3, 0.4)
    held = furnish(draw, back, draw_vessels(draw, draw.whole(3, 6)))
    lane = float(back.bounds[1, 2] - counter.bounds[0, 2]) + draw.number(0.75, 0.95)
    group = shifted(group, 0.0, lane)
    front, count = float(bounds_of(group)[1, 2]), max(1, int(wide / 0.7))
    for index in range(count):
        if draw.chance(0.75):
            x = ((index + 0.5) / count - 0.5) * wide + draw.number(-0.08, 0.08)
            group += shifted([furniture.bar_stool(draw)], x, front + draw.number(0.22, 0.34))
    return Group([*held, *group], 0.2)


def wall_seats(draw: Draw) -> Group:
    """Return an upholstered bench along a wall, with a table in front."""
    wide = draw.number(1.3, 2.2)
    bench = furniture.sofa_bench(draw, wide)
    table = furniture.table(draw, draw.number(0.6, 0.75), 0.6, 0.73, 0.045)
    laid = furnish(draw, table, [*[cup] * draw.whole(1, 2), plate])
    z = float(bench.bounds[1, 2] - table.bounds[0, 2]) + 0.12
    x = draw.number(-0.25, 0.25) * wide
    made = chair(draw).turned(180.0 + draw.number(-20.0, 20.0))
    gap = z + float(table.bounds[1, 2]) + draw.number(0.24, 0.36)
    return Group([bench, *shifted(laid, x, z), *shifted([made], x, gap)], 0.2)


def crates(draw: Draw) -> Group:
    """Return one to three crates beside each other."""
    made = (
        (small_objects.crate(draw, draw.number(0.35, 0.5)), draw.number(0.02, 0.1))
        for _ in range(draw.whole(1, 3))
    )
    return Group(side_by_side(made))


def coats(draw: Draw) -> Group:
    """Return a coat rack on the wall with a bench and shoes below."""
    wide = draw.number(0.9, 1.6)
    bench = furniture.bench(draw, wide)
    rack = coat_rack(draw, wide).moved((0.0, 0.55, 0.0))
    shoes = [small_objects.shoes(draw) for _ in range(draw.whole(1, 3))]
    group = [bench]
    for index, pair in enumerate(shoes):
        x = ((index + 0.5) / len(shoes) - 0.5) * 0.75 * wide
        group += shifted([pair], x, draw.number(-0.02, 0.02))
    return Group([*group, *shifted([rack], 0.0, float(bench.bounds[0, 2]) - 0.03)], _PASSAGE)


floor_lamp = alone(lamps.floor_lamp)
plant = alone(lambda draw: plants.plant(draw, draw.number(0.55, 1.25)))
stool = alone(furniture.stool)
basket = alone(small_objects.basket)
timber = alone(small_objects.timber)
umbrellas = alone(small_objects.umbrella_stand)


MakeHung = Callable[[Draw], Objects]
"""Makes what hangs on a wall, its back at z = 0."""


def framed(draw: Draw, wide: float | None = None) -> Objects:
    """Return a picture, perhaps in a mount, for a stretch of wall of some width or any."""
    wide = wide or draw.number(0.6, 1.7)
    width = min(draw.number(0.55, 0.85) * wide, 1.5)
    height = min(max(width * draw.number(0.6, 1.3), 0.35), 1.0)
    mount = draw.number(0.05, 0.14) * min(width, height) if draw.chance(0.5) else 0.0
    return [wall_objects.picture(draw, width, height, mount)]


def row_of_pictures(draw: Draw, wide: float) -> Objects:
    """Return two to four pictures of one size beside each other."""
    count, gap = min(draw.whole(2, 4), max(2, int(wide / 0.4))), draw.number(0.05, 0.12)
    width = min(0.85 * wide / count - gap, 0.6)
    size = width, min(width * draw.number(1.0, 1.5), 0.9), 0.1 * width
    return side_by_side((wall_objects.picture(draw, *size), gap) for _ in range(count))


def posters(draw: Draw, wide: float) -> Objects:
    """Return one to three posters."""
    count, gap = max(1, min(draw.whole(1, 3), int(wide / 0.55))), draw.number(0.04, 0.2)
    width = min(0.9 * wide / count - gap, draw.number(0.5, 0.75))
    made = (wall_objects.poster(draw, width, width * draw.number(1.2, 1.45)) for _ in range(count))
    return side_by_side((each, gap) for each in made)


def wall_board(draw: Draw, wide: float | None = None) -> Objects:
    """Return a wall shelf with vessels or books, for a stretch of wall of some width or any."""
    wide = min(draw.number(0.6, 0.9) * wide, 2.2) if wide else draw.number(0.8, 2.2)
    board = furniture.wall_board(draw, wide, draw.number(0.2, 0.28))
    level = board.supports[0]
    if draw.chance(0.3):
        return [board, *row_of_books(draw, level, draw.number(0.4, 0.9))]
    return [board, *in_row(draw, level, draw_vessels(draw, 14, small=True), (0.03, 0.16))]


def tools(draw: Draw, wide: float = 2.0) -> Objects:
    """Return a board with tools, for a stretch of wall of some width or any."""
    return [wall_objects.tool_board(draw, min(0.9 * wide, draw.number(0.9, 1.8)))]


def hung(make: Maker) -> MakeHung:
    """Return a maker of a single object that hangs on a wall."""
    return lambda draw: [make(draw)]


mirror = hung(lambda draw: wall_objects.wall_mirror(draw, draw.number(0.22, 0.4)))
clock, towels = hung(wall_objects.clock), hung(wall_objects.towel_rail)
blackboard = hung(wall_objects.blackboard)
