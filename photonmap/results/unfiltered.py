"""Renders before their direct light was averaged over pixels, see `photonmap.film.direct_filter`.

Passes decide what is averaged, and how that biases pixels does not average out over runs. So runs
are merged by their plain means.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from photonmap.results.result import Result

UNFILTERED = "direct_unfiltered"


def unfiltered(result: Result) -> Result:
    """Return a result with the plain means of direct light, and the errors that go with them.

    It undoes `Accumulator.with_direct`: where direct light is filtered, pixels have one reflectance
    and emit nothing, and its correlation with indirect light is that of the plain means.
    """
    if UNFILTERED not in result.buffers:
        return result
    buffers, errors = dict(result.buffers), dict(result.errors)
    direct, error = (images.pop(UNFILTERED) for images in (buffers, errors))
    before, of_direct, of_indirect, of_radiance = (
        image.astype(np.float64) ** 2
        for image in (error, *(errors[name] for name in ("direct", "indirect", "radiance")))
    )
    changed = (direct != buffers["direct"]) | (error != errors["direct"])
    ratio = np.sqrt(np.divide(before, of_direct, out=np.zeros_like(before), where=of_direct > 0.0))
    whole = before + of_indirect + ratio * (of_radiance - of_direct - of_indirect)
    light, spread = direct + buffers["indirect"], np.sqrt(np.maximum(whole, 0.0))
    r = np.where(changed, buffers["reflectance"], 1.0)
    for images, own, values in ((buffers, direct, light), (errors, error, spread)):
        for name, value in {"radiance": values, "shading": values / r}.items():
            images[name] = np.where(changed, value, images[name]).astype(np.float32)
        images["direct"] = own
    return replace(result, buffers=buffers, errors=errors)
