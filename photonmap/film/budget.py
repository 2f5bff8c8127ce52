"""When a render stops: after so many passes, so much time, or at a stated error of a buffer."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection
from dataclasses import dataclass
from numbers import Real
from typing import Any

from photonmap.buffers import BY_NAME, Omission, names_where, row_of
from photonmap.errors import InputError
from photonmap.runtime.wording import shown, suggest

BUFFERS = names_where(is_goal=True)
"""Buffers whose error may be aimed at, in the order of the kernels' `GOAL_BUFFERS`."""
FORMS = "write 0.02, indirect:0.02 or indirect:p95:0.02"


@dataclass(frozen=True)
class Goal:
    """A relative standard error, SE / sqrt(v² + 0.01 m²) of a buffer v of mean m per band."""

    limit: float  # to be reached
    buffer: str = "radiance"  # one of `BUFFERS`
    percentile: float | None = None
    """over valid pixels and bands, in (0, 100]; None for the root mean square"""

    @classmethod
    def parse(cls, text: float | str | Goal) -> Goal:
        """Read 0.02, "0.02", "indirect:0.02" or "indirect:p95:0.02".

        Another form, no such buffer, or a number out of its range is an `InputError`.
        """
        if isinstance(text, Goal):
            return text
        *head, last = str(text).split(":")
        limit = _read_number(last)
        if limit is None or len(head) > 2:
            raise InputError(f"error {shown(text)} is not understood; {FORMS}")
        if not (math.isfinite(limit) and limit > 0.0):
            raise InputError(f"error {shown(text)} must be positive and finite")
        if limit > 1.0:
            raise InputError(
                f"error {shown(text)} is {100.0 * limit:.6g}%; write a fraction, as 0.02 for 2%"
            )
        if head and head[0] not in BUFFERS:
            raise InputError(
                f"error {shown(text)}: a render cannot aim at the error of {shown(head[0])}; "
                f"{suggest(head[0], BUFFERS)}"
            )
        percentile = None
        if len(head) == 2:
            percentile = _read_number(head[1][1:]) if head[1].startswith("p") else None
            if percentile is None or not 0.0 < percentile <= 100.0:
                raise InputError(
                    f"error {shown(text)}: {shown(head[1])} is not a percentile; {FORMS}"
                )
        return cls(limit, head[0] if head else BUFFERS[0], percentile)

    def __str__(self) -> str:
        """Return what `parse` reads."""
        head = [] if self.is_plain else [self.buffer]
        if self.percentile is not None:
            head.append(f"p{self.percentile:.12g}")
        return ":".join([*head, f"{self.limit:.12g}"])

    @property
    def is_plain(self) -> bool:
        """Whether it is the root mean square over radiance, as the record's `error` is."""
        return self.buffer == "radiance" and self.percentile is None


def _read_number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def refuse_omitted(goal: Goal | None, kept: Collection[str], lacking: Collection[Omission]) -> None:
    """Refuse a goal and a choice of buffers that need what a scene is `lacking`, an `Omission`."""
    if goal is not None and (why := BY_NAME[goal.buffer].omitted) in lacking:
        raise InputError(f"error {goal}: {why} {goal.buffer} is exactly 0; choose another buffer")
    omissions = {row.omitted for name in kept if (row := row_of(name))}
    if lacking and omissions <= {*lacking, "where it is 0 everywhere"}:
        raise InputError(
            f"buffers {', '.join(sorted(kept))}: {' and '.join(lacking)} there may be none of "
            "them; ask for another buffer too"
        )


DEFAULT_ERROR = 0.02
LEAST_PASSES = 4
"""Before these, a spread over passes is too uncertain to stop on."""
NEAR = 2.5
"""Errors over the goal from which on light is filtered to see whether that meets it: in plain
scenes it more than halves them."""
MOST_PASSES = (1 << 32) - 1
"""That the counts of passes, 32 bits, can hold."""
LEAST_PHOTONS = 1 << 14
ENOUGH_PHOTONS = 1 << 18
"""In a pass, unless a user says otherwise."""
PASS_SAMPLES = (0.125, 0.25, 0.5, 1.0)
"""Samples of a pass, as fractions of the usual."""
ON_EDGES = 4
"""That fraction in pixels on edges, over that of others: not all in an eighth, where rooms would
take longer to an error of 0.03."""
CEILING = 3600.0
"""Seconds after which a render that aims at an error stops anyway, unless a user says others."""


def check_pass_samples(fraction: float) -> float:
    """Return a fraction of the usual samples, one of `PASS_SAMPLES`; `InputError` for another."""
    if fraction not in PASS_SAMPLES:
        raise InputError(f"pass samples {shown(fraction)} must be 0.125, 0.25, 0.5 or 1")
    return float(fraction)


def share_on_edges(size: float) -> float:
    """Return the fraction of the usual samples of a pixel on an edge in passes of a size."""
    return min(ON_EDGES * size, 1.0)


def usual_photons(pixels: int) -> int:
    """Return how many photons are emitted per pass unless a user chooses a number.

    What cells hide does not depend on the pixels: small images need nearly as many as large ones.
    """
    return max(pixels, min(4 * pixels, ENOUGH_PHOTONS), LEAST_PHOTONS)


@dataclass(frozen=True)
class Budget:
    """Passes, seconds, an error to reach, or several of them: what comes first ends a render."""

    passes: int | None = None
    seconds: float | None = None
    goal: Goal | None = None

    @classmethod
    def choose(
        cls,
        passes: int | None = None,
        seconds: float | None = None,
        error: float | str | None = None,
    ) -> Budget:
        """Check a user's choice; none at all is the default error.

        One that is not positive and finite is an `InputError`.
        """
        for name, value in (("passes", passes), ("seconds", seconds)):
            is_number = isinstance(value, Real) and 0.0 < value <= sys.float_info.max
            if value is not None and not is_number:
                raise InputError(f"{name} {shown(value)} must be a positive and finite number")
        if passes is not None and not (passes == int(passes) and passes <= MOST_PASSES):
            raise InputError(f"passes {shown(passes)} must be a whole number up to {MOST_PASSES}")
        goal = None if error is None else Goal.parse(error)
        if passes is seconds is goal is None:
            goal = Goal(DEFAULT_ERROR)
        return cls(passes, seconds, goal)

    def describe(self) -> dict[str, Any]:
        """Return the JSON-able record: what was given, by name."""
        described: dict[str, Any] = {}
        if self.goal is not None:
            described["error"] = self.goal.limit if self.goal.is_plain else str(self.goal)
        given = {"passes": self.passes, "seconds": self.seconds}
        return described | {name: value for name, value in given.items() if value}

    @property
    def ceiling(self) -> float:
        """Seconds after which no further pass begins."""
        return self.seconds or (math.inf if self.passes else CEILING)

    def is_near(self, error: float) -> bool:
        """Return whether an error exceeds the goal by so little that filtering may meet it."""
        return self.goal is not None and 1.0 < error / self.goal.limit <= NEAR

    def is_met(self, error: float) -> bool:
        """Return whether an error meets the goal, if there is one."""
        return self.goal is not None and error <= self.goal.limit

    def is_reached(self, count: int, error: float) -> bool:
        """Return whether an error after `count` passes meets the goal, and they state it well."""
        return count >= LEAST_PASSES and self.is_met(error)

    def is_spent(self, count: int, error: float, elapsed: float) -> bool:
        """Return whether to stop after `count` passes and `elapsed` seconds.

        No pass begins that would, at the pace so far, end after the time is up.
        """
        is_last = self.passes is not None and count >= self.passes
        is_late = count > 0 and elapsed * (count + 1) / count > self.ceiling
        return is_last or is_late or self.is_reached(count, error)
