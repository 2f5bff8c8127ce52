"""What timings depend on: the machine, the versions, and the load by other programs."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import psutil

from photonmap.results.record import describe_versions
from photonmap.study.measure import Point

MAX_BACKGROUND_LOAD = 0.1
"""Fraction of all processors, taken by other programs, above which wall times are unreliable."""

_PROCESSORS = Path("/proc/cpuinfo")


def describe_machine() -> dict[str, Any]:
    """Return what timings depend on: system, processor, processors, load_before, versions."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "processors": os.cpu_count(),
        "load_before": psutil.getloadavg()[0],
        "versions": describe_versions(),
    }


def choose_clock(points: Sequence[Point], others: float, threads: int) -> list[Point]:
    """Return points timed by the wall clock, or by processor time on a loaded machine.

    Parameters
    ----------
    points : timed by both clocks
    others : fraction of all processors that other programs took
    threads : of the renders; on an idle machine, wall time is about processor time over threads
    """
    if others <= MAX_BACKGROUND_LOAD:
        return list(points)
    return [replace(point, seconds=point.processor / threads) for point in points]


class BackgroundLoad:
    """Measures the fraction of all processors that other programs take while it is entered."""

    share = 0.0

    def __enter__(self) -> Self:
        """Start to measure."""
        self._machine, self._own, self._wall = _busy(), _own(), time.perf_counter()
        return self

    def __exit__(self, *exception: object) -> None:
        """Set `share`; child processes count as own work once they have ended."""
        foreign = (_busy() - self._machine) - (_own() - self._own)
        span = (time.perf_counter() - self._wall) * (os.cpu_count() or 1)
        self.share = max(foreign / span, 0.0)


def _processor() -> str:
    """Return the name of the processor as the system reports it."""
    if _PROCESSORS.is_file():
        for line in _PROCESSORS.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _busy() -> float:
    """Return the processor seconds of all programs since the system started."""
    times = psutil.cpu_times()
    return times.user + times.system + getattr(times, "nice", 0.0)


def _own() -> float:
    """Return the processor seconds of this process and of its children that have ended."""
    return sum(os.times()[:4])
