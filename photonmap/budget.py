"""When a render stops: after so many passes, so much time, or at a stated error."""

import math
from dataclasses import dataclass

from photonmap.errors import InputError

DEFAULT_ERROR = 0.02
LEAST_PASSES = 16
"""Before these, a spread over passes says too little to stop on."""
LEAST_PHOTONS = 1 << 14
"""In a pass, unless a user says otherwise."""
CEILING = 3600.0
"""Seconds after which a render that aims at an error stops anyway."""


@dataclass(frozen=True)
class Budget:
    """Exactly one of passes, seconds and error."""

    passes: int | None = None
    seconds: float | None = None
    error: float | None = None

    @classmethod
    def choose(
        cls, passes: int | None = None, seconds: float | None = None, error: float | None = None
    ) -> "Budget":
        """Check a user's choice; none at all is the default error.

        Raises
        ------
        InputError : two budgets at once, or one that is not positive and finite
        """
        given = {
            name: value
            for name, value in (("passes", passes), ("seconds", seconds), ("error", error))
            if value is not None
        }
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} are two budgets at once: give one")
        for name, value in given.items():
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{name} {value} must be positive and finite")
        if passes is not None and passes != int(passes):
            raise InputError(f"passes {passes} must be a whole number")
        return cls(**given) if given else cls(error=DEFAULT_ERROR)  # type: ignore[arg-type]

    @property
    def ceiling(self) -> float:
        """Seconds after which no further pass begins."""
        return math.inf if self.passes else (self.seconds or CEILING)

    def is_spent(self, count: int, error: float, elapsed: float) -> bool:
        """Tell whether to stop after `count` passes and `elapsed` seconds.

        No pass begins that would, at the pace so far, end after the time is up.
        """
        if self.passes is not None:
            return count >= self.passes
        late = count > 0 and elapsed * (count + 1) / count > self.ceiling
        reached = self.error is not None and count >= LEAST_PASSES and error <= self.error
        return late or reached

    def fraction(self, count: int, error: float, elapsed: float) -> float:
        """Estimate which part of the work is done, in [0, 1]; 0 while nothing is known."""
        if self.passes is not None:
            return count / self.passes
        if self.error is None:
            return min(elapsed / self.ceiling, 1.0)
        if not math.isfinite(error):
            return 0.0
        # Variance falls with the number of passes.
        needed = max(count * (error / self.error) ** 2, LEAST_PASSES)
        return min(max(count / needed, elapsed / self.ceiling), 1.0)
