"""Vessels, as surfaces of revolution: vases, bowls, bottles, cups, plates, pots; in metres."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.patterns import banded, checkerboard, rings, split_at, waves, zigzag
from photonmap.dataset.models.scene_object import SceneObject, multi_part, single_part, solid
from photonmap.dataset.models.shapes import (
    Floats,
    Random,
    Shape,
    arc,
    joined,
    lathe,
    smooth_curve,
    tube,
)

Knots = Sequence[tuple[float, float]]
"""Radius and height of points of a profile, from the foot to the rim."""

_VASES: Sequence[Knots] = (
    ((0.3, 0.0), (0.62, 0.22), (0.8, 0.45), (0.6, 0.75), (0.28, 0.95), (0.26, 1.05), (0.4, 1.2)),
    ((0.34, 0), (0.42, 0.15), (0.6, 0.55), (0.74, 0.85), (0.62, 1.05), (0.36, 1.14), (0.42, 1.22)),
    ((0.46, 0), (0.72, 0.16), (0.78, 0.36), (0.46, 0.62), (0.22, 0.85), (0.2, 1.15), (0.3, 1.35)),
    ((0.34, 0.0), (0.3, 0.1), (0.5, 0.3), (0.7, 0.6), (0.66, 0.86), (0.5, 1.0), (0.56, 1.1)),
)
"""Profiles of vases, in units of the size."""


@dataclass(frozen=True)
class Detail:
    """Subdivision of a vessel: steps along its profile, segments around its axis."""

    steps: int
    segments: int


FINE, MEDIUM, COARSE = Detail(64, 144), Detail(28, 56), Detail(14, 28)


def hollow(outer: Floats, wall: float, floor: float, segments: int = COARSE.segments) -> Shape:
    """Return a vessel with a wall, a rounded rim and a foot ring, from its outer profile.

    Parameters
    ----------
    outer : (P, 2) radius and height, metres, from the edge of the foot at height 0 to the rim
    wall, floor : thicknesses, metres
    segments : number of segments around the axis
    """
    foot = outer[0, 0]
    ring = min(0.1 * foot, 0.004)
    base = np.array([(0.0, ring), (0.5 * foot, ring), (foot - 2.0 * ring, ring)])
    bead = arc((foot - ring, ring), ring, 180.0, 360.0, 5)
    side = outer[outer[:, 1] > 1.5 * ring]
    direction = np.gradient(outer, axis=0)
    across = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    inner = (outer + wall * across)[::-1]
    inner = inner[(inner[:, 1] > floor) & (inner[:, 0] > wall)]
    rim, mouth = outer[-1], inner[0]
    middle, out = 0.5 * (rim + mouth), direction[-1] / np.linalg.norm(direction[-1])
    lip = [
        middle + 0.5 * wall * (out * math.sin(t) + (rim - mouth) / wall * math.cos(t))
        for t in np.linspace(0, np.pi, 5)
    ]
    last = inner[-1]
    bottom = smooth_curve([last, (0.75 * last[0], floor), (0.4 * last[0], floor), (0.0, floor)], 5)
    upward = np.concatenate([bead[-1:], side[:-1], lip, inner[1:], bottom[1:]])
    return lathe(base, bead, upward, segments=segments).resting()


def pot(knots: Knots, wall: float, floor: float) -> Shape:
    """Return a coarse vessel with a wall and a floor of given thicknesses, metres."""
    return hollow(smooth_curve(knots, COARSE.steps), wall, floor)


def _profile(rng: Random, knots: Knots, size: float, jitter: float, detail: Detail) -> Floats:
    """Return a smooth curve through knots, in units of the size, whose radii are jittered."""
    points = np.array(knots, np.float64)
    points[:, 0] *= 1.0 + jitter * rng.uniform(-1.0, 1.0, len(points))
    return smooth_curve(size * points, detail.steps)


def vase_shape(rng: Random, tall: float, kind: int | None = None, detail: Detail = COARSE) -> Shape:
    """Return a vase of about this height, metres, of one of four profiles; None draws which."""
    knots = _VASES[int(rng.integers(len(_VASES))) if kind is None else kind]
    outer = _profile(rng, knots, tall / knots[-1][1], 0.05, detail) * (0.6, 1.0)
    return hollow(outer, 0.022 * tall, 0.05 * tall, detail.segments)


def decorate(draw: Draw, name: str, shape: Shape) -> SceneObject:
    """Return a glazed vessel: plain, banded, in twisted stripes, checked or with zigzag lines."""
    tall = float(np.ptp(shape.vertices[:, 1]))
    paints = [draw.glazed(color) for color in (draw.accent(), draw.pale(), draw.fabric())]
    kind = draw.whole(0, 5)
    designs: Sequence[Callable[[], Sequence[Shape]]] = (
        lambda: [shape],
        lambda: banded(shape, 0.4 * tall, 0.5 * tall, 0.72 * tall),
        lambda: split_at(shape, waves(draw.whole(5, 8), 60.0 / tall)),
        lambda: checkerboard(shape, waves(draw.whole(6, 9)), rings(tall / 3.5)),
        lambda: split_at(shape, *(zigzag(at * tall, 12, 0.06 * tall) for at in (0.38, 0.62))),
        lambda: banded(shape, 0.3 * tall, 0.8 * tall),
    )
    return multi_part(name, designs[kind](), paints[:2] if kind == 5 else paints)


def vase(draw: Draw, tall: float = 0.28) -> SceneObject:
    """Return a decorated vase of about this height, metres."""
    return decorate(draw, "vase", vase_shape(draw.rng, tall * draw.number(0.8, 1.2)))


def bowl_shape(rng: Random, radius: float, detail: Detail = COARSE) -> Shape:
    """Return an open bowl of this radius, metres."""
    deep = float(rng.uniform(0.5, 0.65))
    knots = [(0.42, 0.0), (0.52, 0.05), (0.78, 0.42 * deep), (0.95, 0.8 * deep), (1.0, deep)]
    outer = _profile(rng, knots, radius, 0.03, detail)
    return hollow(outer, 0.045 * radius, 0.09 * radius, detail.segments)


def bowl(draw: Draw, radius: float = 0.13) -> SceneObject:
    """Return a bowl of about this radius, metres, its rim in another colour."""
    shape = bowl_shape(draw.rng, radius * draw.number(0.85, 1.15))
    paints = [draw.glazed(draw.accent()), draw.glazed(draw.pale())]
    return multi_part("bowl", banded(shape, 0.82 * shape.vertices[:, 1].max()), paints)


def bottle(draw: Draw) -> SceneObject:
    """Return a bottle, of glass if materials are mixed."""
    tall, shoulder = draw.number(0.24, 0.32), draw.number(0.5, 0.66)
    body = [(0.135, 0.0), (0.14, 0.04), (0.14, shoulder), (0.11, shoulder + 0.1)]
    neck = [(0.05, shoulder + 0.2), (0.045, 0.95), (0.052, 1.0)]
    shape = hollow(_profile(draw.rng, body + neck, tall, 0.0, COARSE), 0.012 * tall, 0.02 * tall)
    return single_part("bottle", shape, draw.glass(draw.chip(None, (3, 6), (4, 10))))


def cup_shapes(
    rng: Random, tall: float, detail: Detail = COARSE, slim: float = 1.0
) -> tuple[Shape, Shape]:
    """Return a cup of this height, metres, and its handle at +x, whose ends lie within the wall."""
    wide = slim * tall * float(rng.uniform(0.42, 0.48))
    knots = [(0.8 * wide, 0.0), (0.93 * wide, 0.1 * tall), (0.96 * wide, 0.5 * tall), (wide, tall)]
    outer = _profile(rng, knots, 1.0, 0.02, detail)
    body = hollow(outer, 0.035 * tall, 0.06 * tall, detail.segments)
    top, low = (
        float(np.interp(share * tall, outer[:, 1], outer[:, 0])) + 0.03 * tall
        for share in (0.78, 0.25)
    )
    reach = max(top, low) + 0.28 * tall
    ear = [(top, 0.78), (0.6 * top + 0.4 * reach, 0.84), (reach, 0.68), (reach, 0.45)]
    ear += [(0.5 * low + 0.5 * reach, 0.27), (low, 0.25)]
    path = smooth_curve([(x, y * tall, 0.0) for x, y in ear], 2 * detail.steps)
    return body, tube(path, 0.045 * tall, detail.segments // 3)


basin = solid(
    "basin", lambda draw: (bowl_shape(draw.rng, draw.number(0.18, 0.21)), draw.glazed(draw.grey(9)))
)


def cup(draw: Draw) -> SceneObject:
    """Return a cup with a handle."""
    shape = joined(cup_shapes(draw.rng, draw.number(0.08, 0.1)))
    return single_part("cup", shape, draw.glazed(draw.accent()))


def plate(draw: Draw) -> SceneObject:
    """Return a plate with a coloured rim."""
    radius = draw.number(0.11, 0.13)
    knots = [(0.5, 0.0), (0.55, 0.02), (0.75, 0.06), (0.9, 0.13), (1.0, 0.16)]
    shape = hollow(_profile(draw.rng, knots, radius, 0.0, COARSE), 0.03 * radius, 0.05 * radius)
    paints = [draw.glazed(draw.pale()), draw.glazed(draw.accent())]
    return multi_part("plate", banded(shape, 0.14 * radius), paints)


def pot_shape(rng: Random, tall: float) -> Shape:
    """Return a flower pot of this height, metres."""
    knots = [(0.34, 0.0), (0.37, 0.06), (0.48, 0.7), (0.52, 0.98), (0.52, 1.0)]
    return hollow(_profile(rng, knots, tall, 0.02, COARSE), 0.04 * tall, 0.1 * tall)
