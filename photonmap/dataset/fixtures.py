"""What hangs on walls and ceilings, and lamps: their glowing parts name their group of lights."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.furniture import at
from photonmap.dataset.palette import Palette
from photonmap.dataset.patterns import mondrian
from photonmap.dataset.shapes import (
    Shape,
    box,
    cone,
    curve,
    cylinder,
    lathe,
    lattice,
    sheet,
    smooth_normals,
)
from photonmap.dataset.solids import Random, sphere
from photonmap.dataset.things import Part, Support, Thing
from photonmap.dataset.vessels import pot_shape

WINDOW, LAMP = "window", "lamp"
"""The groups of lights in rooms."""


def window(palette: Palette, width: float, height: float, depth: float = 0.16) -> Thing:
    """Return a window whose hole in the wall is around x = 0, from y = 0, with the wall at z = 0.

    A pane of light lies behind four bars, at the end of the hole.
    """
    frame, bar = palette.grey(9), 0.045
    x = 0.5 * width
    reveal = [
        sheet((-x, 0.0, 0.0), (0.0, 0.0, -depth), (0.0, height, 0.0)),
        sheet((x, 0.0, -depth), (0.0, 0.0, depth), (0.0, height, 0.0)),
        sheet((-x, 0.0, 0.0), (width, 0.0, 0.0), (0.0, 0.0, -depth)),
        sheet((-x, height, -depth), (width, 0.0, 0.0), (0.0, 0.0, depth)),
    ]
    parts = [Part(side, frame) for side in reveal]
    z = -depth + 0.5 * bar + 0.005
    upright = box(bar, height, bar)
    parts += [at(upright, i * (x - 0.5 * bar), 0.0, z, frame) for i in (-1, 0, 1)]
    across = box(width, bar, 0.8 * bar)
    parts += [at(across, 0.0, y, z, frame) for y in (0.0, 0.62 * height, height - bar)]
    pane = sheet((-x, 0.0, -depth), (width, 0.0, 0.0), (0.0, height, 0.0))
    return Thing("window", [*parts, Part(pane, palette.grey(2), WINDOW)])


def sill(palette: Palette, width: float) -> Thing:
    """Return a window sill for a wall, its back at z = 0, below y = 0.03."""
    board = at(box(width + 0.16, 0.03, 0.18, 0.006), 0.0, 0.0, 0.09, palette.grey(8))
    half = 0.5 * width
    return Thing("sill", [board], [Support((-half, half), (0.01, 0.17), 0.03, 0.4)])


def curtain(palette: Palette, rng: Random, width: float, height: float) -> Thing:
    """Return a curtain in folds before a wall at z = 0, from y = 0 to `height`."""
    steps, folds = 120, max(3, round(width / 0.11))
    across = np.linspace(-0.5 * width, 0.5 * width, steps)
    phase = float(rng.uniform(0.0, 6.0))
    wave = 0.035 * np.sin(2.0 * np.pi * folds * (across / width) + phase)
    wave += 0.012 * np.sin(4.3 * np.pi * folds * (across / width) + 2.0 * phase)
    levels = np.linspace(0.0, height, 10)
    grow = 1.25 - 0.5 * levels / height
    front = np.stack(
        [
            np.tile(across, (10, 1)),
            np.tile(levels[:, None], (1, steps)),
            0.08 + grow[:, None] * wave,
        ],
        axis=-1,
    )
    vertices = front.reshape(-1, 3)
    faces = lattice(10, steps)
    normals = smooth_normals(vertices, faces)
    cloth = palette.chip(palette.key, (5, 7), (4, 8))
    return Thing("curtain", [Part(Shape(vertices, faces, normals), cloth)])


def picture(rng: Random, palette: Palette, width: float, height: float) -> Thing:
    """Return a framed picture of rectangles, its back at z = 0."""
    frame, bar, deep = palette.wood(), 0.03, 0.025
    parts = [
        at(box(width, bar, deep), 0.0, 0.0, 0.5 * deep, frame),
        at(box(width, bar, deep), 0.0, height - bar, 0.5 * deep, frame),
    ]
    side = box(bar, height - 2 * bar, deep)
    parts += [at(side, i * 0.5 * (width - bar), bar, 0.5 * deep, frame) for i in (-1, 1)]
    colors = [*palette.colors(5, (4, 8)), palette.grey(9), palette.grey(3)]
    wide, tall = width - 2 * bar, height - 2 * bar
    for x, y, w, h in mondrian(rng, wide, tall, 0.2 * min(wide, tall)):
        corner = (x - 0.5 * wide, y + bar, 0.3 * deep)
        parts.append(Part(sheet(corner, (w, 0.0, 0.0), (0.0, h, 0.0)), palette.choice(colors)))
    return Thing("picture", parts)


def looking_glass(palette: Palette, radius: float) -> Thing:
    """Return a round mirror in a frame, its back at z = 0; among Lambertian materials a disc."""
    rim = cylinder(radius, 0.03, 0.01).turned(90.0, 0).moved((0.0, radius, 0.0))
    disc = cylinder(0.9 * radius, 0.004, 0.001).turned(90.0, 0).moved((0.0, radius, 0.03))
    return Thing("mirror", [Part(rim, palette.wood()), Part(disc, palette.metal())])


def clock(palette: Palette) -> Thing:
    """Return a wall clock, its back at z = 0."""
    radius = 0.16
    rim = cylinder(radius, 0.03, 0.01).turned(90.0, 0).moved((0.0, radius, 0.0))
    face = cylinder(0.88 * radius, 0.004, 0.001).turned(90.0, 0).moved((0.0, radius, 0.03))
    parts = [Part(rim, palette.accent()), Part(face, palette.grey(9))]
    for degrees, long in ((35.0, 0.55), (-80.0, 0.8)):
        hand = box(0.012, long * radius, 0.003, 0.001, 1).turned(degrees, 2)
        parts.append(at(hand, 0.0, radius, 0.0355, palette.grey(2)))
    return Thing("clock", parts)


def pendant(palette: Palette, radius: float, cord: float) -> Thing:
    """Return a paper lantern on a cord that ends at the ceiling, y = 0."""
    parts = [
        at(cylinder(0.004, cord, 0.001, 12), 0.0, -cord, 0.0, palette.grey(3)),
        at(cylinder(0.05, 0.025, 0.008, 32), 0.0, -0.025, 0.0, palette.grey(8)),
        Part(sphere(radius, 3).moved((0.0, -cord - 2 * radius, 0.0)), palette.grey(9), LAMP),
    ]
    return Thing("pendant lamp", parts)


def shade_lamp(palette: Palette, radius: float, cord: float) -> Thing:
    """Return a shade, open below, on a cord that ends at the ceiling, y = 0; a disc glows in it."""
    tall, wall, y = 0.7 * radius, 0.006, -cord - 0.7 * radius
    outer = curve([(radius, 0.0), (0.45 * radius, 0.8 * tall), (0.04, tall)], 24)
    inner = curve(
        [(0.0, tall - wall), (0.45 * radius, 0.8 * tall - wall), (radius - wall, 0.0)], 24
    )
    shade = lathe(inner, [inner[-1], outer[0]], outer, [outer[-1], (0.0, tall)])
    disc = lathe([(0.0, 0.02), (0.9 * radius, 0.02)], segments=32)
    parts = [
        at(cylinder(0.004, cord, 0.001, 12), 0.0, -cord, 0.0, palette.grey(3)),
        at(cylinder(0.05, 0.025, 0.008, 32), 0.0, -0.025, 0.0, palette.grey(8)),
        at(shade, 0.0, y, 0.0, palette.glazed(palette.accent())),
        Part(disc.moved((0.0, y, 0.0)), palette.grey(8), LAMP),
    ]
    return Thing("pendant lamp", parts)


def ceiling_panel(palette: Palette, width: float, depth: float) -> Thing:
    """Return a flat lamp below the ceiling, y = 0."""
    half = (0.5 * width, 0.5 * depth)
    parts = [
        at(box(width + 0.06, 0.05, depth + 0.06, 0.008), 0.0, -0.05, 0.0, palette.grey(8)),
        Part(
            sheet((-half[0], -0.052, -half[1]), (width, 0.0, 0.0), (0.0, 0.0, depth)),
            palette.grey(8),
            LAMP,
        ),
    ]
    return Thing("ceiling lamp", parts)


def floor_lamp(palette: Palette) -> Thing:
    """Return a lamp with a cone of light on a tall stick."""
    metal = palette.metal()
    parts = [
        Part(cylinder(0.15, 0.025, 0.008), metal),
        at(cylinder(0.011, 1.325, 0.002, 24), 0.0, 0.025, 0.0, metal),
        Part(cone(0.21, 0.13, 0.28, 0.01, 32).moved((0.0, 1.35, 0.0)), palette.grey(9), LAMP),
    ]
    return Thing("floor lamp", parts)


def table_lamp(palette: Palette) -> Thing:
    """Return a lamp with a cone of light on a turned foot."""
    foot = curve([(0.06, 0.0), (0.075, 0.03), (0.035, 0.12), (0.05, 0.19), (0.018, 0.24)], 32)
    body = lathe([(0.0, 0.0), foot[0]], foot, [foot[-1], (0.0, foot[-1, 1])], segments=48)
    parts = [
        Part(body, palette.glazed(palette.accent())),
        Part(cone(0.13, 0.08, 0.17, 0.008, 32).moved((0.0, 0.24, 0.0)), palette.grey(9), LAMP),
    ]
    return Thing("table lamp", parts)


def plant(rng: Random, palette: Palette, tall: float) -> Thing:
    """Return a pot with long leaves that bend outwards, together about `tall` high."""
    pot = pot_shape(rng, 0.32 * tall)
    inside = 0.27 * tall
    greens = [palette.chip(38.0, (4, 6), (4, 8), 6.0) for _ in range(3)]
    earth = cylinder(0.125 * tall, 0.02, 0.004, 32).moved((0.0, inside - 0.02, 0.0))
    parts = [
        Part(pot, palette.chip(12.0, (4, 6), (6, 10))),
        Part(earth, palette.chip(18.0, (3, 3), (2, 2))),
    ]
    for index in range(13):
        leaf = _leaf(rng, tall - inside).turned(index * 137.5).moved((0.0, inside, 0.0))
        parts.append(Part(leaf, greens[index % 3]))
    return Thing("plant", parts)


def _leaf(rng: Random, tall: float) -> Shape:
    """Return a thin leaf that rises from the origin and bends towards +x."""
    steps = 16
    t = np.linspace(0.0, 1.0, steps)
    lean, rise = float(rng.uniform(0.1, 0.42)) * tall, float(rng.uniform(0.75, 1.0)) * tall
    x = 0.02 + lean * t**1.6
    y = rise * (t - 0.22 * (lean / tall) * t**3)
    wide = 0.075 * tall * np.sin(np.pi * np.clip(0.06 + 0.94 * t, 0.0, 0.995)) ** 0.8
    cup = 0.25 * wide
    rows = [np.stack([x - cup * (k == 0), y, k * wide], axis=1) for k in (-1, 0, 1)]
    vertices = np.stack(rows, axis=1).reshape(-1, 3)
    faces = lattice(steps, 3)
    return Shape(vertices, faces, smooth_normals(vertices, faces))


def book(rng: Random, palette: Palette, lying: bool = False) -> Thing:
    """Return a book: upright with its spine towards +z, or lying."""
    tall, deep = float(rng.uniform(0.19, 0.29)), float(rng.uniform(0.14, 0.2))
    thick = float(rng.uniform(0.018, 0.05))
    cover = palette.chip(None, (3, 7), (2, 10))
    front = 0.5 * deep + 2e-4
    label = sheet((-0.5 * thick, 0.78 * tall, front), (thick, 0.0, 0.0), (0.0, 0.012, 0.0))
    parts = [Part(box(thick, tall, deep, 0.003, 1), cover), Part(label, palette.pale())]
    thing = Thing("book", parts)
    if not lying:
        return thing
    return thing.changed(lambda shape: shape.turned(90.0, 2).moved((0.5 * tall, 0.5 * thick, 0.0)))
