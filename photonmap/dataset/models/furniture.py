"""Furniture: tables, cupboards, shelves, seats, beds, baths; in metres, fronts towards +z."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import SceneObject, Support, Table, mirrored, model
from photonmap.dataset.models.shapes import Shape, box, cylinder, superquadric, torus, tube
from photonmap.scene.material import Material

_BOARD = 0.022  # thickness of the boards of a shelf, metres


@model("table")
def table(draw: Draw, width: float, depth: float, height: float = 0.74, leg: float = 0.06) -> Table:
    """Return a table on four legs with an apron."""
    wood, top = draw.wood(), 0.035
    under = height - top
    x, z = 0.5 * (width - leg) - 0.03, 0.5 * (depth - leg) - 0.03
    yield box(leg, under, leg), mirrored("xz", x, 0.0, z), wood
    yield box(2 * x - leg, 0.08, 0.02), mirrored("z", 0.0, under - 0.08, z), wood
    yield box(0.02, 0.08, 2 * z - leg), mirrored("x", x, under - 0.08, 0.0), wood
    yield box(width, top, depth, 0.008), under, draw.glazed(draw.wood())
    yield top_support(width, depth, height)


@model("table")
def round_table(draw: Draw, radius: float, height: float) -> Table:
    """Return a round table on a pedestal."""
    wood = draw.wood()
    yield cylinder(0.55 * radius, 0.03, 0.01), 0.0, wood
    yield cylinder(0.045, height - 0.06), 0.03, wood
    yield cylinder(radius, 0.03, 0.01), height - 0.03, draw.glazed(wood)
    yield top_support(1.35 * radius, 1.35 * radius, height)


@model("table")
def pupils_table(draw: Draw) -> Table:
    """Return a table for two with steel legs."""
    top, metal, tall = draw.glazed(draw.wood()), draw.grey(4), 0.72
    yield cylinder(0.018, tall - 0.03, 0.003, 16), mirrored("xz", 0.54, 0.0, 0.2), metal
    yield box(0.02, 0.03, 0.4), mirrored("x", 0.54, tall - 0.06, 0.0), metal
    yield box(1.2, 0.03, 0.5, 0.01), tall - 0.03, top
    yield Support((-0.55, 0.55), (-0.21, 0.21), tall)


@model("garden table")
def garden_table(draw: Draw) -> Table:
    """Return a table of slats."""
    wide, deep, tall, wood, count = 1.3, 0.8, 0.73, draw.wood(), 7
    slat, z = box(wide, 0.03, deep / count - 0.012, 0.004), (np.arange(count) + 0.5) / count - 0.5
    legs = mirrored("xz", 0.5 * wide - 0.1, 0.0, 0.5 * deep - 0.1)
    yield box(0.06, tall - 0.03, 0.06), legs, wood
    yield slat, [(0.0, tall - 0.03, each) for each in z * deep], wood
    yield top_support(wide, deep, tall)


@model("bench")
def trestle(draw: Draw, width: float, depth: float, height: float = 0.8) -> Table:
    """Return a workbench on two side panels, with a shelf below the top."""
    wood, inner = draw.wood(), width - 0.29
    sides = mirrored("x", 0.5 * width - 0.12, 0.0, 0.0)
    yield box(0.05, height - 0.05, depth - 0.1), sides, wood
    yield box(inner, 0.03, depth - 0.16), 0.15, wood
    yield box(width, 0.05, depth, 0.008), height - 0.05, draw.wood()
    half = 0.5 * inner - 0.03
    low = Support((-half, half), (-0.5 * depth + 0.1, 0.5 * depth - 0.1), 0.18, height - 0.25)
    yield top_support(width, depth, height)
    yield low


@model("desk")
def desk(draw: Draw, width: float = 1.4, depth: float = 0.7) -> Table:
    """Return a desk with a side panel on the left and drawers on the right."""
    wood, front = draw.wood(), draw.glazed(draw.accent())
    height, block, face = 0.74, 0.4, 0.5 * depth - 0.07
    x = 0.5 * width - 0.5 * block - 0.03
    drawer, knob = box(block - 0.03, 0.19, 0.018), superquadric((0.03,) * 3, 1.0, 1.0, 16, 20)
    yield box(0.04, height - 0.03, depth - 0.06), (-0.5 * width + 0.05, 0.0, 0.0), wood
    yield box(block, height - 0.03, depth - 0.1), (x, 0.0, -0.02), wood
    for y in (0.06 + 0.21 * index for index in range(3)):
        yield drawer, (x, y, face + 0.009), front
        yield knob, (x, y + 0.08, face + 0.033), draw.metal()
    yield box(width, 0.03, depth, 0.006), height - 0.03, draw.glazed(wood)
    yield top_support(width, depth, height)


@model("counter")
def counter(draw: Draw, width: float) -> Table:
    """Return a counter: boards in front, a top that juts out, a lower one behind."""
    tall, deep, count = 1.05, 0.55, max(3, round(width / 0.16))
    wood, top = draw.wood(), draw.glazed(draw.wood())
    front = draw.chip(None, (4, 7), (2, 8)), draw.pale()
    wide = width / count
    board = box(wide - 0.008, tall - 0.2, 0.018)
    yield box(width, tall - 0.05, 0.3), (0.0, 0.0, 0.05), wood
    for index in range(count):
        yield board, ((index + 0.5) * wide - 0.5 * width, 0.1, 0.209), front[index % 2]
    yield box(width + 0.06, 0.05, deep, 0.012), tall - 0.05, top
    x, z = 0.5 * width - 0.02, 0.5 * deep - 0.03
    yield Support((-x, x), (-z, z), tall)


@model("shelf")
def shelf(draw: Draw, width: float, height: float, boards: int, depth: float = 0.3) -> Table:
    """Return an open shelf with a back panel."""
    paint, back, inner = draw.glazed(draw.wood()), draw.pale(), width - 2 * _BOARD
    step = (height - _BOARD - 0.05) / (boards - 1)
    levels = [0.05 + step * index for index in range(boards)]
    sides, z = mirrored("x", 0.5 * (width - _BOARD), 0.0, 0.0), -0.5 * depth + 0.006
    yield box(_BOARD, height, depth), sides, paint
    yield box(inner, height - 0.02, 0.012, 0.002), (0.0, 0.01, z), back
    yield box(inner, _BOARD, depth - 0.012), [(0.0, y, 0.006) for y in levels], paint
    half, room = 0.5 * inner - 0.008, [step - _BOARD - 0.02] * (boards - 1) + [0.6]
    inside = (-0.5 * depth + 0.02, 0.5 * depth - 0.012)
    for y, free in zip(levels, room, strict=True):
        yield Support((-half, half), inside, y + _BOARD, free)


@model("wall shelf")
def wall_board(draw: Draw, width: float, depth: float = 0.22) -> Table:
    """Return a wall shelf on two brackets, its back at z = 0."""
    wood, half = draw.wood(), 0.5 * width - 0.02
    brackets = mirrored("x", 0.36 * width, 0.0, 0.35 * depth)
    yield box(width, 0.028, depth), (0.0, 0.12, 0.5 * depth), draw.glazed(wood)
    yield box(0.025, 0.12, 0.7 * depth, 0.004), brackets, wood
    yield Support((-half, half), (0.02, depth - 0.01), 0.148, 0.5)


@model("cabinet")
def cabinet(
    draw: Draw,
    width: float,
    height: float,
    doors: int,
    depth: float = 0.45,
    colors: tuple[Material, Material] | None = None,
) -> Table:
    """Return a cupboard with doors on a plinth, of given colours of body and doors or any."""
    body, front = map(draw.glazed, colors or (draw.wood(), draw.fabric()))
    base, top, face, wide = 0.07, 0.03, 0.5 * depth - 0.02, width / doors
    leaf = box(wide - 0.012, height - base - top - 0.02, 0.018)
    handle = box(0.014, 0.14, 0.02, 0.006)
    yield box(width - 0.06, base, depth - 0.06), (0.0, 0.0, -0.01), draw.grey(3)
    yield box(width, height - base - top, depth - 0.04), (0.0, base, -0.02), body
    yield box(width + 0.02, top, depth, 0.006), height - top, body
    for index in range(doors):
        x, side = -0.5 * width + (index + 0.5) * wide, (0.5 * wide - 0.05) * (-1) ** index
        yield leaf, (x, base + 0.01, face - 0.011), front
        yield handle, (x + side, 0.6 * height, face + 0.008), draw.metal()
    yield top_support(width, depth, height)


@model("bed")
def bed(draw: Draw, width: float = 1.5) -> Table:
    """Return a bed with a mattress, a blanket and pillows, its head towards -z."""
    wood, long = draw.wood(), 2.0
    blanket = draw.patterned("print", draw.chip(draw.key, (4, 6), (4, 10)))
    yield box(width + 0.06, 0.26, long, 0.01), 0.06, wood
    yield box(width + 0.1, 1.0, 0.05, 0.015), (0.0, 0.0, -0.5 * long - 0.025), wood
    yield box(width, 0.2, long - 0.02, 0.06, 4), 0.32, draw.grey(8)
    yield box(width + 0.03, 0.17, 1.35, 0.06, 4), (0.0, 0.385, 0.3), blanket
    yield box(width + 0.04, 0.175, 0.3, 0.06, 4), (0.0, 0.384, -0.38), draw.pale()
    yield box(0.06, 0.06, 0.06), mirrored("xz", 0.5 * width - 0.05, 0.0, 0.9), wood
    pillow = superquadric((0.62, 0.15, 0.4), 1.0, 0.45, 40, 64)
    for x in (-0.36, 0.36):
        yield pillow.turned(draw.number(-6.0, 6.0)), (x, 0.52, -0.74), draw.pale()


@model("plinth")
def plinth(draw: Draw, side: float, height: float) -> Table:
    """Return a plinth for a sculpture."""
    yield box(side, height, side, 0.004), 0.0, draw.grey(8)
    yield top_support(side, side, height)


@model("rug")
def rug(draw: Draw, width: float, depth: float, stripes: int = 7) -> Table:
    """Return a rug, 8 mm thick, whose stripes are of one colour and, in turn, two others."""
    thick, (first, *others) = 0.008, (draw.fabric(), draw.accent(), draw.pale())
    wide = width / stripes
    stripe = box(wide, thick, depth, 0.003, 1)
    for i in range(stripes):
        x, color = (i + 0.5) * wide - 0.5 * width, others[i // 2 % 2] if i % 2 else first
        yield stripe, (x, 0.0, 0.0), color
    yield top_support(width, depth, thick)


def top_support(width: float, depth: float, height: float) -> Support:
    """Return the support of a top, without a margin along its edge."""
    x, z = 0.5 * width - 0.03, 0.5 * depth - 0.03
    return Support((-x, x), (-z, z), height)


@model("chair")
def chair(draw: Draw) -> Table:
    """Return a chair with a slatted back."""
    wood, seat = draw.wood(), draw.fabric()
    x, z, leg = 0.19, 0.18, 0.036
    slats = [(0.0, y, -z) for y in (0.56, 0.68, 0.79)]
    yield box(leg, 0.43, leg), mirrored("x", x, 0.0, z), wood
    yield box(leg, 0.88, leg), mirrored("x", x, 0.0, -z), wood
    yield box(0.43, 0.03, 0.41, 0.012), (0.0, 0.43, 0.005), wood
    yield box(0.4, 0.03, 0.36, 0.014), (0.0, 0.46, 0.02), seat
    yield box(2 * x - leg, 0.06, 0.018, 0.006), slats, wood
    yield box(2 * x - leg, 0.03, 0.02), mirrored("z", 0.0, 0.2, z), wood


@model("stool")
def stool(draw: Draw) -> Table:
    """Return a round stool on three legs."""
    wood, leg = draw.wood(), tube([(0.17, 0.0, 0.0), (0.1, 0.44, 0.0)], 0.017, 16).resting()
    for i in range(3):
        yield leg.turned(120.0 * i + 30.0), 0.0, wood
    yield cylinder(0.17, 0.035, 0.012), 0.45, draw.accent()


@model("bar stool")
def bar_stool(draw: Draw) -> Table:
    """Return a tall stool on one leg."""
    yield cylinder(0.2, 0.02, 0.008, 40), 0.0, draw.metal()
    yield cylinder(0.025, 0.68, 0.004, 20), 0.02, draw.metal()
    yield torus(0.15, 0.01, 36), 0.26, draw.metal()
    yield box(0.3, 0.012, 0.014, 0.004), 0.264, draw.metal()
    yield cylinder(0.19, 0.07, 0.03, 40), 0.7, draw.accent()


@model("sofa")
def sofa(draw: Draw, seats: int) -> Table:
    """Return a sofa with cushions."""
    cloth = draw.patterned("cloth", draw.chip(None, (4, 6), (4, 8)))
    wide, arm, deep = 0.62 * seats, 0.16, 0.82
    whole = wide + 2 * arm
    yield box(whole - 0.02, 0.26, deep - 0.02, 0.03, 3), 0.06, cloth
    yield box(whole, 0.72, 0.2, 0.07, 4), (0.0, 0.08, -0.5 * deep + 0.1), cloth
    arms = mirrored("x", 0.5 * (wide + arm), 0.08, 0.1)
    yield box(arm, 0.5, deep - 0.2, 0.06, 4), arms, cloth
    feet = mirrored("xz", 0.5 * whole - 0.08, 0.0, 0.5 * deep - 0.08)
    yield cylinder(0.025, 0.08, segments=24), feet, draw.grey(3)
    places = [((index - 0.5 * (seats - 1)) * 0.62, 0.31, 0.09) for index in range(seats)]
    yield box(0.61, 0.15, 0.62, 0.05, 4), places, cloth
    cushion = superquadric((0.4, 0.14, 0.4), 1.0, 0.35, 40, 64).turned(68.0, 0)
    for x in (-0.5 * wide + 0.22, 0.5 * wide - 0.22)[: min(seats, 2)]:
        leaning = cushion.turned(draw.number(-12.0, 12.0)).resting()
        yield leaning, (x, 0.45, -0.06), draw.accent()


def armchair(draw: Draw) -> SceneObject:
    """Return a sofa of one seat."""
    return replace(sofa(draw, 1), name="armchair")


@model("bench")
def bench(draw: Draw, width: float) -> Table:
    """Return a bench of slats."""
    wood, metal, x = draw.glazed(draw.wood()), draw.grey(3), 0.5 * width - 0.12
    slats = [(0.0, 0.42, 0.12 * k) for k in (-1, 0, 1)]
    yield box(width, 0.03, 0.1, 0.006), slats, wood
    for at in (-x, x):
        yield box(0.05, 0.03, 0.36), (at, 0.39, 0.0), metal
        yield box(0.05, 0.39, 0.05), mirrored("z", at, 0.0, 0.14), metal
    half = 0.5 * width - 0.03
    yield Support((-half, half), (-0.15, 0.15), 0.45)


@model("sofa bench")
def sofa_bench(draw: Draw, width: float) -> Table:
    """Return an upholstered bench with a back."""
    cloth = draw.patterned("cloth", draw.chip(None, (4, 6), (4, 8)))
    yield box(width - 0.06, 0.32, 0.42), (0.0, 0.0, 0.02), draw.wood()
    yield box(width, 0.14, 0.5, 0.05, 4), (0.0, 0.32, 0.02), cloth
    yield box(width, 0.55, 0.12, 0.05, 4), (0.0, 0.46, -0.17), cloth


@model("bathtub")
def bathtub(draw: Draw) -> Table:
    """Return a bathtub with a panel of another colour in front and a tap at its right end."""
    long, deep, tall, wall = draw.number(1.55, 1.8), 0.75, 0.56, 0.07
    glaze, panel = draw.glazed(draw.grey(9)), draw.glazed(draw.pale())
    x, end = 0.5 * (long - wall), deep - 2 * wall + 0.02
    spout = tube([(0.0, 0.0, 0.0), (0.0, 0.16, 0.0), (-0.1, 0.18, 0.0)], 0.014, 16).resting()
    yield box(long, tall, wall, 0.03, 4), mirrored("z", 0.0, 0.0, 0.5 * (deep - wall)), glaze
    yield box(wall, tall, end, 0.03, 4), mirrored("x", x, 0.0, 0.0), glaze
    yield box(long - 0.1, 0.12, deep - 0.1), 0.0, glaze
    yield box(long - 0.08, tall - 0.14, 0.012), (0.0, 0.03, 0.5 * deep), panel
    yield spout, (x, tall, 0.0), draw.metal()


@model("toilet")
def toilet(draw: Draw) -> Table:
    """Return a toilet with its cistern."""
    glaze, lid = draw.glazed(draw.grey(9)), draw.glazed(draw.pale())
    yield superquadric((0.24, 0.44, 0.42), 0.6, 0.6, 32, 48), (0.0, 0.0, -0.02), glaze
    yield superquadric((0.37, 0.2, 0.5), 0.7, 0.7, 32, 48), (0.0, 0.22, 0.03), glaze
    yield superquadric((0.36, 0.05, 0.48), 0.5, 0.7, 24, 48), (0.0, 0.4, 0.03), lid
    yield box(0.38, 0.36, 0.17, 0.025, 3), (0.0, 0.42, -0.27), glaze
    yield box(0.12, 0.02, 0.06, 0.006), (0.0, 0.78, -0.27), draw.metal()


@model("parasol")
def parasol(draw: Draw) -> Table:
    """Return a parasol in eight gores of two colours."""
    radius, tall, sides = draw.number(1.1, 1.4), draw.number(2.3, 2.6), 8
    colors, edge = (draw.accent(), draw.pale()), tall - 0.42
    yield cylinder(0.24, 0.09, 0.02, 40), 0.0, draw.grey(4)
    yield cylinder(0.022, tall - 0.09, 0.003, 20), 0.09, draw.wood()
    for index in range(sides):
        first, last = (2.0 * np.pi * (index + k) / sides for k in (0, 1))
        rim = [(radius * np.cos(t), edge, radius * np.sin(t)) for t in (first, last)]
        vertices = np.array([(0.0, tall - 0.06, 0.0), *rim])
        normal = np.cross(vertices[2] - vertices[0], vertices[1] - vertices[0])
        normals = np.tile(normal / np.linalg.norm(normal), (3, 1))
        gore = Shape(vertices, np.array([[0, 2, 1]]), normals)
        yield gore, 0.0, colors[index % 2]
