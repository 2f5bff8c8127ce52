"""Renders before their direct light was averaged over pixels, see `photonmap.film.direct_filter`.

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
UNFILTERED = "direct_unfiltered"


def unfiltered(result: Result) -> Result:
    """Return a result with the plain means of direct light, and the errors that go with them.

    It undoes `Accumulator.with_direct`: where direct light is filtered, pixels have one reflectance
    and emit nothing, and its correlation with indirect light is that of the plain means.
    """
    if UNFILTERED not in result.buffers:
        return result
    buffers, errors = dict(result.buffers), dict(result.errors)
    for name in result.buffers:
        buffer, group = split_name(name)
        if buffer == UNFILTERED:
            _restore(buffers, errors, group)
    return replace(result, buffers=buffers, errors=errors)


def _restore(buffers: Images, errors: Images, group: str) -> None:
    """Replace the direct light of a light group, or of the whole, and all that follows from it."""
    plain, direct, indirect, shading, radiance = (
        group_name(name, group)
        for name in (UNFILTERED, "direct", "indirect", "shading", "radiance")
    )
    light, error = buffers.pop(plain), errors.pop(plain)
    changed = (light != buffers[direct]) | (error != errors[direct])
    r = np.where(changed, buffers["reflectance"], 1.0).astype(np.float64)
    stated = np.where(changed, errors[shading], 0.0)  # else infinite where no surface is
    before, of_direct, of_indirect, of_both = (
        image.astype(np.float64) ** 2
        for image in (error, errors[direct], errors[indirect], stated * r)
    )
    ratio = np.sqrt(np.divide(before, of_direct, out=np.zeros_like(before), where=of_direct > 0.0))
    whole = before + of_indirect + ratio * (of_both - of_direct - of_indirect)
    both, spread = light + buffers[indirect], np.sqrt(np.maximum(whole, 0.0))
    for images, own, values in ((buffers, light, both), (errors, error, spread)):
        for name, value in {radiance: values, shading: values / r}.items():
            if name in images:
                images[name] = np.where(changed, value, images[name]).astype(np.float32)
        images[direct] = own
