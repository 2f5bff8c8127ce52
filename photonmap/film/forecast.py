"""How long a render will take, predicted after every pass."""

import math

from photonmap.film.bias import FOOTPRINTS_HOLD
from photonmap.film.budget import LEAST_PASSES, Budget

MOST_PASSES = 1e12
STEPS = 64


class Forecast:
    """Predicts the seconds that the passes of a budget take in all.

    `count` and `elapsed` are passes and seconds of earlier runs; with `sharing`, indirect light is
    shared over footprints that shrink, so that passes get noisier.
    """

    def __init__(
        self, budget: Budget, count: int = 0, elapsed: float = 0.0, sharing: bool = True
    ) -> None:
        self._budget, self._sharing = budget, sharing
        self._count, self._elapsed = count, elapsed
        self._predictions = 0
        self.pairs: list[tuple[float, float]] = []
        """(elapsed, predicted) after 1, 2, 4, 8, … passes of this run"""

    def restart(self, elapsed: float) -> None:
        """Count passes from 0 again after so many seconds."""
        self._count, self._elapsed = 0, elapsed

    def total(self, count: int, error: float, elapsed: float, setup: float) -> float:
        """Return the predicted total after `count` passes; infinite while nothing is known.

        The error is that which the budget compares with its goal; of the seconds so far, no later
        pass will take those of `setup` again.
        """
        pace = (elapsed - self._elapsed - setup) / (count - self._count)
        needed = self.passes_needed(count, error)
        if self._budget.passes is not None:
            needed = min(needed, self._budget.passes)
        total = math.inf
        if math.isfinite(needed):
            total = elapsed + max(needed - count, 0.0) * pace
        if self._budget.goal is None or math.isfinite(needed):
            total = min(total, self._last_end(elapsed, elapsed / count))
        self._predictions += 1
        if math.isfinite(total) and self._predictions & (self._predictions - 1) == 0:
            self.pairs.append((elapsed, total))
        return total

    def _last_end(self, elapsed: float, pace: float) -> float:
        """Return when the last pass ends that may begin before the time is up."""
        if math.isinf(self._budget.ceiling):
            return math.inf
        return max(math.floor(self._budget.ceiling / pace) * pace, elapsed)

    def passes_needed(self, count: int, error: float) -> float:
        """Return how many passes meet the goal, by the error after `count`; else infinite."""
        goal = self._budget.goal
        if goal is None or not math.isfinite(error):
            return math.inf
        needed = count * (error / goal.limit) ** 2 / self._noise(count)
        return max(self._solve(needed), LEAST_PASSES)

    def _solve(self, needed: float) -> float:
        """Return the n of n / noise(n) = needed: the error's square falls as noise(n) / n."""
        passes = needed
        for _ in range(STEPS):
            passes = min(needed * self._noise(passes), MOST_PASSES)
        return passes

    def _noise(self, count: float) -> float:
        """Return the mean of (1 + i / FOOTPRINTS_HOLD)^(1/3) over passes i < count.

        So the variance of a pass grows where all of it is shared: as footprints shrink in area.
        """
        if not self._sharing or count <= 0.0:
            return 1.0
        hold = float(FOOTPRINTS_HOLD)
        return max(0.75 * hold * math.expm1(4.0 / 3.0 * math.log1p(count / hold)) / count, 1.0)
