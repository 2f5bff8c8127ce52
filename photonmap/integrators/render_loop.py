"""Pass after pass until the budget is spent, with checkpoints on request."""

from __future__ import annotations

import math
import time
from copy import copy
from dataclasses import asdict
from typing import Any

from photonmap.errors import warn
from photonmap.film.bias import BiasProbe
from photonmap.film.budget import LEAST_PASSES, NEAR, Budget
from photonmap.film.forecast import Forecast
from photonmap.film.light_filter import EXPECTED
from photonmap.film.light_groups import LightGroups
from photonmap.film.moments import Accumulator
from photonmap.integrators.adaptive_sampling import (
    PILOT_PASSES,
    AdaptiveSampling,
    choose_size,
    first_size,
)
from photonmap.integrators.base import Integrator
from photonmap.kernels.core.passes import Estimate
from photonmap.runtime.checkpoint import Checkpoint
from photonmap.runtime.progress import Progress


class RenderLoop:
    """Takes passes of an integrator into moments until a budget is spent.

    The probe estimates the bias on the way. Without `adaptive`, samples are even; `pass_samples` is
    the fraction of the usual ones in a pass, None to choose it by the goal. The state is saved to
    the checkpoint, if there is one, from whose file a run is resumed on request; one that cannot be
    is an `InputError`.
    """

    def __init__(
        self,
        integrator: Integrator,
        moments: LightGroups,
        budget: Budget,
        probe: BiasProbe,
        adaptive: AdaptiveSampling | None = None,
        pass_samples: float | None = None,
        checkpoint: Checkpoint | None = None,
        resume: bool = False,
    ) -> None:
        self._integrator, self._moments = integrator, moments
        self._budget, self._probe = budget, probe
        self._adaptive = adaptive
        if adaptive is not None:
            integrator.sample_scales = adaptive.sample_scales
        self.pass_samples = pass_samples or first_size(budget.goal if integrator.adapts else None)
        self._settled = pass_samples is not None or self.pass_samples == 1.0
        self._checkpoint = checkpoint
        self._start = time.perf_counter()
        self.resumed, self.earlier, self._saving = 0, 0.0, 0.0
        self.interrupted, self._adding = False, False
        self._filtered = 1.0 / NEAR  # the error of filtered light over that of passes, at last
        if checkpoint is not None and resume:
            if checkpoint.path.exists():
                self._load(checkpoint)
            else:
                warn(f"{checkpoint.path}: there is no checkpoint yet; starting from scratch")
        if self.pass_samples != 1.0:
            integrator.resize_passes(self.pass_samples)
        self._counters = asdict(integrator.counters)
        self._forecast = Forecast(budget, self.resumed, self.earlier, integrator.shares)

    def of_part(self, moments: LightGroups, probe: BiasProbe) -> RenderLoop:
        """Return the loop that took the same passes into these moments and this probe alone."""
        loop = copy(self)
        loop._moments, loop._probe = moments, probe
        return loop

    @property
    def _arrays(self) -> dict[str, Any]:
        arrays = {**self._moments.arrays, **self._probe.arrays}
        if self._adaptive is not None:
            arrays |= {
                "first passes": self._adaptive.moments,
                "powers": self._adaptive.sample_scales,
            }
        return arrays

    def _load(self, checkpoint: Checkpoint) -> None:
        def arrays(state: dict[str, Any]) -> dict[str, Any]:
            self._moments.resume(state["passes"])
            return self._arrays

        state = checkpoint.load(arrays)
        self._integrator.counters.restore(state["counters"])
        self.resumed, self.earlier = state["passes"], state["elapsed"]
        self._saving, self._filtered = state["saving"], state["filtered"]
        self.pass_samples, self._settled = state["pass_samples"], state["settled"]
        asked = self._budget.passes
        if asked is not None and self.resumed > asked:
            warn(
                f"{checkpoint.path}: has {self.resumed} passes, more than the {asked} that were "
                "asked for; all of them are in the result"
            )

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
        """Return the error that was aimed at; None for another budget.

        `reached` is the error of that kind so far, above `limit` where the goal is missed; None
        where it is not known.
        """
        if self._budget.goal is None:
            return None
        error, lit = self._error_of(self._moments.filtered), self._integrator.stores_photons
        is_known = math.isfinite(error) and self._moments.whole.states_error(lit)
        return {**asdict(self._budget.goal), "reached": error if is_known else None}

    def warn_of_missed_goal(self) -> None:
        """Warn where the passes ended before the error that was aimed at, or where none exists."""
        goal, whole = self._budget.goal, self._moments.whole
        if goal is None or self.interrupted:
            return
        if not self._budget.is_reached(whole.count, self.error()):
            passes, ceiling = self._budget.passes, self._budget.ceiling
            when = f"pass {passes}" if self._moments.passes == passes else f"{ceiling:.6g} s"
            warn(f"stopped after {when}, before the error {goal} was reached")
        elif not (whole.shows_nothing() or whole.states_error(self._integrator.stores_photons)):
            warn(
                f"there is no error {goal} to reach: every pixel is unresolved, or shows an "
                "emitter or background, wholly or in part"
            )

    def error(self) -> float:
        """Return the error that the budget limits, so far; that of radiance if it limits none."""
        moments, budget = self._moments, self._budget
        error = self._error_of(moments.whole)
        if moments.filters and moments.whole.count >= LEAST_PASSES and budget.is_near(error):
            if budget.is_met(error * self._filtered):
                self._filtered = self._error_of(moments.filtered) / error
            error *= self._filtered
        return error

    def _error_of(self, moments: Accumulator) -> float:
        goal, lit = self._budget.goal, self._integrator.stores_photons
        if goal is None or goal.is_plain:
            return math.hypot(moments.error(lit=lit), self.bias or 0.0)
        return moments.error(goal.buffer, goal.percentile, lit)

    @property
    def bias(self) -> float | None:
        """The estimated bias of radiance, see `BiasProbe`."""
        return self._probe.bias(self._moments.whole.count)

    def describe_bias_blocks(self, scale: float) -> dict[str, Any] | None:
        """Return the estimated bias of blocks of pixels, times `scale`; None if it is not known."""
        blocks = self._probe.blocks(self._moments.whole.count, self._moments.whole, scale)
        return None if blocks is None else blocks.describe()

    def run(self, progress: Progress) -> None:
        """Take passes until the budget is spent, or until Ctrl-C, and save the last state.

        It raises `KeyboardInterrupt` before the first pass was complete; or at a second one, while
        arrays are half-changed.
        """
        self._start = time.perf_counter()
        try:
            self._repeat(progress)
        except KeyboardInterrupt:
            if self._moments.passes == 0 or self._adding:
                raise
            self.interrupted = True
            progress.stage("interrupted")
            # without the pass that was interrupted
            self._integrator.counters.restore(self._counters)
        if self._checkpoint is not None:
            self._checkpoint.save(self._arrays, self._state())
        self._moments.close()

    def _repeat(self, progress: Progress) -> None:
        integrator, moments = self._integrator, self._moments
        error = self.error()
        while not self._budget.is_spent(moments.passes, error, self.elapsed):
            index = moments.passes
            estimate = integrator.estimate(index)
            self._adding = True
            moments.add(estimate.pixels, estimate.via_specular)
            self._adding = False
            if self._adaptive is not None:
                self._adaptive.learn(index, estimate, integrator.plan)
            self._probe.probe(index, estimate, moments.whole)
            self._counters = asdict(integrator.counters)
            error, elapsed, passes = self.error(), self.elapsed, index + 1
            # `error` is that of whole replicates
            now = error * math.sqrt(moments.whole.count / passes)
            total = self._forecast.total(passes, now, elapsed, integrator.setup_seconds)
            progress.update(
                passes, error, elapsed / total, elapsed, integrator.counters.rays / elapsed
            )
            if passes == PILOT_PASSES and not self._settled:
                self._settle(error, estimate)
            if self._checkpoint is not None:
                self._checkpoint.save_if_due(self._arrays, self._state())

    def _settle(self, error: float, estimate: Estimate) -> None:
        """Choose the size of passes by the error of the first ones; begin again if it changes.

        `estimate` is that of the last one.
        """
        expected = error * EXPECTED if self._moments.filters else error
        needed = self._forecast.passes_needed(self._moments.passes, expected)
        size = choose_size(needed, self._integrator.many_lights)
        self._settled = True
        if size == self.pass_samples:
            return
        self._adding = True
        self._moments.clear()
        self.pass_samples = size
        self._integrator.resize_passes(size)
        if self._adaptive is not None:
            self._adaptive.begin_again(estimate, self._integrator.plan)
        self._forecast.restart(self.elapsed - self._integrator.setup_seconds)
        self._adding = False

    def _state(self) -> dict[str, Any]:
        return {
            "passes": self._moments.passes,
            "counters": self._counters,
            "elapsed": self.elapsed,
            "saving": self.saving,
            "filtered": self._filtered,
            "pass_samples": self.pass_samples,
            "settled": self._settled,
        }
