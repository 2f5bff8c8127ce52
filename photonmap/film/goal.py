"""The error that a render aims at: of which buffer, and in which sense."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from photonmap.buffers import is_omitted, names_where
from photonmap.errors import InputError
from photonmap.runtime.wording import shown, suggest

BUFFERS = names_where(is_goal=True)
"""Buffers whose error may be aimed at, in the order of the kernels' `GOAL_BUFFERS`."""
FORMS = "write 0.02, indirect:0.02 or indirect:p95:0.02"


@dataclass(frozen=True)
class Goal:
    """A relative standard error, SE / sqrt(v² + 0.01 m²) of a buffer v of mean m per band.

    Parameters
    ----------
    limit : to be reached
    buffer : one of `BUFFERS`
    percentile : over valid pixels and bands, in (0, 100]; None for the root mean square
    """

    limit: float
    buffer: str = "radiance"
    percentile: float | None = None

    @classmethod
    def parse(cls, text: float | str | Goal) -> Goal:
        """Read 0.02, "0.02", "indirect:0.02" or "indirect:p95:0.02".

        Raises
        ------
        InputError : another form, no such buffer, or a number out of its range
        """
        if isinstance(text, Goal):
            return text
        *head, last = str(text).split(":")
        limit = _number(last)
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
            percentile = _number(head[1][1:]) if head[1].startswith("p") else None
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


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def refuse_omitted(goal: Goal | None, kept: Collection[str]) -> None:
    """Refuse a goal and a choice of buffers that need mirrors, glass or rough surfaces."""
    if goal is not None and is_omitted(goal.buffer):
        raise InputError(
            f"error {goal}: without mirrors, glass or rough surfaces {goal.buffer} is exactly "
            f"0; choose another buffer"
        )
    if all(is_omitted(name) for name in kept):
        raise InputError(
            f"buffers {', '.join(sorted(kept))}: without mirrors, glass or rough surfaces there "
            f"may be none of them; ask for another buffer too"
        )
