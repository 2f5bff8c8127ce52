"""Furniture with things on it, as groups that are placed together."""

from __future__ import annotations

from photonmap.dataset import fixtures, toys, vessels
from photonmap.dataset.palette import Palette
from photonmap.dataset.placing import Maker, in_row, scatter
from photonmap.dataset.solids import Random
from photonmap.dataset.things import Support, Thing, overlap


def ware(rng: Random, palette: Palette, count: int, small: bool = False) -> list[Maker]:
    """Draw makers of vessels."""
    tall = 0.17 if small else 0.26
    makers: list[Maker] = [
        lambda: vessels.vase(rng, palette, tall),
        lambda: vessels.bowl(rng, palette, 0.4 * tall + 0.02),
        lambda: vessels.bottle(rng, palette),
        lambda: vessels.cup(rng, palette),
    ]
    return [makers[int(i)] for i in rng.integers(0, len(makers), count)]


def playthings(rng: Random, palette: Palette, count: int) -> list[Maker]:
    """Draw makers of toys."""
    makers: list[Maker] = [
        lambda: toys.ball(rng, palette, 0.07),
        lambda: toys.block_stack(rng, palette, 0.065),
        lambda: toys.block(rng, palette, 0.07),
        lambda: toys.block(rng, palette, 0.07),
        lambda: toys.ring_tower(palette, 0.085, 4),
    ]
    return [makers[int(i)] for i in rng.integers(0, len(makers), count)]


def sculptures(rng: Random, palette: Palette, count: int, size: float) -> list[Maker]:
    """Draw makers of sculpture, each kind before any twice."""
    makers: list[Maker] = [
        lambda: toys.knot_sculpture(rng, palette, 0.5 * size),
        lambda: toys.quadric_sculpture(rng, palette, size),
        lambda: toys.pebble(rng, palette, 0.55 * size),
        lambda: vessels.vase(rng, palette, 1.5 * size),
    ]
    order = [*rng.permutation(len(makers)), *rng.permutation(len(makers))]
    return [makers[int(i)] for i in order[:count]]


def books(rng: Random, palette: Palette, level: Support, share: float = 1.0) -> list[Thing]:
    """Stand books side by side on a share of a level's width, from the left."""
    low, high = level.x
    part = Support((low, low + share * (high - low)), level.z, level.y, level.room)
    makers: list[Maker] = [lambda: fixtures.book(rng, palette)] * 60
    return in_row(rng, part, makers, (0.0, 0.002), front=True)


def pile(
    rng: Random, palette: Palette, level: Support, count: int, taken: list[Thing]
) -> list[Thing]:
    """Lay books on top of each other, the largest below, at a free place of a level."""
    made = [fixtures.book(rng, palette, lying=True) for _ in range(count)]
    made.sort(key=lambda thing: -float(thing.bounds[1, 0]))
    placed = scatter(rng, level, [lambda: made[0]], taken)
    if not placed:
        return []
    for thing in made[1:]:
        below = placed[-1].bounds
        middle = below.mean(axis=0)
        turned = thing.turned(float(rng.uniform(-9.0, 9.0)))
        laid = turned.moved((middle[0], below[1, 1], middle[2]))
        if any(overlap(laid.boxes, other.boxes) for other in taken):
            break
        placed.append(laid)
    return placed


def laden(
    rng: Random, thing: Thing, makers: list[Maker], level: int = 0, first: list[Thing] | None = None
) -> list[Thing]:
    """Return a thing with others scattered on one of its levels, besides those there already."""
    placed = list(first or [])
    return [thing, *placed, *scatter(rng, thing.supports[level], makers, placed)]


def filled_shelf(rng: Random, palette: Palette, shelf: Thing, bookish: float = 0.6) -> list[Thing]:
    """Return a shelf with books or vessels on every board.

    Parameters
    ----------
    bookish : the chance that a board holds books; they leave some room for a vessel
    """
    group = [shelf]
    for level in shelf.supports[:-1]:
        if rng.random() < bookish:
            share = float(rng.uniform(0.55, 1.0))
            group += books(rng, palette, level, share)
            low, high = level.x
            rest = Support((low + share * (high - low) + 0.02, high), level.z, level.y, level.room)
            group += in_row(rng, rest, ware(rng, palette, 2, small=True), (0.02, 0.08))
        else:
            group += in_row(rng, level, ware(rng, palette, 6, small=True), (0.03, 0.12))
    top = shelf.supports[-1]
    return group + in_row(rng, top, ware(rng, palette, 3), (0.1, 0.3))
