"""Renders with photonmap, timed without loading and compiling."""

from __future__ import annotations

import time
from typing import Any

import photonmap as pm


def render(scene: pm.Scene, **settings: Any) -> tuple[pm.Result, float]:
    """Render; return the result and its seconds.

    Everything that `photonmap.render` does counts, including the sampling pre-pass, moments and
    standard errors, except for the stages load and compile of its record.
    """
    start = time.perf_counter()
    result = pm.render(scene, **settings)
    seconds = time.perf_counter() - start
    spent = result.record["seconds"]
    return result, seconds - spent["load"] - spent["compile"]


def warm_up(scene: pm.Scene, **settings: Any) -> None:
    """Compile the kernels that a render needs, of one pass if none are given; touch its memory."""
    pm.render(scene, **{"passes": 1, **settings})
