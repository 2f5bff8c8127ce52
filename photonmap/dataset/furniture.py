"""Tables, cupboards, shelves, beds and plinths, in metres, with their fronts towards +z."""

from __future__ import annotations

from collections.abc import Sequence

from photonmap.dataset.palette import Palette
from photonmap.dataset.shapes import Shape, box, cylinder
from photonmap.dataset.solids import Random, superquadric
from photonmap.dataset.things import Part, Support, Thing
from photonmap.scene import Material

_BOARD = 0.022


def at(shape: Shape, x: float, y: float, z: float, material: Material) -> Part:
    """Return a part at a place."""
    return Part(shape.moved((x, y, z)), material)


def table(
    palette: Palette, width: float, depth: float, height: float = 0.74, leg: float = 0.06
) -> Thing:
    """Return a table on four legs with an apron."""
    wood = palette.wood()
    top = 0.035
    under = height - top
    x, z = 0.5 * (width - leg) - 0.03, 0.5 * (depth - leg) - 0.03
    legs = [at(box(leg, under, leg), i * x, 0.0, k * z, wood) for i in (-1, 1) for k in (-1, 1)]
    apron = [at(box(2 * x - leg, 0.08, 0.02), 0.0, under - 0.08, k * z, wood) for k in (-1, 1)]
    apron += [at(box(0.02, 0.08, 2 * z - leg), i * x, under - 0.08, 0.0, wood) for i in (-1, 1)]
    board = at(box(width, top, depth, 0.008), 0.0, under, 0.0, palette.glazed(palette.wood()))
    return Thing("table", [*legs, *apron, board], [_top(width, depth, height)])


def round_table(palette: Palette, radius: float, height: float) -> Thing:
    """Return a round table on one foot."""
    wood = palette.wood()
    parts = [
        Part(cylinder(0.55 * radius, 0.03, 0.01), wood),
        at(cylinder(0.045, height - 0.06), 0.0, 0.03, 0.0, wood),
        at(cylinder(radius, 0.03, 0.01), 0.0, height - 0.03, 0.0, palette.glazed(wood)),
    ]
    return Thing("table", parts, [_top(1.35 * radius, 1.35 * radius, height)])


def trestle(palette: Palette, width: float, depth: float, height: float = 0.8) -> Thing:
    """Return a work bench on two panels, with a board below."""
    wood = palette.wood()
    side = box(0.05, height - 0.05, depth - 0.1)
    parts = [at(side, i * (0.5 * width - 0.12), 0.0, 0.0, wood) for i in (-1, 1)]
    inner = width - 0.29
    parts.append(at(box(inner, 0.03, depth - 0.16), 0.0, 0.15, 0.0, wood))
    parts.append(at(box(width, 0.05, depth, 0.008), 0.0, height - 0.05, 0.0, palette.wood()))
    half = 0.5 * inner - 0.03
    low = Support((-half, half), (-0.5 * depth + 0.1, 0.5 * depth - 0.1), 0.18, height - 0.25)
    return Thing("bench", parts, [_top(width, depth, height), low])


def desk(palette: Palette, width: float = 1.4, depth: float = 0.7) -> Thing:
    """Return a desk: a panel on the left, drawers on the right."""
    wood, front = palette.wood(), palette.glazed(palette.accent())
    height, block = 0.74, 0.4
    parts = [at(box(0.04, height - 0.03, depth - 0.06), -0.5 * width + 0.05, 0.0, 0.0, wood)]
    x = 0.5 * width - 0.5 * block - 0.03
    parts.append(at(box(block, height - 0.03, depth - 0.1), x, 0.0, -0.02, wood))
    face = 0.5 * depth - 0.07
    for index in range(3):
        y = 0.06 + 0.21 * index
        parts.append(at(box(block - 0.03, 0.19, 0.018), x, y, face + 0.009, front))
        knob = superquadric((0.03, 0.03, 0.03), 1.0, 1.0, 16, 20)
        parts.append(at(knob, x, y + 0.08, face + 0.033, palette.metal()))
    parts.append(at(box(width, 0.03, depth, 0.006), 0.0, height - 0.03, 0.0, palette.glazed(wood)))
    return Thing("desk", parts, [_top(width, depth, height)])


def shelf(palette: Palette, width: float, height: float, boards: int, depth: float = 0.3) -> Thing:
    """Return an open shelf with a back."""
    paint = palette.glazed(palette.wood())
    back = palette.pale()
    side = box(_BOARD, height, depth)
    parts = [at(side, i * 0.5 * (width - _BOARD), 0.0, 0.0, paint) for i in (-1, 1)]
    inner = width - 2 * _BOARD
    z = -0.5 * depth + 0.006
    parts.append(at(box(inner, height - 0.02, 0.012, 0.002), 0.0, 0.01, z, back))
    step = (height - _BOARD - 0.05) / (boards - 1)
    board = box(inner, _BOARD, depth - 0.012)
    levels = [0.05 + step * index for index in range(boards)]
    parts += [at(board, 0.0, y, 0.006, paint) for y in levels]
    half = 0.5 * inner - 0.008
    inside = (-0.5 * depth + 0.02, 0.5 * depth - 0.012)
    supports = [
        Support((-half, half), inside, y + _BOARD, step - _BOARD - 0.02) for y in levels[:-1]
    ]
    supports.append(Support((-half, half), inside, levels[-1] + _BOARD, 0.6))
    return Thing("shelf", parts, supports)


def wall_board(palette: Palette, width: float, depth: float = 0.22) -> Thing:
    """Return a board for a wall, its back at z = 0, with two brackets below."""
    wood = palette.wood()
    parts = [at(box(width, 0.028, depth), 0.0, 0.12, 0.5 * depth, palette.glazed(wood))]
    bracket = box(0.025, 0.12, 0.7 * depth, 0.004)
    parts += [at(bracket, i * 0.36 * width, 0.0, 0.35 * depth, wood) for i in (-1, 1)]
    half = 0.5 * width - 0.02
    return Thing("wall shelf", parts, [Support((-half, half), (0.02, depth - 0.01), 0.148, 0.5)])


def cabinet(
    palette: Palette,
    width: float,
    height: float,
    doors: int,
    depth: float = 0.45,
    colors: tuple[Material, Material] | None = None,
) -> Thing:
    """Return a cupboard with doors on a plinth; its body and doors have colours of their own."""
    body, front = map(palette.glazed, colors or (palette.wood(), palette.fabric()))
    base, top, face = 0.07, 0.03, 0.5 * depth - 0.02
    parts = [at(box(width - 0.06, base, depth - 0.06), 0.0, 0.0, -0.01, palette.grey(3))]
    parts.append(at(box(width, height - base - top, depth - 0.04), 0.0, base, -0.02, body))
    parts.append(at(box(width + 0.02, top, depth, 0.006), 0.0, height - top, 0.0, body))
    wide = width / doors
    for index in range(doors):
        x = -0.5 * width + (index + 0.5) * wide
        parts.append(
            at(
                box(wide - 0.012, height - base - top - 0.02, 0.018),
                x,
                base + 0.01,
                face - 0.011,
                front,
            )
        )
        side = 0.5 * wide - 0.05
        handle = box(0.014, 0.14, 0.02, 0.006)
        x += side if index % 2 == 0 else -side
        parts.append(at(handle, x, 0.6 * height, face + 0.008, palette.metal()))
    return Thing("cabinet", parts, [_top(width, depth, height)])


def bed(rng: Random, palette: Palette, width: float = 1.5) -> Thing:
    """Return a bed, its head towards -z, with a mattress, a blanket and pillows."""
    wood, blanket = palette.wood(), palette.chip(palette.key, (4, 6), (4, 10))
    long = 2.0
    parts = [
        at(box(width + 0.06, 0.26, long, 0.01), 0.0, 0.06, 0.0, wood),
        at(box(width + 0.1, 1.0, 0.05, 0.015), 0.0, 0.0, -0.5 * long - 0.025, wood),
        at(box(width, 0.2, long - 0.02, 0.06, 4), 0.0, 0.32, 0.0, palette.grey(8)),
        at(box(width + 0.03, 0.17, 1.35, 0.06, 4), 0.0, 0.385, 0.3, blanket),
        at(box(width + 0.04, 0.175, 0.3, 0.06, 4), 0.0, 0.384, -0.38, palette.pale()),
    ]
    feet = [(i * (0.5 * width - 0.05), k * 0.9) for i in (-1, 1) for k in (-1, 1)]
    parts += [at(box(0.06, 0.06, 0.06), x, 0.0, z, wood) for x, z in feet]
    pillow = superquadric((0.62, 0.15, 0.4), 1.0, 0.45, 40, 64)
    for i in (-1, 1):
        lying = pillow.turned(float(rng.uniform(-6.0, 6.0)))
        parts.append(at(lying, 0.36 * i, 0.52, -0.74, palette.pale()))
    return Thing("bed", parts)


def plinth(palette: Palette, side: float, height: float) -> Thing:
    """Return a plinth for sculpture."""
    parts = [Part(box(side, height, side, 0.004), palette.grey(8))]
    return Thing("plinth", parts, [_top(side, side, height)])


def rug(palette: Palette, width: float, depth: float, stripes: int = 7) -> Thing:
    """Return a rug of stripes, 8 mm thick."""
    thick, colors = 0.008, [palette.fabric(), palette.accent(), palette.pale()]
    wide = width / stripes
    parts = [
        at(
            box(wide, thick, depth, 0.003, 1),
            (i + 0.5) * wide - 0.5 * width,
            0.0,
            0.0,
            _turn(colors, i),
        )
        for i in range(stripes)
    ]
    return Thing("rug", parts, [_top(width, depth, thick)])


def _turn(colors: Sequence[Material], index: int) -> Material:
    """Return colours in turn, the first one every other time."""
    return colors[0] if index % 2 == 0 else colors[1 + index // 2 % 2]


def _top(width: float, depth: float, height: float) -> Support:
    """Return the level of a top, without its edge."""
    x, z = 0.5 * width - 0.03, 0.5 * depth - 0.03
    return Support((-x, x), (-z, z), height)
