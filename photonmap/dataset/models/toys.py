"""Toys: balls, stacked rings, blocks; in metres."""

from __future__ import annotations

from photonmap.dataset.models.curved_shapes import sphere
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import (
    checkerboard,
    dots,
    height,
    rings,
    split,
    split_at_levels,
    waves,
)
from photonmap.dataset.models.scene_object import Part, SceneObject, multi_part, single_part
from photonmap.dataset.models.shapes import Random, box, cone, cylinder, torus

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
