"""The recommendation in plain words, made of the numbers measured."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from photonmap.budget import LEAST_PASSES
from photonmap.study.recommend import BUFFER, PATH, Estimate, Law
from photonmap.study.sweeps import called

TARGETS = (0.05, 0.02, 0.01, 0.005)
HEADLINE = 0.01
"""The target that is told at length."""

_CHEAPER = 0.97  # of the time, from which on it is worth a word
_FINER = 1 / 3  # of the colour error, likewise
_STEPS = 400  # of time, between which the best bands are looked for


def recommend(laws: Sequence[Law], base: str, targets: Sequence[float] = TARGETS) -> list[str]:
    """Say what each target takes with the base's bands, with others, and by path tracing.

    Parameters
    ----------
    laws : one for each number of bands, and the path tracer's
    base : the bands to compare with
    targets : noise of shading
    """
    found = {law.label: law for law in laws}
    if called(base) not in found:
        return []
    first = _whole(found, called(base), HEADLINE)
    rest = [_short(found, called(base), target) for target in targets if target != HEADLINE]
    bands = [law for law in laws if law.label != PATH]
    return [first, *rest, *(text for text in (_limits(bands), _best(bands)) if text)]


def duration(seconds: float) -> str:
    """Return seconds to two digits, in a fitting unit."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{two_digits(seconds / size)} {unit}"
    return f"{two_digits(seconds)} s"


def percent(part: float) -> str:
    """Return a part of 1 to two digits, in percent."""
    return f"{two_digits(100.0 * part)}%"


def two_digits(value: float) -> str:
    """Return a number to two digits, without exponent."""
    if abs(value) >= 9.95 or value == 0.0 or not math.isfinite(value):
        return f"{value:.0f}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}"


def told(estimate: Estimate) -> str:
    """Return the time of an estimate, marked where it lies beyond what was measured."""
    return duration(estimate.seconds) + " (extrapolated)" * estimate.extrapolated


def _short(laws: dict[str, Law], base: str, target: float) -> str:
    """Say what a target takes with the base's bands, and by path tracing."""
    took = laws[base].seconds_to(target)
    path = f"; path tracing: {told(laws[PATH].seconds_to(target))}" if PATH in laws else ""
    return f"{100 * target:g}% on {BUFFER}: {told(took)} with {base}{path}."


def _whole(laws: dict[str, Law], base: str, target: float) -> str:
    """Say the same, and what fewer and more bands change."""
    law, took = laws[base], laws[base].seconds_to(target)
    parts = [f"{100 * target:g}% on {BUFFER}: {told(took)} with {base}{_off(law)}"]
    others = [other for name, other in laws.items() if name not in (base, PATH)]
    ratios = {other.label: other.seconds_to(target).seconds / took.seconds for other in others}
    cheaper = [other for other in others if ratios[other.label] < _CHEAPER]
    finer = [other for other in others if other.indirect < _FINER * law.indirect]
    if cheaper:
        least = min(cheaper, key=lambda other: ratios[other.label])
        parts.append(f"{ratios[least.label]:.0%} of that time with {least.label}{_off(least, law)}")
    if finer:
        best = min(finer, key=lambda other: ratios[other.label])
        if best not in cheaper:
            ratio = f"{ratios[best.label]:.2g} times the time"
            parts.append(f"{ratio} with {best.label}{_off(best, law)}")
    if PATH in laws:
        parts.append(f"path tracing: {told(laws[PATH].seconds_to(target))}")
    return "; ".join(parts) + "."


def _off(law: Law, base: Law | None = None) -> str:
    """Return what is wrong with the colour of indirect light, where it is known."""
    if math.isnan(law.indirect):
        return ""
    link = "but " if base and law.indirect > base.indirect else ""
    return f", {link}{percent(law.indirect)} colour error in indirect light"


def _limits(bands: Sequence[Law]) -> str:
    """Return what no time helps against."""
    short = [f"{law.label} below {percent(law.spectral)}" for law in bands if law.spectral > 0.0]
    return f"No time brings the colour of {BUFFER} of {', of '.join(short)}." if short else ""


def _best(bands: Sequence[Law]) -> str:
    """Return which bands have the least error, noise and colour together, by the time there is."""
    if len(bands) < 2:
        return ""
    first = min(law.cost.seconds(LEAST_PASSES) for law in bands)
    last = max(law.seconds_to(TARGETS[-1]).seconds for law in bands)
    times = np.geomspace(first, last, _STEPS)
    best = [min(bands, key=lambda law: law.total_after(float(t))).label for t in times]
    turns = [0, *(i for i in range(1, len(best)) if best[i] != best[i - 1])]
    spans = [
        f"{best[turn]} from {duration(float(times[turn]))} on" if turn else best[0]
        for turn in turns
    ]
    return f"Noise and colour of {BUFFER} together are least with {', '.join(spans)}."
