"""Choose the settings of methods for each scene by all other scenes, as Grosse et al. 2009 do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from photonmap.evaluate.bench.measure import Column, checked, measure
from photonmap.evaluate.bench.metric_list import MEAN_LAYER, METRICS
from photonmap.evaluate.bench.views import Shot
from photonmap.evaluate.methods.method import Method

Settings = Mapping[str, float]
_BY = METRICS["lmse"]
"""The metric that settings are chosen by."""


def tune(
    methods: Sequence[Method],
    names: Sequence[str],
    shots: Callable[[], Iterator[Shot]],
    log: Callable[[str], None],
) -> dict[str, dict[str, Settings]]:
    """Return the settings of each method for each scene: by name of the method, then of the scene.

    For a scene, those are chosen that have the least mean LMSE of reflectance and shading over the
    images of all other scenes. Images on which a method fails with any setting do not count. Where
    there is one scene only, or a method has no grid, these are its defaults.

    Parameters
    ----------
    names : of the scenes
    shots : returns the images of the data set
    log : called with a line for each image
    """
    chosen = {method.name: dict.fromkeys(names, method.defaults) for method in methods}
    tuned = [method for method in methods if method.grid]
    if not tuned or len(names) < 2:
        return chosen
    scenes: list[str] = []
    rows: dict[str, list[list[float]]] = {method.name: [] for method in tuned}
    for shot in shots():
        scenes.append(shot.truth.scene)
        for method in tuned:
            rows[method.name].append([_score(method, each, shot) for each in method.grid])
        log(f"settings tried on {shot.truth.name}")
    for method in tuned:
        scores = np.array(rows[method.name])
        usable = np.isfinite(scores).all(axis=1)
        for name in names:
            others = usable & (np.array(scenes) != name)
            if others.any():
                best = int(np.argmin(scores[others].mean(axis=0)))
                chosen[method.name][name] = method.grid[best]
    return chosen


def _score(method: Method, settings: Settings, shot: Shot) -> float:
    """Return the LMSE of a method with some settings; nan where it fails."""
    try:
        layers = checked(method.estimate(shot.view.copy(), **settings), shot.truth)
    except Exception:  # whatever a method raises; it is reported when images are scored
        return float("nan")
    return measure(layers, shot.truth, [_BY]).scores.get(Column(_BY.name, MEAN_LAYER), float("nan"))
