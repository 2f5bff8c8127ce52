"""Small sculptures: torus knots, superquadrics, pebbles; in metres."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.curved_shapes import knot, lump, superquadric
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import (
    checkerboard,
    height,
    patches,
    rings,
    split,
    split_at_levels,
    waves,
)
from photonmap.dataset.models.scene_object import SceneObject, multi_part, single_part
from photonmap.dataset.models.shapes import Random


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
