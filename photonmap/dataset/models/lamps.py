"""Lamps, in metres; their emissive parts are of group `LAMP`. Ceilings are at y = 0."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import Row, SceneObject, Table, model
from photonmap.dataset.models.shapes import (
    arc,
    box,
    cone,
    cylinder,
    lathe,
    parallelogram,
    smooth_curve,
    sphere,
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
            obj = obj.mapped(lambda p, g=group: replace(p, light_group=g) if p.light_group else p)  # type: ignore[misc]
        made.append(obj)
    return made


def _cord(draw: Draw, cord: float) -> Iterator[Row]:
    """Yield a cord of this length, metres, and the cap at the ceiling."""
    yield cylinder(0.004, cord, 0.001, 12), -cord, draw.grey(3)
    yield cylinder(0.05, 0.025, 0.008, 32), -0.025, draw.grey(8)


@model("pendant lamp")
def pendant(draw: Draw) -> Table:
    """Return a paper lantern with ribs of wire on a cord."""
    radius, cord = draw.number(0.15, 0.26), draw.number(0.15, 0.4)
    middle = -cord - radius
    yield from _cord(draw, cord)
    yield sphere(radius, 2), middle - radius, draw.grey(9), LAMP
    for degrees in np.linspace(-_RIBS, _RIBS, 2 * round(_RIBS / _RIB_EVERY) + 1):
        # Thicker ones hold the paper at the top and at the bottom.
        thick = 0.006 if abs(degrees) == _RIBS else 0.0018
        wide, high = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        rib = lathe(arc((radius * wide, 0.0), thick, -90.0, 270.0, 7), segments=48)
        yield rib, middle + radius * high, draw.grey(5)


@model("pendant lamp")
def shade_lamp(draw: Draw) -> Table:
    """Return a shade, open below, around an emissive disc, on a cord."""
    radius, cord = draw.number(0.22, 0.36), draw.number(0.2, 0.5)
    tall, wall, y = 0.7 * radius, 0.006, -cord - 0.7 * radius
    outer = smooth_curve([(radius, 0.0), (0.45 * radius, 0.8 * tall), (0.04, tall)], 24)
    inner = smooth_curve(
        [(0.0, tall - wall), (0.45 * radius, 0.8 * tall - wall), (radius - wall, 0.0)], 24
    )
    shade = lathe(inner, [inner[-1], outer[0]], outer, [outer[-1], (0.0, tall)])
    disc = lathe([(0.0, 0.02), (0.9 * radius, 0.02)], segments=32)
    yield from _cord(draw, cord)
    yield shade, y, draw.glazed(draw.accent())
    yield disc, y, draw.grey(9), LAMP


@model("ceiling lamp")
def ceiling_panel(draw: Draw) -> Table:
    """Return a flat panel lamp below the ceiling."""
    wide, deep = draw.number(0.6, 1.4), draw.number(0.3, 0.7)
    corner = (-0.5 * wide, -0.052, -0.5 * deep)
    yield box(wide + 0.06, 0.05, deep + 0.06, 0.008), -0.05, draw.grey(8)
    yield parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, deep)), 0.0, draw.grey(9), LAMP


@model("ceiling spot")
def ceiling_spot(draw: Draw, radius: float) -> Table:
    """Return a flat round lamp below the ceiling."""
    yield cylinder(radius, 0.035, 0.008, 48), -0.035, draw.grey(8)
    yield lathe([(0.0, 0.0), (0.85 * radius, 0.0)], segments=32), -0.037, draw.grey(9), LAMP


@model("table lamp")
def table_lamp(draw: Draw) -> Table:
    """Return a lamp with an emissive conical shade on a turned foot."""
    knots = [(0.06, 0.0), (0.075, 0.03), (0.035, 0.12), (0.05, 0.19), (0.018, 0.24)]
    foot = smooth_curve(knots, 32)
    body = lathe([(0.0, 0.0), foot[0]], foot, [foot[-1], (0.0, foot[-1, 1])], segments=48)
    yield body, 0.0, draw.glazed(draw.accent())
    yield cone(0.13, 0.08, 0.17, 0.008, 16), 0.24, draw.grey(9), LAMP


@model("floor lamp")
def floor_lamp(draw: Draw) -> Table:
    """Return a lamp with an emissive conical shade on a tall pole."""
    yield cylinder(0.15, 0.025, 0.008), 0.0, draw.metal()
    yield cylinder(0.011, 1.325, 0.002, 24), 0.025, draw.metal()
    yield cone(0.21, 0.13, 0.28, 0.01, 16), 1.35, draw.grey(9), LAMP


@model("bollard")
def bollard(draw: Draw) -> Table:
    """Return a low lamp with an emissive ring below its cap."""
    yield cylinder(0.075, 0.62, 0.006, 40), 0.0, draw.grey(4)
    yield lathe([(0.07, 0.0), (0.07, 0.14)], segments=32), 0.62, draw.grey(9), LAMP
    yield cylinder(0.075, 0.08, 0.01, 40), 0.76, draw.grey(4)


@model("wall lantern")
def wall_lantern(draw: Draw) -> Table:
    """Return a lantern on a bracket, its back at z = 0."""
    yield box(0.1, 0.22, 0.02), (0.0, 0.0, 0.01), draw.grey(3)
    yield box(0.03, 0.03, 0.12), (0.0, 0.16, 0.07), draw.grey(3)
    yield cone(0.11, 0.03, 0.08, 0.006, 32), (0.0, 0.13, 0.16), draw.grey(3)
    yield cone(0.05, 0.085, 0.15, 0.006, 24), (0.0, -0.02, 0.16), draw.grey(9), LAMP


@model("street lamp")
def street_lamp(draw: Draw) -> Table:
    """Return a lamp on a pole with an emissive ball."""
    tall, metal = draw.number(2.6, 3.4), draw.grey(3)
    yield cone(0.1, 0.06, 0.4, 0.01, 32), 0.0, metal
    yield cylinder(0.04, tall - 0.7, 0.004, 24), 0.4, metal
    yield cone(0.06, 0.12, 0.06, 0.006, 32), tall - 0.3, metal
    yield sphere(0.17, 2), tall - 0.24, draw.grey(9), LAMP
