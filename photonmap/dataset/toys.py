"""Toys and small sculpture: balls, blocks, rings, knots, superquadrics, pebbles."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.palette import Palette
from photonmap.dataset.patterns import checks, divide, dots, height, levels, patches, rings, waves
from photonmap.dataset.shapes import box, cone, cylinder, torus
from photonmap.dataset.solids import Random, knot, lump, sphere, superquadric
from photonmap.dataset.things import Part, Thing, painted, solid

ROUGH = 36
"""Segments of small round toys."""


def ball(rng: Random, palette: Palette, radius: float = 0.07) -> Thing:
    """Return a ball: plain, striped, dotted, or in sectors; at times a mirror among mixed ones."""
    shape = sphere(radius * float(rng.uniform(0.8, 1.2)), 3)
    kind = int(rng.integers(5))
    paints = [palette.accent(), palette.pale(), palette.accent()]
    top = shape.vertices[:, 1].max()
    if kind == 0:
        return solid("ball", shape, palette.metal() if palette.mixed else paints[0])
    if kind == 1:
        return painted("ball", levels(shape, height, [0.35 * top, 0.65 * top]), paints)
    if kind == 2:
        return painted("ball", divide(shape, dots(rng, shape, 0.22 * top, 24)), paints)
    if kind == 3:
        return painted("ball", divide(shape, waves(int(rng.integers(3, 5)))), paints)
    return painted("ball", checks(shape, waves(4), rings(0.6 * top)), paints)


def ring_tower(palette: Palette, size: float, count: int, segments: int = ROUGH) -> Thing:
    """Return rings around a stick, ever smaller, with a ball on top; their radius is `size`."""
    base, stick = palette.wood(), palette.wood()
    colors = palette.colors(count + 1)
    parts = [Part(cylinder(0.95 * size, 0.16 * size, 0.04 * size, segments), palette.glazed(base))]
    y = 0.16 * size
    for index in range(count):
        thickness = size * (0.235 - 0.016 * index)
        radius = size * (0.80 - 0.115 * index)
        shape = torus(radius - 0.3 * thickness, thickness, segments).moved((0.0, y, 0.0))
        parts.append(Part(shape, palette.glazed(colors[index])))
        y += 2.0 * thickness
    rod = cylinder(0.13 * size, y - 0.16 * size, segments=segments)
    parts.append(Part(rod.moved((0.0, 0.16 * size, 0.0)), stick))
    parts.append(Part(sphere(0.22 * size, 3).moved((0.0, y, 0.0)), palette.glazed(colors[count])))
    return Thing("ring tower", parts)


def block(rng: Random, palette: Palette, side: float = 0.06) -> Thing:
    """Return a toy block: a cube, a brick, a cylinder or a cone."""
    kind, color = int(rng.integers(4)), palette.glazed(palette.accent())
    shape = (
        box(side, side, side, 0.05 * side),
        box(2.0 * side, side, side, 0.05 * side),
        cylinder(0.5 * side, side, 0.05 * side, ROUGH),
        cone(0.5 * side, 0.04 * side, 1.2 * side, 0.02 * side, ROUGH),
    )[kind]
    return solid("block", shape, color)


def block_stack(rng: Random, palette: Palette, side: float = 0.06, count: int = 4) -> Thing:
    """Return blocks on top of each other, each turned a little, with a cone or ball on top."""
    parts, y = [], 0.0
    for color in palette.colors(count):
        shape = box(side, side, side, 0.05 * side).turned(float(rng.uniform(-18.0, 18.0)))
        parts.append(Part(shape.moved((0.0, y, 0.0)), palette.glazed(color)))
        y += side
    pointed = cone(0.5 * side, 0.03 * side, side, segments=ROUGH)
    top = pointed if rng.random() < 0.5 else sphere(0.45 * side, 3)
    parts.append(Part(top.moved((0.0, y, 0.0)), palette.glazed(palette.accent())))
    return Thing("block stack", parts)


def knot_sculpture(rng: Random, palette: Palette, size: float = 0.16) -> Thing:
    """Return a torus knot: of one colour, or of two along its length."""
    p, q = ((2, 3), (3, 2), (2, 5))[int(rng.integers(3))]
    shape = knot(size, 0.19 * size, p, q, 240)
    paints = [palette.glazed(palette.accent()), palette.glazed(palette.accent())]
    if rng.random() < 0.5:
        return solid("knot", shape, paints[0])
    return painted("knot", divide(shape, waves(3)), paints)


def quadric_sculpture(rng: Random, palette: Palette, size: float = 0.22) -> Thing:
    """Return a superquadric: plain, striped or checked."""
    extents = size * rng.uniform(0.8, 1.25, 3)
    north, east = rng.uniform(0.25, 1.6, 2)
    shape = superquadric(extents, float(north), float(east), 64, 96)
    paints = [palette.accent(), palette.pale(), palette.accent()]
    kind = int(rng.integers(3))
    if kind == 0:
        return solid("superquadric", shape, palette.glazed(paints[0]))
    if kind == 1:
        at = np.linspace(0.0, extents[1], 6)[1:-1].tolist()
        return painted("superquadric", levels(shape, height, at), paints)
    return painted("superquadric", checks(shape, waves(4), rings(0.5 * extents[1])), paints)


def pebble(rng: Random, palette: Palette, radius: float = 0.1) -> Thing:
    """Return a lump of smooth noise: plain or in patches."""
    shape = lump(rng, radius * float(rng.uniform(0.8, 1.2)))
    paints = [palette.accent(), palette.fabric(), palette.pale()]
    if rng.random() < 0.5:
        return solid("pebble", shape, paints[1])
    return painted("pebble", patches(rng, shape, 3, 1.2 * radius), paints)
