"""Pass after pass until the budget is spent, saved on the way if asked for."""

from __future__ import annotations

import math
import time
from dataclasses import asdict
from typing import Any

from photonmap.bias import BiasProbe
from photonmap.budget import Budget
from photonmap.checkpoint import Checkpoint
from photonmap.errors import warn
from photonmap.focus import Focus
from photonmap.forecast import Forecast
from photonmap.ledger import Ledger
from photonmap.passes import Passes
from photonmap.progress import Progress


class Rounds:
    """Takes passes into moments.

    Parameters
    ----------
    run, moments : from which passes come, and into which they are taken
    budget : when to stop
    probe : estimates the bias on the way
    focus : learns where to sample; None to sample evenly
    checkpoint : where to save the state; None for nowhere
    resume : go on from the checkpoint's file

    Raises
    ------
    InputError : the checkpoint cannot be gone on from
    """

    def __init__(
        self,
        run: Passes,
        moments: Ledger,
        budget: Budget,
        probe: BiasProbe,
        focus: Focus | None = None,
        checkpoint: Checkpoint | None = None,
        resume: bool = False,
    ) -> None:
        self._run, self._moments, self._budget, self._probe = run, moments, budget, probe
        self._focus = focus
        if focus is not None:
            run.powers = focus.powers
        self._checkpoint = checkpoint
        self._start = time.perf_counter()
        self.resumed, self.earlier, self._saving = 0, 0.0, 0.0
        self.interrupted, self._adding = False, False
        if checkpoint is not None and resume:
            if checkpoint.path.exists():
                self._load(checkpoint)
            else:
                warn(f"{checkpoint.path}: there is no checkpoint yet: starting anew")
        self._counters = run.counters
        self._forecast = Forecast(budget, self.resumed, self.earlier, run.shares)

    @property
    def _arrays(self) -> dict[str, Any]:
        arrays = {**self._moments.arrays, **self._probe.arrays}
        if self._focus is not None:
            arrays |= {"first passes": self._focus.moments, "powers": self._focus.powers}
        return arrays

    def _load(self, checkpoint: Checkpoint) -> None:
        state = checkpoint.load(self._arrays)
        self._moments.resume(state["passes"])
        self._run.resume(state["counters"])
        self.resumed, self.earlier = state["passes"], state["elapsed"]
        self._saving = state["saving"]

    @property
    def saving(self) -> float:
        """Seconds that checkpoints took, those of earlier runs too."""
        return self._saving + (self._checkpoint.seconds if self._checkpoint else 0.0)

    @property
    def predicted(self) -> list[tuple[float, float]]:
        """Seconds after 1, 2, 4, … passes, and the seconds in all that were predicted then."""
        return self._forecast.pairs

    @property
    def saves(self) -> bool:
        """Whether the state is saved."""
        return self._checkpoint is not None

    @property
    def elapsed(self) -> float:
        """Seconds of passes so far, those of earlier runs too."""
        return self.earlier + time.perf_counter() - self._start

    def describe_goal(self) -> dict[str, Any] | None:
        """Return the error that was aimed at, and what was reached; None for another budget."""
        if self._budget.goal is None:
            return None
        reached = self.error()
        return {
            **asdict(self._budget.goal),
            "reached": reached if math.isfinite(reached) else None,
        }

    def error(self) -> float:
        """Return the error that the budget judges so far; that of radiance if it judges none."""
        goal, lit = self._budget.goal, self._run.stores > 0
        if goal is None or goal.is_plain:
            error = self._moments.whole.error(lit=lit)
            return math.hypot(error, self.bias or 0.0)
        return self._moments.whole.error(goal.buffer, goal.percentile, lit)

    @property
    def bias(self) -> float | None:
        """The estimated bias of radiance, see `BiasProbe`."""
        return self._probe.bias(self._moments.whole.count)

    def go(self, progress: Progress) -> None:
        """Take passes until the budget is spent, or until Ctrl-C, and save the last state.

        Raises
        ------
        KeyboardInterrupt : before the first pass was complete; or again, amid arrays
        """
        self._start = time.perf_counter()
        try:
            self._repeat(progress)
        except KeyboardInterrupt:
            if self._moments.whole.count == 0 or self._adding:
                raise
            self.interrupted = True
            self._run.resume(self._counters)  # without the pass that was cut off
        if self._checkpoint is not None:
            self._checkpoint.save(self._arrays, self._state())

    def _repeat(self, progress: Progress) -> None:
        run, whole = self._run, self._moments.whole
        error = self.error()
        while not self._budget.is_spent(whole.count, error, self.elapsed):
            pixels = run.run(whole.count)
            self._adding = True
            self._moments.add(pixels, run.seen)
            self._adding = False
            if self._focus is not None:
                self._focus.learn(whole.count - 1, pixels, run.seen, run.plan)
            self._probe.probe(whole.count - 1, pixels, whole)
            self._counters = run.counters
            error, elapsed = self.error(), self.elapsed
            total = self._forecast.total(whole.count, error, elapsed, run.setup_seconds)
            progress.update(whole.count, error, elapsed / total, elapsed, run.rays / elapsed)
            if self._checkpoint is not None:
                self._checkpoint.save_if_due(self._arrays, self._state())

    def _state(self) -> dict[str, Any]:
        return {
            "passes": self._moments.whole.count,
            "counters": self._counters,
            "elapsed": self.elapsed,
            "saving": self.saving,
        }
