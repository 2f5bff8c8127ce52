"""Clocks for a machine that others use too: interleaved repeats."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


def timed(call: Callable[[], Any]) -> float:
    """Return the seconds that a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def interleave(
    calls: dict[str, Callable[[], Any]],
    repeats: int,
    before: Callable[[], Any] = lambda: None,
) -> dict[str, list[float]]:
    """Time each call `repeats` times, taking turns in an order that rotates.

    `before` runs ahead of each call, untimed; one round goes ahead of all and does not count.
    """
    names = list(calls)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for repeat in range(-1, repeats):
        for place in range(len(names)):
            name = names[(repeat + place) % len(names)]
            before()
            spent = timed(calls[name])
            if repeat >= 0:
                seconds[name].append(spent)
    return seconds


def ratio(above: list[float], below: list[float]) -> float:
    """Return the median of the ratios of two interleaved series."""
    return statistics.median(a / b for a, b in zip(above, below, strict=True))


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """Return p of the power law seconds ~ size^p that fits best."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
