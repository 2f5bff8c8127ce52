"""Windows and what hangs on walls: curtains, pictures, mirrors, clocks; in metres."""

from __future__ import annotations

import numpy as np

from photonmap.dataset.models.artwork import artwork, printed, rectangle
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import Part, Row, SceneObject, assembled, part_at
from photonmap.dataset.models.shapes import (
    Random,
    Shape,
    box,
    cylinder,
    lattice,
    parallelogram,
    smooth_normals,
)

WINDOW = "window"
"""The light group of all windows."""


def window(palette: Palette, width: float, height: float, depth: float = 0.16) -> SceneObject:
    """Return a window for an opening around x = 0, from y = 0, in a wall at z = 0.

    An emissive pane closes the opening at z = −depth, behind the bars of the frame. While it is
    off, it is a pale blind that is drawn for the night.
    """
    frame, bar = palette.grey(9), 0.045
    x = 0.5 * width
    reveal = [
        parallelogram((-x, 0.0, 0.0), (0.0, 0.0, -depth), (0.0, height, 0.0)),
        parallelogram((x, 0.0, -depth), (0.0, 0.0, depth), (0.0, height, 0.0)),
        parallelogram((-x, 0.0, 0.0), (width, 0.0, 0.0), (0.0, 0.0, -depth)),
        parallelogram((-x, height, -depth), (width, 0.0, 0.0), (0.0, 0.0, depth)),
    ]
    parts = [Part(side, frame) for side in reveal]
    z = -depth + 0.5 * bar + 0.005
    upright = box(bar, height, bar)
    parts += [part_at(upright, i * (x - 0.5 * bar), 0.0, z, frame) for i in (-1, 0, 1)]
    across = box(width, bar, 0.8 * bar)
    parts += [part_at(across, 0.0, y, z, frame) for y in (0.0, 0.62 * height, height - bar)]
    pane = parallelogram((-x, 0.0, -depth), (width, 0.0, 0.0), (0.0, height, 0.0))
    return SceneObject("window", [*parts, Part(pane, palette.pale(), WINDOW)])


def curtain(palette: Palette, rng: Random, width: float, height: float) -> SceneObject:
    """Return a folded curtain in front of a wall at z = 0, from y = 0 to `height`."""
    steps, folds = 120, max(3, round(width / 0.11))
    across = np.linspace(-0.5 * width, 0.5 * width, steps)
    phase = float(rng.uniform(0.0, 6.0))
    wave = 0.035 * np.sin(2.0 * np.pi * folds * (across / width) + phase)
    wave += 0.012 * np.sin(4.3 * np.pi * folds * (across / width) + 2.0 * phase)
    levels = np.linspace(0.0, height, 10)
    grow = 1.25 - 0.5 * levels / height
    front = np.stack(
        [
            np.tile(across, (10, 1)),
            np.tile(levels[:, None], (1, steps)),
            0.08 + grow[:, None] * wave,
        ],
        axis=-1,
    )
    vertices = front.reshape(-1, 3)
    faces = lattice(10, steps)
    normals = smooth_normals(vertices, faces)
    cloth = palette.patterned("cloth", palette.chip(palette.key, (5, 7), (4, 8)))
    return SceneObject("curtain", [Part(Shape(vertices, faces, normals), cloth)])


def picture(
    rng: Random, palette: Palette, width: float, height: float, mount: float = 0.0
) -> SceneObject:
    """Return a framed picture, its back at z = 0, perhaps in a white mount of some breadth."""
    frame, bar, deep = palette.wood(), 0.03, 0.025
    wide, tall = width - 2 * bar, height - 2 * bar
    across, side = box(width, bar, deep), box(bar, tall, deep)
    rows: list[Row] = [
        (across, (0.0, 0.0, 0.5 * deep), frame),
        (across, (0.0, height - bar, 0.5 * deep), frame),
        (side, (0.5 * (width - bar), bar, 0.5 * deep), frame, "x"),
    ]
    if mount:
        board = rectangle(-0.5 * wide, bar, wide, tall)
        rows.append((board, (0.0, 0.0, 0.2 * deep), palette.grey(9)))
    shown = artwork(rng, palette, wide - 2 * mount, tall - 2 * mount)
    rows += [(p.shape, (0.0, bar + mount, 0.3 * deep), p.material) for p in shown]
    return assembled("picture", rows)


def poster(rng: Random, palette: Palette, width: float, height: float) -> SceneObject:
    """Return a poster with a design and lines of type, its back at z = 0."""
    thick = 0.004
    parts = [part_at(box(width, height, thick, 0.001, 1), 0.0, 0.0, 0.5 * thick, palette.grey(9))]
    shown = printed(rng, palette, width - 0.01, height - 0.01)
    parts += [part_at(p.shape, 0.0, 0.005, thick + 0.001, p.material) for p in shown]
    return SceneObject("picture", parts)


def wall_mirror(palette: Palette, radius: float) -> SceneObject:
    """Return a round framed mirror, its back at z = 0; a grey disc if materials are Lambertian."""
    rim = cylinder(radius, 0.03, 0.01).turned(90.0, 0).moved((0.0, radius, 0.0))
    disc = cylinder(0.9 * radius, 0.004, 0.001).turned(90.0, 0).moved((0.0, radius, 0.03))
    return SceneObject("mirror", [Part(rim, palette.wood()), Part(disc, palette.metal())])


def clock(palette: Palette) -> SceneObject:
    """Return a wall clock, its back at z = 0."""
    radius = 0.16
    rim = cylinder(radius, 0.03, 0.01).turned(90.0, 0).moved((0.0, radius, 0.0))
    face = cylinder(0.88 * radius, 0.004, 0.001).turned(90.0, 0).moved((0.0, radius, 0.03))
    parts = [Part(rim, palette.accent()), Part(face, palette.grey(9))]
    for degrees, long in ((35.0, 0.55), (-80.0, 0.8)):
        hand = box(0.012, long * radius, 0.003, 0.001, 1).turned(degrees, 2)
        parts.append(part_at(hand, 0.0, radius, 0.0355, palette.grey(2)))
    return SceneObject("clock", parts)


def door(palette: Palette, width: float, height: float = 2.03) -> SceneObject:
    """Return a closed door in its frame, standing on y = 0 with its back at z = 0."""
    leaf, frame, bar = palette.glazed(palette.pale()), palette.grey(8), 0.07
    panel, handle = 0.72 * width, box(0.12, 0.022, 0.022, 0.008)
    rows: list[Row] = [
        (box(bar, height, 0.045), (0.5 * (width + bar), 0.0, 0.0225), frame, "x"),
        (box(width + 2 * bar, bar, 0.045), (0.0, height, 0.0225), frame),
        (box(width, height, 0.03), (0.0, 0.0, 0.015), leaf),
        (box(panel, 0.65, 0.012), (0.0, 0.15, 0.036), leaf),
        (box(panel, 0.95, 0.012), (0.0, 0.95, 0.036), leaf),
        (handle, (0.5 * width - 0.11, 1.0, 0.055), palette.metal()),
    ]
    return assembled("door", rows)
