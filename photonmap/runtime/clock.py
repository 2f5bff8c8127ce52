"""Seconds of stages."""

from __future__ import annotations

import time


class Clock:
    """Seconds of the stages of a render, by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """End a stage, which began where the one before ended."""
        now = time.perf_counter()
        self.seconds[stage], self._last = now - self._last, now
