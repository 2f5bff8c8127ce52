"""Furniture: tables, cupboards, shelves, beds, seats, plinths; in metres, fronts towards +z."""

from __future__ import annotations

from collections.abc import Sequence

from photonmap.dataset.models.curved_shapes import superquadric, tube
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import (
    Part,
    Row,
    SceneObject,
    Support,
    assembled,
    part_at,
)
from photonmap.dataset.models.shapes import Random, Shape, box, cylinder, rotation
from photonmap.scene.material import Material

_BOARD = 0.022
"""Thickness of the boards of a shelf, metres."""


def table(
    palette: Palette, width: float, depth: float, height: float = 0.74, leg: float = 0.06
) -> SceneObject:
    """Return a table on four legs with an apron."""
    wood = palette.wood()
    top = 0.035
    under = height - top
    x, z = 0.5 * (width - leg) - 0.03, 0.5 * (depth - leg) - 0.03
    rows: list[Row] = [
        (box(leg, under, leg), (x, 0.0, z), wood, "xz"),
        (box(2 * x - leg, 0.08, 0.02), (0.0, under - 0.08, z), wood, "z"),
        (box(0.02, 0.08, 2 * z - leg), (x, under - 0.08, 0.0), wood, "x"),
        (box(width, top, depth, 0.008), (0.0, under, 0.0), palette.glazed(palette.wood())),
    ]
    return assembled("table", rows, [top_support(width, depth, height)])


def round_table(palette: Palette, radius: float, height: float) -> SceneObject:
    """Return a round table on a pedestal."""
    wood = palette.wood()
    parts = [
        Part(cylinder(0.55 * radius, 0.03, 0.01), wood),
        part_at(cylinder(0.045, height - 0.06), 0.0, 0.03, 0.0, wood),
        part_at(cylinder(radius, 0.03, 0.01), 0.0, height - 0.03, 0.0, palette.glazed(wood)),
    ]
    return SceneObject("table", parts, [top_support(1.35 * radius, 1.35 * radius, height)])


def trestle(palette: Palette, width: float, depth: float, height: float = 0.8) -> SceneObject:
    """Return a workbench on two side panels, with a shelf below the top."""
    wood, inner = palette.wood(), width - 0.29
    rows: list[Row] = [
        (box(0.05, height - 0.05, depth - 0.1), (0.5 * width - 0.12, 0.0, 0.0), wood, "x"),
        (box(inner, 0.03, depth - 0.16), (0.0, 0.15, 0.0), wood),
        (box(width, 0.05, depth, 0.008), (0.0, height - 0.05, 0.0), palette.wood()),
    ]
    half = 0.5 * inner - 0.03
    low = Support((-half, half), (-0.5 * depth + 0.1, 0.5 * depth - 0.1), 0.18, height - 0.25)
    return assembled("bench", rows, [top_support(width, depth, height), low])


def desk(palette: Palette, width: float = 1.4, depth: float = 0.7) -> SceneObject:
    """Return a desk with a side panel on the left and drawers on the right."""
    wood, front = palette.wood(), palette.glazed(palette.accent())
    height, block, face = 0.74, 0.4, 0.5 * depth - 0.07
    x = 0.5 * width - 0.5 * block - 0.03
    drawer, knob = box(block - 0.03, 0.19, 0.018), superquadric((0.03,) * 3, 1.0, 1.0, 16, 20)
    rows: list[Row] = [
        (box(0.04, height - 0.03, depth - 0.06), (-0.5 * width + 0.05, 0.0, 0.0), wood),
        (box(block, height - 0.03, depth - 0.1), (x, 0.0, -0.02), wood),
    ]
    for y in (0.06 + 0.21 * index for index in range(3)):
        rows.append((drawer, (x, y, face + 0.009), front))
        rows.append((knob, (x, y + 0.08, face + 0.033), palette.metal()))
    rows.append((box(width, 0.03, depth, 0.006), (0.0, height - 0.03, 0.0), palette.glazed(wood)))
    return assembled("desk", rows, [top_support(width, depth, height)])


def shelf(
    palette: Palette, width: float, height: float, boards: int, depth: float = 0.3
) -> SceneObject:
    """Return an open shelf with a back panel."""
    paint = palette.glazed(palette.wood())
    back = palette.pale()
    side = box(_BOARD, height, depth)
    parts = [part_at(side, i * 0.5 * (width - _BOARD), 0.0, 0.0, paint) for i in (-1, 1)]
    inner = width - 2 * _BOARD
    z = -0.5 * depth + 0.006
    parts.append(part_at(box(inner, height - 0.02, 0.012, 0.002), 0.0, 0.01, z, back))
    step = (height - _BOARD - 0.05) / (boards - 1)
    board = box(inner, _BOARD, depth - 0.012)
    levels = [0.05 + step * index for index in range(boards)]
    parts += [part_at(board, 0.0, y, 0.006, paint) for y in levels]
    half = 0.5 * inner - 0.008
    inside = (-0.5 * depth + 0.02, 0.5 * depth - 0.012)
    supports = [
        Support((-half, half), inside, y + _BOARD, step - _BOARD - 0.02) for y in levels[:-1]
    ]
    supports.append(Support((-half, half), inside, levels[-1] + _BOARD, 0.6))
    return SceneObject("shelf", parts, supports)


def wall_board(palette: Palette, width: float, depth: float = 0.22) -> SceneObject:
    """Return a wall shelf on two brackets, its back at z = 0."""
    wood = palette.wood()
    rows: list[Row] = [
        (box(width, 0.028, depth), (0.0, 0.12, 0.5 * depth), palette.glazed(wood)),
        (box(0.025, 0.12, 0.7 * depth, 0.004), (0.36 * width, 0.0, 0.35 * depth), wood, "x"),
    ]
    half = 0.5 * width - 0.02
    return assembled("wall shelf", rows, [Support((-half, half), (0.02, depth - 0.01), 0.148, 0.5)])


def cabinet(
    palette: Palette,
    width: float,
    height: float,
    doors: int,
    depth: float = 0.45,
    colors: tuple[Material, Material] | None = None,
) -> SceneObject:
    """Return a cupboard with doors on a plinth.

    Parameters
    ----------
    colors : of its body and of its doors; None draws them
    """
    body, front = map(palette.glazed, colors or (palette.wood(), palette.fabric()))
    base, top, face, wide = 0.07, 0.03, 0.5 * depth - 0.02, width / doors
    leaf, handle = (
        box(wide - 0.012, height - base - top - 0.02, 0.018),
        box(0.014, 0.14, 0.02, 0.006),
    )
    rows: list[Row] = [
        (box(width - 0.06, base, depth - 0.06), (0.0, 0.0, -0.01), palette.grey(3)),
        (box(width, height - base - top, depth - 0.04), (0.0, base, -0.02), body),
        (box(width + 0.02, top, depth, 0.006), (0.0, height - top, 0.0), body),
    ]
    side = 0.5 * wide - 0.05
    for index in range(doors):
        x = -0.5 * width + (index + 0.5) * wide
        rows.append((leaf, (x, base + 0.01, face - 0.011), front))
        x += side if index % 2 == 0 else -side
        rows.append((handle, (x, 0.6 * height, face + 0.008), palette.metal()))
    return assembled("cabinet", rows, [top_support(width, depth, height)])


def bed(rng: Random, palette: Palette, width: float = 1.5) -> SceneObject:
    """Return a bed with a mattress, a blanket and pillows, its head towards -z."""
    wood = palette.wood()
    blanket = palette.patterned("print", palette.chip(palette.key, (4, 6), (4, 10)))
    long = 2.0
    rows: list[Row] = [
        (box(width + 0.06, 0.26, long, 0.01), (0.0, 0.06, 0.0), wood),
        (box(width + 0.1, 1.0, 0.05, 0.015), (0.0, 0.0, -0.5 * long - 0.025), wood),
        (box(width, 0.2, long - 0.02, 0.06, 4), (0.0, 0.32, 0.0), palette.grey(8)),
        (box(width + 0.03, 0.17, 1.35, 0.06, 4), (0.0, 0.385, 0.3), blanket),
        (box(width + 0.04, 0.175, 0.3, 0.06, 4), (0.0, 0.384, -0.38), palette.pale()),
        (box(0.06, 0.06, 0.06), (0.5 * width - 0.05, 0.0, 0.9), wood, "xz"),
    ]
    pillow = superquadric((0.62, 0.15, 0.4), 1.0, 0.45, 40, 64)
    for x in (-0.36, 0.36):
        lying = pillow.turned(float(rng.uniform(-6.0, 6.0)))
        rows.append((lying, (x, 0.52, -0.74), palette.pale()))
    return assembled("bed", rows)


def plinth(palette: Palette, side: float, height: float) -> SceneObject:
    """Return a plinth for a sculpture."""
    parts = [Part(box(side, height, side, 0.004), palette.grey(8))]
    return SceneObject("plinth", parts, [top_support(side, side, height)])


def rug(palette: Palette, width: float, depth: float, stripes: int = 7) -> SceneObject:
    """Return a striped rug, 8 mm thick."""
    thick, colors = 0.008, [palette.fabric(), palette.accent(), palette.pale()]
    wide = width / stripes
    parts = [
        part_at(
            box(wide, thick, depth, 0.003, 1),
            (i + 0.5) * wide - 0.5 * width,
            0.0,
            0.0,
            _stripe_color(colors, i),
        )
        for i in range(stripes)
    ]
    return SceneObject("rug", parts, [top_support(width, depth, thick)])


def _stripe_color(colors: Sequence[Material], index: int) -> Material:
    """Return the colour of a stripe: the first colour every other time, the others in turn."""
    return colors[0] if index % 2 == 0 else colors[1 + index // 2 % 2]


def top_support(width: float, depth: float, height: float) -> Support:
    """Return the support of a top, without a margin along its edge."""
    x, z = 0.5 * width - 0.03, 0.5 * depth - 0.03
    return Support((-x, x), (-z, z), height)


def chair(palette: Palette) -> SceneObject:
    """Return a chair with a slatted back."""
    wood, seat = palette.wood(), palette.fabric()
    x, z, leg = 0.19, 0.18, 0.036
    slat = box(2 * x - leg, 0.06, 0.018, 0.006)
    rows: list[Row] = [
        (box(leg, 0.43, leg), (x, 0.0, z), wood, "x"),
        (box(leg, 0.88, leg), (x, 0.0, -z), wood, "x"),
        (box(0.43, 0.03, 0.41, 0.012), (0.0, 0.43, 0.005), wood),
        (box(0.4, 0.03, 0.36, 0.014), (0.0, 0.46, 0.02), seat),
        (slat, (0.0, 0.56, -z), wood),
        (slat, (0.0, 0.68, -z), wood),
        (slat, (0.0, 0.79, -z), wood),
        (box(2 * x - leg, 0.03, 0.02), (0.0, 0.2, z), wood, "z"),
    ]
    return assembled("chair", rows)


def stool(palette: Palette) -> SceneObject:
    """Return a round stool on three legs."""
    wood = palette.wood()
    leg = tube([(0.17, 0.0, 0.0), (0.1, 0.44, 0.0)], 0.017, 16).resting()
    parts = [Part(leg.turned(120.0 * i + 30.0), wood) for i in range(3)]
    parts.append(part_at(cylinder(0.17, 0.035, 0.012), 0.0, 0.45, 0.0, palette.accent()))
    return SceneObject("stool", parts)


def sofa(rng: Random, palette: Palette, seats: int) -> SceneObject:
    """Return a sofa with cushions, or an armchair if it has one seat."""
    cloth = palette.patterned("cloth", palette.chip(None, (4, 6), (4, 8)))
    wide, arm, deep = 0.62 * seats, 0.16, 0.82
    whole = wide + 2 * arm
    foot = (0.5 * whole - 0.08, 0.0, 0.5 * deep - 0.08)
    rows: list[Row] = [
        (box(whole - 0.02, 0.26, deep - 0.02, 0.03, 3), (0.0, 0.06, 0.0), cloth),
        (box(whole, 0.72, 0.2, 0.07, 4), (0.0, 0.08, -0.5 * deep + 0.1), cloth),
        (box(arm, 0.5, deep - 0.2, 0.06, 4), (0.5 * (wide + arm), 0.08, 0.1), cloth, "x"),
        (cylinder(0.025, 0.08, segments=24), foot, palette.grey(3), "xz"),
    ]
    for index in range(seats):
        x = (index - 0.5 * (seats - 1)) * 0.62
        rows.append((box(0.61, 0.15, 0.62, 0.05, 4), (x, 0.31, 0.09), cloth))
    rows += [
        (_leaning_cushion(rng), (x, 0.45, -0.06), palette.accent())
        for x in (-0.5 * wide + 0.22, 0.5 * wide - 0.22)[: seats if seats < 3 else 2]
    ]
    return assembled("sofa" if seats > 1 else "armchair", rows)


def _leaning_cushion(rng: Random) -> Shape:
    """Return a cushion that leans against the back of a sofa."""
    shape = superquadric((0.4, 0.14, 0.4), 1.0, 0.35, 40, 64)
    matrix = rotation(68.0, 0)
    shape = Shape(shape.vertices @ matrix.T, shape.faces, shape.normals @ matrix.T)
    return shape.turned(float(rng.uniform(-12.0, 12.0))).resting()
