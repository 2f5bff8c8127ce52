"""Renders before their light was averaged over pixels, see `photonmap.film.light_filter`.

Passes decide what is averaged, and how that biases pixels does not average out over runs. So runs
are merged by their plain means.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photonmap.buffers import group_name, split_name
from photonmap.results.result import Result

Images = dict[str, NDArray[Any]]
UNFILTERED = {"direct": "direct_unfiltered", "indirect": "indirect_unfiltered"}


def unfiltered(result: Result) -> Result:
    """Return a result with the plain means of light, and the errors that go with them.

    It undoes `Accumulator.with_light`: where light is filtered, pixels have one reflectance and
    emit nothing, and direct and indirect light are correlated as the plain means are.
    """
    groups = [
        group for buffer, group in map(split_name, result.buffers) if buffer in UNFILTERED.values()
    ]
    if not groups:
        return result
    buffers, errors = dict(result.buffers), dict(result.errors)
    for group in dict.fromkeys(groups):
        _restore(buffers, errors, group)
    return replace(result, buffers=buffers, errors=errors)


def _restore(buffers: Images, errors: Images, group: str) -> None:
    """Replace the light of a light group, or of the whole, and all that follows from it."""
    name_of = {name: group_name(name, group) for name in (*UNFILTERED, "shading", "radiance")}
    changed = np.zeros(buffers["reflectance"].shape, bool)
    ratio, before, after = np.ones(changed.shape), np.zeros(changed.shape), np.zeros(changed.shape)
    for name, plain in UNFILTERED.items():
        own, plain = name_of[name], group_name(plain, group)
        stated = errors[own].astype(np.float64) ** 2
        if plain in buffers:
            light, error = buffers.pop(plain), errors.pop(plain)
            changed |= (light != buffers[own]) | (error != errors[own])
            buffers[own], errors[own] = light, error
        plain_stated = errors[own].astype(np.float64) ** 2
        gained = np.divide(plain_stated, stated, out=np.zeros_like(ratio), where=stated > 0.0)
        ratio, before, after = ratio * np.sqrt(gained), before + plain_stated, after + stated
    r = np.where(changed, buffers["reflectance"], 1.0).astype(np.float64)
    # else infinite where no surface is
    whole = (np.where(changed, errors[name_of["shading"]], 0.0) * r) ** 2
    spread = np.sqrt(np.maximum(before + ratio * (whole - after), 0.0))
    light = buffers[name_of["direct"]] + buffers[name_of["indirect"]]
    for images, values in ((buffers, light), (errors, spread)):
        for name, value in {"radiance": values, "shading": values / r}.items():
            if (own := name_of[name]) in images:
                images[own] = np.where(changed, value, images[own]).astype(np.float32)
