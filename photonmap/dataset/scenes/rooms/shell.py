"""Floors, walls, ceiling and skirting of a room."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.scene_object import SceneObject, Table, model
from photonmap.dataset.models.shapes import Shape, box, level, parallelogram, rotation, upright
from photonmap.scene.material import Material

BACK, LEFT, FRONT, RIGHT = "back", "left", "front", "right"
TURNS = {BACK: 0.0, LEFT: 90.0, FRONT: 180.0, RIGHT: -90.0}
"""Rotation about y, degrees, that makes an object that faces +z stand with its back to a wall."""
_SKIRTING = (0.09, 0.014)  # height and thickness of the skirting board, metres

Size = NDArray[np.float64]
Opening = tuple[float, float, float, float]
"""Of a window: its middle along the wall, sill, width and height, metres."""
Floor = Callable[[Draw, Size], SceneObject]
"""Makes a floor for a room of a size along x, y and z, metres."""


def length_of(wall: str, size: Size) -> float:
    """Return the length of a wall, metres."""
    return float(size[0 if wall in (BACK, FRONT) else 2])


def in_front_of(wall: str, size: Size, along: float, gap: float) -> tuple[float, float]:
    """Return x and z at a distance from a wall, `along` metres right of its middle."""
    half = 0.5 * float(size[2 if wall in (BACK, FRONT) else 0])
    x, _, z = rotation(TURNS[wall], 1) @ np.array([along, 0.0, gap - half])
    return float(x), float(z)


@model("ceiling")
def ceiling(draw: Draw, size: Size) -> Table:
    """Return the ceiling."""
    w, h, d = size
    yield parallelogram((-w / 2, h, -d / 2), (w, 0.0, 0.0), (0.0, 0.0, d)), 0.0, draw.grey(7)


@model("walls")
def walls(
    materials: Sequence[Material], size: Size, windows: Mapping[str, Sequence[Opening]]
) -> Table:
    """Return the walls: one of the first material, the others of the second."""
    for wall, turn in TURNS.items():
        x, z = in_front_of(wall, size, 0.0, 0.0)
        material = materials[0 if wall == BACK else 1]
        for piece in wall_pieces(length_of(wall, size), float(size[1]), windows.get(wall, ())):
            yield piece.turned(turn), (x, 0.0, z), material


def wall_pieces(length: float, tall: float, windows: Sequence[Opening]) -> list[Shape]:
    """Return a wall at z = 0 as rectangles around its windows."""
    pieces, at = [], -0.5 * length
    for along, low, width, height in sorted(windows):
        left, right = along - 0.5 * width, along + 0.5 * width
        pieces += [(at, 0.0, left - at, tall), (left, 0.0, width, low)]
        pieces.append((left, low + height, width, tall - low - height))
        at = right
    pieces.append((at, 0.0, 0.5 * length - at, tall))
    return [upright(*piece) for piece in pieces]


@model("skirting")
def skirting(draw: Draw, size: Size) -> Table:
    """Return the skirting board along all walls."""
    tall, thick = _SKIRTING
    for wall, turn in TURNS.items():
        x, z = in_front_of(wall, size, 0.0, 0.5 * thick)
        board = box(length_of(wall, size) - 2.0 * thick, tall, thick, 0.004)
        yield board.turned(turn), (x, 0.0, z), draw.grey(8)


@model("floor")
def planks(draw: Draw, size: Size) -> Table:
    """Return a floor of planks in three similar colours, in staggered rows along x or z."""
    hue, value = draw.number(15.0, 21.0), draw.whole(4, 6)
    chips = [draw.chip(hue, (value, value + 1), (4, 4), 3.0) for _ in range(3)]
    colors = [draw.varnished(draw.patterned("wood", chip)) for chip in chips]
    across, wide, long = draw.chance(0.5), draw.number(0.1, 0.24), draw.number(0.9, 2.0)
    width, depth = (size[2], size[0]) if across else (size[0], size[2])
    rows = math.ceil(width / wide)
    wide = width / rows
    for row in range(rows):
        ends = np.arange(-depth / 2 - draw.number(0.0, long), depth / 2, long)
        ends = ends[(ends > -depth / 2 + 0.05) & (ends < depth / 2 - 0.05)]
        for low, high in pairwise([-depth / 2, *ends.tolist(), depth / 2]):
            plank = level(-width / 2 + row * wide, high, wide, high - low)
            yield plank.turned(90.0) if across else plank, 0.0, draw.material_among(colors)


@model("floor")
def tiles(draw: Draw, size: Size) -> Table:
    """Return a floor of tiles: checked, striped, or of one colour with a few of another."""
    side, kind = draw.number(0.2, 0.6), draw.whole(0, 2)
    chips = draw.chip(None, (7, 8), (2, 4)), draw.chip(None, (4, 6), (2, 6))
    colors = [draw.varnished(draw.patterned("marble", chip)) for chip in chips]
    columns, rows, slabs = slabs_of(size, side)
    sparse = draw.rng.random((columns, rows)) < 0.15
    for (i, k), slab in zip(np.ndindex(columns, rows), slabs, strict=True):
        yield slab, 0.0, colors[((i + k) % 2, i % 2, int(sparse[i, k]))[kind]]


@model("floor")
def plain(draw: Draw, size: Size) -> Table:
    """Return a floor of one colour."""
    width, _, depth = size
    value, grey = draw.whole(4, 6), not draw.chance(0.6)
    color = draw.grey(value) if grey else draw.chip(None, (value, value + 1), (2, 4))
    floor = level(-width / 2, depth / 2, width, depth)
    yield floor, 0.0, draw.varnished(draw.patterned("marble", color))


def slabs_of(size: Size, side: float) -> tuple[int, int, list[Shape]]:
    """Cover a floor with slabs of about a side, metres; return columns, rows, and each slab."""
    width, _, depth = size
    columns, rows = round(width / side), round(depth / side)
    wide, deep = width / columns, depth / rows
    return (
        columns,
        rows,
        [
            level(i * wide - 0.5 * width, (k + 1) * deep - 0.5 * depth, wide, deep)
            for i, k in np.ndindex(columns, rows)
        ],
    )
