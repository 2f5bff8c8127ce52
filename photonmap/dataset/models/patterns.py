"""Patterns: shapes split along zero lines of scalar fields, into parts of one material each."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from photonmap.dataset.models.shapes import (
    Floats,
    Indices,
    Noise,
    Random,
    Shape,
    joined,
    normalised,
)

Field = Callable[[Floats], Floats]
"""A scalar field: returns (V,) values at (V, 3) points."""

_MARGIN = 0.02
"""Least distance of a cut from either end of an edge, as a fraction of the edge.

It keeps triangles from vanishing.
"""


def split(shape: Shape, field: Field) -> tuple[Shape, Shape]:
    """Split a shape where a field is 0; return where it is negative, and the rest."""
    values = field(shape.vertices)
    below = values < 0.0
    corners = below[shape.faces]
    count = corners.sum(axis=1)
    whole, cut = shape.faces[count == 3], shape.faces[(count == 1) | (count == 2)]
    kept = shape.faces[count == 0]
    lone = np.where(below[cut].sum(axis=1) == 1, below[cut].T, ~below[cut].T).argmax(axis=0)
    a, b, c = (np.take_along_axis(cut, ((lone + i) % 3)[:, None], 1)[:, 0] for i in range(3))
    extended, first, second = _cut_edges(shape, values, a, b, c)
    tips = np.stack([a, first, second], axis=1)
    stumps = np.concatenate([np.stack([first, b, c], 1), np.stack([first, c, second], 1)])
    low = below[a]
    return (
        _part(extended, [whole, tips[low], stumps[np.tile(~low, 2)]]),
        _part(extended, [kept, tips[~low], stumps[np.tile(low, 2)]]),
    )


def _cut_edges(
    shape: Shape, values: Floats, a: Indices, b: Indices, c: Indices
) -> tuple[Shape, Indices, Indices]:
    """Add a vertex where each of the edges a–b and a–c is cut; return the two rows of indices."""
    edges = np.sort(np.concatenate([np.stack([a, b], 1), np.stack([a, c], 1)]), axis=1)
    count = len(shape.vertices)
    code, inverse = np.unique(edges[:, 0] * count + edges[:, 1], return_inverse=True)
    left, right = np.divmod(code, count)
    t = np.clip(values[left] / (values[left] - values[right]), _MARGIN, 1.0 - _MARGIN)[:, None]
    vertices, normals = (
        np.concatenate([rows, (1.0 - t) * rows[left] + t * rows[right]])
        for rows in (shape.vertices, shape.normals)
    )
    added = count + inverse.reshape(2, -1)
    return Shape(vertices, shape.faces, normalised(normals)), added[0], added[1]


def _part(shape: Shape, faces: Sequence[Indices]) -> Shape:
    """Return some faces of a shape with only the vertices that they use."""
    corners = np.concatenate(faces)
    used, renumbered = np.unique(corners, return_inverse=True)
    return Shape(shape.vertices[used], renumbered.reshape(-1, 3), shape.normals[used])


def split_at(shape: Shape, *fields: Field) -> list[Shape]:
    """Split a shape where each of several ascending fields is 0; return parts from low to high."""
    parts, rest = list[Shape](), shape
    for field in fields:
        low, rest = split(rest, field)
        parts.append(low)
    return [*parts, rest]


def split_at_levels(shape: Shape, field: Field, at: Sequence[float]) -> list[Shape]:
    """Split a shape at ascending levels of a field; return the parts from low to high."""

    def above(level: float) -> Field:
        return lambda points: field(points) - level

    return split_at(shape, *map(above, at))


def sections(shape: Shape, count: int, steps: int) -> list[Shape]:
    """Cut a closed tube across its path into alternating sections of two parts, `count` of each.

    Its faces follow the path of so many steps, such as `knot` returns.
    """
    rows = shape.faces.reshape(steps, -1, 3)
    pieces = np.array_split(rows, 2 * count)
    return [_part(shape, [piece.reshape(-1, 3) for piece in pieces[first::2]]) for first in (0, 1)]


def checkerboard(shape: Shape, first: Field, second: Field) -> list[Shape]:
    """Return the part where two fields have equal signs, and the part where they differ."""
    low, high = split(shape, first)
    (a, b), (c, d) = split(low, second), split(high, second)
    return [joined([a, d]), joined([b, c])]


def height(points: Floats) -> Floats:
    """Return the y coordinates."""
    return points[:, 1]


def banded(shape: Shape, *levels: float) -> list[Shape]:
    """Split a shape at ascending heights, metres."""
    return split_at_levels(shape, height, levels)


def waves(count: int, twist: float = 0.0) -> Field:
    """Return a field with `count` sectors of either sign around y, twisted by degrees per metre."""
    spin = np.radians(twist)
    return lambda p: np.sin(count * (np.arctan2(p[:, 2], p[:, 0]) + spin * p[:, 1]) + 0.3)


def rings(period: float, phase: float = 0.0) -> Field:
    """Return a field of horizontal stripes: it changes sign twice a period of height, metres."""
    return lambda points: np.sin(2.0 * np.pi * (points[:, 1] / period + phase))


def zigzag(base: float, count: int, depth: float) -> Field:
    """Return the height above a line that zigzags `count` times around y, metres."""

    def field(points: Floats) -> Floats:
        turns = np.arctan2(points[:, 2], points[:, 0]) / (2.0 * np.pi) * count
        return points[:, 1] - base - depth * (4.0 * np.abs(turns % 1.0 - 0.5) - 1.0)

    return field


def dots(rng: Random, shape: Shape, radius: float, count: int) -> Field:
    """Return a field that is negative within at most `count` balls around vertices of a shape.

    Centres are more than 2.6 radii apart.
    """
    candidates = shape.vertices[rng.integers(0, len(shape.vertices), 40 * count)]
    free = np.ones(len(candidates), bool)
    chosen: list[Floats] = []
    while free.any() and len(chosen) < count:
        point = candidates[np.argmax(free)]
        chosen.append(point)
        free &= ((candidates - point) ** 2).sum(axis=1) > (2.6 * radius) ** 2
    centers = np.array(chosen)

    def field(points: Floats) -> Floats:
        square = (points**2).sum(axis=1)[:, None] + (centers**2).sum(axis=1)
        return np.sqrt(np.maximum(square - 2.0 * points @ centers.T, 0.0).min(axis=1)) - radius

    return field


def patches(rng: Random, shape: Shape, colors: int, scale: float) -> list[Shape]:
    """Split a shape into parts of about equal numbers of vertices, in patches of a scale."""
    noise = Noise(rng, 0.35 / scale, octaves=2)
    at = np.quantile(noise(shape.vertices), np.arange(1, colors) / colors)
    return split_at_levels(shape, noise, at.tolist())


def mondrian(
    rng: Random, width: float, height: float, least: float
) -> list[tuple[float, float, float, float]]:
    """Divide a rectangle at random into x, y, width and height; no side is below `least`."""
    todo, done = [(0.0, 0.0, width, height)], []
    while todo:
        x, y, w, h = todo.pop()
        longer = max(w, h)
        if longer < 2.0 * least or (longer < 3.5 * least and rng.random() < 0.35):
            done.append((x, y, w, h))
            continue
        at = float(rng.uniform(least, longer - least))
        todo += (
            [(x, y, at, h), (x + at, y, w - at, h)]
            if w >= h
            else [(x, y, w, at), (x, y + at, w, h - at)]
        )
    return done
