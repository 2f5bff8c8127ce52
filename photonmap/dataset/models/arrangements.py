"""Place objects on supports at random, resting exactly and without intersections."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from photonmap.dataset.models import small_objects, vessels
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.scene_object import SceneObject, Support, overlap
from photonmap.dataset.models.shapes import Random

Maker = Callable[[], SceneObject]
"""Makes an object at the origin."""

_ATTEMPTS = 24
"""Random positions tried for an object before it is left out."""
_GAP = 0.012
"""Least distance between objects on one support, metres."""


def scatter(
    rng: Random, support: Support, makers: Sequence[Maker], taken: Sequence[SceneObject] = ()
) -> list[SceneObject]:
    """Place objects at random positions and rotations on a support; leave out what does not fit.

    Parameters
    ----------
    taken : objects that stand there already
    """
    boxes = [_footprint(obj) for obj in taken]
    placed = []
    for make in makers:
        made = make().turned(float(rng.uniform(0.0, 360.0)))
        low, high = made.bounds
        if high[1] > support.room or not _fits(support, low, high):
            continue
        for _ in range(_ATTEMPTS):
            x = rng.uniform(support.x[0] - low[0], support.x[1] - high[0])
            z = rng.uniform(support.z[0] - low[2], support.z[1] - high[2])
            obj = made.moved((x, support.y, z))
            foot = _footprint(obj)
            if not any(overlap(foot[None], box[None]) for box in boxes):
                boxes.append(foot)
                placed.append(obj)
                break
    return placed


def in_row(
    rng: Random,
    support: Support,
    makers: Sequence[Maker],
    gap: tuple[float, float] = (0.0, 0.0),
    front: bool = False,
) -> list[SceneObject]:
    """Place objects side by side along x until the support is full.

    Parameters
    ----------
    gap : least and greatest distance between neighbours, metres
    front : align the objects with the front edge, at high z, instead of the middle
    """
    at, placed = support.x[0] + float(rng.uniform(*gap)), []
    for make in makers:
        obj = make()
        low, high = obj.bounds
        if high[1] > support.room or high[2] - low[2] > support.z[1] - support.z[0]:
            continue
        if at + high[0] - low[0] > support.x[1]:
            break
        z = support.z[1] - high[2] if front else 0.5 * (sum(support.z) - low[2] - high[2])
        placed.append(obj.moved((at - low[0], support.y, z)))
        at += high[0] - low[0] + float(rng.uniform(*gap)) + 1e-4
    return placed


def place_at(support: Support, obj: SceneObject, x: float = 0.5, z: float = 0.5) -> SceneObject:
    """Place an object at fractions x and z of a support's width and depth."""
    at = (
        (1.0 - x) * support.x[0] + x * support.x[1],
        support.y,
        (1.0 - z) * support.z[0] + z * support.z[1],
    )
    return obj.moved(at)


def _fits(support: Support, low: np.ndarray, high: np.ndarray) -> bool:
    """Return whether an object of these bounds is no larger than the support."""
    wide, deep = high[0] - low[0], high[2] - low[2]
    return bool(wide <= support.x[1] - support.x[0] and deep <= support.z[1] - support.z[0])


def _footprint(obj: SceneObject) -> np.ndarray:
    """Return the bounds of an object widened by half of the gap, (2, 3), metres."""
    margin = np.array([0.5 * _GAP, 0.0, 0.5 * _GAP])
    low, high = obj.bounds
    return np.stack([low - margin, high + margin])


def draw_makers(rng: Random, makers: Sequence[Maker], count: int) -> list[Maker]:
    """Draw some of several makers, perhaps one more than once."""
    return [makers[int(i)] for i in rng.integers(0, len(makers), count)]


def draw_vessels(rng: Random, palette: Palette, count: int, small: bool = False) -> list[Maker]:
    """Draw makers of vessels."""
    tall = 0.17 if small else 0.26
    makers: list[Maker] = [
        lambda: vessels.vase(rng, palette, tall),
        lambda: vessels.bowl(rng, palette, 0.4 * tall + 0.02),
        lambda: vessels.bottle(rng, palette),
        lambda: vessels.cup(rng, palette),
    ]
    return draw_makers(rng, makers, count)


def draw_toys(rng: Random, palette: Palette, count: int) -> list[Maker]:
    """Draw makers of toys."""
    makers: list[Maker] = [
        lambda: small_objects.ball(rng, palette, 0.07),
        lambda: small_objects.block_stack(rng, palette, 0.065),
        lambda: small_objects.block(rng, palette, 0.07),
        lambda: small_objects.block(rng, palette, 0.07),
        lambda: small_objects.ring_tower(palette, 0.085, 4),
    ]
    return draw_makers(rng, makers, count)


def draw_sculptures(rng: Random, palette: Palette, count: int, size: float) -> list[Maker]:
    """Draw makers of sculptures, every kind once before any kind comes a second time."""
    makers: list[Maker] = [
        lambda: small_objects.knot_sculpture(rng, palette, 0.5 * size),
        lambda: small_objects.quadric_sculpture(rng, palette, size),
        lambda: small_objects.pebble(rng, palette, 0.55 * size),
        lambda: vessels.vase(rng, palette, 1.5 * size),
    ]
    order = [*rng.permutation(len(makers)), *rng.permutation(len(makers))]
    return [makers[int(i)] for i in order[:count]]


def row_of_books(
    rng: Random, palette: Palette, support: Support, fraction: float = 1.0
) -> list[SceneObject]:
    """Stand books side by side on a fraction of a support's width, from the left."""
    low, high = support.x
    part = Support((low, low + fraction * (high - low)), support.z, support.y, support.room)
    makers: list[Maker] = [lambda: small_objects.book(rng, palette)] * 60
    return in_row(rng, part, makers, (0.0, 0.002), front=True)


def stack_books(
    rng: Random, palette: Palette, support: Support, count: int, taken: list[SceneObject]
) -> list[SceneObject]:
    """Stack books, the largest at the bottom, at a free position of a support.

    Parameters
    ----------
    taken : objects that stand on the support already
    """
    made = [small_objects.book(rng, palette, lying=True) for _ in range(count)]
    made.sort(key=lambda book: -float(book.bounds[1, 0]))
    placed = scatter(rng, support, [lambda: made[0]], taken)
    if not placed:
        return []
    for book in made[1:]:
        below = placed[-1].bounds
        middle = below.mean(axis=0)
        turned = book.turned(float(rng.uniform(-9.0, 9.0)))
        laid = turned.moved((middle[0], below[1, 1], middle[2]))
        if any(overlap(laid.boxes, other.boxes) for other in taken):
            break
        placed.append(laid)
    return placed


def furnish(
    rng: Random,
    carrier: SceneObject,
    makers: list[Maker],
    support: int = 0,
    first: list[SceneObject] | None = None,
) -> list[SceneObject]:
    """Return an object with others scattered on one of its supports.

    Parameters
    ----------
    carrier : the object that carries the others
    support : index of the support
    first : objects placed on that support already
    """
    placed = list(first or [])
    return [carrier, *placed, *scatter(rng, carrier.supports[support], makers, placed)]


def fill_shelf(
    rng: Random, palette: Palette, shelf: SceneObject, book_probability: float = 0.6
) -> list[SceneObject]:
    """Return a shelf with books or vessels on every board, vessels on top.

    Parameters
    ----------
    book_probability : that a board holds books; they leave some room for vessels
    """
    group = [shelf]
    for board in shelf.supports[:-1]:
        if rng.random() < book_probability:
            filled = float(rng.uniform(0.55, 1.0))
            group += row_of_books(rng, palette, board, filled)
            low, high = board.x
            rest = Support((low + filled * (high - low) + 0.02, high), board.z, board.y, board.room)
            group += in_row(rng, rest, draw_vessels(rng, palette, 2, small=True), (0.02, 0.08))
        else:
            group += in_row(rng, board, draw_vessels(rng, palette, 6, small=True), (0.03, 0.12))
    top = shelf.supports[-1]
    return group + in_row(rng, top, draw_vessels(rng, palette, 3), (0.1, 0.3))
