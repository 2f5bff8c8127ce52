"""Lamps for ceilings, floors and tables, in metres; their emissive parts are of group `LAMP`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from photonmap.dataset.models.curved_shapes import sphere
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, SceneObject, part_at
from photonmap.dataset.models.shapes import (
    arc,
    box,
    cone,
    cylinder,
    lathe,
    parallelogram,
    smooth_curve,
)

LAMP = "lamp"
"""The light group of a lamp, until `numbered` tells the lamps of a scene apart."""
_RIBS, _RIB_EVERY = 70.0, 10.0
"""Greatest latitude of the ribs of a lantern, and the angle between them, degrees."""


def is_lamp(obj: SceneObject) -> bool:
    """Return whether an object emits as a lamp."""
    return any(part.light_group == LAMP for part in obj.parts)


def numbered(objects: Iterable[SceneObject]) -> list[SceneObject]:
    """Return objects whose lamps are light groups of their own: `LAMP`, "lamp 2", "lamp 3"."""
    count, made = 0, []
    for obj in objects:
        if is_lamp(obj):
            count += 1
            group = LAMP if count == 1 else f"{LAMP} {count}"
            parts = [
                replace(part, light_group=group) if part.light_group else part for part in obj.parts
            ]
            obj = replace(obj, parts=parts)
        made.append(obj)
    return made


def _cord(palette: Palette, cord: float) -> list[Part]:
    """Return a cord of this length, metres, and the cap at the ceiling, at y = 0."""
    return [
        part_at(cylinder(0.004, cord, 0.001, 12), 0.0, -cord, 0.0, palette.grey(3)),
        part_at(cylinder(0.05, 0.025, 0.008, 32), 0.0, -0.025, 0.0, palette.grey(8)),
    ]


def pendant(palette: Palette, radius: float, cord: float) -> SceneObject:
    """Return a paper lantern with ribs of wire on a cord; the ceiling is at y = 0."""
    middle, wire = -cord - radius, palette.grey(5)
    parts = [
        *_cord(palette, cord),
        Part(sphere(radius, 2).moved((0.0, middle - radius, 0.0)), palette.grey(9), LAMP),
    ]
    for degrees in np.linspace(-_RIBS, _RIBS, 2 * round(_RIBS / _RIB_EVERY) + 1):
        # Thicker ones hold the paper at the top and at the bottom.
        thick = 0.006 if abs(degrees) == _RIBS else 0.0018
        wide, high = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        rib = lathe(arc((radius * wide, 0.0), thick, -90.0, 270.0, 7), segments=48)
        parts.append(part_at(rib, 0.0, middle + radius * high, 0.0, wire))
    return SceneObject("pendant lamp", parts)


def shade_lamp(palette: Palette, radius: float, cord: float) -> SceneObject:
    """Return a shade, open below, around an emissive disc, on a cord; the ceiling is at y = 0."""
    tall, wall, y = 0.7 * radius, 0.006, -cord - 0.7 * radius
    outer = smooth_curve([(radius, 0.0), (0.45 * radius, 0.8 * tall), (0.04, tall)], 24)
    inner = smooth_curve(
        [(0.0, tall - wall), (0.45 * radius, 0.8 * tall - wall), (radius - wall, 0.0)], 24
    )
    shade = lathe(inner, [inner[-1], outer[0]], outer, [outer[-1], (0.0, tall)])
    disc = lathe([(0.0, 0.02), (0.9 * radius, 0.02)], segments=32)
    parts = [
        *_cord(palette, cord),
        part_at(shade, 0.0, y, 0.0, palette.glazed(palette.accent())),
        Part(disc.moved((0.0, y, 0.0)), palette.grey(8), LAMP),
    ]
    return SceneObject("pendant lamp", parts)


def ceiling_panel(palette: Palette, width: float, depth: float) -> SceneObject:
    """Return a flat panel lamp below the ceiling at y = 0."""
    half = (0.5 * width, 0.5 * depth)
    parts = [
        part_at(box(width + 0.06, 0.05, depth + 0.06, 0.008), 0.0, -0.05, 0.0, palette.grey(8)),
        Part(
            parallelogram((-half[0], -0.052, -half[1]), (width, 0.0, 0.0), (0.0, 0.0, depth)),
            palette.grey(8),
            LAMP,
        ),
    ]
    return SceneObject("ceiling lamp", parts)


def floor_lamp(palette: Palette) -> SceneObject:
    """Return a lamp with an emissive conical shade on a tall pole."""
    metal = palette.metal()
    parts = [
        Part(cylinder(0.15, 0.025, 0.008), metal),
        part_at(cylinder(0.011, 1.325, 0.002, 24), 0.0, 0.025, 0.0, metal),
        Part(cone(0.21, 0.13, 0.28, 0.01, 16).moved((0.0, 1.35, 0.0)), palette.grey(9), LAMP),
    ]
    return SceneObject("floor lamp", parts)


def table_lamp(palette: Palette) -> SceneObject:
    """Return a lamp with an emissive conical shade on a turned foot."""
    foot = smooth_curve(
        [(0.06, 0.0), (0.075, 0.03), (0.035, 0.12), (0.05, 0.19), (0.018, 0.24)], 32
    )
    body = lathe([(0.0, 0.0), foot[0]], foot, [foot[-1], (0.0, foot[-1, 1])], segments=48)
    parts = [
        Part(body, palette.glazed(palette.accent())),
        Part(cone(0.13, 0.08, 0.17, 0.008, 16).moved((0.0, 0.24, 0.0)), palette.grey(9), LAMP),
    ]
    return SceneObject("table lamp", parts)


def ceiling_spot(palette: Palette, radius: float) -> SceneObject:
    """Return a flat round lamp below the ceiling at y = 0."""
    disc = lathe([(0.0, 0.0), (0.85 * radius, 0.0)], segments=32)
    parts = [
        part_at(cylinder(radius, 0.035, 0.008, 48), 0.0, -0.035, 0.0, palette.grey(8)),
        Part(disc.moved((0.0, -0.037, 0.0)), palette.grey(8), LAMP),
    ]
    return SceneObject("ceiling spot", parts)
