"""Place objects on supports at random, resting exactly and without intersections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from photonmap.dataset.models.materials import Draw, Range
from photonmap.dataset.models.scene_object import Maker, SceneObject, Support, overlap
from photonmap.dataset.models.small_objects import book, draw_vessels

_ATTEMPTS = 24  # random positions tried for an object before it is left out
_GAP = 0.012  # least distance between objects on one support, metres


def scatter(
    draw: Draw, support: Support, makers: Sequence[Maker], taken: Sequence[SceneObject] = ()
) -> list[SceneObject]:
    """Place objects at random beside those that are `taken`; leave out what does not fit."""
    boxes, placed = [_footprint(obj) for obj in taken], []
    for make in makers:
        made = make(draw).turned(draw.number(0.0, 360.0))
        low, high = made.bounds
        wide, _, deep = high - low
        if (
            high[1] > support.room
            or wide > support.x[1] - support.x[0]
            or deep > support.z[1] - support.z[0]
        ):
            continue
        for _ in range(_ATTEMPTS):
            x = draw.number(support.x[0] - low[0], support.x[1] - high[0])
            z = draw.number(support.z[0] - low[2], support.z[1] - high[2])
            obj = made.moved((x, support.y, z))
            foot = _footprint(obj)
            if not any(overlap(foot[None], box[None]) for box in boxes):
                boxes.append(foot)
                placed.append(obj)
                break
    return placed


def in_row(
    draw: Draw,
    support: Support,
    makers: Sequence[Maker],
    gap: Range = (0.0, 0.0),
    front: bool = False,
) -> list[SceneObject]:
    """Place objects side by side along x, at gaps from a range, until the support is full.

    They are in the middle of its depth, or at its `front` edge, at high z.
    """
    at, placed = support.x[0] + draw.number(*gap), []
    for make in makers:
        obj = make(draw)
        low, high = obj.bounds
        if high[1] > support.room or high[2] - low[2] > support.z[1] - support.z[0]:
            continue
        if at + high[0] - low[0] > support.x[1]:
            break
        z = support.z[1] - high[2] if front else 0.5 * (sum(support.z) - low[2] - high[2])
        placed.append(obj.moved((at - low[0], support.y, z)))
        at += high[0] - low[0] + draw.number(*gap) + 1e-4
    return placed


def place_at(support: Support, obj: SceneObject, x: float = 0.5, z: float = 0.5) -> SceneObject:
    """Place an object at fractions x and z of a support's width and depth."""
    x, z = ((1.0 - t) * side[0] + t * side[1] for t, side in ((x, support.x), (z, support.z)))
    return obj.moved((x, support.y, z))


def _footprint(obj: SceneObject) -> np.ndarray:
    """Return the bounds of an object widened by half of the gap, (2, 3), metres."""
    return obj.bounds + np.outer((-1.0, 1.0), (0.5 * _GAP, 0.0, 0.5 * _GAP))


def row_of_books(draw: Draw, support: Support, fraction: float = 1.0) -> list[SceneObject]:
    """Stand books side by side on a fraction of a support's width, from the left."""
    low, high = support.x
    part = replace(support, x=(low, low + fraction * (high - low)))
    return in_row(draw, part, [book] * 60, (0.0, 0.002), front=True)


def stack_books(
    draw: Draw, support: Support, count: int, taken: Sequence[SceneObject] = ()
) -> list[SceneObject]:
    """Stack books, the largest at the bottom, on a support beside objects that are `taken`."""
    made = [book(draw, lying=True) for _ in range(count)]
    made.sort(key=lambda book: -float(book.bounds[1, 0]))
    placed = scatter(draw, support, [lambda _: made[0]], taken)
    for book_ in made[1:] if placed else ():
        below = placed[-1].bounds
        middle = below.mean(axis=0)
        turned = book_.turned(draw.number(-9.0, 9.0))
        laid = turned.moved((middle[0], below[1, 1], middle[2]))
        if any(overlap(laid.boxes, other.boxes) for other in taken):
            break
        placed.append(laid)
    return placed


def furnish(
    draw: Draw, carrier: SceneObject, makers: Sequence[Maker], first: Sequence[SceneObject] = ()
) -> list[SceneObject]:
    """Return an object with others scattered on its first support, beside the `first`."""
    return [carrier, *first, *scatter(draw, carrier.supports[0], makers, first)]


def fill_shelf(draw: Draw, shelf: SceneObject, book_probability: float = 0.6) -> list[SceneObject]:
    """Return a shelf with vessels on top, and on every board vessels or books and few vessels."""
    group = [shelf]
    for board in shelf.supports[:-1]:
        if draw.chance(book_probability):
            filled, (low, high) = draw.number(0.55, 1.0), board.x
            group += row_of_books(draw, board, filled)
            rest = replace(board, x=(low + filled * (high - low) + 0.02, high))
            group += in_row(draw, rest, draw_vessels(draw, 2, small=True), (0.02, 0.08))
        else:
            group += in_row(draw, board, draw_vessels(draw, 6, small=True), (0.03, 0.12))
    return group + in_row(draw, shelf.supports[-1], draw_vessels(draw, 3), (0.1, 0.3))
