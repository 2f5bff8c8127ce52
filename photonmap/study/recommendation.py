"""The recommendation in plain words, from the measured numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from photonmap.film.budget import LEAST_PASSES
from photonmap.study.convergence import BUFFER, PATH, Estimate, Law
from photonmap.study.sweeps import bands_label

TARGETS = (0.05, 0.02, 0.01, 0.005)
HEADLINE = 0.01
"""Target error of shading that is described at length."""

_CHEAPER = 0.97
"""Largest fraction of the base's time at which fewer bands are worth mentioning."""
_FINER = 1 / 3
"""Largest fraction of the base's colour error at which more bands are worth mentioning."""
_STEPS = 400
"""Times, logarithmically spaced, at which the best number of bands is evaluated."""


def recommend(laws: Sequence[Law], base: str, targets: Sequence[float] = TARGETS) -> list[str]:
    """Return sentences on the time to each target: with the base's bands, others, and path tracing.

    Parameters
    ----------
    laws : one for each number of bands, and one for the path tracer
    base : the bands to which the others are compared
    targets : relative errors of shading due to noise
    """
    found = {law.label: law for law in laws}
    if bands_label(base) not in found:
        return []
    first = _whole(found, bands_label(base), HEADLINE)
    rest = [_short(found, bands_label(base), target) for target in targets if target != HEADLINE]
    bands = [law for law in laws if law.label != PATH]
    return [first, *rest, *(text for text in (_limits(bands), _best(bands)) if text)]


def duration(seconds: float) -> str:
    """Return a time to two digits, in seconds, minutes or hours."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{two_digits(seconds / size)} {unit}"
    return f"{two_digits(seconds)} s"


def percent(part: float) -> str:
    """Return a fraction to two digits, as a percentage."""
    return f"{two_digits(100.0 * part)}%"


def two_digits(value: float) -> str:
    """Return a number to two significant digits, without an exponent."""
    if abs(value) >= 9.95 or value == 0.0 or not math.isfinite(value):
        return f"{value:.0f}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(abs(value))))}f}"


def estimated_time(estimate: Estimate) -> str:
    """Return the time of an estimate, marked if it lies beyond the measured range."""
    return duration(estimate.seconds) + " (extrapolated)" * estimate.extrapolated


def _short(laws: dict[str, Law], base: str, target: float) -> str:
    """Return the time to a target with the base's bands, and by path tracing."""
    took = laws[base].seconds_to(target)
    path = (
        f"; path tracing: {estimated_time(laws[PATH].seconds_to(target))}" if PATH in laws else ""
    )
    return f"{100 * target:g}% error in {BUFFER}: {estimated_time(took)} with {base}{path}."


def _whole(laws: dict[str, Law], base: str, target: float) -> str:
    """Return the same, and what fewer and more bands would change."""
    law, took = laws[base], laws[base].seconds_to(target)
    parts = [f"{100 * target:g}% error in {BUFFER}: {estimated_time(took)} with {base}{_off(law)}"]
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
        parts.append(f"path tracing: {estimated_time(laws[PATH].seconds_to(target))}")
    return "; ".join(parts) + "."


def _off(law: Law, base: Law | None = None) -> str:
    """Return the colour error of indirect light, if it is known."""
    if math.isnan(law.indirect):
        return ""
    link = "but " if base and law.indirect > base.indirect else ""
    return f", {link}{percent(law.indirect)} colour error in indirect light"


def _limits(bands: Sequence[Law]) -> str:
    """Return the errors that more time does not reduce."""
    short = [f"{percent(law.spectral)} with {law.label}" for law in bands if law.spectral > 0.0]
    if not short:
        return ""
    return (
        f"However long the render, the colour error of {BUFFER} never falls below "
        f"{', '.join(short)}."
    )


def _best(bands: Sequence[Law]) -> str:
    """Return which bands have the smallest error, noise and colour combined, for a given time."""
    if len(bands) < 2:
        return ""
    first = min(law.cost.seconds(LEAST_PASSES) for law in bands)
    last = max(law.seconds_to(TARGETS[-1]).seconds for law in bands)
    times = np.geomspace(first, last, _STEPS)
    best = [min(bands, key=lambda law: law.total_after(float(t))).label for t in times]
    turns = [0, *(i for i in range(1, len(best)) if best[i] != best[i - 1])]
    spans = [
        f"from {duration(float(times[turn]))} on with {best[turn]}" if turn else f"with {best[0]}"
        for turn in turns
    ]
    return f"Noise and colour error of {BUFFER} combined are smallest {', '.join(spans)}."
