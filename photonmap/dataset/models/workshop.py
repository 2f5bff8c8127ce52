"""Tools, timber and boxes of a workshop, in metres."""

from __future__ import annotations

from collections.abc import Callable

from photonmap.dataset.models.arrangements import Maker, draw_makers
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, Row, SceneObject, assembled, part_at
from photonmap.dataset.models.shapes import Random, box, cone, cylinder, torus


def hammer(rng: Random, palette: Palette) -> list[Part]:
    """Return a hammer that hangs from its head at y = 0, its back at z = 0."""
    long = float(rng.uniform(0.26, 0.34))
    shaft = cylinder(0.011, long, 0.003, 16)
    head = cylinder(0.016, 0.11, 0.004, 20).turned(90.0, 2).moved((0.055, 0.0, 0.0))
    return [
        part_at(shaft, 0.0, -long, 0.018, palette.wood()),
        part_at(head, 0.0, -0.005, 0.018, palette.metal()),
    ]


def saw(rng: Random, palette: Palette) -> list[Part]:
    """Return a saw that hangs from its handle."""
    long = float(rng.uniform(0.3, 0.42))
    return [
        part_at(box(0.09, 0.11, 0.022, 0.01, 3), 0.0, -0.11, 0.013, palette.accent()),
        part_at(box(0.07, long, 0.003, 0.001), 0.0, -0.11 - long, 0.013, palette.metal()),
    ]


def screwdriver(rng: Random, palette: Palette) -> list[Part]:
    """Return a screwdriver with its handle up."""
    long = float(rng.uniform(0.1, 0.16))
    return [
        part_at(cone(0.013, 0.017, 0.1, 0.005, 20), 0.0, -0.1, 0.019, palette.accent()),
        part_at(cylinder(0.004, long, 0.001, 12), 0.0, -0.1 - long, 0.019, palette.metal()),
    ]


def tape(rng: Random, palette: Palette) -> list[Part]:
    """Return a roll of tape or wire."""
    radius = float(rng.uniform(0.05, 0.09))
    ring = torus(radius, 0.018, 36).turned(90.0, 0)
    return [part_at(ring, 0.0, -radius, 0.02, palette.accent())]


_TOOLS: tuple[tuple[Callable[[Random, Palette], list[Part]], float], ...] = (
    (hammer, 0.15),
    (saw, 0.13),
    (screwdriver, 0.08),
    (screwdriver, 0.08),
    (tape, 0.24),
)
"""Makers of tools and the widths that they take."""


def tool_board(rng: Random, palette: Palette, wide: float) -> SceneObject:
    """Return a board with tools in one or two rows, its back at z = 0 and its foot at y = 0."""
    rows = int(rng.integers(1, 3))
    tall = 0.62 * rows
    board = palette.chip(None, (5, 7), (2, 6))
    parts = [part_at(box(wide, tall, 0.018), 0.0, 0.0, 0.009, board)]
    for row in range(rows):
        at = -0.5 * wide + 0.05
        while True:
            make, room = _TOOLS[int(rng.integers(len(_TOOLS)))]
            if at + room > 0.5 * wide - 0.05:
                break
            top = (0.62 * (row + 1) - 0.06, 0.019)
            parts += [
                Part(part.shape.moved((at + 0.5 * room, *top)), part.material)
                for part in make(rng, palette)
            ]
            at += room + float(rng.uniform(0.0, 0.05))
    return SceneObject("tool board", parts)


def crate(rng: Random, palette: Palette, size: float) -> SceneObject:
    """Return an open crate of boards."""
    wood, wall = palette.wood(), 0.016
    wide, tall, deep = size * rng.uniform(0.8, 1.2, 3) * (1.2, 0.7, 0.9)
    slat = 0.42 * tall
    rows: list[Row] = [(box(wide, wall, deep, 0.002), (0.0, 0.0, 0.0), wood)]
    long, across = box(wide, slat, wall, 0.002), box(wall, slat, deep - 2 * wall, 0.002)
    for y in (wall, wall + (tall - wall - slat)):
        rows.append((long, (0.0, y, 0.5 * (deep - wall)), wood, "z"))
        rows.append((across, (0.5 * (wide - wall), y, 0.0), wood, "x"))
    post, inner = box(wall, tall, wall, 0.002), (0.5 * wide - 1.5 * wall, 0.5 * deep - 1.5 * wall)
    rows += [
        (post, (i * inner[0], wall, k * inner[1]), palette.wood()) for i in (-1, 1) for k in (-1, 1)
    ]
    return assembled("crate", rows)


def tin(rng: Random, palette: Palette) -> SceneObject:
    """Return a tin of paint with a band in its colour."""
    radius, tall = float(rng.uniform(0.05, 0.09)), float(rng.uniform(0.1, 0.2))
    colour, metal = palette.accent(), palette.metal()
    parts = [
        Part(cylinder(radius, tall, 0.004, 40), metal),
        part_at(cylinder(1.01 * radius, 0.6 * tall, 0.002, 40), 0.0, 0.2 * tall, 0.0, colour),
    ]
    return SceneObject("tin", parts)


def toolbox(rng: Random, palette: Palette) -> SceneObject:
    """Return a toolbox with a handle."""
    wide, tall, deep = float(rng.uniform(0.35, 0.5)), 0.18, 0.2
    paint = palette.glazed(palette.accent())
    parts = [
        Part(box(wide, tall, deep, 0.01, 3), paint),
        part_at(box(wide, 0.06, 0.7 * deep, 0.015, 3), 0.0, tall, 0.0, palette.grey(3)),
        part_at(box(0.5 * wide, 0.025, 0.03, 0.01, 3), 0.0, tall + 0.06, 0.0, palette.metal()),
    ]
    return SceneObject("toolbox", parts)


def timber(rng: Random, palette: Palette) -> SceneObject:
    """Return a stack of planks on two bearers."""
    long, wide = float(rng.uniform(1.2, 2.2)), float(rng.uniform(0.14, 0.2))
    bearer = box(0.06, 0.06, 2.2 * wide, 0.003)
    parts = [part_at(bearer, i * 0.35 * long, 0.0, 0.0, palette.wood()) for i in (-1, 1)]
    for layer in range(int(rng.integers(2, 6))):
        for k in (-0.5, 0.5):
            short = long * float(rng.uniform(0.82, 1.0))
            plank = box(short, 0.028, wide, 0.002)
            x = float(rng.uniform(-0.5, 0.5)) * (long - short)
            parts.append(part_at(plank, x, 0.06 + 0.03 * layer, 1.04 * k * wide, palette.wood()))
    return SceneObject("timber", parts)


def shop_things(rng: Random, palette: Palette, count: int) -> list[Maker]:
    """Return makers of what lies on benches and shelves."""
    makers: list[Maker] = [
        lambda: tin(rng, palette),
        lambda: tin(rng, palette),
        lambda: toolbox(rng, palette),
        lambda: crate(rng, palette, 0.2),
    ]
    return draw_makers(rng, makers, count)
