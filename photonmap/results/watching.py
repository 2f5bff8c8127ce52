"""The image of a render as it comes, shown now and then between passes."""

from __future__ import annotations

import time
from collections.abc import Callable

from photonmap.results.result import Result
from photonmap.runtime.progress import Progress

Watch = Callable[[Result], None]
"""Called with what a render has so far, without standard errors."""

_EVERY = 0.5
"""Least seconds between two images."""
_SHARE = 0.05
"""The largest part of the time that showing images takes, after the first."""


class Watching:
    """Progress that shows the image too.

    Parameters
    ----------
    progress : gets all calls that this one gets
    watch : shows an image
    snapshot : number of passes → the image so far
    """

    def __init__(self, progress: Progress, watch: Watch, snapshot: Callable[[int], Result]) -> None:
        self._progress, self._watch, self._snapshot = progress, watch, snapshot
        self._due = 0.0

    def stage(self, name: str) -> None:
        """Pass it on."""
        self._progress.stage(name)

    def update(
        self, passes: int, error: float, fraction: float, elapsed: float, rays: float
    ) -> None:
        """Pass it on, and show the image if it is time."""
        self._progress.update(passes, error, fraction, elapsed, rays)
        start = time.perf_counter()
        if start >= self._due:
            self._watch(self._snapshot(passes))
            now = time.perf_counter()
            self._due = now + max(_EVERY, (now - start) / _SHARE)

    def close(self) -> None:
        """Pass it on."""
        self._progress.close()
