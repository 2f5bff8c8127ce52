"""Clocks for a machine that others use too: interleaved repeats, and how much others took."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np
import psutil


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


class Others:
    """Tells which share of all processors other programs took while it was entered."""

    share = 0.0

    def __enter__(self) -> Self:
        """Begin to watch."""
        self._machine, self._own, self._wall = _busy(), _own(), time.perf_counter()
        return self

    def __exit__(self, *exception: object) -> None:
        """Work out the share; children count as own work once they have ended."""
        foreign = (_busy() - self._machine) - (_own() - self._own)
        span = (time.perf_counter() - self._wall) * (os.cpu_count() or 1)
        self.share = max(foreign / span, 0.0)


def _busy() -> float:
    times = psutil.cpu_times()
    return times.user + times.system + getattr(times, "nice", 0.0)


def _own() -> float:
    return sum(os.times()[:4])
