"""Vessels, books, toys, sculptures, and things of bathrooms, workshops and halls; in metres."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from photonmap.dataset.models.materials import Draw
from photonmap.dataset.models.patterns import (
    banded,
    checkerboard,
    dots,
    patches,
    rings,
    split,
    split_at,
    waves,
    zigzag,
)
from photonmap.dataset.models.scene_object import (
    Maker,
    SceneObject,
    Table,
    mirrored,
    model,
    multi_part,
    sized,
    solid,
)
from photonmap.dataset.models.shapes import (
    Floats,
    Random,
    Shape,
    arc,
    box,
    cone,
    cylinder,
    joined,
    knot,
    lathe,
    lump,
    smooth_curve,
    sphere,
    superquadric,
    torus,
    tube,
    upright,
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
    return multi_part("bottle", [shape], [draw.glass(draw.chip(None, (3, 6), (4, 10)))])


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


cup = solid(
    "cup",
    lambda draw: (joined(cup_shapes(draw.rng, draw.number(0.08, 0.1))), draw.glazed(draw.accent())),
)


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


TOY_SEGMENTS = 36
"""Segments around the axis of small round toys."""


@model("book")
def book(draw: Draw, lying: bool = False) -> Table:
    """Return a book: upright with its spine towards +z, or lying."""
    tall, deep, thick = draw.number(0.19, 0.29), draw.number(0.14, 0.2), draw.number(0.018, 0.05)
    label = upright(-0.5 * thick, 0.78 * tall, thick, 0.012).moved((0.0, 0.0, 0.5 * deep + 2e-4))
    colors = draw.chip(None, (3, 7), (2, 10)), draw.pale()
    for shape, color in zip((box(thick, tall, deep, 0.003, 1), label), colors, strict=True):
        if lying:
            yield shape.turned(90.0, 2), (0.5 * tall, 0.5 * thick, 0.0), color
        else:
            yield shape, 0.0, color


def ball(draw: Draw, radius: float = 0.07) -> SceneObject:
    """Return a plain, striped, dotted, sliced or checked ball; a plain one may be a mirror."""
    shape = sphere(radius * draw.number(0.8, 1.2), 3)
    kind, top = draw.whole(0, 4), shape.vertices[:, 1].max()
    paints = [draw.accent(), draw.pale(), draw.accent()]
    if kind == 0:
        return multi_part("ball", [shape], [draw.metal()] if draw.mixed else paints)
    designs: Sequence[Callable[[], Sequence[Shape]]] = (
        lambda: banded(shape, 0.35 * top, 0.65 * top),
        lambda: split(shape, dots(draw.rng, shape, 0.22 * top, 24)),
        lambda: split(shape, waves(draw.whole(3, 4))),
        lambda: checkerboard(shape, waves(4), rings(0.6 * top)),
    )
    return multi_part("ball", designs[kind - 1](), paints)


@model("ring tower")
def ring_tower(draw: Draw, size: float, count: int, segments: int = TOY_SEGMENTS) -> Table:
    """Return a stack of ever smaller rings around a stick, on a base of about a radius, metres."""
    base, stick, colors = draw.wood(), draw.wood(), draw.colors(count + 1)
    y = foot = 0.16 * size
    yield cylinder(0.95 * size, foot, 0.04 * size, segments), 0.0, draw.glazed(base)
    for index in range(count):
        thickness, radius = size * (0.235 - 0.016 * index), size * (0.80 - 0.115 * index)
        ring = torus(radius - 0.3 * thickness, thickness, segments)
        yield ring, y, draw.glazed(colors[index])
        y += 2.0 * thickness
    yield cylinder(0.13 * size, y - foot, segments=segments), foot, stick
    yield sphere(0.22 * size, 3), y, draw.glazed(colors[count])


@model("block")
def block(draw: Draw, side: float = 0.06) -> Table:
    """Return a toy block: a cube, a brick, a cylinder or a cone."""
    shapes = (
        box(side, side, side, 0.05 * side),
        box(2.0 * side, side, side, 0.05 * side),
        cylinder(0.5 * side, side, 0.05 * side, TOY_SEGMENTS),
        cone(0.5 * side, 0.04 * side, 1.2 * side, 0.02 * side, TOY_SEGMENTS),
    )
    yield draw.one_of(shapes), 0.0, draw.glazed(draw.accent())


@model("block stack")
def block_stack(draw: Draw, side: float = 0.06, count: int = 4) -> Table:
    """Return a stack of blocks, each turned a little, with a cone or a ball on top."""
    y, cube = 0.0, box(side, side, side, 0.05 * side)
    for color in draw.colors(count):
        yield cube.turned(draw.number(-18.0, 18.0)), y, draw.glazed(color)
        y += side
    pointed = cone(0.5 * side, 0.03 * side, side, segments=TOY_SEGMENTS)
    top = pointed if draw.chance(0.5) else sphere(0.45 * side, 3)
    yield top, y, draw.glazed(draw.accent())


def knot_sculpture(draw: Draw, size: float = 0.16) -> SceneObject:
    """Return a torus knot of one colour, or in sectors of two."""
    shape = knot(size, 0.19 * size, *draw.one_of(((2, 3), (3, 2), (2, 5))), 240)
    paints = [draw.glazed(draw.accent()), draw.glazed(draw.accent())]
    return multi_part("knot", [shape] if draw.chance(0.5) else split(shape, waves(3)), paints)


def quadric_sculpture(draw: Draw, size: float = 0.22) -> SceneObject:
    """Return a plain, striped or checked superquadric."""
    extents = size * draw.rng.uniform(0.8, 1.25, 3)
    shape = superquadric(extents, draw.number(0.25, 1.6), draw.number(0.25, 1.6), 64, 96)
    paints = [draw.accent(), draw.pale(), draw.accent()]
    kind, name = draw.whole(0, 2), "superquadric"
    if kind == 0:
        return multi_part(name, [shape], [draw.glazed(paints[0])])
    if kind == 1:
        return multi_part(name, banded(shape, *np.linspace(0.0, extents[1], 6)[1:-1]), paints)
    return multi_part(name, checkerboard(shape, waves(4), rings(0.5 * extents[1])), paints)


def pebble(draw: Draw, radius: float = 0.1) -> SceneObject:
    """Return a lump of smooth noise, plain or in patches."""
    shape = lump(draw.rng, radius * draw.number(0.8, 1.2))
    paints = [draw.accent(), draw.fabric(), draw.pale()]
    if draw.chance(0.5):
        return multi_part("pebble", [shape], paints[1:])
    return multi_part("pebble", patches(draw.rng, shape, 3, 1.2 * radius), paints)


@model("globe")
def globe(draw: Draw) -> Table:
    """Return a globe on a foot."""
    radius, lift = draw.number(0.1, 0.15), 0.1
    pieces = patches(draw.rng, sphere(radius, 4), 3, 1.2 * radius)
    sea, land = draw.chip(68.0, (4, 6), (6, 10), 5.0), draw.chip(35.0, (5, 7), (4, 8), 6.0)
    for piece, color in zip(pieces, (sea, land, draw.pale()), strict=True):
        yield piece, lift, color
    yield cylinder(0.6 * radius, 0.02, 0.006, 32), 0.0, draw.wood()
    yield cylinder(0.01, lift - 0.01, 0.002, 16), 0.015, draw.metal()
    yield torus(1.08 * radius, 0.006, 48).turned(90.0, 0), lift + radius, draw.metal()


@model("soap")
def soap_bottle(draw: Draw) -> Table:
    """Return a bottle with a pump."""
    tall = draw.number(0.1, 0.15)
    outer = [(0.03, 0.0), (0.034, 0.01), (0.034, 0.8 * tall), (0.012, tall)]
    yield pot(outer, 0.003, 0.004), 0.0, draw.glazed(draw.accent())
    yield cylinder(0.008, 0.04, 0.002, 16), tall, draw.grey(8)
    yield box(0.014, 0.01, 0.05, 0.003), (0.0, tall + 0.04, 0.015), draw.grey(8)


paper_roll = solid("paper roll", lambda draw: (cylinder(0.055, 0.1, 0.006, 32), draw.grey(9)))
towel = solid("towel", lambda draw: (box(0.24, 0.07, 0.16, 0.02, 3), draw.fabric()))
basket = solid("basket", lambda draw: (pot_shape(draw.rng, draw.number(0.4, 0.6)), draw.wood()))


@model("bin")
def litter_bin(draw: Draw) -> Table:
    """Return a litter bin."""
    outer = [(0.17, 0.0), (0.18, 0.02), (0.2, 0.4), (0.22, 0.75)]
    yield pot(outer, 0.01, 0.015), 0.0, draw.glazed(draw.accent())


@model("shoes")
def shoes(draw: Draw) -> Table:
    """Return a pair of shoes."""
    sole = superquadric((0.09, 0.02, 0.27), 0.3, 0.8, 16, 32)
    upper, leather = superquadric((0.085, 0.1, 0.26), 0.9, 0.8, 24, 36), draw.fabric()
    for x in (-0.06, 0.06):
        yield sole, (x, 0.0, 0.0), draw.grey(3)
        yield upper, (x, 0.015, 0.0), leather


@model("tap")
def tap(draw: Draw) -> Table:
    """Return the tap of a basin."""
    spout = tube([(0, 0, 0), (0, 0.2, 0), (0, 0.23, 0.05), (0, 0.21, 0.09)], 0.012, 24).resting()
    yield spout, 0.0, draw.metal()


@model("crate")
def crate(draw: Draw, size: float) -> Table:
    """Return an open crate of boards."""
    wood, wall = draw.wood(), 0.016
    wide, tall, deep = size * draw.rng.uniform(0.8, 1.2, 3) * (1.2, 0.7, 0.9)
    slat = 0.42 * tall
    yield box(wide, wall, deep, 0.002), (0.0, 0.0, 0.0), wood
    long, across = box(wide, slat, wall, 0.002), box(wall, slat, deep - 2 * wall, 0.002)
    for y in (wall, wall + (tall - wall - slat)):
        yield long, mirrored("z", 0.0, y, 0.5 * (deep - wall)), wood
        yield across, mirrored("x", 0.5 * (wide - wall), y, 0.0), wood
    post = box(wall, tall, wall, 0.002)
    for at in mirrored("xz", 0.5 * wide - 1.5 * wall, wall, 0.5 * deep - 1.5 * wall):
        yield post, at, draw.wood()


@model("tin")
def tin(draw: Draw) -> Table:
    """Return a tin of paint with a band in its colour."""
    radius, tall, color = draw.number(0.05, 0.09), draw.number(0.1, 0.2), draw.accent()
    yield cylinder(radius, tall, 0.004, 40), 0.0, draw.metal()
    yield cylinder(1.01 * radius, 0.6 * tall, 0.002, 40), 0.2 * tall, color


@model("toolbox")
def toolbox(draw: Draw) -> Table:
    """Return a toolbox with a handle."""
    wide = draw.number(0.35, 0.5)
    yield box(wide, 0.18, 0.2, 0.01, 3), 0.0, draw.glazed(draw.accent())
    yield box(wide, 0.06, 0.7 * 0.2, 0.015, 3), 0.18, draw.grey(3)
    yield box(0.5 * wide, 0.025, 0.03, 0.01, 3), 0.18 + 0.06, draw.metal()


@model("timber")
def timber(draw: Draw) -> Table:
    """Return a stack of planks on two bearers."""
    long, wide = draw.number(1.2, 2.2), draw.number(0.14, 0.2)
    bearer = box(0.06, 0.06, 2.2 * wide, 0.003)
    for i in (-1, 1):
        yield bearer, (i * 0.35 * long, 0.0, 0.0), draw.wood()
    for layer in range(draw.whole(2, 5)):
        for k in (-0.5, 0.5):
            short = long * draw.number(0.82, 1.0)
            at = draw.number(-0.5, 0.5) * (long - short), 0.06 + 0.03 * layer, 1.04 * k * wide
            yield box(short, 0.028, wide, 0.002), at, draw.wood()


@model("umbrella stand")
def umbrella_stand(draw: Draw) -> Table:
    """Return a tall pot with furled umbrellas."""
    outer = [(0.1, 0.0), (0.11, 0.02), (0.12, 0.25), (0.13, 0.5)]
    yield pot(outer, 0.008, 0.012), 0.0, draw.glazed(draw.accent())
    for turn in draw.rng.uniform(0.0, 360.0, draw.whole(1, 3)):
        x, z = 0.05 * np.cos(np.radians(turn)), 0.05 * np.sin(np.radians(turn))
        long = draw.number(0.6, 0.8)
        yield cylinder(0.022, long, 0.01, 16), (x, 0.012, z), draw.fabric()
        yield cylinder(0.008, 0.12, 0.003, 12), (x, 0.012 + long, z), draw.wood()


def draw_vessels(draw: Draw, count: int, small: bool = False) -> list[Maker]:
    """Draw makers of vessels."""
    tall = 0.17 if small else 0.26
    makers = [sized(vase, tall), sized(bowl, 0.4 * tall + 0.02), bottle, cup]
    return draw.several(makers, count)


TOYS: Sequence[Maker] = (
    sized(ball, 0.07),
    sized(block_stack, 0.065),
    sized(block, 0.07),
    sized(block, 0.07),
    lambda draw: ring_tower(draw, 0.085, 4),
)
TOILETRIES: Sequence[Maker] = (soap_bottle, paper_roll, towel)
SHOP_THINGS: Sequence[Maker] = (tin, tin, toolbox, sized(crate, 0.2))


def draw_sculpture(draw: Draw, size: float) -> Maker:
    """Draw a maker of a sculpture."""
    makers: list[Maker] = [
        sized(knot_sculpture, 0.5 * size),
        sized(quadric_sculpture, size),
        sized(pebble, 0.55 * size),
        sized(vase, 1.5 * size),
    ]
    # The second permutation is not used; without it, later draws would be others.
    first, _ = draw.rng.permutation(len(makers)), draw.rng.permutation(len(makers))
    return makers[int(first[0])]
