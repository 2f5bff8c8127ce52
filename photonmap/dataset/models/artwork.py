"""What pictures show: flat designs, cut along their outlines into parts of one chip each."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import Field, mondrian, patches, split, split_at_levels
from photonmap.dataset.models.scene_object import Part
from photonmap.dataset.models.shapes import Floats, Random, Shape, lattice, parallelogram
from photonmap.scene.material import Material

_CELL = 0.025
"""Side of the cells of a sheet that is cut along curves, metres."""

Design = Callable[[Random, Palette, float, float], list[Part]]
"""Makes what fills a width and a height, metres: from x = -width / 2 and y = 0, facing +z at z = 0.
"""


def artwork(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return one of the designs."""
    designs: Sequence[Design] = (rectangles, landscape, circles, stripes, blots)
    return designs[int(rng.integers(len(designs)))](rng, palette, width, height)


def rectangles(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return rectangles of several colours."""
    colors = [*palette.colors(5, (4, 8)), palette.grey(9), palette.grey(3)]
    return [
        Part(rectangle(x - 0.5 * width, y, w, h), palette.choice(colors))
        for x, y, w, h in mondrian(rng, width, height, 0.2 * min(width, height))
    ]


def landscape(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return hills behind each other, before a sky with a sun."""
    sky, parts = _sheet(width, height), list[Part]()
    hue = float(rng.uniform(0.0, 100.0))
    for index in range(int(rng.integers(2, 5))):
        base = height * (0.15 + 0.16 * index)
        hill, sky = split(sky, _below_hills(rng, base, 0.1 * height, width))
        value = 4 + index
        parts.append(Part(hill, palette.chip(hue + 8.0 * index, (value, value + 1), (4, 8), 6.0)))
    radius = float(rng.uniform(0.07, 0.14)) * min(width, height)
    spot = np.array([rng.uniform(-0.35, 0.35) * width, rng.uniform(0.72, 0.82) * height, 0.0])
    sun, sky = split(sky, lambda points: _away(points, spot) - radius)
    parts += [Part(sun, palette.chip(18.0, (7, 8), (8, 14), 6.0)), Part(sky, palette.pale())]
    return _filled(parts)


def circles(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return rings around a point."""
    spot = np.array([rng.uniform(-0.2, 0.2) * width, rng.uniform(0.35, 0.65) * height, 0.0])
    count = int(rng.integers(3, 7))
    step = 0.5 * max(width, height) / count * float(rng.uniform(0.8, 1.2))
    levels = [step * (number + 0.6) for number in range(count)]
    rings = split_at_levels(_sheet(width, height), lambda points: _away(points, spot), levels)
    return _dealt(rings, [*palette.colors(3), palette.pale()])


def stripes(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return slanting or upright stripes of uneven widths."""
    turn = float(rng.choice([0.0, 0.5, rng.uniform(0.1, 0.4)])) * np.pi
    along = np.array([np.cos(turn), np.sin(turn), 0.0])
    sheet = _sheet(width, height)
    far = np.sort(sheet.vertices @ along)
    levels = far[0] + np.ptp(far) * np.cumsum(rng.dirichlet(np.full(int(rng.integers(4, 9)), 3.0)))
    bands = split_at_levels(sheet, lambda points: points @ along, levels[:-1].tolist())
    return _dealt(bands, [*palette.colors(3), palette.grey(9), palette.pale()])


def blots(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return smooth patches of three or four colours."""
    count = int(rng.integers(3, 5))
    scale = float(rng.uniform(0.25, 0.5)) * min(width, height)
    shapes = patches(rng, _sheet(width, height), count, scale)
    return _dealt(shapes, palette.colors(count, (4, 8), 4.0))


def printed(rng: Random, palette: Palette, width: float, height: float) -> list[Part]:
    """Return a white sheet with a design, and lines of type below it."""
    edge, share = 0.07 * width, float(rng.uniform(0.55, 0.75))
    ink, low = palette.grey(3), (1.0 - share) * height
    parts = [Part(rectangle(-0.5 * width, 0.0, width, height), palette.grey(9))]
    shown = artwork(rng, palette, width - 2 * edge, share * height - edge)
    parts += [Part(part.shape.moved((0.0, low, 0.001)), part.material) for part in shown]
    y, line = low - 0.12 * low, 0.09 * low
    while y - line > 0.1 * low:
        long = float(rng.uniform(0.4, 1.0)) * (width - 2 * edge)
        mark = rectangle(-0.5 * width + edge, y - line, long, line).moved((0.0, 0.0, 0.001))
        parts.append(Part(mark, ink))
        y -= 1.9 * line
    return parts


def rectangle(x: float, y: float, width: float, height: float) -> Shape:
    """Return a rectangle from a corner (x, y) at z = 0, facing +z."""
    return parallelogram((x, y, 0.0), (width, 0.0, 0.0), (0.0, height, 0.0))


def _sheet(width: float, height: float) -> Shape:
    """Return a rectangle of small cells, so that it can be cut along curves."""
    columns, rows = (max(6, round(side / _CELL)) + 1 for side in (width, height))
    x, y = np.linspace(-0.5 * width, 0.5 * width, columns), np.linspace(0.0, height, rows)
    vertices = np.zeros((rows, columns, 3))
    vertices[..., 0], vertices[..., 1] = x, y[:, None]
    normals = np.tile((0.0, 0.0, 1.0), (rows * columns, 1))
    return Shape(vertices.reshape(-1, 3), lattice(rows, columns), normals)


def _below_hills(rng: Random, base: float, tall: float, width: float) -> Field:
    """Return a field that is negative below a wavy line."""
    waves, phase = rng.uniform(0.5, 2.0, 3), rng.uniform(0.0, 2.0 * np.pi, 3)

    def field(points: Floats) -> Floats:
        turns = 2.0 * np.pi * points[:, :1] / width * waves
        return points[:, 1] - base - tall * np.sin(turns + phase).mean(axis=1)

    return field


def _away(points: Floats, spot: Floats) -> Floats:
    return np.linalg.norm(points - spot, axis=1)


def _dealt(shapes: Sequence[Shape], colors: Sequence[Material]) -> list[Part]:
    return _filled([Part(each, colors[i % len(colors)]) for i, each in enumerate(shapes)])


def _filled(parts: Sequence[Part]) -> list[Part]:
    return [part for part in parts if len(part.shape.faces)]
