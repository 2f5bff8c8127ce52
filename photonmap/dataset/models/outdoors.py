"""What stands in gardens, on terraces and in streets, in metres, fronts towards +z."""

from __future__ import annotations

import math

import numpy as np

from photonmap.dataset.models.curved_shapes import Noise, sphere, tube
from photonmap.dataset.models.furniture import top_support
from photonmap.dataset.models.lamps import LAMP
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import (
    Part,
    Row,
    SceneObject,
    assembled,
    part_at,
)
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    cone,
    cylinder,
    joined,
    lathe,
    smooth_curve,
    smooth_normals,
)
from photonmap.dataset.models.vessels import COARSE, hollow
from photonmap.scene.material import Material

_GREEN = 38.0
"""Munsell hue of leaves."""


def leaf_green(palette: Palette) -> Material:
    """Draw a chip in a colour of leaves."""
    return palette.chip(_GREEN, (3, 6), (4, 8), 6.0)


def _foliage(rng: Random, radius: float, flat: float = 1.0) -> Shape:
    """Return a ball of leaves, roughly, around the origin."""
    ball = sphere(1.0, 4)
    points = ball.vertices - (0.0, 1.0, 0.0)
    rough = 0.1 * Noise(rng, 0.5)(points) + 0.09 * Noise(rng, 2.6, octaves=2)(points)
    points = radius * points * (1.0 + np.clip(rough, -0.3, 0.3))[:, None] * (1.0, flat, 1.0)
    return Shape(points, ball.faces, smooth_normals(points, ball.faces))


def tree(rng: Random, palette: Palette, tall: float) -> SceneObject:
    """Return a tree of about this height with a crown of three to five balls of leaves."""
    bark = palette.chip(18.0, (3, 5), (2, 4), 6.0)
    stem = float(rng.uniform(0.4, 0.55)) * tall
    bend = rng.uniform(-0.06, 0.06, (3, 2)) * tall
    bend[0] = 0.0
    path = [(x, y * stem, z) for (x, z), y in zip(bend, (0.0, 0.5, 1.15), strict=True)]
    trunk = tube(smooth_curve(path, 16), 0.028 * tall, 20).resting()
    greens, parts = [leaf_green(palette) for _ in range(2)], [Part(trunk, bark)]
    count, crown = int(rng.integers(3, 6)), 0.5 * (tall - stem)
    for index in range(count):
        turn, out = 2.0 * math.pi * (index + rng.random()) / count, 0.55 * crown * (index > 0)
        radius = crown * float(rng.uniform(0.6, 0.85))
        x, z = out * math.cos(turn), out * math.sin(turn)
        y = stem + crown * float(rng.uniform(0.75, 1.2))
        parts.append(part_at(_foliage(rng, radius), x, y, z, greens[index % 2]))
    return SceneObject("tree", parts)


def shrub(rng: Random, palette: Palette, size: float) -> SceneObject:
    """Return a shrub, perhaps with flowers."""
    leaves = _foliage(rng, size, float(rng.uniform(0.7, 1.0))).resting()
    parts = [Part(leaves, leaf_green(palette))]
    if rng.random() < 0.5:
        bloom, petal = palette.accent(), sphere(0.06 * size + 0.01, 1)
        chosen = leaves.vertices[np.unique(rng.integers(0, len(leaves.vertices), 40))]
        chosen = chosen[chosen[:, 1] > 0.5 * leaves.bounds[1, 1]]
        if len(chosen):
            lift = np.array([0.0, 0.03 * size, 0.0])
            parts.append(Part(joined([petal.moved(point - lift) for point in chosen]), bloom))
    return SceneObject("shrub", parts)


def planter(rng: Random, palette: Palette, width: float) -> SceneObject:
    """Return a box of earth with small shrubs in it."""
    tall, deep = float(rng.uniform(0.35, 0.5)), 0.38
    earth = palette.chip(18.0, (3, 3), (2, 2))
    parts = [
        Part(box(width, tall, deep, 0.01), palette.wood()),
        part_at(box(width - 0.05, 0.02, deep - 0.05), 0.0, tall, 0.0, earth),
    ]
    count = max(2, round(width / 0.28))
    for index in range(count):
        x = (index + 0.5) * width / count - 0.5 * width
        small = shrub(rng, palette, float(rng.uniform(0.11, 0.16)))
        parts += [part_at(p.shape, x, tall + 0.015, 0.0, p.material) for p in small.parts]
    return SceneObject("planter", parts)


def parasol(rng: Random, palette: Palette) -> SceneObject:
    """Return a parasol in eight gores of two colours."""
    radius, tall, sides = float(rng.uniform(1.1, 1.4)), float(rng.uniform(2.3, 2.6)), 8
    colors = (palette.accent(), palette.pale())
    parts = [
        Part(cylinder(0.24, 0.09, 0.02, 40), palette.grey(4)),
        part_at(cylinder(0.022, tall - 0.09, 0.003, 20), 0.0, 0.09, 0.0, palette.wood()),
    ]
    edge = tall - 0.42
    for index in range(sides):
        first, last = (2.0 * math.pi * (index + k) / sides for k in (0, 1))
        rim = [(radius * math.cos(t), edge, radius * math.sin(t)) for t in (first, last)]
        vertices = np.array([(0.0, tall - 0.06, 0.0), *rim])
        normal = np.cross(vertices[2] - vertices[0], vertices[1] - vertices[0])
        normals = np.tile(normal / np.linalg.norm(normal), (3, 1))
        parts.append(Part(Shape(vertices, np.array([[0, 2, 1]]), normals), colors[index % 2]))
    return SceneObject("parasol", parts)


def street_lamp(palette: Palette, tall: float) -> SceneObject:
    """Return a lamp on a pole with an emissive ball."""
    metal = palette.grey(3)
    parts = [
        Part(cone(0.1, 0.06, 0.4, 0.01, 32), metal),
        part_at(cylinder(0.04, tall - 0.7, 0.004, 24), 0.0, 0.4, 0.0, metal),
        part_at(cone(0.06, 0.12, 0.06, 0.006, 32), 0.0, tall - 0.3, 0.0, metal),
        Part(sphere(0.17, 2).moved((0.0, tall - 0.24, 0.0)), palette.grey(9), LAMP),
    ]
    return SceneObject("street lamp", parts)


def bollard(palette: Palette) -> SceneObject:
    """Return a low lamp with an emissive ring below its cap."""
    metal = palette.grey(4)
    ring = lathe([(0.07, 0.0), (0.07, 0.14)], segments=32)
    parts = [
        Part(cylinder(0.075, 0.62, 0.006, 40), metal),
        Part(ring.moved((0.0, 0.62, 0.0)), palette.grey(9), LAMP),
        part_at(cylinder(0.075, 0.08, 0.01, 40), 0.0, 0.76, 0.0, metal),
    ]
    return SceneObject("bollard", parts)


def wall_lantern(palette: Palette) -> SceneObject:
    """Return a lantern on a bracket, its back at z = 0."""
    metal = palette.grey(3)
    parts = [
        part_at(box(0.1, 0.22, 0.02), 0.0, 0.0, 0.01, metal),
        part_at(box(0.03, 0.03, 0.12), 0.0, 0.16, 0.07, metal),
        part_at(cone(0.11, 0.03, 0.08, 0.006, 32), 0.0, 0.13, 0.16, metal),
        Part(cone(0.05, 0.085, 0.15, 0.006, 24).moved((0.0, -0.02, 0.16)), palette.grey(9), LAMP),
    ]
    return SceneObject("wall lantern", parts)


def litter_bin(rng: Random, palette: Palette) -> SceneObject:
    """Return a litter bin."""
    outer = smooth_curve([(0.17, 0.0), (0.18, 0.02), (0.2, 0.4), (0.22, 0.75)], 14)
    shape = hollow(outer, 0.01, 0.015, COARSE.segments)
    return SceneObject("bin", [Part(shape, palette.glazed(palette.accent()))])


def garden_table(palette: Palette) -> SceneObject:
    """Return a table of slats."""
    wide, deep, tall, wood, count = 1.3, 0.8, 0.73, palette.wood(), 7
    slat = box(wide, 0.03, deep / count - 0.012, 0.004)
    leg = (0.5 * wide - 0.1, 0.0, 0.5 * deep - 0.1)
    rows: list[Row] = [(box(0.06, tall - 0.03, 0.06), leg, wood, "xz")]
    rows += [
        (slat, (0.0, tall - 0.03, ((index + 0.5) / count - 0.5) * deep), wood)
        for index in range(count)
    ]
    return assembled("garden table", rows, [top_support(wide, deep, tall)])
