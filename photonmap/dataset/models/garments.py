"""What hangs on hooks, in metres: coats, jackets, scarves and bags."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.curved_shapes import sphere, tube
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.patterns import height, split_at_levels
from photonmap.dataset.models.scene_object import Part, part_at
from photonmap.dataset.models.shapes import (
    Floats,
    Random,
    Shape,
    box,
    lattice,
    smooth_curve,
    smooth_normals,
    without_degenerate,
)

SPACING = 0.36
"""Least distance between hooks, metres, at which what hangs there does not touch."""
_ROWS, _COLUMNS = 48, 80
_BACK = -0.07
"""Where the wall stops what hangs, metres behind its middle."""


def garment(rng: Random, palette: Palette) -> list[Part]:
    """Return a coat, jacket, scarf or bag around the y axis that hangs from a hook at y = 0."""
    kind = rng.random()
    if kind < 0.75:
        return coat(rng, palette, float(rng.uniform(*((0.55, 0.7) if kind < 0.3 else (0.8, 1.05)))))
    return scarf(rng, palette) if kind < 0.88 else bag(rng, palette)


def coat(rng: Random, palette: Palette, long: float) -> list[Part]:
    """Return a coat: a body that widens in folds from its loop to its hem, sleeves and buttons."""
    cloth, button = palette.fabric(), palette.grey(int(rng.choice([2, 8])))
    body = _body(rng, long)
    parts = [Part(body, cloth)]
    for side in (-1.0, 1.0):
        top, low = -0.15, -0.15 - min(0.5, 0.72 * long)
        x, z = side * 0.105, float(rng.uniform(0.0, 0.02))
        swing = side * float(rng.uniform(0.0, 0.012))
        path = smooth_curve(
            [
                (x * 0.8, top + 0.03, 0.0),
                (x, top - 0.05, z),
                (x + 1.6 * swing, 0.5 * (top + low), z + 0.012),
                (x + swing, low, z + 0.03),
            ],
            24,
        )
        parts.append(Part(tube(path, 0.038, 20), cloth))
        cuff = tube(path[-3:] - (0.0, 0.004, 0.0), 0.0405, 20)
        parts.append(Part(cuff, cloth))
    front = body.vertices.reshape(_ROWS, _COLUMNS, 3)[:, 3 * _COLUMNS // 4]
    for y in np.arange(-0.2, -0.8 * long, -0.13):
        at = front[np.abs(front[:, 1] - y).argmin()]
        parts.append(part_at(sphere(0.011, 2), at[0], at[1] - 0.011, at[2], button))
    return parts


def _body(rng: Random, long: float) -> Shape:
    """Return the body of a coat: its outline, and folds that deepen towards the hem."""
    outline = smooth_curve(
        [
            (-long, 0.135, 0.066),
            (-0.55 * long - 0.1, 0.11, 0.056),
            (-0.28, 0.098, 0.052),
            (-0.16, 0.104, 0.05),
            (-0.085, 0.066, 0.042),
            (-0.03, 0.038, 0.032),
            (0.0, 0.026, 0.024),
        ],
        _ROWS - 2,
    )
    outline = np.concatenate([[(-long, 0.0, 0.0)], outline, [(0.0, 0.0, 0.0)]])
    y, half, deep = outline.T[:, :, None]
    turn = 2.0 * np.pi * np.arange(_COLUMNS) / _COLUMNS
    phase, down = rng.uniform(0.0, 2.0 * np.pi, 2), -y / long
    folds = 0.6 * np.cos(7.0 * turn + phase[0]) + 0.4 * np.cos(11.0 * turn + phase[1])
    reach = 1.0 + (0.02 + 0.13 * down**1.3) * folds
    sway = float(rng.uniform(-0.02, 0.02)) * down
    vertices = np.stack(
        [
            half * reach * np.cos(turn) + sway,
            np.broadcast_to(y, reach.shape),
            np.maximum(-deep * reach * np.sin(turn), _BACK),
        ],
        axis=-1,
    ).reshape(-1, 3)
    return _closed(vertices, _ROWS, _COLUMNS)


def scarf(rng: Random, palette: Palette) -> list[Part]:
    """Return a scarf that hangs over a hook with both ends down, striped in two colours."""
    colors = [palette.fabric(), palette.fabric()]
    parts = []
    for x, z in ((-0.02, 0.0), (0.02, 0.022)):
        long = float(rng.uniform(0.45, 0.8))
        levels = np.linspace(-long, 0.0, int(rng.integers(5, 9)))[1:-1]
        bands = split_at_levels(_strip(long).moved((x, 0.0, z)), height, levels.tolist())
        parts += [Part(band, colors[i % 2]) for i, band in enumerate(bands)]
    return parts


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
    return _closed(np.stack(sides, axis=-1).reshape(-1, 3), rows, columns)


def bag(rng: Random, palette: Palette) -> list[Part]:
    """Return a shopping bag with its handles over the hook."""
    cloth, wide, tall = (
        palette.fabric(),
        float(rng.uniform(0.24, 0.3)),
        float(rng.uniform(0.28, 0.4)),
    )
    drop = 0.22
    parts = [part_at(box(wide, tall, 0.09, 0.03, 4), 0.0, -drop - tall, 0.0, cloth)]
    badge = box(0.5 * wide, 0.35 * tall, 0.006, 0.002)
    parts.append(part_at(badge, 0.0, -drop - 0.7 * tall, 0.045, palette.accent()))
    for z in (-0.025, 0.025):
        ends = 0.3 * wide
        path = smooth_curve(
            [(-ends, -drop - 0.03, z), (-0.4 * ends, -0.08, z), (0.0, -0.01, z),
             (0.4 * ends, -0.08, z), (ends, -drop - 0.03, z)],
            30,
        )  # fmt: skip
        parts.append(Part(tube(path, 0.007, 12), cloth))
    return parts


def _closed(vertices: Floats, rows: int, columns: int) -> Shape:
    faces = without_degenerate(vertices, lattice(rows, columns, wrap_columns=True))
    return Shape(vertices, faces, smooth_normals(vertices, faces))
