"""What hangs on hooks, in metres: coats, jackets, scarves and bags; and the rack with the hooks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.patterns import banded
from photonmap.dataset.models.scene_object import Part, Row, Table, dealt, model, placed
from photonmap.dataset.models.shapes import Floats, Shape, box, grid, smooth_curve, sphere, tube

SPACING = 0.36
"""Least distance between hooks, metres, at which what hangs there does not touch."""
_ROWS, _COLUMNS = 48, 80
_BACK = -0.07  # where the wall stops what hangs, metres behind its middle


def garment(draw: Draw) -> list[Part]:
    """Return a coat, jacket, scarf or bag around the y axis that hangs from a hook at y = 0."""
    kind = draw.rng.random()
    if kind < 0.75:
        long = draw.number(0.55, 0.7) if kind < 0.3 else draw.number(0.8, 1.05)
        return placed(_coat(draw, long))
    return placed(_scarf(draw) if kind < 0.88 else _bag(draw))


def _coat(draw: Draw, long: float) -> Iterator[Row]:
    """Yield a coat: a body that widens in folds from its loop to its hem, sleeves and buttons."""
    cloth, button = draw.fabric(), draw.grey(int(draw.rng.choice([2, 8])))
    front = _body(draw, long)
    body = grid(front, wrap_columns=True)
    yield body, 0.0, cloth
    top, low = -0.15, -0.15 - min(0.5, 0.72 * long)
    for side in (-1.0, 1.0):
        x, z = side * 0.105, draw.number(0.0, 0.02)
        swing = side * draw.number(0.0, 0.012)
        shoulder = [(x * 0.8, top + 0.03, 0.0), (x, top - 0.05, z)]
        elbow, hand = (x + 1.6 * swing, 0.5 * (top + low), z + 0.012), (x + swing, low, z + 0.03)
        path = smooth_curve([*shoulder, elbow, hand], 24)
        yield tube(path, 0.038, 20), 0.0, cloth
        yield tube(path[-3:] - (0.0, 0.004, 0.0), 0.0405, 20), 0.0, cloth
    front = front[:, 3 * _COLUMNS // 4]
    for y in np.arange(-0.2, -0.8 * long, -0.13):
        at = front[np.abs(front[:, 1] - y).argmin()]
        yield sphere(0.011, 2), (at[0], at[1] - 0.011, at[2]), button


def _body(draw: Draw, long: float) -> Floats:
    """Return the body of a coat: its outline, and folds that deepen towards the hem."""
    outline = smooth_curve(
        [(-long, 0.135, 0.066), (-0.55 * long - 0.1, 0.11, 0.056), (-0.28, 0.098, 0.052),
         (-0.16, 0.104, 0.05), (-0.085, 0.066, 0.042), (-0.03, 0.038, 0.032), (0.0, 0.026, 0.024)],
        _ROWS - 2,
    )  # fmt: skip
    outline = np.concatenate([[(-long, 0.0, 0.0)], outline, [(0.0, 0.0, 0.0)]])
    y, half, deep = outline.T[:, :, None]
    turn = 2.0 * np.pi * np.arange(_COLUMNS) / _COLUMNS
    phase, down = draw.rng.uniform(0.0, 2.0 * np.pi, 2), -y / long
    folds = 0.6 * np.cos(7.0 * turn + phase[0]) + 0.4 * np.cos(11.0 * turn + phase[1])
    reach = 1.0 + (0.02 + 0.13 * down**1.3) * folds
    x = half * reach * np.cos(turn) + draw.number(-0.02, 0.02) * down
    z = np.maximum(-deep * reach * np.sin(turn), _BACK)
    return np.stack([x, np.broadcast_to(y, x.shape), z], axis=-1)


def _scarf(draw: Draw) -> Iterator[Row]:
    """Yield a scarf that hangs over a hook with both ends down, striped in two colours."""
    colors = [draw.fabric(), draw.fabric()]
    for x, z in ((-0.02, 0.0), (0.02, 0.022)):
        long = draw.number(0.45, 0.8)
        levels = np.linspace(-long, 0.0, draw.whole(5, 8))[1:-1]
        yield from dealt(banded(_strip(long).moved((x, 0.0, z)), *levels.tolist()), colors)


def _strip(long: float) -> Shape:
    """Return a folded strip of cloth that hangs from y = 0, 12 mm deep, narrower at the top."""
    rows, columns = 40, 40
    down = np.concatenate([[long], np.linspace(long, 0.0, rows - 2), [0.0]])[:, None]
    ends = np.concatenate([[0.0], np.ones(rows - 2), [0.0]])[:, None]
    turn = 2.0 * np.pi * np.arange(columns) / columns
    across = np.cos(turn)
    half = 0.075 * (0.3 + 0.7 * np.minimum(down / 0.25, 1.0))
    waves = 0.007 * np.sin(9.0 * across) * np.minimum(down / 0.2, 1.0)
    sides = half * across * ends, -down + 0.0 * turn, (waves - 0.006 * np.sin(turn)) * ends
    return grid(np.stack(sides, axis=-1), wrap_columns=True)


def _bag(draw: Draw) -> Iterator[Row]:
    """Yield a shopping bag with its handles over the hook."""
    cloth, wide, tall, drop = draw.fabric(), draw.number(0.24, 0.3), draw.number(0.28, 0.4), 0.22
    yield box(wide, tall, 0.09, 0.03, 4), -drop - tall, cloth
    badge = box(0.5 * wide, 0.35 * tall, 0.006, 0.002)
    yield badge, (0.0, -drop - 0.7 * tall, 0.045), draw.accent()
    ends = 0.3 * wide
    half = [(-ends, -drop - 0.03), (-0.4 * ends, -0.08), (0.0, -0.01)]
    path = half + [(-x, y) for x, y in half[1::-1]]
    for z in (-0.025, 0.025):
        handle = smooth_curve([(x, y, z) for x, y in path], 30)
        yield tube(handle, 0.007, 12), 0.0, cloth


@model("coat rack")
def coat_rack(draw: Draw, width: float) -> Table:
    """Return a board with hooks and garments on most, its back at z = 0 and its foot at y = 0."""
    high, metal, count = 1.2, draw.metal(), max(2, int(width / SPACING))
    yield box(width, 0.12, 0.02), (0.0, high, 0.01), draw.wood()
    for x in (np.arange(count) + 0.5) * width / count - 0.5 * width:
        yield box(0.02, 0.03, 0.09, 0.006), (x, high + 0.05, 0.065), metal
        if draw.chance(0.75):
            yield garment(draw), (x, high + 0.07, 0.085)
