"""How many samples a pass takes, so that a loose error is not overshot by the least passes.

A render needs `LEAST_PASSES` before it can trust its own error. Where that many full passes would
be more work than the goal needs, passes take a half or a quarter of the samples. The first ones,
which are such quarters, tell; if they turn out too small, they are discarded.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from photonmap.film.budget import LEAST_PASSES, PASS_SAMPLES
from photonmap.film.goal import Goal
from photonmap.kernels.core.passes import SamplingPlan
from photonmap.runtime.storage import strips

PILOT_PASSES = 2
"""Passes after which the size of the others is chosen."""
LOOSE = 0.01
"""Error from which on a goal is worth the pilot passes."""
COSTS = {0.25: (0.38, 1.0), 0.5: (0.58, 0.4), 1.0: (1.0, 0.18)}
"""By fractions of the usual samples: the time of a pass over that of a full one, and the passes
needed over those of quarters. Means over the Cornell box, and over `vase`, `living_room`, `kitchen`
and `terrace` under one and two lights, 160×120."""


def first_size(goal: Goal | None) -> float:
    """Return the size of the first passes of a render that aims at an error, or at none."""
    return min(PASS_SAMPLES) if goal is not None and goal.limit >= LOOSE else 1.0


def choose_size(needed: float) -> float:
    """Return the size of passes that costs least, where so many quarters would meet the goal."""
    if not math.isfinite(needed):
        return 1.0

    def time(size: float) -> float:
        seconds, passes = COSTS[size]
        return seconds * max(needed * passes, LEAST_PASSES)

    return min(COSTS, key=time)


def resize(plan: SamplingPlan, size: float) -> SamplingPlan:
    """Return a plan with fewer samples of the camera, or where these are one, of everything."""
    if size == 1.0:
        return plan
    samples, lights, gathers = (
        np.empty_like(counts) for counts in (plan.samples, plan.lights, plan.gathers)
    )
    for part in strips(len(samples)):
        wanted = plan.samples[part] * size
        samples[part] = np.maximum(wanted, 1.0)
        rest = wanted / samples[part]
        lights[part] = _scaled(plan.lights[part], rest)
        gathers[part] = _scaled(plan.gathers[part], rest)
    return plan._replace(samples=samples, lights=lights, gathers=gathers)


def _scaled(counts: NDArray[np.uint8], factor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return scaled counts, of which none becomes 0 that was not."""
    return np.ceil(counts * factor)
