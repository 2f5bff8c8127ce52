"""Timing on a shared machine: interleaved repeats."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any


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
    """Time each call `repeats` times, taking turns in a rotating order.

    `before` runs ahead of each call and is not timed. A first round warms up and does not count.
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
