"""Floors, walls, ceiling and skirting of a room."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, SceneObject
from photonmap.dataset.models.shapes import Random, Shape, box, parallelogram, rotation
from photonmap.scene.material import Material

BACK, LEFT, FRONT, RIGHT = "back", "left", "front", "right"
TURNS = {BACK: 0.0, LEFT: 90.0, FRONT: 180.0, RIGHT: -90.0}
"""Rotation about y, degrees, that makes an object that faces +z stand with its back to a wall."""
_SKIRTING = (0.09, 0.014)
"""Height and thickness of the skirting board, metres."""

Size = NDArray[np.float64]
Opening = tuple[float, float, float, float]
"""Of a window: its middle along the wall, sill, width and height, metres."""
Floor = Callable[[Random, Palette, Size], SceneObject]
"""Makes a floor for a room of a size along x, y and z, metres."""


def length_of(wall: str, size: Size) -> float:
    """Return the length of a wall, metres."""
    return float(size[0 if wall in (BACK, FRONT) else 2])


def in_front_of(wall: str, size: Size, along: float, gap: float) -> tuple[float, float]:
    """Return x and z at a distance from a wall, `along` metres right of its middle."""
    half = 0.5 * float(size[2 if wall in (BACK, FRONT) else 0])
    x, _, z = rotation(TURNS[wall], 1) @ np.array([along, 0.0, gap - half])
    return float(x), float(z)


def ceiling(palette: Palette, size: Size) -> SceneObject:
    """Return the ceiling."""
    w, h, d = size
    shape = parallelogram((-w / 2, h, -d / 2), (w, 0.0, 0.0), (0.0, 0.0, d))
    return SceneObject("ceiling", [Part(shape, palette.grey(7))])


def walls(
    materials: Sequence[Material], size: Size, windows: Mapping[str, Sequence[Opening]]
) -> SceneObject:
    """Return the walls: one of the first material, the others of the second."""
    parts = []
    for wall, turn in TURNS.items():
        x, z = in_front_of(wall, size, 0.0, 0.0)
        material = materials[0 if wall == BACK else 1]
        pieces = wall_pieces(length_of(wall, size), float(size[1]), windows.get(wall, ()))
        parts += [Part(piece.turned(turn).moved((x, 0.0, z)), material) for piece in pieces]
    return SceneObject("walls", parts)


def wall_pieces(length: float, tall: float, windows: Sequence[Opening]) -> list[Shape]:
    """Return a wall at z = 0 as rectangles around its windows."""
    pieces, at = [], -0.5 * length
    for along, low, width, height in sorted(windows):
        left, right = along - 0.5 * width, along + 0.5 * width
        pieces += [(at, 0.0, left - at, tall), (left, 0.0, width, low)]
        pieces.append((left, low + height, width, tall - low - height))
        at = right
    pieces.append((at, 0.0, 0.5 * length - at, tall))
    return [parallelogram((u, v, 0.0), (w, 0.0, 0.0), (0.0, h, 0.0)) for u, v, w, h in pieces]


def skirting(palette: Palette, size: Size) -> SceneObject:
    """Return the skirting board along all walls."""
    tall, thick = _SKIRTING
    parts = []
    for wall, turn in TURNS.items():
        long = length_of(wall, size) - 2.0 * thick
        x, z = in_front_of(wall, size, 0.0, 0.5 * thick)
        shape = box(long, tall, thick, 0.004).turned(turn).moved((x, 0.0, z))
        parts.append(Part(shape, palette.grey(8)))
    return SceneObject("skirting", parts)


def planks(rng: Random, palette: Palette, size: Size) -> SceneObject:
    """Return a floor of planks in three similar colours, in staggered rows along x or z."""
    hue, value = float(rng.uniform(15.0, 21.0)), int(rng.integers(4, 7))
    chips = [palette.chip(hue, (value, value + 1), (4, 4), 3.0) for _ in range(3)]
    colors = [palette.varnished(palette.patterned("wood", chip)) for chip in chips]
    across, wide, long = rng.random() < 0.5, rng.uniform(0.1, 0.24), rng.uniform(0.9, 2.0)
    width, depth = (size[2], size[0]) if across else (size[0], size[2])
    rows = math.ceil(width / wide)
    wide, parts = width / rows, []
    for row in range(rows):
        ends = np.arange(-depth / 2 - rng.uniform(0.0, long), depth / 2, long)
        ends = ends[(ends > -depth / 2 + 0.05) & (ends < depth / 2 - 0.05)]
        for low, high in pairwise([-depth / 2, *ends.tolist(), depth / 2]):
            corner = (-width / 2 + row * wide, 0.0, high)
            shape = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, low - high))
            parts.append(Part(shape.turned(90.0) if across else shape, palette.choice(colors)))
    return SceneObject("floor", parts)


def tiles(rng: Random, palette: Palette, size: Size) -> SceneObject:
    """Return a floor of tiles: checked, striped, or of one colour with a few of another."""
    width, _, depth = size
    side, kind = float(rng.uniform(0.2, 0.6)), int(rng.integers(3))
    columns, rows = round(width / side), round(depth / side)
    chips = (palette.chip(None, (7, 8), (2, 4)), palette.chip(None, (4, 6), (2, 6)))
    colors = [palette.varnished(palette.patterned("marble", chip)) for chip in chips]
    wide, deep = width / columns, depth / rows
    sparse = rng.random((columns, rows)) < 0.15
    parts = []
    for i in range(columns):
        for k in range(rows):
            corner = (i * wide - width / 2, 0.0, (k + 1) * deep - depth / 2)
            shape = parallelogram(corner, (wide, 0.0, 0.0), (0.0, 0.0, -deep))
            parts.append(Part(shape, colors[((i + k) % 2, i % 2, int(sparse[i, k]))[kind]]))
    return SceneObject("floor", parts)


def plain(rng: Random, palette: Palette, size: Size) -> SceneObject:
    """Return a floor of one colour."""
    width, _, depth = size
    shape = parallelogram((-width / 2, 0.0, depth / 2), (width, 0.0, 0.0), (0.0, 0.0, -depth))
    value = int(rng.integers(4, 7))
    color = (
        palette.chip(None, (value, value + 1), (2, 4))
        if rng.random() < 0.6
        else palette.grey(value)
    )
    material = palette.varnished(palette.patterned("marble", color))
    return SceneObject("floor", [Part(shape, material)])
