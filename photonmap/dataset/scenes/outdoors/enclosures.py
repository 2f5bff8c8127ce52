"""What encloses a place outdoors: house fronts, hedges, fences and walls; and its ground."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from photonmap.dataset.models.curved_shapes import Noise
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.places.outdoors import leaf_green
from photonmap.dataset.models.scene_object import Part
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    lattice,
    parallelogram,
    smooth_normals,
)
from photonmap.dataset.scenes.rooms.shell import Size

MakeGround = Callable[[Random, Palette, Size], list[Part]]
"""Makes the ground of a place of a size along x, y and z, metres."""
MakeSide = Callable[[Random, Palette, float], list[Part]]
"""Makes one side of a place, of a length, its inner face at z = 0 and around x = 0."""


def hedge(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a trimmed hedge."""
    tall, rows = float(rng.uniform(1.4, 2.2)), 24
    columns = max(8, round(length / 0.08))
    across, up = np.meshgrid(
        np.linspace(-0.5 * length, 0.5 * length, columns), np.linspace(0.0, tall, rows)
    )
    points = np.stack([across, up, np.zeros_like(up)], axis=-1).reshape(-1, 3)
    depth = 0.035 * Noise(rng, 1.3, octaves=4)(points)
    points[:, 2] = np.minimum(depth - 0.08, -0.005)
    faces = lattice(rows, columns)
    front = Shape(points, faces, smooth_normals(points, faces))
    top = box(length, 0.04, 0.6, 0.01).moved((0.0, tall - 0.05, -0.36))
    return [Part(front, leaf_green(palette)), Part(top, leaf_green(palette))]


def fence(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a fence of boards, every other one set back, on two rails."""
    tall, count = float(rng.uniform(1.5, 2.0)), max(6, round(length / 0.14))
    wide, woods = length / count, [palette.wood(), palette.wood()]
    parts = []
    for index in range(count):
        x = (index + 0.5) * wide - 0.5 * length
        board = box(wide - 0.008, tall, 0.02, 0.003, 1)
        parts.append(Part(board.moved((x, 0.0, -0.012 - 0.022 * (index % 2))), woods[index % 2]))
    back = box(length, tall - 0.04, 0.02, 0.003, 1).moved((0.0, 0.0, -0.06))
    return [*parts, Part(back, woods[0])]


def brick_wall(rng: Random, palette: Palette, length: float) -> list[Part]:
    """Return a wall of courses of bricks in three similar colours, joints painted like them."""
    tall = float(rng.uniform(1.5, 2.4))
    hue = float(rng.uniform(8.0, 16.0))
    colors = [palette.chip(hue, (4, 6), (4, 6), 3.0) for _ in range(3)]
    wide, high = 0.3, 0.12
    parts, rows = [], round(tall / high)
    for row in range(rows):
        shift = 0.5 * wide * (row % 2)
        ends = np.arange(-0.5 * length + shift, 0.5 * length, wide)
        ends = np.unique(np.clip([-0.5 * length, *ends, 0.5 * length], -0.5 * length, 0.5 * length))
        for left, right in pairwise(ends.tolist()):
            brick = parallelogram(
                (left, row * tall / rows, 0.0),
                (right - left, 0.0, 0.0),
                (0.0, tall / rows, 0.0),
            )
            parts.append(Part(brick, palette.choice(colors)))
    return parts


def lawn(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return a lawn with a path of slabs that leads across."""
    width, _, depth = size
    path, parts = float(rng.uniform(0.8, 1.2)), list[Part]()
    x = float(rng.uniform(-0.2, 0.2)) * width
    green, stone = leaf_green(palette), [palette.grey(6), palette.chip(None, (6, 7), (2, 2))]
    for low, high in ((-0.5 * width, x - 0.5 * path), (x + 0.5 * path, 0.5 * width)):
        grass = parallelogram((low, 0.0, 0.5 * depth), (high - low, 0.0, 0.0), (0.0, 0.0, -depth))
        parts.append(Part(grass, green))
    count = math.ceil(depth / 0.6)
    for index in range(count):
        start = 0.5 * depth - index * depth / count
        slab = parallelogram(
            (x - 0.5 * path, 0.0, start), (path, 0.0, 0.0), (0.0, 0.0, -depth / count)
        )
        parts.append(Part(slab, stone[index % 2]))
    return parts


def paving(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return slabs in three similar colours."""
    width, _, depth = size
    side = float(rng.uniform(0.35, 0.6))
    columns, rows = round(width / side), round(depth / side)
    hue = float(rng.uniform(0.0, 100.0))
    colors = [palette.chip(hue, (5, 7), (2, 2), 8.0) for _ in range(2)] + [palette.grey(6)]
    wide, deep = width / columns, depth / rows
    parts = []
    for i in range(columns):
        for k in range(rows):
            corner = (i * wide - 0.5 * width, 0.0, (k + 1) * deep - 0.5 * depth)
            slab = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, -deep))
            parts.append(Part(slab, palette.choice(colors)))
    return parts


def road(rng: Random, palette: Palette, size: Size) -> list[Part]:
    """Return a road along x with a broken line, between two pavements with kerbs."""
    width, _, depth = size
    edge, kerb = 0.5 * depth - float(rng.uniform(1.6, 2.2)), 0.14
    stone, rim, asphalt = palette.chip(None, (5, 7), (2, 2)), palette.grey(7), palette.grey(3)
    paint, wide = palette.grey(9), 0.12
    lines = [-0.5 * depth, -edge - kerb, -edge, -0.5 * wide, 0.5 * wide, edge, edge + kerb]
    strips = [stone, rim, asphalt, None, asphalt, rim, stone]
    parts = []
    for low, high, material in zip(lines, [*lines[1:], 0.5 * depth], strips, strict=True):
        count = 1 if material else max(2, round(width / 0.9))
        for index in range(count):
            start, long = (index / count - 0.5) * width, width / count
            piece = parallelogram((start, 0.0, high), (long, 0.0, 0.0), (0.0, 0.0, low - high))
            parts.append(Part(piece, material or (paint if index % 2 else asphalt)))
    return parts
