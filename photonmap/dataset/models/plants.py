"""Plants, in metres: pot plants, trees, shrubs and boxes of them."""

from __future__ import annotations

import math

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import Table, model
from photonmap.dataset.models.shapes import (
    Noise,
    Random,
    Shape,
    box,
    cylinder,
    grid,
    joined,
    smooth_curve,
    sphere,
    tube,
)
from photonmap.dataset.models.small_objects import pot_shape


@model("plant")
def plant(draw: Draw, tall: float) -> Table:
    """Return a potted plant with long leaves that bend outwards, about `tall` metres high."""
    pot, inside = pot_shape(draw.rng, 0.32 * tall), 0.27 * tall
    greens = [draw.chip(38.0, (4, 6), (4, 8), 6.0) for _ in range(3)]
    yield pot, 0.0, draw.chip(12.0, (4, 6), (6, 10))
    yield cylinder(0.125 * tall, 0.02, 0.004, 32), inside - 0.02, draw.chip(18.0, (3, 3), (2, 2))
    for index in range(13):
        yield _leaf(draw, tall - inside).turned(index * 137.5), inside, greens[index % 3]


def _leaf(draw: Draw, tall: float) -> Shape:
    """Return a thin leaf that rises from the origin and bends towards +x."""
    t = np.linspace(0.0, 1.0, 16)
    lean, rise = draw.number(0.1, 0.42) * tall, draw.number(0.75, 1.0) * tall
    x = 0.02 + lean * t**1.6
    y = rise * (t - 0.22 * (lean / tall) * t**3)
    wide = 0.075 * tall * np.sin(np.pi * np.clip(0.06 + 0.94 * t, 0.0, 0.995)) ** 0.8
    ribs = [np.stack([x - 0.25 * wide * (k == 0), y, k * wide], axis=1) for k in (-1, 0, 1)]
    return grid(np.stack(ribs, axis=1))


def _foliage(rng: Random, radius: float, flat: float = 1.0) -> Shape:
    """Return a ball of leaves, roughly, around the origin."""
    ball = sphere(1.0, 4)
    points = ball.vertices - (0.0, 1.0, 0.0)
    rough = 0.1 * Noise(rng, 0.5)(points) + 0.09 * Noise(rng, 2.6, octaves=2)(points)
    points = radius * points * (1.0 + np.clip(rough, -0.3, 0.3))[:, None] * (1.0, flat, 1.0)
    return Shape.smooth(points, ball.faces)


@model("tree")
def tree(draw: Draw, tall: float) -> Table:
    """Return a tree of about this height with a crown of three to five balls of leaves."""
    bark, stem = draw.chip(18.0, (3, 5), (2, 4), 6.0), draw.number(0.4, 0.55) * tall
    bend = draw.rng.uniform(-0.06, 0.06, (3, 2)) * tall
    bend[0] = 0.0
    path = [(x, y * stem, z) for (x, z), y in zip(bend, (0.0, 0.5, 1.15), strict=True)]
    trunk = tube(smooth_curve(path, 16), 0.028 * tall, 20).resting()
    yield trunk, 0.0, bark
    greens = [draw.leaf() for _ in range(2)]
    count, crown = draw.whole(3, 5), 0.5 * (tall - stem)
    for index in range(count):
        turn, out = 2.0 * math.pi * (index + draw.rng.random()) / count, 0.55 * crown * (index > 0)
        radius = crown * draw.number(0.6, 0.85)
        y = stem + crown * draw.number(0.75, 1.2)
        at = out * math.cos(turn), y, out * math.sin(turn)
        yield _foliage(draw.rng, radius), at, greens[index % 2]


@model("shrub")
def shrub(draw: Draw, size: float) -> Table:
    """Return a shrub, perhaps with flowers."""
    leaves = _foliage(draw.rng, size, draw.number(0.7, 1.0)).resting()
    yield leaves, 0.0, draw.leaf()
    if draw.chance(0.5):
        bloom, petal = draw.accent(), sphere(0.06 * size + 0.01, 1)
        chosen = leaves.vertices[np.unique(draw.rng.integers(0, len(leaves.vertices), 40))]
        chosen = chosen[chosen[:, 1] > 0.5 * leaves.bounds[1, 1]]
        lift = np.array([0.0, 0.03 * size, 0.0])
        if len(chosen):
            yield joined([petal.moved(point - lift) for point in chosen]), 0.0, bloom


@model("planter")
def planter(draw: Draw, width: float) -> Table:
    """Return a box of earth with small shrubs in it."""
    tall, deep, earth = draw.number(0.35, 0.5), 0.38, draw.chip(18.0, (3, 3), (2, 2))
    yield box(width, tall, deep, 0.01), 0.0, draw.wood()
    yield box(width - 0.05, 0.02, deep - 0.05), tall, earth
    count = max(2, round(width / 0.28))
    for x in (np.arange(count) + 0.5) * width / count - 0.5 * width:
        yield shrub(draw, draw.number(0.11, 0.16)).parts, (x, tall + 0.015, 0.0)
