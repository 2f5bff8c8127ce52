"""Plants, books, toys and small sculptures, in metres."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.curved_shapes import knot, lump, sphere, superquadric
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import (
    checkerboard,
    dots,
    height,
    patches,
    rings,
    split,
    split_at_levels,
    waves,
)
from photonmap.dataset.models.scene_object import Part, SceneObject, multi_part, single_part
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    cone,
    cylinder,
    lattice,
    parallelogram,
    smooth_normals,
    torus,
)
from photonmap.dataset.models.vessels import pot_shape


def plant(rng: Random, palette: Palette, tall: float) -> SceneObject:
    """Return a potted plant with long leaves that bend outwards, about `tall` metres high."""
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
    return SceneObject("plant", parts)


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


def book(rng: Random, palette: Palette, lying: bool = False) -> SceneObject:
    """Return a book: upright with its spine towards +z, or lying."""
    tall, deep = float(rng.uniform(0.19, 0.29)), float(rng.uniform(0.14, 0.2))
    thick = float(rng.uniform(0.018, 0.05))
    cover = palette.chip(None, (3, 7), (2, 10))
    front = 0.5 * deep + 2e-4
    label = parallelogram((-0.5 * thick, 0.78 * tall, front), (thick, 0.0, 0.0), (0.0, 0.012, 0.0))
    parts = [Part(box(thick, tall, deep, 0.003, 1), cover), Part(label, palette.pale())]
    obj = SceneObject("book", parts)
    if not lying:
        return obj
    return obj.transformed(
        lambda shape: shape.turned(90.0, 2).moved((0.5 * tall, 0.5 * thick, 0.0))
    )


TOY_SEGMENTS = 36
"""Segments around the axis of small round toys."""


def ball(rng: Random, palette: Palette, radius: float = 0.07) -> SceneObject:
    """Return a ball: plain, striped, dotted, in sectors or checked.

    Among mixed materials a plain ball is a mirror.
    """
    shape = sphere(radius * float(rng.uniform(0.8, 1.2)), 3)
    kind = int(rng.integers(5))
    paints = [palette.accent(), palette.pale(), palette.accent()]
    top = shape.vertices[:, 1].max()
    if kind == 0:
        return single_part("ball", shape, palette.metal() if palette.mixed else paints[0])
    if kind == 1:
        return multi_part("ball", split_at_levels(shape, height, [0.35 * top, 0.65 * top]), paints)
    if kind == 2:
        return multi_part("ball", split(shape, dots(rng, shape, 0.22 * top, 24)), paints)
    if kind == 3:
        return multi_part("ball", split(shape, waves(int(rng.integers(3, 5)))), paints)
    return multi_part("ball", checkerboard(shape, waves(4), rings(0.6 * top)), paints)


def ring_tower(
    palette: Palette, size: float, count: int, segments: int = TOY_SEGMENTS
) -> SceneObject:
    """Return a stack of ever smaller rings around a stick, with a ball on top.

    Parameters
    ----------
    size : radius of the base, about, metres
    """
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
    return SceneObject("ring tower", parts)


def block(rng: Random, palette: Palette, side: float = 0.06) -> SceneObject:
    """Return a toy block: a cube, a brick, a cylinder or a cone."""
    kind, color = int(rng.integers(4)), palette.glazed(palette.accent())
    shape = (
        box(side, side, side, 0.05 * side),
        box(2.0 * side, side, side, 0.05 * side),
        cylinder(0.5 * side, side, 0.05 * side, TOY_SEGMENTS),
        cone(0.5 * side, 0.04 * side, 1.2 * side, 0.02 * side, TOY_SEGMENTS),
    )[kind]
    return single_part("block", shape, color)


def block_stack(rng: Random, palette: Palette, side: float = 0.06, count: int = 4) -> SceneObject:
    """Return a stack of blocks, each turned a little, with a cone or a ball on top."""
    parts, y = [], 0.0
    for color in palette.colors(count):
        shape = box(side, side, side, 0.05 * side).turned(float(rng.uniform(-18.0, 18.0)))
        parts.append(Part(shape.moved((0.0, y, 0.0)), palette.glazed(color)))
        y += side
    pointed = cone(0.5 * side, 0.03 * side, side, segments=TOY_SEGMENTS)
    top = pointed if rng.random() < 0.5 else sphere(0.45 * side, 3)
    parts.append(Part(top.moved((0.0, y, 0.0)), palette.glazed(palette.accent())))
    return SceneObject("block stack", parts)


def knot_sculpture(rng: Random, palette: Palette, size: float = 0.16) -> SceneObject:
    """Return a torus knot of one colour, or in sectors of two."""
    p, q = ((2, 3), (3, 2), (2, 5))[int(rng.integers(3))]
    shape = knot(size, 0.19 * size, p, q, 240)
    paints = [palette.glazed(palette.accent()), palette.glazed(palette.accent())]
    if rng.random() < 0.5:
        return single_part("knot", shape, paints[0])
    return multi_part("knot", split(shape, waves(3)), paints)


def quadric_sculpture(rng: Random, palette: Palette, size: float = 0.22) -> SceneObject:
    """Return a plain, striped or checked superquadric."""
    extents = size * rng.uniform(0.8, 1.25, 3)
    north, east = rng.uniform(0.25, 1.6, 2)
    shape = superquadric(extents, float(north), float(east), 64, 96)
    paints = [palette.accent(), palette.pale(), palette.accent()]
    kind = int(rng.integers(3))
    if kind == 0:
        return single_part("superquadric", shape, palette.glazed(paints[0]))
    if kind == 1:
        at = np.linspace(0.0, extents[1], 6)[1:-1].tolist()
        return multi_part("superquadric", split_at_levels(shape, height, at), paints)
    return multi_part(
        "superquadric", checkerboard(shape, waves(4), rings(0.5 * extents[1])), paints
    )


def pebble(rng: Random, palette: Palette, radius: float = 0.1) -> SceneObject:
    """Return a lump of smooth noise, plain or in patches."""
    shape = lump(rng, radius * float(rng.uniform(0.8, 1.2)))
    paints = [palette.accent(), palette.fabric(), palette.pale()]
    if rng.random() < 0.5:
        return single_part("pebble", shape, paints[1])
    return multi_part("pebble", patches(rng, shape, 3, 1.2 * radius), paints)
