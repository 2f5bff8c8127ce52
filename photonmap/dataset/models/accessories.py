"""Potted plants and books, in metres."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, SceneObject
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    cylinder,
    lattice,
    parallelogram,
    smooth_normals,
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
