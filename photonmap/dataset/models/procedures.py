"""Procedures that paint: wood, marble, cloth, tiles and prints, as images of a few colours.

All repeat without a seam, as they are sums of waves whose numbers across the image are whole.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from photonmap.dataset.models.shapes import Floats, Random

LEVELS = 16
"""Mixtures of two colours, the pure ones included."""

Indices = NDArray[np.int32]


class Procedure(NamedTuple):
    """A way to paint.

    Parameters
    ----------
    paint : returns which mixture a texel has, (H, W), from 0, the first colour, to `LEVELS` - 1
    size : (H, W), texels
    period : width and height of the image on surfaces, metres; u runs along the grain
    darker : steps of Munsell value from the first colour to the second
    """

    paint: Callable[[Random, Floats, Floats], Floats]
    size: tuple[int, int]
    period: tuple[float, float]
    darker: int


def _waves(rng: Random, x: Floats, y: Floats, most: tuple[int, int], count: int = 24) -> Floats:
    """Return smooth noise of variance about 1 that repeats; up to `most` waves along x and y."""
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    strength = 0.0
    for _ in range(count):
        i, k = int(rng.integers(-most[0], most[0] + 1)), int(rng.integers(0, most[1] + 1))
        weight = 1.0 / (1.0 + np.hypot(i / max(most[0], 1), k / max(most[1], 1)) * 3.0)
        phase = rng.uniform(0.0, 2.0 * np.pi)
        total += weight * np.cos(2.0 * np.pi * (i * x + k * y) + phase)
        strength += 0.5 * weight**2
    return total / np.sqrt(strength)


def wood(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return year rings cut along the grain, which is along x, with fine pores."""
    bend = 0.35 * _waves(rng, x, y, (2, 3))
    rings = 0.5 + 0.5 * np.sin(2.0 * np.pi * (6.0 * y + bend))
    fibre = _waves(rng, x, y, (5, 60), 40)
    return 0.15 + 0.6 * rings**3 + 0.09 * fibre


def marble(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return thin veins, warped twice, on a cloudy ground."""
    shift = [0.06 * _waves(rng, x, y, (4, 4)) for _ in range(2)]
    field = _waves(rng, x + shift[0], y + shift[1], (3, 3), 12)
    finer = _waves(rng, x + shift[1], y - shift[0], (7, 7), 20)
    veins = np.exp(-14.0 * np.abs(field)) + 0.5 * np.exp(-18.0 * np.abs(finer))
    return 0.1 + 0.08 * finer + 0.8 * veins


def cloth(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return a plain weave in a check: threads of two colours cross over and under."""
    threads = 48
    i, k = np.floor(x * threads).astype(int), np.floor(y * threads).astype(int)
    stripe = np.repeat(rng.random(threads // 4) < 0.4, 4)
    over = (i + k) % 2 == 0
    colored = np.where(over, stripe[i % threads], stripe[k % threads])
    across = np.where(over, x, y) * threads % 1.0
    shade = 0.25 * (2.0 * across - 1.0) ** 2
    return 0.1 + 0.6 * colored + shade


def tiles(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return tiles of slightly different shades with grout between them."""
    count = 4
    i, k = np.floor(x * count).astype(int), np.floor(y * count).astype(int)
    shade = 0.3 * rng.random((count, count))[i % count, k % count]
    edge = np.minimum.reduce([x * count % 1, 1 - x * count % 1, y * count % 1, 1 - y * count % 1])
    return np.where(edge < 0.025, 1.0, shade)


def print_(rng: Random, x: Floats, y: Floats) -> Floats:
    """Return a pattern in two colours with sharp edges: dots, leaves, waves or diamonds."""
    kind, count = int(rng.integers(4)), int(rng.integers(3, 7))
    row = np.floor(y * 2 * count)
    u = (x * count + 0.5 * (row % 2)) % 1.0 - 0.5
    v = (y * 2 * count) % 1.0 - 0.5
    if kind == 0:
        inside = np.hypot(u, 0.5 * v) < 0.2
    elif kind == 1:
        inside = np.abs(v) < 0.42 * np.cos(np.pi * np.clip(2.2 * u, -0.5, 0.5)) ** 2 * (
            np.abs(u) < 0.23
        )
    elif kind == 2:
        inside = (y * count + 0.18 * np.sin(2.0 * np.pi * count * x)) % 1.0 < 0.4
    else:
        inside = np.abs(u) + 0.5 * np.abs(v) < 0.24
    return inside.astype(np.float64)


PROCEDURES = {
    "wood": Procedure(wood, (256, 256), (1.2, 0.5), 1),
    "marble": Procedure(marble, (256, 256), (1.1, 1.1), 3),
    "cloth": Procedure(cloth, (240, 240), (0.24, 0.24), 2),
    "tiles": Procedure(tiles, (240, 240), (0.8, 0.8), 2),
    "print": Procedure(print_, (256, 256), (0.6, 0.6), 1),
}
"""By the names that materials have."""


def paint(name: str, rng: Random) -> Indices:
    """Return the image of a procedure: which mixture of two colours each texel is, (H, W)."""
    procedure = PROCEDURES[name]
    height, width = procedure.size
    x = (np.arange(width) + 0.5) / width
    y = (np.arange(height) + 0.5) / height
    amount = procedure.paint(rng, *np.meshgrid(x, y))
    return np.rint(np.clip(amount, 0.0, 1.0) * (LEVELS - 1)).astype(np.int32)
