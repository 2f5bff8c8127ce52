"""Renders by photonmap, timed without loading and compiling."""

from __future__ import annotations

import time
from typing import Any

import photonmap as pm


def render(scene: pm.Scene, **settings: Any) -> tuple[pm.Result, float]:
    """Render; return the result and its seconds.

    All that `photonmap.render` does is counted, the survey, moments and standard errors too,
    except what its record calls load and compile.
    """
    start = time.perf_counter()
    result = pm.render(scene, **settings)
    seconds = time.perf_counter() - start
    spent = result.record["seconds"]
    return result, seconds - spent["load"] - spent["compile"]


def warm_up(scene: pm.Scene, **settings: Any) -> None:
    """Compile and touch what a render needs."""
    pm.render(scene, **settings, passes=1)
