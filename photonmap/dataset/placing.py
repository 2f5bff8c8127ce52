"""Put things on levels at random, so that they rest exactly and do not cut into each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from photonmap.dataset.solids import Random
from photonmap.dataset.things import Support, Thing, overlap

Maker = Callable[[], Thing]
"""Makes a thing around the origin."""

_ATTEMPTS = 24
_GAP = 0.012
"""Metres between things on one level."""


def scatter(
    rng: Random, support: Support, makers: Sequence[Maker], taken: Sequence[Thing] = ()
) -> list[Thing]:
    """Rest things at random places of a level, turned at random; leave out what does not fit.

    Parameters
    ----------
    taken : what stands there already
    """
    boxes = [_footprint(thing) for thing in taken]
    placed = []
    for make in makers:
        made = make().turned(float(rng.uniform(0.0, 360.0)))
        low, high = made.bounds
        if high[1] > support.room or not _fits(support, low, high):
            continue
        for _ in range(_ATTEMPTS):
            x = rng.uniform(support.x[0] - low[0], support.x[1] - high[0])
            z = rng.uniform(support.z[0] - low[2], support.z[1] - high[2])
            thing = made.moved((x, support.y, z))
            foot = _footprint(thing)
            if not any(overlap(foot[None], box[None]) for box in boxes):
                boxes.append(foot)
                placed.append(thing)
                break
    return placed


def in_row(
    rng: Random,
    support: Support,
    makers: Sequence[Maker],
    gap: tuple[float, float] = (0.0, 0.0),
    front: bool = False,
) -> list[Thing]:
    """Rest things side by side along x until the level is full.

    Parameters
    ----------
    gap : least and greatest distance between neighbours, metres
    front : they stand at the front edge, high z; otherwise in the middle
    """
    at, placed = support.x[0] + float(rng.uniform(*gap)), []
    for make in makers:
        thing = make()
        low, high = thing.bounds
        if high[1] > support.room or high[2] - low[2] > support.z[1] - support.z[0]:
            continue
        if at + high[0] - low[0] > support.x[1]:
            break
        z = support.z[1] - high[2] if front else 0.5 * (sum(support.z) - low[2] - high[2])
        placed.append(thing.moved((at - low[0], support.y, z)))
        at += high[0] - low[0] + float(rng.uniform(*gap)) + 1e-4
    return placed


def centered(support: Support, thing: Thing, x: float = 0.5, z: float = 0.5) -> Thing:
    """Rest a thing at a share of a level's width and depth."""
    at = (
        (1.0 - x) * support.x[0] + x * support.x[1],
        support.y,
        (1.0 - z) * support.z[0] + z * support.z[1],
    )
    return thing.moved(at)


def _fits(support: Support, low: np.ndarray, high: np.ndarray) -> bool:
    wide, deep = high[0] - low[0], high[2] - low[2]
    return bool(wide <= support.x[1] - support.x[0] and deep <= support.z[1] - support.z[0])


def _footprint(thing: Thing) -> np.ndarray:
    """Return the bounds of a thing with half of the gap around it, (2, 3)."""
    margin = np.array([0.5 * _GAP, 0.0, 0.5 * _GAP])
    low, high = thing.bounds
    return np.stack([low - margin, high + margin])
