"""What stands in classrooms, cafes and corridors, in metres, fronts towards +z."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.curved_shapes import sphere, superquadric
from photonmap.dataset.models.garments import SPACING, garment
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import patches
from photonmap.dataset.models.scene_object import (
    Part,
    Row,
    SceneObject,
    Support,
    assembled,
    part_at,
)
from photonmap.dataset.models.shapes import (
    Random,
    box,
    cylinder,
    parallelogram,
    smooth_curve,
    torus,
)
from photonmap.dataset.models.vessels import COARSE, hollow


def blackboard(rng: Random, palette: Palette, width: float) -> SceneObject:
    """Return a board with chalk marks and a ledge, its back at z = 0 and its foot at y = 0."""
    tall, bar, frame = 1.1, 0.05, palette.wood()
    slate = palette.chip(45.0, (3, 3), (2, 4), 8.0) if rng.random() < 0.6 else palette.grey(2)
    parts = [part_at(box(width - 0.02, tall - 0.02, 0.02), 0.0, 0.01, 0.012, slate)]
    across = box(width, bar, 0.03)
    parts += [part_at(across, 0.0, y, 0.015, frame) for y in (0.0, tall - bar)]
    upright = box(bar, tall - 2 * bar, 0.03)
    parts += [part_at(upright, i * 0.5 * (width - bar), bar, 0.015, frame) for i in (-1, 1)]
    parts.append(part_at(box(width, 0.02, 0.09), 0.0, 0.0, 0.075, frame))
    chalks = [palette.grey(9), palette.pale(), palette.pale()]
    y, front = tall - 0.2, 0.0225
    while y > 0.2:
        x = -0.5 * width + 0.15
        while (long := float(rng.uniform(0.05, 0.3))) + x < 0.5 * width - 0.15:
            tilt = float(rng.uniform(-0.01, 0.01))
            stroke = parallelogram((x, y, front), (long, tilt, 0.0), (0.0, 0.018, 0.0))
            parts.append(Part(stroke, palette.choice(chalks)))
            x += long + float(rng.uniform(0.03, 0.4))
        y -= float(rng.uniform(0.09, 0.16))
    return SceneObject("blackboard", parts)


def globe(rng: Random, palette: Palette) -> SceneObject:
    """Return a globe on a foot."""
    radius, metal = float(rng.uniform(0.1, 0.15)), palette.metal()
    ball = sphere(radius, 4)
    sea, land = palette.chip(68.0, (4, 6), (6, 10), 5.0), palette.chip(35.0, (5, 7), (4, 8), 6.0)
    pieces = patches(rng, ball, 3, 1.2 * radius)
    colors = (sea, land, palette.pale())
    lift = 0.1
    parts = [part_at(piece, 0.0, lift, 0.0, m) for piece, m in zip(pieces, colors, strict=True)]
    parts.append(Part(cylinder(0.6 * radius, 0.02, 0.006, 32), palette.wood()))
    parts.append(part_at(cylinder(0.01, lift - 0.01, 0.002, 16), 0.0, 0.015, 0.0, metal))
    hoop = torus(1.08 * radius, 0.006, 48).turned(90.0, 0)
    parts.append(part_at(hoop, 0.0, lift + radius, 0.0, metal))
    return SceneObject("globe", parts)


def counter(rng: Random, palette: Palette, width: float) -> SceneObject:
    """Return a counter: boards in front, a top that juts out, a lower one behind."""
    tall, deep = 1.05, 0.55
    wood, top = palette.wood(), palette.glazed(palette.wood())
    front = (palette.chip(None, (4, 7), (2, 8)), palette.pale())
    parts = [part_at(box(width, tall - 0.05, 0.3), 0.0, 0.0, 0.05, wood)]
    count = max(3, round(width / 0.16))
    wide = width / count
    for index in range(count):
        board = box(wide - 0.008, tall - 0.2, 0.018)
        x = (index + 0.5) * wide - 0.5 * width
        parts.append(part_at(board, x, 0.1, 0.209, front[index % 2]))
    parts.append(part_at(box(width + 0.06, 0.05, deep, 0.012), 0.0, tall - 0.05, 0.0, top))
    x, z = 0.5 * width - 0.02, 0.5 * deep - 0.03
    return SceneObject("counter", parts, [Support((-x, x), (-z, z), tall)])


def bar_stool(palette: Palette) -> SceneObject:
    """Return a tall stool on one leg."""
    metal = palette.metal()
    parts = [
        Part(cylinder(0.2, 0.02, 0.008, 40), metal),
        part_at(cylinder(0.025, 0.68, 0.004, 20), 0.0, 0.02, 0.0, metal),
        part_at(torus(0.15, 0.01, 36), 0.0, 0.26, 0.0, metal),
        part_at(box(0.3, 0.012, 0.014, 0.004), 0.0, 0.264, 0.0, metal),
        part_at(cylinder(0.19, 0.07, 0.03, 40), 0.0, 0.7, 0.0, palette.accent()),
    ]
    return SceneObject("bar stool", parts)


def coat_rack(rng: Random, palette: Palette, width: float) -> SceneObject:
    """Return a board with hooks and garments on most, its back at z = 0 and its foot at y = 0."""
    high, metal = 1.2, palette.metal()
    parts = [part_at(box(width, 0.12, 0.02), 0.0, high, 0.01, palette.wood())]
    count = max(2, int(width / SPACING))
    for index in range(count):
        x = (index + 0.5) * width / count - 0.5 * width
        hook = box(0.02, 0.03, 0.09, 0.006)
        parts.append(part_at(hook, x, high + 0.05, 0.065, metal))
        if rng.random() < 0.75:
            place = x, high + 0.07, 0.085
            parts += [part_at(p.shape, *place, p.material) for p in garment(rng, palette)]
    return SceneObject("coat rack", parts)


def bench(palette: Palette, width: float) -> SceneObject:
    """Return a bench of slats."""
    wood, metal, x = palette.glazed(palette.wood()), palette.grey(3), 0.5 * width - 0.12
    slat = box(width, 0.03, 0.1, 0.006)
    rows: list[Row] = [(slat, (0.0, 0.42, 0.12 * k), wood) for k in (-1, 0, 1)]
    for at in (-x, x):
        rows.append((box(0.05, 0.03, 0.36), (at, 0.39, 0.0), metal))
        rows.append((box(0.05, 0.39, 0.05), (at, 0.0, 0.14), metal, "z"))
    half = 0.5 * width - 0.03
    return assembled("bench", rows, [Support((-half, half), (-0.15, 0.15), 0.45)])


def shoes(rng: Random, palette: Palette) -> SceneObject:
    """Return a pair of shoes."""
    leather, sole = palette.fabric(), palette.grey(3)
    rows: list[Row] = []
    for x in (-0.06, 0.06):
        rows.append((superquadric((0.09, 0.02, 0.27), 0.3, 0.8, 16, 32), (x, 0.0, 0.0), sole))
        rows.append((superquadric((0.085, 0.1, 0.26), 0.9, 0.8, 24, 36), (x, 0.015, 0.0), leather))
    return assembled("shoes", rows)


def umbrella_stand(rng: Random, palette: Palette) -> SceneObject:
    """Return a tall pot with furled umbrellas."""
    outer = smooth_curve([(0.1, 0.0), (0.11, 0.02), (0.12, 0.25), (0.13, 0.5)], 14)
    parts = [Part(hollow(outer, 0.008, 0.012, COARSE.segments), palette.glazed(palette.accent()))]
    for turn in rng.uniform(0.0, 360.0, int(rng.integers(1, 4))):
        x, z = 0.05 * np.cos(np.radians(turn)), 0.05 * np.sin(np.radians(turn))
        long = float(rng.uniform(0.6, 0.8))
        parts.append(part_at(cylinder(0.022, long, 0.01, 16), x, 0.012, z, palette.fabric()))
        parts.append(part_at(cylinder(0.008, 0.12, 0.003, 12), x, 0.012 + long, z, palette.wood()))
    return SceneObject("umbrella stand", parts)


def pupils_table(palette: Palette) -> SceneObject:
    """Return a table for two with steel legs."""
    top, metal = palette.glazed(palette.wood()), palette.grey(4)
    wide, deep, tall = 1.2, 0.5, 0.72
    x, z = 0.5 * wide - 0.06, 0.5 * deep - 0.05
    rows: list[Row] = [
        (cylinder(0.018, tall - 0.03, 0.003, 16), (x, 0.0, z), metal, "xz"),
        (box(0.02, 0.03, 2 * z), (x, tall - 0.06, 0.0), metal, "x"),
        (box(wide, 0.03, deep, 0.01), (0.0, tall - 0.03, 0.0), top),
    ]
    return assembled("table", rows, [Support((-0.55, 0.55), (-0.21, 0.21), tall)])


def sofa_bench(palette: Palette, width: float) -> SceneObject:
    """Return an upholstered bench with a back."""
    cloth = palette.patterned("cloth", palette.chip(None, (4, 6), (4, 8)))
    wood = palette.wood()
    parts = [
        part_at(box(width - 0.06, 0.32, 0.42), 0.0, 0.0, 0.02, wood),
        part_at(box(width, 0.14, 0.5, 0.05, 4), 0.0, 0.32, 0.02, cloth),
        part_at(box(width, 0.55, 0.12, 0.05, 4), 0.0, 0.46, -0.17, cloth),
    ]
    return SceneObject("sofa bench", parts)
