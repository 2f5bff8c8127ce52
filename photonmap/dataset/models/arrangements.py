"""Arrangements: furniture with objects on it, to be placed as a group."""

from __future__ import annotations

from photonmap.dataset.models import accessories, sculptures, toys, vessels
from photonmap.dataset.models.materials.palette import Palette
from photonmap.dataset.models.placement import Maker, in_row, scatter
from photonmap.dataset.models.scene_object import SceneObject, Support, overlap
from photonmap.dataset.models.shapes import Random


def draw_vessels(rng: Random, palette: Palette, count: int, small: bool = False) -> list[Maker]:
    """Draw makers of vessels."""
    tall = 0.17 if small else 0.26
    makers: list[Maker] = [
        lambda: vessels.vase(rng, palette, tall),
        lambda: vessels.bowl(rng, palette, 0.4 * tall + 0.02),
        lambda: vessels.bottle(rng, palette),
        lambda: vessels.cup(rng, palette),
    ]
    return [makers[int(i)] for i in rng.integers(0, len(makers), count)]


def draw_toys(rng: Random, palette: Palette, count: int) -> list[Maker]:
    """Draw makers of toys."""
    makers: list[Maker] = [
        lambda: toys.ball(rng, palette, 0.07),
        lambda: toys.block_stack(rng, palette, 0.065),
        lambda: toys.block(rng, palette, 0.07),
        lambda: toys.block(rng, palette, 0.07),
        lambda: toys.ring_tower(palette, 0.085, 4),
    ]
    return [makers[int(i)] for i in rng.integers(0, len(makers), count)]


def draw_sculptures(rng: Random, palette: Palette, count: int, size: float) -> list[Maker]:
    """Draw makers of sculptures, every kind once before any kind comes a second time."""
    makers: list[Maker] = [
        lambda: sculptures.knot_sculpture(rng, palette, 0.5 * size),
        lambda: sculptures.quadric_sculpture(rng, palette, size),
        lambda: sculptures.pebble(rng, palette, 0.55 * size),
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
    makers: list[Maker] = [lambda: accessories.book(rng, palette)] * 60
    return in_row(rng, part, makers, (0.0, 0.002), front=True)


def stack_books(
    rng: Random, palette: Palette, support: Support, count: int, taken: list[SceneObject]
) -> list[SceneObject]:
    """Stack books, the largest at the bottom, at a free position of a support.

    Parameters
    ----------
    taken : objects that stand on the support already
    """
    made = [accessories.book(rng, palette, lying=True) for _ in range(count)]
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
