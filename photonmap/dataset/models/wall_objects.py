"""Windows, doors, and what hangs on walls: curtains, pictures, boards, tools; in metres.

What hangs has its back at z = 0 and its foot at y = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.patterns import Field, mondrian, patches, split, split_at_levels
from photonmap.dataset.models.scene_object import Row, Table, dealt, mirrored, model
from photonmap.dataset.models.shapes import (
    Floats,
    Shape,
    box,
    cone,
    cylinder,
    grid,
    parallelogram,
    torus,
    upright,
)
from photonmap.scene.material import Material

WINDOW = "window"
"""The light group of all windows."""
_CELL = 0.025  # side of the cells of a sheet that is cut along curves, metres

Design = Callable[[Draw, float, float], Iterable[Row]]
"""Makes what fills a width and a height, metres: from x = -width / 2 and y = 0, facing +z at z = 0.

It is cut along its outlines into parts of one chip each.
"""


def artwork(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Return one of the designs."""
    designs: Sequence[Design] = (_rectangles, _landscape, _circles, _stripes, _blots)
    return draw.one_of(designs)(draw, width, height)


def _rectangles(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Yield rectangles of several colours."""
    colors = [*draw.colors(5, (4, 8)), draw.grey(9), draw.grey(3)]
    for x, y, w, h in mondrian(draw.rng, width, height, 0.2 * min(width, height)):
        yield upright(x - 0.5 * width, y, w, h), 0.0, draw.material_among(colors)


def _landscape(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Yield hills behind each other, before a sky with a sun."""
    sky, hue = _sheet(width, height), draw.number(0.0, 100.0)
    for index in range(draw.whole(2, 4)):
        base = height * (0.15 + 0.16 * index)
        hill, sky = split(sky, _below_hills(draw, base, 0.1 * height, width))
        color = draw.chip(hue + 8.0 * index, (4 + index, 5 + index), (4, 8), 6.0)
        yield from dealt([hill], [color])
    radius = draw.number(0.07, 0.14) * min(width, height)
    away = _distance_from(draw.number(-0.35, 0.35) * width, draw.number(0.72, 0.82) * height)
    sun = split(sky, lambda points: away(points) - radius)
    yield from dealt(sun, [draw.chip(18.0, (7, 8), (8, 14), 6.0), draw.pale()])


def _circles(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Return rings around a point."""
    away = _distance_from(draw.number(-0.2, 0.2) * width, draw.number(0.35, 0.65) * height)
    count = draw.whole(3, 6)
    step = 0.5 * max(width, height) / count * draw.number(0.8, 1.2)
    levels = [step * (number + 0.6) for number in range(count)]
    rings = split_at_levels(_sheet(width, height), away, levels)
    return dealt(rings, [*draw.colors(3), draw.pale()])


def _stripes(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Return slanting or upright stripes of uneven widths."""
    turn = float(draw.rng.choice([0.0, 0.5, draw.rng.uniform(0.1, 0.4)])) * np.pi
    along, sheet = np.array([np.cos(turn), np.sin(turn), 0.0]), _sheet(width, height)
    far = np.sort(sheet.vertices @ along)
    widths = draw.rng.dirichlet(np.full(draw.whole(4, 8), 3.0))
    levels = far[0] + np.ptp(far) * np.cumsum(widths)
    bands = split_at_levels(sheet, lambda points: points @ along, levels[:-1].tolist())
    return dealt(bands, [*draw.colors(3), draw.grey(9), draw.pale()])


def _blots(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Return smooth patches of three or four colours."""
    count, scale = draw.whole(3, 4), draw.number(0.25, 0.5) * min(width, height)
    shapes = patches(draw.rng, _sheet(width, height), count, scale)
    return dealt(shapes, draw.colors(count, (4, 8), 4.0))


def _printed(draw: Draw, width: float, height: float) -> Iterable[Row]:
    """Yield a white sheet with a design, and lines of type below it."""
    edge, share = 0.07 * width, draw.number(0.55, 0.75)
    low = (1.0 - share) * height
    yield upright(-0.5 * width, 0.0, width, height), 0.0, draw.grey(9)
    yield artwork(draw, width - 2 * edge, share * height - edge), (0.0, low, 0.001)
    y, line = low - 0.12 * low, 0.09 * low
    while y - line > 0.1 * low:
        long = draw.number(0.4, 1.0) * (width - 2 * edge)
        mark = upright(-0.5 * width + edge, y - line, long, line)
        yield mark, (0.0, 0.0, 0.001), draw.grey(3)
        y -= 1.9 * line


def _sheet(width: float, height: float) -> Shape:
    """Return a rectangle of small cells, so that it can be cut along curves."""
    columns, rows = (max(6, round(side / _CELL)) + 1 for side in (width, height))
    points = np.zeros((rows, columns, 3))
    points[..., 0] = np.linspace(-0.5 * width, 0.5 * width, columns)
    points[..., 1] = np.linspace(0.0, height, rows)[:, None]
    return grid(points, np.broadcast_to((0.0, 0.0, 1.0), points.shape))


def _below_hills(draw: Draw, base: float, tall: float, width: float) -> Field:
    """Return a field that is negative below a wavy line."""
    waves, phase = draw.rng.uniform(0.5, 2.0, 3), draw.rng.uniform(0.0, 2.0 * np.pi, 3)

    def field(points: Floats) -> Floats:
        turns = 2.0 * np.pi * points[:, :1] / width * waves
        return points[:, 1] - base - tall * np.sin(turns + phase).mean(axis=1)

    return field


def _distance_from(x: float, y: float) -> Field:
    return lambda points: np.linalg.norm(points - (x, y, 0.0), axis=1)


@model("window")
def window(draw: Draw, width: float, height: float, depth: float = 0.16) -> Table:
    """Return a window for an opening around x = 0, from y = 0, in a wall at z = 0.

    An emissive pane closes the opening at z = −depth, behind the bars of the frame. While it is
    off, it is a pale blind that is drawn for the night.
    """
    frame, bar, x, z = draw.grey(9), 0.045, 0.5 * width, -depth + 0.5 * 0.045 + 0.005
    right, up, back, ahead = (
        (width, 0.0, 0.0), (0.0, height, 0.0), (0.0, 0.0, -depth), (0.0, 0.0, depth)
    )  # fmt: skip
    reveal = [
        parallelogram((-x, 0.0, 0.0), back, up),
        parallelogram((x, 0.0, -depth), ahead, up),
        parallelogram((-x, 0.0, 0.0), right, back),
        parallelogram((-x, height, -depth), right, ahead),
    ]
    uprights = [(i * (x - 0.5 * bar), 0.0, z) for i in (-1, 0, 1)]
    across = [(0.0, y, z) for y in (0.0, 0.62 * height, height - bar)]
    for side in reveal:
        yield side, 0.0, frame
    yield box(bar, height, bar), uprights, frame
    yield box(width, bar, 0.8 * bar), across, frame
    yield parallelogram((-x, 0.0, -depth), right, up), 0.0, draw.pale(), WINDOW


@model("curtain")
def curtain(draw: Draw, width: float, height: float) -> Table:
    """Return a folded curtain in front of a wall at z = 0, from y = 0 to `height`."""
    folds, phase = max(3, round(width / 0.11)), draw.number(0.0, 6.0)
    across, up = np.linspace(-0.5 * width, 0.5 * width, 120), np.linspace(0.0, height, 10)[:, None]
    wave = 0.035 * np.sin(2.0 * np.pi * folds * (across / width) + phase)
    wave += 0.012 * np.sin(4.3 * np.pi * folds * (across / width) + 2.0 * phase)
    ahead = 0.08 + (1.25 - 0.5 * up / height) * wave
    points = np.stack([*np.broadcast_arrays(across, up), ahead], axis=-1)
    cloth = draw.patterned("cloth", draw.chip(draw.key, (5, 7), (4, 8)))
    yield grid(points), 0.0, cloth


@model("picture")
def picture(draw: Draw, width: float, height: float, mount: float = 0.0) -> Table:
    """Return a framed picture, perhaps in a white mount of some breadth."""
    frame, bar, deep = draw.wood(), 0.03, 0.025
    wide, tall = width - 2 * bar, height - 2 * bar
    across = [(0.0, y, 0.5 * deep) for y in (0.0, height - bar)]
    yield box(width, bar, deep), across, frame
    yield box(bar, tall, deep), mirrored("x", 0.5 * (width - bar), bar, 0.5 * deep), frame
    if mount:
        board = upright(-0.5 * wide, bar, wide, tall)
        yield board, (0.0, 0.0, 0.2 * deep), draw.grey(9)
    yield artwork(draw, wide - 2 * mount, tall - 2 * mount), (0.0, bar + mount, 0.3 * deep)


@model("picture")
def poster(draw: Draw, width: float, height: float) -> Table:
    """Return a poster with a design and lines of type."""
    thick = 0.004
    sheet = box(width, height, thick, 0.001, 1)
    yield sheet, (0.0, 0.0, 0.5 * thick), draw.grey(9)
    yield _printed(draw, width - 0.01, height - 0.01), (0.0, 0.005, thick + 0.001)


@model("mirror")
def wall_mirror(draw: Draw, radius: float) -> Table:
    """Return a round framed mirror; a grey disc if materials are Lambertian."""
    yield from _disc(radius, 0.9, draw.wood(), draw.metal())


@model("clock")
def clock(draw: Draw) -> Table:
    """Return a wall clock."""
    radius = 0.16
    yield from _disc(radius, 0.88, draw.accent(), draw.grey(9))
    for degrees, long in ((35.0, 0.55), (-80.0, 0.8)):
        hand = box(0.012, long * radius, 0.003, 0.001, 1).turned(degrees, 2)
        yield hand, (0.0, radius, 0.0355), draw.grey(2)


def _disc(radius: float, inner: float, rim: Material, face: Material) -> Iterable[Row]:
    """Yield an upright disc with a rim, of an inner radius relative to its own."""
    rests, front = (0.0, radius, 0.0), (0.0, radius, 0.03)
    yield cylinder(radius, 0.03, 0.01).turned(90.0, 0), rests, rim
    yield cylinder(inner * radius, 0.004, 0.001).turned(90.0, 0), front, face


@model("door")
def door(draw: Draw, width: float, height: float = 2.03) -> Table:
    """Return a closed door in its frame."""
    leaf, frame, bar = draw.glazed(draw.pale()), draw.grey(8), 0.07
    panel, handle = 0.72 * width, box(0.12, 0.022, 0.022, 0.008)
    yield box(bar, height, 0.045), mirrored("x", 0.5 * (width + bar), 0.0, 0.0225), frame
    yield box(width + 2 * bar, bar, 0.045), (0.0, height, 0.0225), frame
    yield box(width, height, 0.03), (0.0, 0.0, 0.015), leaf
    yield box(panel, 0.65, 0.012), (0.0, 0.15, 0.036), leaf
    yield box(panel, 0.95, 0.012), (0.0, 0.95, 0.036), leaf
    yield handle, (0.5 * width - 0.11, 1.0, 0.055), draw.metal()


@model("blackboard")
def blackboard(draw: Draw) -> Table:
    """Return a board with chalk marks and a ledge."""
    width, tall, bar, frame = draw.number(1.8, 2.8), 1.1, 0.05, draw.wood()
    slate = draw.chip(45.0, (3, 3), (2, 4), 8.0) if draw.chance(0.6) else draw.grey(2)
    across = [(0.0, y, 0.015) for y in (0.0, tall - bar)]
    uprights = mirrored("x", 0.5 * (width - bar), bar, 0.015)
    yield box(width - 0.02, tall - 0.02, 0.02), (0.0, 0.01, 0.012), slate
    yield box(width, bar, 0.03), across, frame
    yield box(bar, tall - 2 * bar, 0.03), uprights, frame
    yield box(width, 0.02, 0.09), (0.0, 0.0, 0.075), frame
    chalks, y = [draw.grey(9), draw.pale(), draw.pale()], tall - 0.2
    while y > 0.2:
        x = -0.5 * width + 0.15
        while (long := draw.number(0.05, 0.3)) + x < 0.5 * width - 0.15:
            along = (long, draw.number(-0.01, 0.01), 0.0)
            stroke = parallelogram((x, y, 0.0225), along, (0.0, 0.018, 0.0))
            yield stroke, 0.0, draw.material_among(chalks)
            x += long + draw.number(0.03, 0.4)
        y -= draw.number(0.09, 0.16)


@model("towel rail")
def towel_rail(draw: Draw) -> Table:
    """Return a rail with one to three towels."""
    count = draw.whole(1, 3)
    wide, metal, y, z = 0.34 * count + 0.08, draw.metal(), 0.62, 0.075
    rail = cylinder(0.009, wide, 0.002, 16).turned(90.0, 2).moved((0.5 * wide, 0.0, 0.0))
    arm = cylinder(0.009, z, 0.002, 16).turned(90.0, 0)
    yield rail, (0.0, y, z), metal
    yield arm, mirrored("x", 0.5 * wide - 0.02, y, 0.0), metal
    for index in range(count):
        x, long = (index - 0.5 * (count - 1)) * 0.34, draw.number(0.4, 0.6)
        yield box(0.29, long, 0.034, 0.016, 3), (x, y + 0.02 - long, z), draw.fabric()
        yield box(0.292, 0.05, 0.036, 0.017, 3), (x, y + 0.06 - long, z), draw.pale()


def _hammer(draw: Draw) -> Iterable[Row]:
    """Yield a hammer that hangs from its head at y = 0, its back at z = 0, as all tools."""
    long = draw.number(0.26, 0.34)
    yield cylinder(0.011, long, 0.003, 16), (0.0, -long, 0.018), draw.wood()
    head = cylinder(0.016, 0.11, 0.004, 20).turned(90.0, 2).moved((0.055, 0.0, 0.0))
    yield head, (0.0, -0.005, 0.018), draw.metal()


def _saw(draw: Draw) -> Iterable[Row]:
    long = draw.number(0.3, 0.42)
    yield box(0.09, 0.11, 0.022, 0.01, 3), (0.0, -0.11, 0.013), draw.accent()
    yield box(0.07, long, 0.003, 0.001), (0.0, -0.11 - long, 0.013), draw.metal()


def _screwdriver(draw: Draw) -> Iterable[Row]:
    long = draw.number(0.1, 0.16)
    yield cone(0.013, 0.017, 0.1, 0.005, 20), (0.0, -0.1, 0.019), draw.accent()
    yield cylinder(0.004, long, 0.001, 12), (0.0, -0.1 - long, 0.019), draw.metal()


def _tape(draw: Draw) -> Iterable[Row]:
    radius = draw.number(0.05, 0.09)
    ring = torus(radius, 0.018, 36).turned(90.0, 0)
    yield ring, (0.0, -radius, 0.02), draw.accent()


_TOOLS: Sequence[tuple[Callable[[Draw], Iterable[Row]], float]] = (
    (_hammer, 0.15),
    (_saw, 0.13),
    (_screwdriver, 0.08),
    (_screwdriver, 0.08),
    (_tape, 0.24),
)
"""Makers of tools and the widths that they take."""


@model("tool board")
def tool_board(draw: Draw, wide: float) -> Table:
    """Return a board with tools in one or two rows."""
    levels = draw.whole(1, 2)
    board = box(wide, 0.62 * levels, 0.018)
    yield board, (0.0, 0.0, 0.009), draw.chip(None, (5, 7), (2, 6))
    for level in range(levels):
        at, y = -0.5 * wide + 0.05, 0.62 * (level + 1) - 0.06
        while True:
            make, room = draw.one_of(_TOOLS)
            if at + room > 0.5 * wide - 0.05:
                break
            yield make(draw), (at + 0.5 * room, y, 0.019)
            at += room + draw.number(0.0, 0.05)
