"""How figures and intervals are written."""

from __future__ import annotations

from photonmap.evaluate.intervals import Interval


def number(value: float) -> str:
    """Return a number with three significant digits."""
    text = f"{value:#.3g}".rstrip(".")
    return text if "e" not in text else f"{value:.2g}"


def interval(ends: Interval | None) -> str:
    """Return an interval as text; "" for none."""
    return "" if ends is None else f"[{number(ends.low)}, {number(ends.high)}]"
