"""Place objects on supports at random, resting exactly and without intersections."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

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
