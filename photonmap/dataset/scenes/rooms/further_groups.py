"""Functional groups of bathrooms, classrooms, cafes, workshops and corridors."""

from __future__ import annotations

from photonmap.dataset.models import furniture, vessels
from photonmap.dataset.models.arrangements import draw_vessels, furnish, stack_books
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.placement import place_at, scatter
from photonmap.dataset.models.places import bathroom, public_rooms, workshop
from photonmap.dataset.models.scene_object import SceneObject, bounds_of
from photonmap.dataset.models.shapes import Random
from photonmap.dataset.scenes.rooms.groups import (
    draw,
    seats_around,
    shifted,
    side_by_side,
    stocked,
)
from photonmap.dataset.scenes.rooms.room_builder import Group

_PASSAGE = 0.6
"""Depth of the floor that is kept free, metres."""


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


def basket(rng: Random, palette: Palette) -> Group:
    """Return a basket for laundry."""
    return Group([bathroom.basket(rng, palette)])


def towels(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a rail with towels."""
    return [bathroom.towel_rail(rng, palette)]


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


def blackboard(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a board to write on."""
    return [public_rooms.blackboard(rng, palette, draw(rng, 1.8, 2.8))]


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


def tool_wall(rng: Random, palette: Palette) -> list[SceneObject]:
    """Return a board with tools."""
    return [workshop.tool_board(rng, palette, draw(rng, 0.9, 1.8))]


def timber(rng: Random, palette: Palette) -> Group:
    """Return a stack of planks."""
    return Group([workshop.timber(rng, palette)])


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


def umbrellas(rng: Random, palette: Palette) -> Group:
    """Return an umbrella stand."""
    return Group([public_rooms.umbrella_stand(rng, palette)])
