"""How a render reports its progress: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from photonmap.errors import InputError
from photonmap.runtime.terminal import drawing, tolerant
from photonmap.runtime.wording import shown

if TYPE_CHECKING:
    from rich.progress import Progress as RichProgress

STAGES = {
    "load": "loading",
    "first compile": "compiling kernels for scenes of this kind (once)",
    "compile": "loading kernels",
    "render": "rendering",
    "interrupted": "interrupted; finishing with the complete passes (Ctrl-C again to discard them)",
    "write": "writing",
}
LINE_EVERY = 5.0
"""Seconds between plain lines."""
_WATCH_EVERY = 0.5
"""Least seconds between two images."""
_WATCH_SHARE = 0.05
"""The largest part of the time that showing images takes, after the first."""


class Progress(Protocol):
    """What a render calls; all times in seconds."""

    def stage(self, name: str) -> None:
        """Begin one of `STAGES`."""

    def update(
        self, passes: int, error: float, fraction: float, elapsed: float, rays: float, /
    ) -> None:
        """Report a complete pass: the error so far, the part done, rays per second."""

    def close(self) -> None:
        """End the last stage."""


class Silent:
    """Reports nothing."""

    def stage(self, name: str) -> None:
        """Do nothing."""

    def update(self, *state: float) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class CompileNotice(Silent):
    """One line on stderr where kernels are compiled, which may take a minute; else nothing."""

    def stage(self, name: str) -> None:
        """Print the line."""
        if name == "first compile":
            _print(f"photonmap: {STAGES[name]}")


class Lines(Silent):
    """Plain lines on stderr, one a stage and one every few seconds."""

    def __init__(self) -> None:
        self._last = -math.inf

    def stage(self, name: str) -> None:
        """Print the stage's name where it is worth a line."""
        if name in ("first compile", "render", "interrupted"):
            _print(STAGES[name])

    def update(self, *state: float) -> None:
        """Print a line if the last one is some seconds old."""
        if time.monotonic() - self._last >= LINE_EVERY:
            self._last = time.monotonic()
            _print(_describe(*state))


class Bar:
    """A progress bar on a terminal's stderr."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

        self._bar: RichProgress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[state]}"),
            console=Console(file=drawing(sys.stderr)),
            transient=True,
        )
        self._bar.start()
        self._task = self._bar.add_task("", total=None, state="")

    def stage(self, name: str) -> None:
        """Show the stage's name, and the bar if it was closed."""
        self._bar.start()
        self._bar.update(self._task, description=STAGES[name], total=None, state="")

    def update(self, *state: float) -> None:
        """Move the bar."""
        self._bar.update(self._task, total=1.0, completed=state[2], state=_describe(*state))

    def close(self) -> None:
        """Take the bar away."""
        self._bar.stop()


class Watching:
    """Progress that passes all calls on, and shows the image so far, which `snapshot` makes."""

    def __init__(
        self, progress: Progress, watch: Callable[[Any], None], snapshot: Callable[[int], Any]
    ) -> None:
        self._progress, self._watch, self._snapshot = progress, watch, snapshot
        self._due = 0.0

    def stage(self, name: str) -> None:
        """Pass it on."""
        self._progress.stage(name)

    def update(self, passes: int, *state: float) -> None:
        """Pass it on, and show the image if it is time."""
        self._progress.update(passes, *state)
        start = time.perf_counter()
        if start >= self._due:
            self._watch(self._snapshot(passes))
            now = time.perf_counter()
            self._due = now + max(_WATCH_EVERY, (now - start) / _WATCH_SHARE)

    def close(self) -> None:
        """Pass it on."""
        self._progress.close()


def choose_progress(quiet: bool) -> Progress:
    """Return a bar on a terminal, lines where stderr is piped, nothing if quiet."""
    if quiet:
        return Silent()
    return Bar() if tolerant(sys.stderr).isatty() else Lines()


def check_progress(progress: Progress | bool) -> Progress:
    """Return what is notified: the object itself, or what is chosen for True and False.

    One without methods to be notified by is an `InputError`.
    """
    if isinstance(progress, bool):
        return choose_progress(not progress)
    if not all(callable(getattr(progress, name, None)) for name in ("stage", "update", "close")):
        remedy = "give True, False, or an object with stage, update and close"
        raise InputError(f"progress {shown(progress)} cannot be notified; {remedy}")
    return progress


def check_watch(watch: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return what is called with images; what cannot be called is an `InputError`."""
    if not callable(watch):
        raise InputError(f"watch {shown(watch)} cannot be called; give a function of a Result")
    return watch


def _print(line: str) -> None:
    print(line, file=tolerant(sys.stderr), flush=True)


def _describe(passes: float, error: float, fraction: float, elapsed: float, rays: float) -> str:
    left = elapsed * (1.0 - fraction) / fraction if fraction > 0.0 else math.inf
    known = f"error {error:.4f}" if math.isfinite(error) else "error unknown yet"
    return f"pass {passes}, {known}, {duration(left)} left, {rays / 1e6:.1f} Mrays/s"


def duration(seconds: float) -> str:
    """Return a number of seconds in minutes and seconds."""
    if not math.isfinite(seconds):
        return "unknown time"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
