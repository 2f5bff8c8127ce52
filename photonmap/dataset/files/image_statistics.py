"""Statistics of one image for the report: share of direct light, histograms."""

from __future__ import annotations

from typing import Any

import numpy as np

from photonmap.results.result import Result

BINS = 20
"""Number of bins of every histogram."""


def summarise(result: Result, rgb: Result) -> dict[str, Any]:
    """Return an image's statistics, JSON-able.

    `direct_share` is Σ|direct| / Σ|direct + indirect| over pixels and bands, None without light.
    Histograms over valid pixels have `BINS` bins over [0, 1]: one of reflectance in all bands, and
    those of the illuminant's red and blue fractions of R + G + B where none of the three is
    negative.

    Parameters
    ----------
    result : in its bands, with the buffers that `with_derived` adds
    rgb : the same in linear sRGB
    """
    direct = result.direct.astype(np.float64)
    whole = float(np.abs(direct + result.indirect).sum())
    valid = result.buffers["valid"]
    light = rgb.buffers["illuminant"][valid]
    light = light[(light >= 0.0).all(axis=-1) & light.any(axis=-1)].astype(np.float64)
    fractions = light / light.sum(axis=-1, keepdims=True)
    return {
        "direct_share": float(np.abs(direct).sum()) / whole if whole else None,
        "valid": float(valid.mean()),
        "reflectance": _histogram(result.reflectance[valid]),
        "illuminant_red": _histogram(fractions[:, 0]),
        "illuminant_blue": _histogram(fractions[:, 2]),
    }


def _histogram(values: Any) -> list[int]:
    return np.histogram(np.clip(values, 0.0, 1.0), BINS, (0.0, 1.0))[0].tolist()
