"""What seconds depend on: the machine, the versions, and what others did to it meanwhile."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import psutil

from photonmap.record import describe_versions
from photonmap.study.point import Point

DISTURBED = 0.1
"""Share of all processors that other programs may take before the wall clock tells little."""

_PROCESSORS = Path("/proc/cpuinfo")


def describe_machine() -> dict[str, Any]:
    """Return what the numbers depend on: system, processor, processors, load_before, versions."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "processors": os.cpu_count(),
        "load_before": psutil.getloadavg()[0],
        "versions": describe_versions(),
    }


def choose_clock(points: Sequence[Point], others: float, threads: int) -> list[Point]:
    """Return points whose seconds are by the wall, or by the processors where others disturbed.

    Parameters
    ----------
    points : timed by both
    others : share of the machine that other programs took
    threads : that rendered; on an idle machine seconds are about processor time over these
    """
    if others <= DISTURBED:
        return list(points)
    return [replace(point, seconds=point.processor / threads) for point in points]


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


def _processor() -> str:
    """Return the processor's name as the system tells it."""
    if _PROCESSORS.is_file():
        for line in _PROCESSORS.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _busy() -> float:
    times = psutil.cpu_times()
    return times.user + times.system + getattr(times, "nice", 0.0)


def _own() -> float:
    return sum(os.times()[:4])
